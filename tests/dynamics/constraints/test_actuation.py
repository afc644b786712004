"""Which joints drive, and how they share."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers.command_line import ROBOTS

import robodyn
from robodyn import Contact, ContactCost, Drive, Loop, Scene
from robodyn.dynamics.constraints.solve import actuation
from robodyn.errors import SceneError

LOOP = Loop("wrist_pin", "rod", (0.3, 0.0, 0.0), "slider")


def driving(scene: Scene) -> set[str]:
    model = robodyn.load(ROBOTS / "crank_slider.urdf")
    found = actuation(model, scene)
    assert not (found.passive & found.driven).any()
    assert found.counted.all()
    return set(np.array(model.rates)[found.driven])


@pytest.mark.parametrize(
    ("scene", "expected"),
    [
        (Scene(loops=(LOOP,)), {"main", "pin", "rail"}),
        (Scene(loops=(LOOP,), actuated=("main",)), {"main"}),
        (Scene(loops=(LOOP,), actuated=()), set()),
        (Scene(loops=(LOOP,), passive=("rail",)), {"main", "pin"}),
        (Scene(loops=(LOOP,), drive={"main": Drive(4.0)}), {"main"}),
        (Scene(loops=(LOOP,), drive={"main": Drive(4.0)}, actuated=("rail",)), {"rail"}),
        (Scene(loops=(LOOP,), drive={"main": Drive(4.0)}, passive=("rail",)), {"main", "pin"}),
        (Scene(drive={"main": Drive(4.0)}, passive=("pin",)), {"main", "rail"}),
    ],
)
def test_who_drives(scene, expected):
    assert driving(scene) == expected


def test_weights():
    model = robodyn.load(ROBOTS / "crank_slider.urdf")
    scene = Scene(loops=(LOOP,), share="weighted", weights={"rail": 3.0, "main": "effort"})
    found = actuation(model, scene)
    expected = {"main": 1.0 / 20.0**2, "pin": 1.0, "rail": 3.0}
    assert dict(zip(model.rates, found.weights, strict=True)) == pytest.approx(expected, rel=1e-15)
    assert dict(zip(model.rates, found.limits, strict=True)) == {"main": 20.0, "pin": 200.0, "rail": 500.0}
    assert (actuation(model, replace(scene, share="least", weights={})).weights == 1.0).all()


def without_limits(moving_base: bool = False) -> robodyn.Model:
    text = (ROBOTS / "quadruped.urdf").read_text()
    head, *parts = text.split('effort="')
    return robodyn.load(
        "".join([head, *('effort="0' + part[part.index('"') :] for part in parts)]).encode(), moving_base=moving_base
    )


def test_limits_that_are_missing():
    with pytest.raises(SceneError, match=r"'lf_abduction' has no effort limit, by which \"effort\" weighs \(give its"):
        actuation(without_limits(), Scene(passive=("lf_knee",), share="weighted", weight="effort"))
    feet = (Contact("lf", "lf_foot"),)
    for cost in (ContactCost(torques=1.0), ContactCost(within_limits=True)):
        with pytest.raises(SceneError, match="counts torques by their effort limits, and no joint that drives has one"):
            actuation(without_limits(True), Scene(moving_base=True, contacts=feet, contact_cost=cost))


def test_bases_are_passive_where_contacts_or_loops_to_the_ground_hold_them():
    model = robodyn.load(ROBOTS / "quadruped.urdf", moving_base=True)
    feet = (Contact("lf", "lf_foot"),)
    assert actuation(model, Scene(moving_base=True, contacts=feet)).passive[:6].all()
    flying = actuation(model, Scene(moving_base=True, passive=("lf_knee",)))
    assert not flying.counted[:6].any()
    assert flying.passive.sum() == 1
    bolted = Scene(moving_base=True, loops=(Loop("bolt", "trunk", kind="weld"),))
    assert actuation(model, bolted).passive[:6].all()
    assert not actuation(model, replace(bolted, held=True)).counted[:6].any()
    assert not actuation(model, replace(bolted, loops=(replace(bolted.loops[0], to="lf_foot"),))).counted[:6].any()


def test_weights_of_joints_that_do_not_drive():
    with pytest.raises(SceneError, match=r"\[weights\]: nothing drives 'pin' \(give weights of joints that drive\)"):
        driving(Scene(loops=(LOOP,), actuated=("main",), share="weighted", weights={"pin": 2.0}))
