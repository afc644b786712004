"""How many unknowns and equations there are, which of them depend on others, and the index; all from ranks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robodyn.equations.dae.rank import Rank
from robodyn.equations.dae.solve import equilibrated, saddle, scaled_rows
from robodyn.equations.dae.system import Matrices, System
from robodyn.programs.vectors import product

Floats = NDArray[np.float64]
FULL = 1e-13
"""An eigenvalue counts if it is larger than this part of the largest, in a matrix of like rows and columns."""
UNDETERMINED = 1e-8
"""A reaction is undetermined if more than this part of it may change and nothing moves otherwise."""


@dataclass(frozen=True)
class Counts:
    """Unknowns, equations and ranks.

    Attributes:
        bodies: N; there are 6 N positions and 6 N velocities.
        reactions: m, the algebraic unknowns, one for each constraint equation.
        rank: of G.
        redundant: the equations that follow from those before them, as (connection, reaction) names.
        undetermined: the reactions that rigid bodies leave open, likewise.
        coefficients: ranks of the coefficients of accelerations and reactions, with constraints on positions,
            velocities and accelerations, redundant ones left out; `size` is the number of these unknowns.
    """

    bodies: int
    reactions: int
    rank: int
    redundant: tuple[tuple[str, str], ...]
    undetermined: tuple[tuple[str, str], ...]
    coefficients: tuple[int, int, int]
    size: int

    @property
    def freedom(self) -> int:
        """6 N - rank G."""
        return 6 * self.bodies - self.rank

    @property
    def unknowns(self) -> int:
        """Positions, velocities and reactions; there are as many equations."""
        return 12 * self.bodies + self.reactions

    @property
    def index(self) -> tuple[int, int, int] | None:
        """The differentiation index with constraints on positions, velocities and accelerations.

        The constraints are differentiated until accelerations and reactions follow from the equations; once more, and
        these are differential equations for the reactions too. Without reactions they are one to begin with. None where
        nothing resists some motion: no differentiation helps.
        """
        if not self.reactions:
            return (0, 0, 0)
        times = next((k for k, rank in enumerate(self.coefficients) if rank == self.size), None)
        if times is None:
            return None
        first, second, third = (max(times - level, 0) + 1 for level in range(3))
        return first, second, third


def counted(system: System, found: Matrices, rank: Rank, length: float) -> Counts:
    """The counts of a system in a state."""
    names = [(c.name, reaction) for c in system.connections for reaction in c.reactions]
    G = found.G[rank.independent]
    n = len(found.f)
    K = equilibrated(saddle(found.M, G))[0]
    laws = _rank(product(K[:n], K[:n].T))
    return Counts(
        len(system.inertias),
        len(names),
        len(rank.independent),
        tuple(names[k] for k in rank.dependent),
        tuple(names[k] for k in _undetermined(found.G, rank, length)),
        (laws, laws, _rank(K)),
        len(K),
    )


def _rank(K: Floats) -> int:
    """Of a symmetric matrix."""
    sizes = np.abs(np.linalg.eigvalsh(K))
    return int((sizes > FULL * sizes.max()).sum())


def _undetermined(G: Floats, rank: Rank, length: float) -> list[int]:
    """Rows that take part in a combination of rows that vanishes."""
    if not len(rank.dependent):
        return []
    rows = scaled_rows(G, length)
    left = np.linalg.svd(rows)[0][:, len(rank.independent) :]
    return [int(k) for k in np.flatnonzero(np.abs(left).max(axis=1) > UNDETERMINED)]
