"""The nearest inertia that a body can have."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.planted_defects import HEALTHY

from robodyn.checks.bodies.masses import nearest
from robodyn.checks.check import check_one
from robodyn.checks.fixes import fixed
from robodyn.support.floats import Floats

EPS = 2.0**-52


def second(I: Floats) -> Floats:
    return np.trace(I) / 2.0 * np.eye(3) - I


def inertia(S: Floats) -> Floats:
    return np.trace(S) * np.eye(3) - S


def turned(moments: tuple[float, ...], seed: int) -> Floats:
    """An inertia with these second moments along turned axes."""
    axes, _ = np.linalg.qr(np.random.default_rng(seed).standard_normal((3, 3)))
    return inertia((axes * moments) @ axes.T)


@pytest.mark.parametrize(
    ("moments", "kept"),
    [
        ((2.5, 2.5, -1.5), (2.5, 2.5, 2.5e-6)),
        ((3.0, -1.0, 0.0), (3.0, 3e-6, 3e-6)),
        ((4.0, 2.0, 1.0), (4.0, 2.0, 1.0)),
        ((4e-9, 2e-9, -1e-9), (4e-9, 2e-9, 4e-15)),
    ],
)
def test_second_moments_are_clipped_in_their_axes(moments: tuple[float, ...], kept: tuple[float, ...]) -> None:
    found = nearest(turned(moments, 3))
    assert found is not None
    assert np.abs(found - turned(kept, 3)).max() <= 16 * EPS * max(moments)


def test_none_is_nearer() -> None:
    """Random inertias that a body can have, near the one that is found and far from it, are all farther."""
    random = np.random.default_rng(5)
    I = turned((2.0, 0.5, -0.7), 1)
    found = nearest(I)
    assert found is not None
    least = np.linalg.norm(second(found) - second(I))
    for size in np.geomspace(1e-4, 10.0, 60):
        root = np.linalg.cholesky(second(found)) + size * random.standard_normal((3, 3))
        assert np.linalg.norm(root @ root.T - second(I)) > least - 1e-5


@pytest.mark.parametrize("I", [-np.eye(3), np.diag((-3.0, -1.0, -2.0)), np.zeros((3, 3))])
def test_nothing_is_near(I: Floats) -> None:
    assert nearest(I) is None


def test_what_it_writes_a_body_can_have_and_it_is_said_how_far_it_is() -> None:
    text = HEALTHY.replace('izz="0.0035"', 'izz="0.0085"').encode()
    result = fixed(text, "picker.urdf", check_one, unsafe=True)
    (made,) = result.made
    assert made.fix.what == "correct the inertia: the nearest one that a body can have, 11 % away"
    assert made.change is not None
    assert not {one.code for one in check_one(result.after)} & {"RD206", "RD207"}
    assert fixed(text, "picker.urdf", check_one).after == text
