"""Modes in words."""

from __future__ import annotations

import pytest

from robodyn.equations.linearized.modes import Mode
from robodyn.report.linearized import moves


@pytest.mark.parametrize(
    ("shape", "shares", "words"),
    [
        ((1.0, 0.5), (1.0, 0.2), "a 1, b 0.5"),
        ((-0.25, 1.0), (0.01, 1.0), "b 1, a 0.25 against"),
        ((1.0, 31.0), (1.0, 0.7), "a 1, b 31"),
        ((0.02, 1.0, 40.0), (0.5, 1.0, 0.9), "b 1, c 40"),
        ((1.0, 0.01), (1.0, 0.9), "a 1"),
        ((1.0, 0.5j, -0.5j), (1.0, 0.3, 0.2), "a 1, b 0.5 ahead by 90 deg, c 0.5 behind by 90 deg"),
    ],
)
def test_who_moves_how_much(shape, shares, words):
    """The first is the one that the others are measured by, whatever their units."""
    mode = Mode(-1.0, 2.0, 0.0, tuple(map(complex, shape)), shares)
    assert moves("abc"[: len(shape)], mode) == words
