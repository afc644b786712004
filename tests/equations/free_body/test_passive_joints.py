"""Free bodies of robots with joints that nothing drives: what the state takes there is told."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers.command_line import ROBOTS

import robodyn
from robodyn.support.wording import figure

FLAT = 0.5 * np.pi


def four_bar(angle: float, actuated: tuple[str, ...] = ("left",)):
    model, scene = robodyn.load(ROBOTS / "four_bar.urdf"), robodyn.load_scene(ROBOTS / "four_bar_lift.toml")
    q = {"left": angle, "right": angle, "top": -angle}
    return robodyn.free_bodies(model, [q[name] for name in model.rates], scene=replace(scene, actuated=actuated))


def test_nothing_is_told_where_loops_hold():
    assert four_bar(0.3).warnings == ()


@pytest.mark.parametrize(("angle", "actuated"), [(FLAT, ("left",)), (0.3, ())], ids=["flat", "no drive"])
def test_what_nothing_gives_is_told(angle, actuated):
    found = four_bar(angle, actuated)
    passive = [name for name in found.tau if name not in actuated]
    told = [name for name in passive if abs(found.tau[name]) > 1e-9]
    assert told
    assert found.warnings == tuple(
        f"nothing drives '{name}', and the motion takes {figure(found.tau[name])} N m there, shown as its drive"
        for name in told
    )
