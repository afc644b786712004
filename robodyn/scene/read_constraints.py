"""The parts of a scene.toml about what holds a robot together and what it stands on: loops, actuation, contacts."""

from __future__ import annotations

from collections import Counter
from itertools import combinations
from typing import Any

from robodyn.scene.parts import ALWAYS, AUTO, EFFORT, Contact, ContactCost, Loop, Vector
from robodyn.scene.scene import Scene
from robodyn.scene.toml_table import SceneTable

KINDS = ("point", "hinge", "weld")
MOST_DIRECTIONS = 3
MOST_POINTS = 64
"""Of a contact."""
FLAT = 1e-6
"""Directions that span less are taken for parallel."""
SHARES = ("least", "weighted")


def constraints_of(table: SceneTable) -> dict[str, Any]:
    """Return the fields of a Scene that loops, actuation and contacts say.

    Raises:
        SceneError: a missing or wrong value, a name given twice, or keys that contradict each other.
    """
    found = {"loops": _loops(table), **_actuation(table), **_contacts(table)}
    names = Counter(each.name for each in (*found["loops"], *found["contacts"]))
    for name, count in names.items():
        if count > 1:
            what = f'{count} loops and contacts have the name "{name}"'
            raise table.error(what, remedy="give each a name of its own")
    return found


def _loops(table: SceneTable) -> tuple[Loop, ...]:
    return tuple(_loop(entry) for entry in table.list("loop"))


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
        raise table.error(f'"{key}" is zero', remedy="give a vector that has a direction")
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


def _actuation(table: SceneTable) -> dict[str, Any]:
    actuated, passive = table.names("actuated"), table.names("passive")
    if actuated is not None and passive is not None:
        raise table.error('"actuated" and "passive" are both given', remedy="give one: the other joints are the other")
    weights = table.take("weights", None)
    share = table.text("share", Scene.share if weights is None else "weighted", SHARES)
    if weights is not None and share != "weighted":
        raise table.error('"weights" are given, and "share" is "least"', remedy='write share = "weighted"')
    found = {"actuated": actuated, "passive": passive or (), "share": share}
    if weights is None or weights == EFFORT:
        return found | ({} if weights is None else {"weight": EFFORT})
    values = SceneTable(weights, "[weights]", table.file)
    return found | {"weights": {name: _weight(values, name) for name in list(values.values)}}


def _weight(table: SceneTable, name: str) -> float | str:
    if table.values[name] == EFFORT:
        table.take(name, ...)
        return EFFORT
    weight: float = table.number(name)
    if weight <= 0.0:
        raise table.error(f'"{name}" is {weight:g}', remedy=f'give a positive weight, or "{EFFORT}" for its limit')
    return weight


def _contacts(table: SceneTable) -> dict[str, Any]:
    found = tuple(_contact(entry) for entry in table.list("contact"))
    cost = SceneTable(table.take("contact_cost", {}), "[contact_cost]", table.file)
    forces = cost.number("forces", ContactCost.forces)
    if forces <= 0.0:
        raise cost.error(f'"forces" is {forces:g}', remedy="it is positive: torques alone leave forces open")
    torques = cost.nonnegative("torques", ContactCost.torques)
    within = cost.flag("within_limits", ContactCost.within_limits)
    cost.finish()
    return {"contacts": found, "contact_cost": ContactCost(forces, torques, within)}


def _contact(table: SceneTable) -> Contact:
    name, link = table.text("name"), table.text("link")
    contact = Contact(
        name,
        link,
        _points(table),
        _direction(table, "normal", ...) if "normal" in table.values else table.take("normal", None),
        table.nonnegative("friction", Contact.friction),
        _on(table),
        table.number("level", Contact.level),
        table.nonnegative("height", Contact.height),
        table.nonnegative("speed", Contact.speed),
    )
    table.finish()
    return contact


def _points(table: SceneTable) -> tuple[Vector, ...]:
    if "polygon" not in table.values:
        table.known.append("polygon")
        return (table.vector("point", (0.0, 0.0, 0.0)),)
    if "point" in table.values:
        raise table.error('"point" and "polygon" are both given', remedy="give one of them")
    polygon = table.vectors("polygon", MOST_POINTS)
    if len(set(polygon)) < max(len(polygon), 3):
        raise table.error(f'"polygon" has {len(set(polygon))} different points', remedy="give at least 3, each once")
    return polygon


def _on(table: SceneTable) -> Any:
    on = table.take("on", Contact.on)
    if isinstance(on, str) and on:
        return on
    pairs: list[Any] = on if isinstance(on, list) and on else [None]
    for pair in pairs:
        good = isinstance(pair, list) and len(pair) == 2
        if (
            not good
            or any(isinstance(x, bool) or not isinstance(x, (int, float)) for x in pair)
            or not pair[0] <= pair[1]
        ):
            remedy = f'give "{ALWAYS}", "{AUTO}", the name of a column, or intervals: [[0, 0.5], [1, 1.5]]'
            raise table.error(f'"on" is {on!r:.60}', remedy=remedy)
    return tuple((float(start), float(end)) for start, end in pairs)
