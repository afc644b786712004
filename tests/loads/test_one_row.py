"""A table of one row is a robot at rest, with what rates it gives; two rows are too few to differentiate."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from helpers.command_line import ROBOTS, run

from robodyn.dynamics.inverse import inverse_dynamics
from robodyn.robot.load import load


@pytest.mark.parametrize(
    ("name", "given"), [("puma560", ()), ("scara", ("qd",)), ("cylindrical", ("qd", "qdd")), ("scara", ("qdd",))]
)
def test_one_row_is_taken_as_rest(name: str, given: tuple[str, ...], tmp_path: Path) -> None:
    model = load(str(ROBOTS / f"{name}.urdf"))
    rng = np.random.default_rng(len(given))
    names = [joint.name for joint in model.independent]
    state = {kind: rng.uniform(-0.1, 0.1, model.n) for kind in ("q", "qd", "qdd")}
    used = ("q", *given)
    head = ",".join(f"{kind}_{joint}" for kind in used for joint in names)
    row = ",".join(repr(float(x)) for kind in used for x in state[kind])
    (tmp_path / "one.csv").write_text(f"time,{head}\n0,{row}\n")
    call = ("torques", str(ROBOTS / f"{name}.urdf"), str(tmp_path / "one.csv"))
    found = json.loads(run(*call, "--format", "json").out)
    still = np.zeros(model.n)
    exact = inverse_dynamics(model, state["q"], *(state[kind] if kind in given else still for kind in ("qd", "qdd")))
    scale = np.abs(exact).max()
    assert np.abs([joint["peak"] for joint in found["joints"]] - exact).max() <= 1e-12 * scale
    said = "one row is no motion: velocities and accelerations that it does not give are 0"
    assert any(line.startswith(said) and "fbd ROBOT --at" in line for line in found["warnings"]) == (
        not {"qd", "qdd"} <= {*given}
    )


def test_two_rows_and_explicit_derivatives_are_refused(tmp_path: Path) -> None:
    urdf = str(ROBOTS / "two_link_planar.urdf")
    first = load(urdf).independent[0].name
    (tmp_path / "two.csv").write_text(f"time,q_{first}\n0,0.1\n1,0.2\n")
    call = ("torques", urdf, str(tmp_path / "two.csv"), "--hold", "rest")
    assert "has 2 rows, too few to differentiate" in run(*call).err
    (tmp_path / "two.csv").write_text(f"time,q_{first}\n0,0.1\n")
    assert run(*call, "--derivatives", "given").status == 2


def test_an_example_is_said_to_be_no_duty_cycle(tmp_path: Path) -> None:
    call = ("torques", str(ROBOTS / "puma560.urdf"), str(tmp_path / "m.csv"), "--example")
    said = "which is no duty cycle and reaches 40 % of the limits of speed: size by the motion that the robot will do"
    assert f"m.csv, an example motion to begin with, {said}\n" in run(*call, "--sizing").out
    (tmp_path / "m.csv").unlink()
    assert "m.csv, an example motion to begin with\n" in run(*call).out
