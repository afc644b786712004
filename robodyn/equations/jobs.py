"""What all forms of the equations ask of a robot and its scene."""

from __future__ import annotations

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
