"""An equilibrium that limits do not allow is never called stable: drives too weak, joints beyond their stops."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from helpers.command_line import run

ROBOT = """<robot name="p"><link name="base"/><link name="rod"><inertial><origin xyz="1 0 0"/><mass value="1"/>
<inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial></link>
<joint name="hinge" type="revolute"><parent link="base"/><child link="rod"/><axis xyz="0 1 0"/>
<limit effort="{effort:.9g}" velocity="5" lower="{lower:.9g}" upper="{upper:.9g}"/>
<dynamics damping="0.5"/></joint></robot>"""


def call(folder: Path, angle: float, effort: float, lower: float, upper: float) -> tuple[str, ...]:
    """A rod that a stiff drive holds at an angle, where it carries 9.81 cos(angle) N m."""
    (folder / "rod.urdf").write_text(ROBOT.format(effort=effort, lower=lower, upper=upper))
    torque = float(-9.81 * np.cos(angle))
    (folder / "drive.toml").write_text(
        f"drive.hinge = {{ kp = 1000, kd = 10, torque = {torque!r}, reference = {angle!r} }}\n"
    )
    return ("linearize", str(folder / "rod.urdf"), "--scene", str(folder / "drive.toml"))


@pytest.mark.parametrize("seed", [0, 9, 2, 6, 11, 15])
def test_limits_are_asked(seed: int, tmp_path: Path) -> None:
    rng = np.random.default_rng(seed)
    angle = float(rng.uniform(-1.2, 1.2))
    needed = abs(9.81 * np.cos(angle))
    weak, out = bool(seed & 1), bool(seed & 2)
    lower, upper = (angle + 0.1, angle + 2.0) if out and seed & 4 else (-3.0, angle - 0.1 if out else 3.0)
    base = call(tmp_path, angle, needed * (0.99 if weak else 1.01), lower, upper)
    base += ("--equilibrium",) if seed & 8 else (f"--at={angle!r}",)
    found, outcome = json.loads(run(*base, "--format", "json").out), run(*base, "--report", str(tmp_path / "r.md"))
    assert (found["stable"], found["verdict"]) == ((False, "beyond limits") if weak or out else (True, "stable"))
    assert sorted(each["quantity"] for each in found["limits_exceeded"]) == ["effort"] * weak + ["position"] * out
    page = (tmp_path / "r.md").read_text()
    assert ("**✅ Stable" in page) == (not weak and not out)
    assert ("**❌ The equilibrium is beyond limits" in page) == (weak or out)
    assert ("\nStable: every small push dies away.\n" in outcome.out) == (not weak and not out)
    if weak:
        assert f"% of its limit of {needed * 0.99:g} N m." in outcome.out
    assert outcome.status == 0
    assert run(*base, "--fail-on-limits").status == (weak or out)


def test_matrices_are_printed(tmp_path: Path) -> None:
    base = call(tmp_path, 0.0, 100.0, -3.0, 3.0)
    out, found = run(*base, "--equilibrium").out, json.loads(run(*base, "--equilibrium", "--format", "json").out)
    rows = "          q_hinge  qd_hinge\nq_hinge       0       1.000\nqd_hinge   -990.1   -10.40\n"
    assert f"\nA of x' = A x + B u\n{rows}" in out
    assert "\nB of x' = A x + B u\n          tau_hinge\nq_hinge      0\nqd_hinge     0.9901\n" in out
    assert found["A"][1] == pytest.approx([-1000 / 1.01, -10.5 / 1.01])
    assert "\nA of x(t + 0.01 s) = A x(t) + B u\n" in run(*base, "--step", "0.01").out
