"""What constraints determine along a motion: ranks, decided once, and what follows from them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robodyn.support.floats import Floats
from robodyn.support.sums import einsum

Mask = NDArray[np.bool_]

NONE = 1e-8
"""Singular values below this part of the largest of J are none."""
NOISY = 10.0
"""So many times the noise of J is none too."""
NOISE = 1e-12
"""Entries of J below this part of the largest do not count for the scales."""
GOOD = 1e-2
"""Reference samples whose singular values are within this part of the best decide what is determined."""
ROUNDS = 12
"""Of equilibration."""


@dataclass(frozen=True, eq=False)
class Structure:
    """What a motion's constraints determine, for m equations J qd = 0 of n rates, p of them passive and a actuated.

    With A = J_P^T (p, m), N a basis of the null space of A, B = J_A^T N:

    Attributes:
        passive: (n,) rates that nothing drives.
        equation_scale, rate_scale: (m,), (n,) of powers of two; diag(equation_scale) J diag(rate_scale) is
            equilibrated, so that units and the size of a robot decide nothing.
        largest: singular value of the equilibrated J; none: smaller ones count as none, relative to it.
        rank: of A; usual: its smallest singular value that counts, relative to `largest` (1 for rank 0).
        redundancy: rank of B: how many actuators there are beyond the freedoms that they drive; `usual_redundancy` as
            `usual`.
        freedoms: n - rank(J).
        undriven: p - rank(A), freedoms that move while all actuators stand still; `undriven_rates` (p,): the passive
            rates that they move.
        overconstrained: m - rank(J), equations that others imply.
        torque_determined: (a,) the actuated torque is the same for all forces of the loops that balance the motion.
        equation_determined: (m,) so is the force of the equation.
    """

    passive: Mask
    equation_scale: Floats
    rate_scale: Floats
    largest: float
    none: float
    rank: int
    usual: float
    redundancy: int
    usual_redundancy: float
    freedoms: int
    undriven: int
    undriven_rates: Mask
    overconstrained: int
    torque_determined: Mask
    equation_determined: Mask

    def scaled(self, J: Floats) -> Floats:
        """Return the equilibrated J (N, m, n)."""
        return np.asarray(J * self.equation_scale[:, None] * self.rate_scale)


def structure(J: Floats, passive: Mask, noise: float = 0.0) -> Structure:
    """Return what constraints determine along a motion.

    Method: singular values of the equilibrated J, A and B (LAPACK's gesdd); ranks are the largest of all samples.

    Args:
        J: (k, m, n) at reference samples, spread over the motion: up to about 16 will do.
        passive: (n,) rates that nothing drives.
        noise: relative error of J's entries, as of loops that are open by this part of the robot's size: equations that
            others imply on closed loops are then taken for implied.

    Accuracy: ranks are those of the equilibrated matrices, singular values below 1e-8 of the largest, or 10 times the
    noise, taken for none.
    """
    none = max(NONE, NOISY * noise)
    J, passive = np.asarray(J, dtype=float), np.asarray(passive, dtype=bool)
    _, m, n = J.shape
    equation_scale, rate_scale = _scales(np.abs(J).max(axis=0, initial=0.0))
    J = J * equation_scale[:, None] * rate_scale
    values = _values(J)
    largest = float(values.max(initial=0.0))
    size = np.where(values[:, :1] > 0.0, values[:, :1], 1.0) if values.size else np.ones((len(J), 1))
    left, sizes, right = svd(J[:, :, passive].transpose(0, 2, 1))
    rank, usual, good = _usual(sizes, none * size, largest)
    open_forces = right[good][:, rank:].transpose(0, 2, 1)
    B = times(J[good][:, :, ~passive].transpose(0, 2, 1), open_forces)
    redundancy, usual_redundancy, _ = _usual(_values(B), none * size[good], largest)
    return Structure(
        passive=passive,
        equation_scale=equation_scale,
        rate_scale=rate_scale,
        largest=largest,
        none=none,
        rank=rank,
        usual=usual,
        redundancy=redundancy,
        usual_redundancy=usual_redundancy,
        freedoms=n - rank - redundancy,
        undriven=int(passive.sum()) - rank,
        undriven_rates=_rows(left[good][:, :, rank:]) > none,
        overconstrained=m - rank - redundancy,
        torque_determined=_rows(B) <= none * largest,
        equation_determined=_rows(open_forces) <= none,
    )


def _scales(sizes: Floats) -> tuple[Floats, Floats]:
    """Return powers of two for rows (m,) and columns (n,) that bring the 2-norms of both near 1.

    Method: Sinkhorn and Knopp's alternation on squares; a row or column of zeros keeps 1.
    """
    squares = np.where(sizes > NOISE * sizes.max(initial=0.0), sizes, 0.0) ** 2
    rows, columns = np.ones(len(squares)), np.ones(squares.shape[1])
    for _ in range(ROUNDS):
        rows = _inverse((squares * columns).sum(axis=1))
        columns = _inverse((squares * rows[:, None]).sum(axis=0))
    return np.exp2(np.round(np.log2(rows) / 2.0)), np.exp2(np.round(np.log2(columns) / 2.0))


def _inverse(sums: Floats) -> Floats:
    return np.where(sums > 0.0, 1.0 / np.where(sums > 0.0, sums, 1.0), 1.0)


def _usual(sizes: Floats, none: Floats, largest: float) -> tuple[int, float, Mask]:
    """Return the rank, its smallest singular value relative to the largest of all, and which samples are near that.

    Args:
        none: (k, 1) at each sample, up to where singular values are none.
    """
    ranks = (sizes > none).sum(axis=1)
    rank = int(ranks.max(initial=0))
    if not rank:
        return 0, 1.0, np.ones(len(sizes), dtype=bool)
    smallest = sizes[:, rank - 1]
    return rank, float(smallest.max()) / largest, smallest >= GOOD * smallest.max()


def _rows(matrices: Floats) -> Floats:
    """Return the largest norm of each row among matrices (k, rows, columns)."""
    return np.asarray(np.sqrt((matrices**2).sum(axis=2)).max(axis=0, initial=0.0))


def times(A: Floats, B: Floats) -> Floats:
    """Return the products (N, i, k) of matrices (N, i, j) and (N, j, k)."""
    return np.asarray(einsum("nij,njk->nik", A, B))


def svd(A: Floats) -> tuple[Floats, Floats, Floats]:
    """Return U (N, p, p), the singular values (N, min(p, m)) and V^T (N, m, m) of A (N, p, m); p or m may be 0."""
    count, p, m = A.shape
    if A.size:
        return np.linalg.svd(A)
    left, right = (np.broadcast_to(np.eye(size), (count, size, size)) for size in (p, m))
    return left, np.zeros((count, 0)), right


def _values(A: Floats) -> Floats:
    return np.asarray(np.linalg.svd(A, compute_uv=False)) if A.size else np.zeros((len(A), 0))
