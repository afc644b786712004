"""The forces of loops and the torques of drives that a motion takes: linear equations whose rank is decided once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robodyn.support.floats import Floats, einsum

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
LOST = 1e-6
"""A singular value below this part of its usual size is lost at a sample: nothing is divided by it."""


@dataclass(frozen=True, eq=False)
class Structure:
    """What a motion's constraints determine, for m equations J qd = 0 of n rates, p of them passive and a actuated.

    With A = J_P^T (p, m), N a basis of the null space of A, B = J_A^T N:

    Attributes:
        equation_scale, rate_scale: (m,), (n,) powers of two; diag(equation_scale) J diag(rate_scale) is equilibrated,
            so that units and the size of a robot decide nothing.
        largest: singular value of the equilibrated J; none: smaller ones count as none, relative to it.
        rank: of A; usual: its smallest singular value that counts, relative to `largest`; of B, how many actuators
            there are beyond the freedoms that they drive: redundancy, usual_redundancy.
        undriven_rates: (p,) the passive rates that move while all actuators stand still.
        overconstrained: m - rank(J), equations that others imply.
        torque_determined, equation_determined: (a,), (m,) the same for all forces that balance the motion.
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
    undriven_rates: Mask
    overconstrained: int
    torque_determined: Mask
    equation_determined: Mask


def structure(J: Floats, passive: Mask, noise: float = 0.0) -> Structure:
    """Return what constraints determine along a motion, by the largest ranks at reference samples J (k, m, n).

    Singular values of the equilibrated J, A and B below 1e-8 of the largest, or 10 times the noise, count as none;
    noise is the relative error of J, as of loops that are open by this part of the robot's size: equations that others
    imply on closed loops are then taken for implied.
    """
    none = max(NONE, NOISY * noise)
    J, passive = np.asarray(J, dtype=float), np.asarray(passive, dtype=bool)
    equation_scale, rate_scale = _scales(np.abs(J).max(axis=0, initial=0.0))
    J = J * equation_scale[:, None] * rate_scale
    sizes_of_J = np.linalg.svd(J, compute_uv=False).max(axis=1, keepdims=True, initial=0.0)
    largest, size = float(sizes_of_J.max(initial=0.0)), np.where(sizes_of_J > 0.0, sizes_of_J, 1.0)
    left, sizes, right = np.linalg.svd(J[:, :, passive].transpose(0, 2, 1))
    rank, usual, good = _usual(sizes, none * size, largest)
    open_forces = right[good][:, rank:].transpose(0, 2, 1)
    B = J[good][:, :, ~passive].transpose(0, 2, 1) @ open_forces
    redundancy, usual_redundancy, _ = _usual(np.linalg.svd(B, compute_uv=False), none * size[good], largest)
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
        undriven_rates=_rows(left[good][:, :, rank:]) > none,
        overconstrained=J.shape[1] - rank - redundancy,
        torque_determined=_rows(B) <= none * largest,
        equation_determined=_rows(open_forces) <= none,
    )


def _scales(sizes: Floats) -> tuple[Floats, Floats]:
    """Return powers of two for rows (m,) and columns (n,) that bring the 2-norms of both near 1 (Sinkhorn, Knopp)."""
    squares = np.where(sizes > NOISE * sizes.max(initial=0.0), sizes, 0.0) ** 2
    rows, columns = np.ones(len(squares)), np.ones(squares.shape[1])
    for _ in range(ROUNDS):
        rows = _inverse((squares * columns).sum(axis=1))
        columns = _inverse((squares * rows[:, None]).sum(axis=0))
    return np.exp2(np.round(np.log2(rows) / 2.0)), np.exp2(np.round(np.log2(columns) / 2.0))


def _inverse(sums: Floats) -> Floats:
    return np.where(sums > 0.0, 1.0 / np.where(sums > 0.0, sums, 1.0), 1.0)


def _usual(sizes: Floats, none: Floats, largest: float) -> tuple[int, float, Mask]:
    """Return the rank, its smallest singular value relative to the largest of all, and which samples are near that."""
    ranks = (sizes > none).sum(axis=1)
    rank = int(ranks.max(initial=0))
    if not rank:
        return 0, 1.0, np.ones(len(sizes), dtype=bool)
    smallest = sizes[:, rank - 1]
    return rank, float(smallest.max()) / largest, smallest >= GOOD * smallest.max()


def _rows(matrices: Floats) -> Floats:
    """The largest norm of each row among matrices (k, rows, columns)."""
    return np.asarray(np.sqrt((matrices**2).sum(axis=2)).max(axis=0, initial=0.0))


def rank_changes(A: Floats, decomposition: tuple[Floats, ...], rank: int) -> Floats:
    """Return (N,) for each sample at what part of the way from the one before it A loses its usual rank; else NaN.

    Along a smooth motion A = U S V^T has smooth singular values that may change their sign: from a sample to the next
    one, A_2, the eigenvalues of S^-1 U^T A_2 V are near 1 but for those, which become negative. That takes a change of
    A of at least the smallest of them, so that few pairs are looked at.
    """
    found = np.full(len(A), np.nan)
    if not rank or len(A) < 2:
        return found
    left, sizes, right = (part[:-1] for part in decomposition)
    smallest, step = sizes[:, rank - 1], np.sqrt(((A[1:] - A[:-1]) ** 2).sum(axis=(1, 2)))
    pairs = np.flatnonzero((smallest <= step) & (smallest > np.finfo(float).eps * sizes[:, 0]))
    if len(pairs):
        turned = left[pairs][:, :, :rank].transpose(0, 2, 1) @ A[pairs + 1] @ right[pairs][:, :rank].transpose(0, 2, 1)
        least = np.linalg.eigvals(turned / sizes[pairs][:, :rank, None]).real.min(axis=1)
        lost = least < 0.0
        found[pairs[lost] + 1] = 1.0 / (1.0 - least[lost])
    return found


