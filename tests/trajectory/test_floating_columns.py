"""Floating joints: quaternions differentiated into body rates, absent columns, normalisation."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from robodyn.errors import TrajectoryError
from robodyn.trajectory.columns.signals import Signal, Signals
from robodyn.trajectory.motion import Trajectory
from robodyn.trajectory.reader import TrajectoryReader
from robodyn.trajectory.readers.table import ArrayTable
from robodyn.trajectory.reading import Reading

Array = NDArray[np.float64]
FREE = Signals((Signal("base", "floating"),))
EPS = np.finfo(np.float64).eps


def read(columns: dict[str, Array], mode: str = "auto") -> Trajectory:
    reader = TrajectoryReader(ArrayTable(None, columns), FREE, reading=Reading(mode))  # type: ignore[arg-type]
    (block,) = reader.blocks()
    return block


def turn(time: Array) -> tuple[Array, Array, Array]:
    """Roll, pitch and yaw that all move: quaternion x y z w, w and wd in body axes by the kinematics of the angles."""
    a, ad, add = 0.7 * np.sin(time), 0.7 * np.cos(time), -0.7 * np.sin(time)
    b, bd, bdd = 0.5 * np.sin(2 * time), np.cos(2 * time), -2 * np.sin(2 * time)
    c, cd, cdd = 3 * time, 3 + 0 * time, 0 * time
    Q = Rotation.from_euler("ZYX", np.column_stack((c, b, a))).as_quat()
    sa, ca, sb, cb = np.sin(a), np.cos(a), np.sin(b), np.cos(b)
    w = np.column_stack((ad - cd * sb, bd * ca + cd * sa * cb, -bd * sa + cd * ca * cb))
    wd = np.column_stack(
        (
            add - cdd * sb - cd * cb * bd,
            bdd * ca - bd * sa * ad + cdd * sa * cb + cd * (ca * ad * cb - sa * sb * bd),
            -bdd * sa - bd * ca * ad + cdd * ca * cb + cd * (-sa * ad * cb - ca * sb * bd),
        )
    )
    return Q, w, wd


def columns(time: Array, Q: Array) -> dict[str, Array]:
    return {"time": time, **{f"base_q{axis}": Q[:, i] for i, axis in enumerate("xyzw")}}


@pytest.mark.parametrize("jitter", [0.0, 0.2])
@pytest.mark.parametrize("flips", [False, True])
def test_body_rates_of_a_clean_rotation(jitter: float, flips: bool) -> None:
    """w and wd to the accuracy of the spline, whichever of Q and -Q each sample holds."""
    rng = np.random.default_rng(0)
    time = (np.arange(1000) + rng.uniform(-jitter, jitter, 1000)) / 200
    Q, w, wd = turn(time)
    result = read(columns(time, Q * rng.choice([-1.0, 1.0], (1000, 1)) if flips else Q))
    inner = slice(10, -10)
    assert np.abs(result.qd[inner, :3] - w[inner]).max() < 1e-8
    assert np.abs(result.qdd[inner, :3] - wd[inner]).max() < 1e-6
    np.testing.assert_array_equal(result.qd[:, 3:], 0.0)


def test_noisy_rotation_is_smoothed() -> None:
    time = np.arange(3000) / 1000
    Q, w, wd = turn(time)
    result = read(columns(time, np.round(Q, 5)))
    assert result.derivation is not None
    (joint,) = result.derivation.joints
    assert joint.name == "base orientation"
    assert joint.acceleration.startswith("Savitzky-Golay")
    error = (result.qdd[:, :3] - wd)[100:-100]
    assert np.sqrt((error**2).mean()) < 0.02
    assert np.abs(result.qd[:, :3] - w)[100:-100].max() < 2e-3
    rough = read(columns(time, np.round(Q, 5)), "central").qdd[:, :3] - wd
    assert np.sqrt((rough[100:-100] ** 2).mean()) > 5.0


@pytest.mark.slow
def test_implied_deviation_of_body_rates() -> None:
    time = np.arange(1500) / 500
    Q, _, _ = turn(time)
    rng = np.random.default_rng(1)
    runs = [read(columns(time, Q + 1e-5 * rng.normal(size=Q.shape)), "spline") for _ in range(30)]
    spread = np.sqrt(np.stack([run.qdd[:, :3] for run in runs])[:, 100:-100].var(axis=0, ddof=1).mean())
    assert runs[0].derivation is not None
    assert 0.8 < runs[0].derivation.joints[0].std / spread < 1.25


def test_given_rates_are_kept_and_only_the_rest_derived() -> None:
    time = np.arange(600) / 200
    Q, w, wd = turn(time)
    rates = {"base_wx": w[:, 0], "base_wdy": wd[:, 1], "base_x": np.sin(time), "base_vy": np.cos(time)}
    result = read(columns(time, Q) | rates)
    np.testing.assert_array_equal(result.qd[:, 0], w[:, 0])
    np.testing.assert_array_equal(result.qdd[:, 1], wd[:, 1])
    np.testing.assert_array_equal(result.qd[:, 4], np.cos(time))
    inner = slice(10, -10)
    assert np.abs(result.qdd[inner, :3] - wd[inner]).max() < 1e-6
    assert np.abs(result.qdd[inner, 3] + np.sin(time)[inner]).max() < 1e-8
    assert np.abs(result.qdd[inner, 4] + np.sin(time)[inner]).max() < 1e-8
    assert result.notes == (
        "base: position y z is not given and taken as 0",
        "base: velocity vz is not given and taken as 0",
    )


def test_absent_columns() -> None:
    time = np.arange(50) / 100
    result = read({"time": time, "base_az": np.full(50, 2.0)})
    np.testing.assert_array_equal(result.q, np.tile([0, 0, 0, 0, 0, 0, 1.0], (50, 1)))
    np.testing.assert_array_equal(result.qd, 0.0)
    np.testing.assert_array_equal(result.qdd, np.tile([0, 0, 0, 0, 0, 2.0], (50, 1)))
    assert result.derivation is None
    assert result.notes == (
        "base: position x y z is not given and taken as 0",
        "base: orientation is not given and taken as the identity",
        "base: velocity wx wy wz vx vy vz is not given and taken as 0",
    )


@pytest.mark.parametrize("scale", [1.0, 1.0005, 0.5, 1e-200, 1e200])
def test_quaternions_are_normalised(scale: float) -> None:
    time = np.arange(300) / 100
    Q, w, _ = turn(time)
    result = read(columns(time, Q * scale), "spline")
    assert np.abs(np.linalg.norm(result.q[:, 3:], axis=1) - 1.0).max() <= 4 * EPS
    assert np.abs(result.qd[10:-10, :3] - w[10:-10]).max() < 1e-6
    assert any("quaternions normalised" in note for note in result.notes) == (abs(scale - 1.0) > 1e-3)


def test_zero_quaternion() -> None:
    Q = np.tile([0.0, 0.0, 0.0, 1.0], (9, 1))
    Q[5] = 0.0
    with pytest.raises(TrajectoryError, match="row 6: the quaternion of 'base' is zero"):
        read(columns(np.arange(9.0), Q))
