"""Motions that become stiff on the way: followed by other steps or another method, or said to be wrong."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest
from helpers.report_text import simulation_text
from helpers.simulated_robots import pendulum, turntable

import robodyn
from robodyn.errors import InputError
from robodyn.report.simulation import simulation_json
from robodyn.scene.parts import Drive, Friction
from robodyn.simulation import stiff_steps
from robodyn.simulation.methods import TooMuchError

CREEP = 1e-3 * 0.8 / 0.6
"""rad/s under 0.8 of the friction, of v / sqrt(v^2 + slip^2) = 0.8."""


@pytest.mark.parametrize("how", [{}, {"rtol": 1e-7}])
def test_friction_that_becomes_stiff_on_the_way_is_followed(how, monkeypatch):
    """From 4000/s to 1e7/s: rk4 with the steps of the start ends 0.35 rad away."""
    monkeypatch.setattr(stiff_steps, "MOST_UNASKED", 4e4 if not how else 5e3)
    model, scene = turntable()
    found = robodyn.simulate(model, scene, 1.0, **how)
    assert abs(found.q[-1, 0] - CREEP) <= 2e-6
    assert abs(found.qd[-1, 0] - CREEP) <= 1e-6
    assert found.method.name == "radau"
    assert not found.caveats or "STEP" not in found.caveats[0].text
    (said,) = [note for note in found.notes if note.endswith("radau follows it")]
    assert said.startswith('Coulomb friction near rest of "turn" settles at ')
    assert " on the way, too fast for the steps before from 0." in said


def test_shorter_steps_where_few_more_are_needed():
    """The axis is passed by 5 cm: the friction settles 100 times as fast as at the start there."""
    model, scene = turntable()
    scene = replace(scene, drive={**scene.drive, "rail": Drive(kp=100.0, kd=20.0, reference=0.05)}, slip_speed=0.01)
    short, long = (robodyn.simulate(model, scene, 0.5, step=step) for step in (1e-5, 1e-3))
    found = robodyn.simulate(model, scene, 0.5)
    assert (found.method.name, found.step) == ("rk4", 5e-5)
    assert abs(found.q[-1, 0] - short.q[-1, 0]) <= 1e-6
    assert abs(long.q[-1, 0] - short.q[-1, 0]) >= 1e-4


def test_steps_of_the_user_are_kept_and_the_report_says_since_when_they_are_too_long():
    model, scene = turntable()
    found = robodyn.simulate(model, scene, 1.0, step=2e-4)
    assert found.step == 2e-4
    (said,) = [caveat.text for caveat in found.caveats if "STEP" in caveat.text]
    assert said.startswith('STEP TOO LONG from 0.1568 s on: Coulomb friction near rest of "turn" settles at 9.9')
    assert "which rk4 follows with steps of up to 2.8e-07 s; with 0.0002 s it chatters (give --step 1e-07" in said
    assert f"warning: {said}" in simulation_text(found)
    assert said in json.loads(simulation_json(found))["warnings"]
    assert found.within_limits is not True


def test_what_overflows_on_the_way_is_followed_by_radau():
    model, scene = turntable(Friction(viscous=1.0), joint_limits="ignore")
    found = robodyn.simulate(model, scene, 1.0)
    assert found.method.name == "radau"
    assert abs(found.qd[-1, 0] - 0.8) <= 1e-5
    with pytest.raises(InputError, match="a number overflows"):
        robodyn.simulate(model, scene, 1.0, step=2e-3)


def test_a_limit_that_is_reached_by_chattering_does_not_end_the_motion():
    """By steps of 1 ms the slide is thrown off to its limit at 0.53 s."""
    found = robodyn.simulate(*turntable(Friction(viscous=1.0)), 1.0)
    assert (found.method.name, found.step, found.ended) == ("rk4", 2e-4, "")
    assert abs(found.qd[-1, 0] - 0.8) <= 1e-5


def test_long_motions_that_are_not_stiff_stay_with_their_method(monkeypatch):
    """More evaluations than a stiff motion may take, by a pendulum that swings with a little friction."""
    monkeypatch.setattr(stiff_steps, "MOST_UNASKED", 500)
    scene = robodyn.Scene(friction={"j1": Friction(viscous=0.1)}, initial_q={"j1": 1.0})
    found = robodyn.simulate(pendulum(), scene, 10.0, rtol=1e-9)
    assert found.method.name == "dop853"
    assert found.evaluations > 500


def test_a_bound_on_evaluations_tells_how_far_they_came():
    from robodyn.dynamics.plan import plan
    from robodyn.simulation.methods import MethodOptions, method_named
    from robodyn.simulation.simulate import integrated, start_of
    from robodyn.simulation.table import Signal

    scene = robodyn.Scene(initial_q={"j1": 1.0})
    a_plan = plan(pendulum(), scene)
    how = MethodOptions(method_named("dop853"), 0.0, 1e-9, most=200)
    with pytest.raises(TooMuchError, match="dop853 has taken 200 evaluations and is at ") as caught:
        integrated(a_plan, how, 10.0, "numpy", Signal(scene, pendulum(), None), start_of(a_plan))
    assert 0.1 < caught.value.time < 5.0
    assert abs(caught.value.state[0]) <= 1.0
