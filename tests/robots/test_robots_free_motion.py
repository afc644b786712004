"""Bodies in space: the satellite keeps its momenta, the rigid body flips as the elliptic functions say."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.peers import pin
from helpers.robot_files import model, read_csv, stacked
from mpmath import mp
from scipy.spatial.transform import Rotation

EPS = np.finfo(float).eps
PERIOD = 55.061681107466372


class Base:
    """The base_ columns as arrays."""

    def __init__(self, name):
        table = read_csv(name)
        self.table, self.h = table, table["time"][1]
        self.p, self.v = (stacked(table, [f"base_{stem}{axis}" for axis in "xyz"]) for stem in ("", "v"))
        self.w, self.wd = (stacked(table, [f"base_{stem}{axis}" for axis in "xyz"]) for stem in ("w", "wd"))
        self.quaternion = stacked(table, [f"base_q{axis}" for axis in "xyzw"])
        self.rotation = Rotation.from_quat(self.quaternion)

    def quaternion_derivatives(self):
        first = 0.5 * _hamilton(self.quaternion, self.w)
        return first, 0.5 * (_hamilton(first, self.w) + _hamilton(self.quaternion, self.wd))


def _hamilton(q, w):
    """q (w, 0) row by row."""
    vector = q[:, 3:] * w + np.cross(q[:, :3], w)
    return np.column_stack([vector, -np.sum(q[:, :3] * w, axis=1)])


def _defect(h, f, fd, fdd):
    rule = h / 15 * (7 * fd[:-2] + 16 * fd[1:-1] + 7 * fd[2:]) + h * h / 15 * (fdd[:-2] - fdd[2:])
    return np.abs(f[2:] - f[:-2] - rule).max(axis=1)


@pytest.mark.parametrize(("name", "knots", "smooth"), [("satellite_slew", 6, 5e-15), ("rigid_body_flip", 0, 2.5e-10)])
def test_attitude_follows_the_rates(name, knots, smooth):
    """The rule is exact to degree 6: what is left is h^7 of the flip, and the jump of the jerk at six knots."""
    base = Base(name)
    defect = _defect(base.h, base.quaternion, *base.quaternion_derivatives())
    assert np.count_nonzero(defect > smooth) == knots
    assert defect.max() <= 1e-9
    np.testing.assert_allclose(np.linalg.norm(base.quaternion, axis=1), 1, rtol=0, atol=2 * EPS)
    assert np.abs(np.diff(base.quaternion, axis=0)).max() < 0.1


class Satellite:
    """Pinocchio's satellite with the state of every row: body axes, linear before angular."""

    def __init__(self):
        self.model = model("satellite", pin.JointModelFreeFlyer())
        self.data = self.model.createData()
        self.model.gravity.setZero()
        self.base = base = Base("satellite_slew")
        q, qd = (stacked(base.table, [f"{level}_{side}_array" for side in ("left", "right")]) for level in ("q", "qd"))
        self.q = np.hstack([base.p, base.quaternion, q])
        self.v = np.hstack([base.rotation.inv().apply(base.v), base.w, qd])


@pytest.fixture(scope="module")
def satellite():
    return Satellite()


def test_satellite_momenta_stay_zero_and_its_centre_of_mass_rests(satellite):
    for q, v in zip(satellite.q, satellite.v, strict=True):
        momentum = pin.computeCentroidalMomentum(satellite.model, satellite.data, q, v)
        parts = 0.5 * np.abs(v[6:]).sum()
        assert np.abs(momentum.vector).max() <= 100 * EPS * max(parts, EPS)
        place = pin.centerOfMass(satellite.model, satellite.data, q)
        np.testing.assert_allclose(place, (0.03, -0.012, 0.06), rtol=0, atol=2 * EPS)


def test_flip_keeps_energy_and_angular_momentum():
    base = Base("rigid_body_flip")
    L = base.w * [1, 2, 3]
    np.testing.assert_allclose(np.sum(base.w * L, axis=1), 2 * 1.000002, rtol=4 * EPS)
    np.testing.assert_allclose(base.rotation.apply(L), [L[0]] * len(L), rtol=0, atol=8 * EPS)
    np.testing.assert_allclose(base.wd * [1, 2, 3], -np.cross(base.w, L), rtol=0, atol=2 * EPS)
    assert not base.p.any()


def test_flip_is_jacobis_and_its_period_the_published():
    """w1 = A1 cn u, w2 = A2 sn u, w3 = A3 dn u with u = p t + u0: L. Landau and E. Lifshitz, Mechanics, 37."""
    base = Base("rigid_body_flip")
    with mp.workdps(30):
        w1, w2, w3 = mp.mpf("0.001"), mp.mpf(1), mp.mpf("0.001")
        energy, square = w1**2 + 2 * w2**2 + 3 * w3**2, w1**2 + 4 * w2**2 + 9 * w3**2
        A1 = A2 = mp.sqrt((3 * energy - square) / 2)
        A3 = mp.sqrt((square - energy) / 6)
        p, m = mp.sqrt((square - energy) / 6), (3 * energy - square) / (square - energy)
        assert float(4 * mp.ellipk(m) / p) == PERIOD
        u0 = mp.ellipf(mp.atan2(w2 / A2, w1 / A1), m)
        for t, w in zip(base.table["time"][::8], base.w[::8], strict=True):
            u = p * mp.mpf(t) + u0
            closed = [A * mp.ellipfun(kind, u, m=m) for A, kind in zip((A1, A2, A3), ("cn", "sn", "dn"), strict=True)]
            np.testing.assert_allclose(w, np.array(closed, dtype=float), rtol=4 * EPS, atol=0)
    assert base.table["time"][-1] > PERIOD
    assert base.w[:, 1].min() < -0.999
