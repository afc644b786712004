"""`--measured` tells nothing impossible, and nothing that explains less than 2 %: arms lighter than described."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from helpers.command_line import ROBOTS, run

from robodyn.dynamics.inverse import inverse_dynamics
from robodyn.robot.load import load
from robodyn.scene.parts import Friction
from robodyn.scene.scene import Scene

ROBOT = ROBOTS / "puma.urdf"


def log_of(seed: int, file: Path) -> tuple[str, ...]:
    """A log of an arm whose links have other inertias than the description has, and friction that it has not."""
    rng = np.random.default_rng(seed)

    def other(found: re.Match[str]) -> str:
        return f'{found[1]}="{float(found[2]) * rng.uniform(0.4, 1.0):.9g}"'

    text = re.sub(r'\b(ixx|iyy|izz)="([^"]+)"', other, ROBOT.read_text())
    (file.parent / "true.urdf").write_text(text)
    true = load(str(file.parent / "true.urdf"))
    time = np.arange(0.0, 6.0, 0.004)
    w, phase = rng.uniform(1.0, 6.0, (3, true.n)), rng.uniform(0.0, 6.0, (3, true.n))
    angle = time[:, None, None] * w + phase
    q, qd, qdd = (0.2 * x.sum(axis=1) for x in (np.sin(angle), w * np.cos(angle), -w * w * np.sin(angle)))
    names = [joint.name for joint in true.independent]
    scene = Scene(friction={names[0]: Friction(2.0, 1.0, -1.0)})
    tau = inverse_dynamics(true, q, qd, qdd, scene=scene)
    tau += 0.002 * np.abs(tau).max(axis=0) * rng.standard_normal(tau.shape)
    head = ",".join(["time", *(f"{kind}_{name}" for kind in ("q", "qd", "qdd", "tau") for name in names)])
    np.savetxt(file, np.column_stack((time, q, qd, qdd, tau)), delimiter=",", header=head, comments="")
    return ("torques", str(ROBOT), str(file), "--measured")


@pytest.mark.parametrize("seed", range(6))
def test_what_is_told_is_possible_and_counts(seed: int, tmp_path: Path) -> None:
    call = log_of(seed, tmp_path / "log.csv")
    found = json.loads(run(*call, "--format", "json").out)
    for fault in found["diagnosis"]:
        if fault["kind"] in ("viscous", "coulomb", "rotor"):
            assert all(each["value"] >= 0.0 for each in fault["parameters"])
    said = run(*call).out.partition("What explains the difference\n")[2].partition("\n\n")[0].splitlines()
    lines = [line for line in said if re.match(r"\d+\. ", line)]
    told = [fault for fault in found["diagnosis"] if max(fault["explains"].values()) >= 0.02]
    assert len(lines) == len(told) > 0
    assert not any("inertia of -" in line or "friction of -" in line for line in said)


def test_less_friction_than_a_scene_says_is_possible(tmp_path: Path) -> None:
    call = log_of(0, tmp_path / "log.csv")
    (tmp_path / "much.toml").write_text("[friction]\nwaist = { viscous = 6, coulomb = 1 }\n")
    found = json.loads(run(*call, "--scene", str(tmp_path / "much.toml"), "--format", "json").out)
    values = [
        x["parameters"][0]["value"] for x in found["diagnosis"] if (x["kind"], x["joint"]) == ("viscous", "waist")
    ]
    assert values == [pytest.approx(-4.0, abs=1.0)]  # other inertias stand in its way
