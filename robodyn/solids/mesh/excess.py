"""What a closed surface counts too often, by columns in three directions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from robodyn.programs.vectors import length
from robodyn.solids.mesh.columns import Lattice
from robodyn.solids.mesh.pieces import pieces
from robodyn.solids.mesh.triangles import Floats

COLUMNS = 16384
"""In each direction, for surfaces that are closed."""

_DIRECTIONS = np.array([(0.8203, -0.4115, 0.3971), (0.2391, 0.8770, 0.4168), (-0.5198, -0.2469, 0.8178)])
"""Nearly at right angles, and along nothing that a part has."""


def directions() -> list[Floats]:
    """Three unit vectors."""
    return [direction / length(direction) for direction in _DIRECTIONS]


def excess(corners: Floats, count: int = COLUMNS) -> Floats:
    """(3, 4, 4) in each direction, by about so many columns, the moments of what a surface counts too often."""
    found = []
    for direction in directions():
        lattice = Lattice.over(corners, direction, count=count)
        every = pieces(lattice.hits(corners))
        wrong = every.of((every.weight != 0) & (every.weight != 1))
        found.append(replace(wrong, weight=wrong.weight - (wrong.weight > 0)).moments(lattice))
    return np.array(found)