class TorqueDistribution(NamedTuple):
    """For N samples: multipliers (N, m), torques (N, a) of the actuated rates, and

    Attributes:
        unbalanced: (N, p) generalised forces that the motion needs at passive rates and that nothing gives.
        smallest: (N,) the rank-th singular value of the equilibrated A, relative to `Structure.largest`; 1 for rank 0.
        singular: (N,) where the rank of A or of B drops: what is lost carries nothing, and the multipliers are the
            least in equilibrated units, and not the limit of those beside.
        higher: (N,) where A has a higher rank than at all reference samples: the structure is another.
        A, decomposition: (N, p, m) equilibrated, and its singular values, for `rank_changes`.
    """

    multipliers: Floats
    torques: Floats
    unbalanced: Floats
    smallest: Floats
    singular: Mask
    higher: Mask
    A: Floats
    decomposition: tuple[Floats, Floats, Floats]


def torque_distribution(found: Structure, J: Floats, tau: Floats, weights: Floats) -> TorqueDistribution:
    """Return the forces of constraints and the torques of drives: `tau = S_a torques + J^T multipliers`.

    At passive rates `A multipliers = tau_P`, with the least equilibrated remainder; of all solutions that with the
    least sum of weights times torques^2, and of those with the same torques that with the least sum of multipliers^2,
    whatever their units (N and N m alike).

    Method: `multipliers = A^+ tau_P + N z` of the equilibrated A at its usual rank, by singular values (Udwadia and
    Kalaba 1992; Featherstone 2008, sections 8.3 and 8.12, without redundant actuation).

    Args:
        J: (N, m, n), tau: (N, n) of the robot without constraints, weights: (a,) of the torques' squares, all > 0.

    Accuracy: 2000 eps of the largest torque where the equilibrated A, B and the weights' square roots have conditions
        of at most 10, and in proportion to these.
    """
    passive, rank = found.passive, found.rank
    scaled, forces = J * found.equation_scale[:, None] * found.rate_scale, tau * found.rate_scale
    A = scaled[:, :, passive].transpose(0, 2, 1)
    left, sizes, right = parts = np.linalg.svd(A)
    kept = sizes[:, :rank] > LOST * found.usual * found.largest
    singular: Mask = ~np.all(kept, axis=1)
    given = einsum("nij,ni->nj", left[:, :, :rank], forces[:, passive])
    x = einsum("nij,ni->nj", right[:, :rank], np.where(kept, given / np.where(kept, sizes[:, :rank], 1.0), 0.0))
    open_forces = np.where(singular[:, None, None], 0.0, right[:, rank:].transpose(0, 2, 1))
    if found.redundancy:
        drive = scaled[:, :, ~passive].transpose(0, 2, 1)
        roots = np.sqrt(weights / weights.max()) / found.rate_scale[~passive]
        wanted = forces[:, ~passive] - einsum("nij,nj->ni", drive, x)
        # z has the least weighted torques `wanted - B z`, 0 where B has lost rank; what is left open changes none
        B, b = drive @ open_forces, found.redundancy
        sizes_of_B = np.linalg.svd(B, compute_uv=False)[:, :b]
        lost: Mask = ~np.all(sizes_of_B > LOST * found.usual_redundancy * found.largest, axis=1)
        left_of_B, sizes_of_B, right_of_B = np.linalg.svd(B * roots[:, None])
        along = einsum("nij,ni->nj", left_of_B[:, :, :b], wanted * roots)
        along = along / np.where(lost[:, None], 1.0, sizes_of_B[:, :b])
        z = np.where(lost[:, None], 0.0, einsum("nij,ni->nj", right_of_B[:, :b], along))
        x, singular = x + einsum("nij,nj->ni", open_forces, z), singular | lost
        open_forces = np.where(singular[:, None, None], 0.0, open_forces @ right_of_B[:, b:].transpose(0, 2, 1))
    left_over = (forces - einsum("nij,ni->nj", scaled, x)) / found.rate_scale
    multipliers = x * found.equation_scale
    if open_forces.shape[2]:
        basis = np.linalg.qr(open_forces * found.equation_scale[:, None])[0]
        shortest = multipliers - einsum("nij,nj->ni", basis, einsum("nij,ni->nj", basis, multipliers))
        multipliers = np.where(singular[:, None], multipliers, shortest)
    multipliers = np.where(J.any(axis=2), multipliers, 0.0)
    over = sizes[:, rank : rank + 1].max(axis=1, initial=0.0) > max(LOST, found.none) * found.largest
    smallest = sizes[:, rank - 1] / found.largest if rank else np.ones(len(tau))
    torques, unbalanced = left_over[:, ~passive], left_over[:, passive]
    return TorqueDistribution(multipliers, torques, unbalanced, smallest, singular, over, A, parts)
