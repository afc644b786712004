"""What a step costs: an effect that is absent from the scene costs no operation, one that is present some."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest
from helpers.oracles import robot

from robodyn.dynamics.plan import plan
from robodyn.scene.parts import Drive, Friction, Immersed, LimitSpring, Spring
from robodyn.scene.scene import Scene
from robodyn.simulation.equations import Equations, Steps
from robodyn.simulation.methods import method_named

BARE = Scene(gravity=(0, 0, 0))
PRESENT = {
    "coulomb friction": replace(BARE, friction={"elbow": Friction(forward=2.0, backward=-2.0)}, slip_speed=0.01),
    "limit spring": replace(BARE, limit_spring=LimitSpring(10.0), joint_limits="spring"),
    "fluid": replace(BARE, immersed=(Immersed("forearm", drag_area=(1, 1, 1)),), fluid_density=1000.0),
    "a drive": replace(BARE, drive={"elbow": Drive(torque=1.0)}),
    "a drive that follows": replace(BARE, drive={"elbow": Drive(kp=2.0, kd=3.0, reference=0.3)}),
}
ABSENT = {
    "joint spring": replace(BARE, spring={"elbow": Spring(0.0, 0.1)}),
    "a drive": replace(BARE, drive={"elbow": Drive(reference=1.0, speed=2.0)}),
    "limits as events": replace(BARE, joint_limits="stop"),
    "limits not looked at": replace(BARE, joint_limits="ignore"),
    "an initial state": replace(BARE, initial_q={"elbow": 1.0}, initial_qd={"elbow": 1.0}),
}
METHODS = ("euler", "rk4", "gauss4")


@cache
def programs(scene: Scene, method: str):
    steps = Steps(Equations(plan(robot("two_link_planar"), scene)), method_named(method))
    return steps.step, steps.sweep


@pytest.mark.parametrize("name", ABSENT)
def test_what_is_absent_costs_nothing(name):
    for method in METHODS:
        assert programs(ABSENT[name], method) == programs(BARE, method)


@pytest.mark.parametrize("name", PRESENT)
def test_what_is_present_costs_something_in_every_evaluation(name):
    def size(scene, method):
        step, sweep = programs(scene, method)
        return (sweep or step).size

    more = {method: size(PRESENT[name], method) - size(BARE, method) for method in METHODS}
    assert more["euler"] >= 1
    assert more["gauss4"] >= 2 * 0.6 * more["euler"]
    assert more["rk4"] >= 4 * 0.6 * more["euler"]
