"""What all forms of the equations ask of a robot and its scene, and names as identifiers."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace

from robodyn.dynamics.plan import Plan, plan
from robodyn.errors import InputError
from robodyn.robot.model import Model
from robodyn.scene.fit import check_moves
from robodyn.scene.scene import Scene
from robodyn.support.wording import listed


def check_equations(model: Model, scene: Scene) -> None:
    """Raise if there are no equations, or if numbers are missing that only a trajectory has.

    Raises:
        InputError: nothing of the robot can move, or wrenches of the scene name columns.
    """
    check_moves(model)
    if scene.columns:
        raise InputError(
            f"the scene's wrenches name columns of a trajectory: {listed(scene.columns)}",
            remedy="give them as numbers; equations have no trajectory",
        )


def bias_plan(model: Model, scene: Scene) -> Plan:
    """The plan of a motion without acceleration."""
    return replace(plan(model, scene), still=frozenset(("qdd", i) for i in range(model.n)))


def identifier(name: str, otherwise: str) -> str:
    """The letters and digits of a name, with single underscores for all else; `otherwise` in front of a digit."""
    words = [word for word in re.split(r"[^A-Za-z0-9]+", name) if word]
    text = "_".join(words) or otherwise
    return text if text[0].isalpha() else f"{otherwise}_{text}"


def identifiers(names: Iterable[str], otherwise: str) -> tuple[str, ...]:
    """An identifier for each name; those that would be alike, but for capitals, are numbered."""
    out: list[str] = []
    taken: set[str] = set()
    for name in names:
        first = text = identifier(name, otherwise)
        number = 1
        while text.lower() in taken:
            number += 1
            text = f"{first}_{number}"
        taken.add(text.lower())
        out.append(text)
    return tuple(out)
