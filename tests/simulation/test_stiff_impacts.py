"""Impacts against springs at limits: followed, or said to be wrong, whatever stiffness, mass, speed and method."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.report_text import simulation_text
from helpers.simulated_robots import slide

import robodyn
from robodyn.errors import InputError
from robodyn.report.limits import limits_verdict
from robodyn.scene.parts import LimitSpring
from robodyn.scene.scene import Scene
from robodyn.simulation.methods import METHODS
from robodyn.simulation.result import Simulation
from robodyn.simulation.stiff_steps import KEPT

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


@pytest.mark.parametrize(("stiffness", "mass", "speed"), drawn(25))
def test_elastic_impacts_are_followed_by_default(stiffness: float, mass: float, speed: float) -> None:
    found = rebound(stiffness, mass, speed)
    assert found.qd[-1, 0] == pytest.approx(-speed, rel=KEPT)
    assert found.energy_drift <= KEPT * 0.5 * mass * speed**2
    assert found.caveats == ()


@pytest.mark.parametrize("method", FIXED)
def test_an_impact_that_is_not_followed_is_never_green(method: str) -> None:
    """With steps of every length, from far too long to short enough."""
    doubted = 0
    for (stiffness, mass, speed), times in zip(drawn(12, 1), np.geomspace(0.01, 2.0, 12), strict=True):
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
    assert abs(rebound(1e8, 1.0, 2.0, step=1e-6).qd[-1, 0] + 2.0) <= 2e-5


def test_tolerances_that_are_too_wide_are_said() -> None:
    found = rebound(1e8, 1.0, 2.0, rtol=1e-2)
    assert [caveat.text.endswith("(give a smaller --rtol)") for caveat in found.caveats] == [True]
    assert rebound(1e8, 1.0, 2.0, rtol=1e-9).caveats == ()


@pytest.mark.slow
def test_damped_impacts_lose_what_their_damping_takes() -> None:
    """Their force jumps where they begin, within a step; against steps of 0.002 of a radian of the spring."""
    for stiffness, mass, speed in drawn(6, 2):
        damping = 0.4 * np.sqrt(stiffness * mass)
        found, fine = (
            rebound(stiffness, mass, speed, damping, **how) for how in ({}, {"step": 0.002 * np.sqrt(mass / stiffness)})
        )
        assert found.caveats == ()
        assert found.qd[-1, 0] == pytest.approx(fine.qd[-1, 0], abs=0.02 * speed)
