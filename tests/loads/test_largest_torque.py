"""Peak, bar, share of the limit and verdict are of the largest torque, and agree with tables, the base and motors."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from helpers.command_line import run
from helpers.exact_motions import course

import robodyn
from robodyn.report.limits import limits_verdict


def wheel(effort: float) -> bytes:
    """Return a body of unit inertia that turns about the vertical."""
    body = '<inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
    limit = f'<axis xyz="0 0 1"/><limit effort="{effort!r}" velocity="1e3"/>'
    turns = f'<joint name="j1" type="continuous"><parent link="l0"/><child link="l1"/>{limit}</joint>'
    return f'<robot name="wheel"><link name="l0"/><link name="l1">{body}</link>{turns}</robot>'.encode()


def moves(kind: str, seed: int, time: np.ndarray) -> list[np.ndarray]:
    return [part[:, 0] for part in course(kind, np.random.default_rng(seed), [(-2.0, 2.0)], 0.0).at(time)]


@pytest.mark.parametrize(("kind", "rate"), [("cosine", 1000), ("trapezoid", 100)])
def test_no_verdict_is_green_over_a_limit_just_below_the_largest_torque(kind: str, rate: int) -> None:
    """Of 25 motions 15 were green at 100 Hz, and the bar missed the largest torque in 17.

    What begins with the last three samples, their positions do not tell.
    """
    held = green = tried = 0
    for seed in range(8, 20):
        time = np.arange(0.0, 1.2, 1 / rate)
        q, _, qdd = moves(kind, seed, time)
        true = float(np.abs(qdd).max())
        if np.abs(qdd[:-3]).max() < true:
            continue
        tried += 1
        model = robodyn.load(wheel(0.985 * true))
        found = robodyn.torques(model, robodyn.motion(model, time, q[:, None]))
        (load,) = found.joints
        green += limits_verdict(found).level == "good" or found.within_limits is True
        held += abs(abs(load.peak) - true) <= load.error_bar + 1e-9 * true
    assert green == 0
    assert held >= 0.93 * tried
    assert tried >= 10


def test_the_peak_is_the_largest_of_the_table_and_of_the_base(tmp_path: Path) -> None:
    time = np.arange(0.0, 1.2, 0.01)
    q, _, qdd = moves("cosine", 0, time)
    true = float(np.abs(qdd).max())
    (tmp_path / "wheel.urdf").write_bytes(wheel(0.985 * true))
    np.savetxt(
        tmp_path / "q.csv", np.column_stack((time, q)), delimiter=",", header="time,q_j1", comments="", fmt="%.17g"
    )
    out = tmp_path / "tau.csv"
    call = ("torques", str(tmp_path / "wheel.urdf"), str(tmp_path / "q.csv"), "--out", str(out), "--format", "json")
    outcome = run(*call, "--fail-on-limits")
    found = json.loads(outcome.out)
    (load,) = found["joints"]
    tau = np.loadtxt(out, delimiter=",", skiprows=1)[:, 1]
    assert abs(load["peak"]) == pytest.approx(np.abs(tau).max(), rel=1e-12)
    mz = found["base_wrench"]["mz"]
    assert abs(mz["peak"]) == pytest.approx(abs(load["peak"]), rel=1e-12)
    assert outcome.status == int(abs(load["peak"]) > load["effort_limit"])
    assert found["verdict"]["level"] != "good"
    assert any("limit" in line and "within" in line for line in found["warnings"]) or outcome.status == 1


def test_a_motor_whose_limit_is_within_the_bar_is_not_called_kept() -> None:
    time = np.arange(0.0, 1.2, 1e-3)
    q, _, _ = moves("trapezoid", 3, time)
    step = 2 * np.pi / 2**14
    model = robodyn.load(wheel(1e3))
    motion = robodyn.motion(model, time, step * np.round(q / step)[:, None])
    (load,) = robodyn.torques(model, motion).joints
    limit = abs(load.peak) + 0.5 * load.error_bar
    scene = robodyn.Scene(motor={"j1": robodyn.Motor(peak=limit)})
    found = robodyn.torques(model, motion, scene)
    assert found.within_limits is None
    assert any("the motor of 'j1'" in caveat.text for caveat in found.caveats)
