"""The projection onto friction cones and its derivative."""

from __future__ import annotations

import numpy as np
import pytest

from robodyn.dynamics.contacts.dual import projected

UP = np.array((0.0, 0.0, 1.0))
ANGLES = [0.0, 0.3, 1.0, 1.5, np.pi / 2]


@pytest.mark.parametrize("angle", ANGLES)
def test_it_is_the_nearest_point(angle):
    """p in the cone, z - p in the polar cone and across p (Moreau)."""
    cosine, sine = (float(np.cos(angle)), float(np.sin(angle))) if angle < 1.57 else (0.0, 1.0)
    for z in np.random.default_rng(0).normal(size=(300, 3)):
        p = projected(z, UP, cosine, sine).f
        rest = z - p
        assert cosine * np.hypot(*p[:2]) <= sine * p[2] + 1e-15
        assert sine * np.hypot(*rest[:2]) <= -cosine * rest[2] + 1e-15
        assert abs(p @ rest) <= 1e-14


@pytest.mark.parametrize("angle", ANGLES[1:])
def test_its_derivative(angle):
    cosine, sine = float(np.cos(angle)), float(np.sin(angle))
    for z in np.random.default_rng(1).normal(size=(100, 3)):
        at, h = projected(z, UP, cosine, sine), 1e-6
        D = at.inside * np.eye(3) + at.edge * np.outer(at.u, at.u) + at.turn * np.outer(at.v, at.v)
        pairs = [
            (projected(z + h * e, UP, cosine, sine).f, projected(z - h * e, UP, cosine, sine).f) for e in np.eye(3)
        ]
        numeric = np.stack([(up - down) / (2.0 * h) for up, down in pairs], axis=1)
        assert np.abs(D - numeric).max() <= 1e-6


def test_it_turns_with_the_normal():
    random = np.random.default_rng(2)
    for z in random.normal(size=(50, 3)):
        turn, _ = np.linalg.qr(random.normal(size=(3, 3)))
        assert projected(turn @ z, turn[:, 2], 0.8, 0.6).f == pytest.approx(
            turn @ projected(z, UP, 0.8, 0.6).f, abs=1e-14
        )
