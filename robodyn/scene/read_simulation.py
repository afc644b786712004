"""The parts of a scene.toml that only a simulation reads: initial state, drives, springs at joint limits."""

from __future__ import annotations

from typing import Any

from robodyn.scene.parts import Drive, LimitSpring
from robodyn.scene.scene import Scene
from robodyn.scene.toml_table import SceneTable

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
