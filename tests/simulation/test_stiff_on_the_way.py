"""Motions that become stiff on the way, and impacts: followed by other steps or methods, or said to be wrong."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from helpers.report_text import simulation_text
from helpers.sampled import sampled
from helpers.simulated_robots import pendulum, slide, turntable

import robodyn
from robodyn.errors import InputError
from robodyn.report.limits import limits_verdict
from robodyn.report.simulation import simulation_json
from robodyn.scene.scene import Drive, Friction, LimitSpring, Scene
from robodyn.simulation import stiff_steps
from robodyn.simulation.methods import METHODS
from robodyn.simulation.result import Simulation
from robodyn.simulation.stiff_steps import KEPT

CREEP = 1e-3 * 0.8 / 0.6
"""rad/s under 0.8 of the friction, of v / sqrt(v^2 + slip^2) = 0.8."""


@pytest.mark.parametrize("how", [{}, pytest.param({"rtol": 1e-7}, marks=pytest.mark.slow)])
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


FIXED = [method.name for method in METHODS if not (method.adaptive or method.leapfrog or method.keeps_momenta)]


def rebound(stiffness: float, mass: float, speed: float, damping: float = 0.0, **how: object) -> Simulation:
    """A slide that meets its limit at 9 m in a motion as long as four half-periods of the spring."""
    half = float(np.pi * np.sqrt(mass / stiffness))
    spring = LimitSpring(stiffness, damping)
    begun = {"initial_q": {"j1": 9.0 - 1.51 * half * speed}, "initial_qd": {"j1": speed}}
    scene = Scene(gravity=(0, 0, 0), limit_spring=spring, joint_limits="spring", **begun)
    return robodyn.simulate(slide(mass), scene, 4.0 * half, executor="numpy", **how)


def drawn(count: int, seed: int = 0) -> list[tuple[float, float, float]]:
    """Stiffness [N/m], mass [kg] and speed [m/s], evenly by their logarithms."""
    rng = np.random.default_rng(seed)
    return [tuple(10.0 ** rng.uniform((3, -1, -2), (10, 2, 1))) for _ in range(count)]


def test_a_spring_of_1e8_throws_a_kilogram_back_as_fast_as_it_came() -> None:
    found = rebound(1e8, 1.0, 2.0)
    assert found.qd[-1, 0] == pytest.approx(-2.0, rel=KEPT)
    assert limits_verdict(found).headline == "No limit is exceeded"
    assert any("of the energy: those of" in note for note in found.notes)
    wide = rebound(1e8, 1.0, 2.0, rtol=1e-2)
    assert [caveat.text.endswith("(give a smaller --rtol)") for caveat in wide.caveats] == [True]
    assert rebound(1e8, 1.0, 2.0, rtol=1e-9).caveats == ()


@pytest.mark.parametrize(("stiffness", "mass", "speed"), sampled([pytest.param(*one) for one in drawn(12)], 4))
def test_elastic_impacts_are_followed_by_default(stiffness: float, mass: float, speed: float) -> None:
    found = rebound(stiffness, mass, speed)
    assert found.qd[-1, 0] == pytest.approx(-speed, rel=KEPT)
    assert found.energy_drift <= KEPT * 0.5 * mass * speed**2
    assert found.caveats == ()


@pytest.mark.parametrize("method", sampled(FIXED, 8))
def test_an_impact_that_is_not_followed_is_never_green(method: str) -> None:
    """With steps of every length, from far too long to short enough."""
    doubted = 0
    for (stiffness, mass, speed), times in zip(drawn(8, 1), np.geomspace(0.01, 2.0, 8), strict=True):
        try:
            found = rebound(stiffness, mass, speed, method=method, step=float(times * np.sqrt(mass / stiffness)))
        except InputError:  # the steps do not settle
            continue
        kept = abs(found.qd[-1, 0] + speed) <= KEPT * speed
        assert kept or found.within_limits is not True
        doubted += any(caveat.text.startswith("ENERGY DRIFTS: ") for caveat in found.caveats)
    assert doubted


def test_the_warning_says_by_how_much_and_what_to_do() -> None:
    found = rebound(1e8, 1.0, 2.0, step=1e-4)
    (caveat,) = found.caveats
    assert caveat.text.endswith(
        " % of what the motion turns over, and more than 0.1 % (give --step 2e-05, or --method radau)"
    )
    assert f"{found.energy_drift:.3g} J" in caveat.text
    text = simulation_text(found)
    assert f"warning: {caveat.text}" in text
    assert "by steps that do not keep the energy (ENERGY DRIFTS)" in limits_verdict(found).headline
