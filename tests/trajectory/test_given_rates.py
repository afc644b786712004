"""Velocities and accelerations that a table gives are held against its positions: noise, lag, exact ones."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from helpers.command_line import run
from helpers.oracles import ROBOTS, robot

import robodyn
from robodyn.report.limits import limits_verdict
from robodyn.trajectory.columns.signals import Signal, Signals
from robodyn.trajectory.read import from_arrays

ONE = Signals((Signal("a", "angle"),))
TIME = np.arange(0.0, 2.0, 1e-3)


def swing(n: int, time: np.ndarray = TIME, hertz: float = 1.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Positions, velocities and accelerations of n joints that swing by half a radian."""
    w, phase = 2 * np.pi * hertz, hertz * 2 * np.pi * time[:, None] + np.arange(n)
    return 0.5 * np.sin(phase), 0.5 * w * np.cos(phase), -0.5 * w * w * np.sin(phase)


def read(q: np.ndarray, bits: int) -> np.ndarray:
    step = 2 * np.pi / 2**bits
    return step * np.round(q / step)


def gradients(q: np.ndarray, time: np.ndarray = TIME) -> tuple[np.ndarray, np.ndarray]:
    qd = np.gradient(q, time, axis=0)
    return qd, np.gradient(qd, time, axis=0)


@pytest.mark.parametrize("bits", [13, 17, 20])
def test_bars_of_accelerations_that_are_differences_hold_the_largest_torque(bits: int) -> None:
    """89.8 N m "error 0.0" was printed where 6.9 is true, and no limit was said to be exceeded."""
    model = robot("puma560")
    q, qd, qdd = swing(model.n)
    true = np.abs(robodyn.inverse_dynamics(model, q, qd, qdd)).max(axis=0)
    given = read(q, bits)
    rates = gradients(given)
    found = robodyn.torques(model, robodyn.motion(model, TIME, given, *rates))
    for joint, largest in zip(found.joints, true, strict=True):
        assert abs(abs(joint.peak) - largest) <= joint.error_bar
    assert any(
        "accelerations are off by" in caveat.text and "--derivatives anew" in caveat.text for caveat in found.caveats
    )
    assert limits_verdict(found).level != "good"
    anew = robodyn.torques(model, robodyn.motion(model, TIME, given, *rates, derivatives="anew"))
    assert not any("anew" in caveat.text for caveat in anew.caveats)
    for joint, largest in zip(anew.joints, true, strict=True):
        assert abs(abs(joint.peak) - largest) <= joint.error_bar <= largest


@pytest.mark.parametrize("delay", [0.005, 0.02])
def test_a_delay_is_told(delay: float) -> None:
    q, qd, _ = swing(1)
    late = swing(1, TIME - delay)[2]
    (caveat,) = from_arrays(ONE, TIME, q, qd, late).caveats
    told = float(re.search(r"([\d.]+) ms late", caveat.text)[1])  # type: ignore[index]
    assert told == pytest.approx(1e3 * delay, rel=0.1)


@pytest.mark.parametrize("hertz", [0.5, 2.0, 120.0])
def test_exact_rates_are_not_doubted_however_fast(hertz: float) -> None:
    motion = from_arrays(ONE, TIME, *swing(1, hertz=hertz))
    assert not motion.caveats
    assert motion.sampling is not None
    assert motion.sampling.off.max() <= 1e-3 * np.abs(motion.qdd).max()


def test_exact_rates_of_encoder_positions_are_known_as_well_as_these_tell() -> None:
    q, qd, qdd = swing(1)
    motion = from_arrays(ONE, TIME, read(q, 17), qd, qdd)
    assert not motion.caveats
    assert motion.sampling is not None
    assert 0.0 < motion.sampling.off.max() <= 0.02 * np.abs(qdd).max()


def test_what_nothing_was_compared_with_has_no_bar() -> None:
    model, time = robot("puma560"), np.linspace(0.0, 1.0, 12)
    found = robodyn.torques(model, robodyn.motion(model, time, *swing(model.n, time)))
    assert {joint.error_bar for joint in found.joints} == {None}


def test_the_encoders_error_goes_into_the_bar(tmp_path: Path) -> None:
    """An error that repeats with the angle moves with the motion: positions alone do not tell it."""
    model = robot("puma560")
    q, qd, qdd = swing(model.n)
    size = 2e-5
    given = q + size * np.sin(256 * q)
    true = np.abs(robodyn.inverse_dynamics(model, q, qd, qdd)).max(axis=0)
    found, bars = {}, []
    for error in (0.0, size):
        loads = robodyn.torques(model, robodyn.motion(model, TIME, given, encoder_error=error)).joints
        off = [abs(abs(joint.peak) - x) / joint.error_bar for joint, x in zip(loads, true, strict=True)]
        found[error] = max(off)
        bars.append([joint.error_bar for joint in loads])
    assert found[size] <= 1.0 < found[0.0]
    table = tmp_path / "read.csv"
    head = ",".join(["time", *(f"q_{name}" for name in model.coordinates)])
    np.savetxt(table, np.column_stack((TIME, given)), delimiter=",", header=head, comments="", fmt="%.17g")
    for known, more in zip(bars, ((), ("--encoder-error", f"{size}")), strict=True):
        outcome = run("torques", str(ROBOTS / "puma560.urdf"), str(table), "--format", "json", *more)
        assert outcome.status == 0, outcome.err
        assert [joint["error_bar"] for joint in json.loads(outcome.out)["joints"]] == pytest.approx(known, rel=1e-6)
    assert run("torques", str(ROBOTS / "puma560.urdf"), str(table), "--encoder-error", "-1").status == 2
