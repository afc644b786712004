"""The parts of a scene.toml that only a simulation reads: loops, initial state, drives, springs at joint limits."""

from __future__ import annotations

from collections import Counter
from itertools import combinations
from typing import Any

from robodyn.scene.scene import Drive, LimitSpring, Loop, Scene, Vector
from robodyn.scene.toml_table import SceneTable

KINDS = ("point", "hinge", "weld")
MOST_DIRECTIONS = 3
FLAT = 1e-6
"""Directions that span less are taken for parallel."""


def loops_of(table: SceneTable) -> tuple[Loop, ...]:
    """Return the closures of a scene.

    Raises:
        SceneError: a key that does not go with the kind, a missing or wrong value, or a name given twice.
    """
    loops = tuple(_loop(entry) for entry in table.list("loop"))
    for name, count in Counter(loop.name for loop in loops).items():
        if count > 1:
            raise table.error(f'{count} loops have the name "{name}"', remedy="give each a name of its own")
    return loops


def _loop(table: SceneTable) -> Loop:
    kind = table.text("kind", Loop.kind, KINDS)
    axis = _direction(table, "axis", ...) if kind == "hinge" else Loop.axis
    loop = Loop(
        name=table.text("name"),
        link=table.text("link"),
        point=table.vector("point", Loop.point),
        to=table.text("to", Loop.to),
        to_point=table.vector("to_point", Loop.to_point),
        kind=kind,
        axis=axis,
        to_axis=_direction(table, "to_axis", axis) if kind == "hinge" else Loop.to_axis,
        rpy=table.vector("rpy", Loop.rpy) if kind == "weld" else Loop.rpy,
        directions=_directions(table) if kind == "point" else (),
    )
    table.finish()
    if loop.link == loop.to:
        raise table.error(f'"link" and "to" are both "{loop.link}"', remedy="a loop connects two links")
    return loop


def _direction(table: SceneTable, key: str, default: object) -> Vector:
    x, y, z = table.vector(key, default)
    if not any((x, y, z)):
        raise table.error(f'"{key}" is zero', remedy="give a vector along the hinge")
    return x, y, z


def _directions(table: SceneTable) -> tuple[Vector, ...]:
    found = table.vectors("directions", MOST_DIRECTIONS)
    for a, b in combinations(found, 2):
        if _square(_cross(a, b)) <= FLAT**2 * _square(a) * _square(b):
            raise table.error('two of "directions" are parallel', remedy="give each direction once")
    if any(not _square(a) for a in found):
        raise table.error('one of "directions" is zero', remedy="give vectors in the axes of the other link")
    if len(found) == MOST_DIRECTIONS:
        a, b, c = found
        volume = sum(x * y for x, y in zip(_cross(a, b), c, strict=True))
        if volume**2 <= FLAT**2 * _square(a) * _square(b) * _square(c):
            raise table.error('"directions" lie in a plane', remedy="two of them are enough")
    return found


def _cross(a: Vector, b: Vector) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _square(a: Vector) -> float:
    return a[0] * a[0] + a[1] * a[1] + a[2] * a[2]


LIMITS = ("stop", "ignore", "spring")
BETWEEN = ("linear", "hold")


def simulated_of(table: SceneTable) -> dict[str, Any]:
    """Return the fields of a Scene that these parts say."""
    return {
        "drive": {name: entry.read(Drive) for name, entry in table.tables("drive")},
        "between_rows": table.text("between_rows", Scene.between_rows, BETWEEN),
        **_initial(table),
        **_limits(table),
    }


def _initial(table: SceneTable) -> dict[str, Any]:
    initial = SceneTable(table.take("initial", {}), "[initial]", table.file)
    found = {}
    for key in ("q", "qd"):
        values = SceneTable(initial.take(key, {}), f"[initial] {key}", table.file)
        found[f"initial_{key}"] = {name: values.entry(name) for name in list(values.values)}
    initial.finish()
    return found


def _limits(table: SceneTable) -> dict[str, Any]:
    given = table.take("limit_spring", None)
    kind = table.text("joint_limits", Scene.joint_limits if given is None else "spring", LIMITS)
    if (given is not None) != (kind == "spring"):
        what = f'"joint_limits" is "{kind}" ' + ("without" if given is None else "with") + " a [limit_spring]"
        remedy = "give its stiffness, N m/rad" if given is None else 'write joint_limits = "spring"'
        raise table.error(what, remedy=remedy)
    if given is None:
        return {"joint_limits": kind}
    values = SceneTable(given, "[limit_spring]", table.file)
    spring = values.read(LimitSpring)
    if spring.stiffness <= 0 or spring.damping < 0:
        remedy = "stiffness is positive, damping positive or zero"
        raise values.error(f"stiffness {spring.stiffness:g}, damping {spring.damping:g}", remedy=remedy)
    return {"joint_limits": kind, "limit_spring": spring}
