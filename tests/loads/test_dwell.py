"""In a dwell friction does not flip and gears lose nothing: RMS of motors and duty are those of the exact motion."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.command_line import ROBOTS

from robodyn.loads.torques import torques
from robodyn.robot.load import load
from robodyn.scene.read import parse_scene
from robodyn.trajectory.read import motion

ROBOT_JOINTS = {"puma560": "shoulder", "scara": "quill", "cylindrical": "column", "two_link_planar": "shoulder"}
SCENES = {
    "coulomb": "[friction]\n{0} = {{ coulomb = 12, viscous = 3 }}\n[motor]\n{0} = {{ gear = 100, efficiency = 0.7 }}\n",
    "stribeck": "[friction]\n{0} = {{ coulomb = [9, -14], stribeck = 20 }}\n"
    "[motor]\n{0} = {{ inertia = 1e-5, gear = 50 }}\n",
    "load": "[friction]\n{0} = {{ coulomb = 5, load = 0.1 }}\n[motor]\n{0} = {{ gear = 80, efficiency = 0.8 }}\n",
}


def moves(time, long):
    """q, qd, qdd of a move of constant acceleration and deceleration in 1 s, a dwell, and the way back."""
    parts = []
    for start in (0.0, 1.0 + long):
        s = np.clip(time - start, 0.0, 1.0)
        first, inside = s < 0.5, (s > 0.0) & (s < 1.0)
        parts.append(
            (
                np.where(first, 2 * s * s, 1 - 2 * (1 - s) ** 2),
                np.where(first, 4 * s, 4 * (1 - s)),
                np.where(inside, np.where(first, 4.0, -4.0), 0.0),
            )
        )
    return [there - back for there, back in zip(*parts, strict=True)]


CASES = [*zip(ROBOT_JOINTS, [*SCENES, "coulomb"], (6, 15, 6, 15), strict=True)]
MORE = [(name, scene, digits) for name in ROBOT_JOINTS for scene, digits in zip(SCENES, (15, 9, 6), strict=True)]


@pytest.mark.parametrize(
    ("name", "scene", "digits"), [*CASES, *(pytest.param(*case, marks=pytest.mark.slow) for case in MORE)]
)
def test_friction_and_losses_of_a_dwell(name: str, scene: str, digits: int) -> None:
    model = load(str(ROBOTS / f"{name}.urdf"))
    names = [joint.name for joint in model.independent]
    k = names.index(ROBOT_JOINTS[name]) if ROBOT_JOINTS[name] in names else 0
    found = parse_scene(SCENES[scene].format(names[k]).encode())
    rng = np.random.default_rng(digits)
    step, long = float(rng.choice([1e-3, 2e-3, 5e-3])), float(rng.choice([0.2, 0.7, 1.5]))
    time = np.arange(round((2.0 + long) / step) + 1) * step
    size = 0.3 if model.independent[k].kind == "revolute" else 0.1
    q, qd, qdd = (np.zeros((len(time), model.n)) for _ in range(3))
    for column, values, shift in zip((q, qd, qdd), moves(time, long), (0.1, 0.0, 0.0), strict=True):
        column[:, k] = shift + size * values
    exact = torques(model, motion(model, time, q, qd, qdd), found)
    columns = []
    given = motion(model, time, np.round(q, digits))
    derived = torques(model, given, found, sinks=[lambda _, tau: columns.append(tau)])
    there = (time > 1.0 + 1e-9) & (time < 1.0 + long - 1e-9)
    tau = np.concatenate(columns)[there, k]
    assert not given.qd[there].any()
    assert np.ptp(tau[8:-8]) < 0.01 * max(abs(exact.joints[k].peak), 1.0)
    assert derived.sizing is not None
    assert exact.sizing is not None
    ours, true = derived.sizing.joints[k], exact.sizing.joints[k]
    assert ours.motor is not None
    assert true.motor is not None
    assert ours.motor.rms == pytest.approx(true.motor.rms, rel=5e-3)
    assert ours.duty_cycle == pytest.approx(true.duty_cycle, abs=5 * step)
    assert derived.joints[k].hold == pytest.approx(exact.joints[k].hold, rel=1e-5)
