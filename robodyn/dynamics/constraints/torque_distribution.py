"""The forces of loops and the torques of drives that a motion takes: linear equations whose rank is decided once."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from robodyn.dynamics.constraints.structure import Mask, Structure, svd, times
from robodyn.programs.stacked import least_squares, orthogonal
from robodyn.support.floats import Floats
from robodyn.support.sums import einsum

LOST = 1e-6
"""A singular value below this part of its usual size is lost at a sample: nothing is divided by it."""


class TorqueDistribution(NamedTuple):
    """For N samples.

    Attributes:
        multipliers: (N, m) forces along the equations: they add J^T multipliers to the torques of the drives.
        torques: (N, a) of the actuated rates.
        unbalanced: (N, p) generalised forces that the motion needs at passive rates and that nothing gives.
        smallest: (N,) the rank-th singular value of the equilibrated A, relative to `Structure.largest`; 1 for rank 0.
        singular: (N,) where the rank of A or of B drops. What is lost there carries nothing, and nothing is chosen:
            the multipliers are the least in equilibrated units, and not the limit of those beside.
        higher: (N,) where A has a higher rank than at all reference samples: the structure is another.
    """

    multipliers: Floats
    torques: Floats
    unbalanced: Floats
    smallest: Floats
    singular: Mask
    higher: Mask


def torque_distribution(found: Structure, J: Floats, tau: Floats, weights: Floats) -> TorqueDistribution:
    """Return the forces of constraints and the torques of drives: `tau = S_a torques + J^T multipliers`.

    At passive rates `A multipliers = tau_P`; where that has no solution, the equilibrated remainder is the least that
    there is. Of all solutions the one with the least sum of weights times torques^2 is taken, and of those with the
    same torques the one with the least sum of multipliers^2, whatever their units (N and N m alike).

    Method: `multipliers = A^+ tau_P + N z` of the equilibrated A at its usual rank (Udwadia and Kalaba 1992;
    Featherstone 2008, sections 8.3 and 8.12, without redundant actuation), by reflections in an order of operations
    that no processor changes. Singular values, truncated, serve where the rank drops, and tell where.

    Args:
        found: of this motion.
        J: (N, m, n), the constraints' J qd = 0.
        tau: (N, n) of the robot without them.
        weights: (a,) of the actuated torques' squares, all > 0.

    Accuracy: 2000 eps of the largest torque where the equilibrated A, B and the weights' square roots have conditions
    of at most 10, and in proportion to these.
    """
    passive, rank = found.passive, found.rank
    scaled, forces = found.scaled(J), tau * found.rate_scale
    A = scaled[:, :, passive].transpose(0, 2, 1)
    left, sizes, right = svd(A)
    kept = sizes[:, :rank] > LOST * found.usual * found.largest
    singular: Mask = ~np.all(kept, axis=1)
    Q = orthogonal(A.transpose(0, 2, 1))
    x = _along(Q[:, :, :rank], solved(times(A, Q[:, :, :rank]), forces[:, passive]))
    if singular.any():
        given = einsum("nij,ni->nj", left[singular][:, :, :rank], forces[singular][:, passive])
        found_there = _divided(given, sizes[singular][:, :rank], kept[singular])
        x[singular] = einsum("nij,ni->nj", right[singular][:, :rank], found_there)
    open_forces = np.where(singular[:, None, None], 0.0, Q[:, :, rank:])
    if found.redundancy:
        drive = scaled[:, :, ~passive].transpose(0, 2, 1)
        roots = np.sqrt(weights / weights.max()) / found.rate_scale[~passive]
        wanted = forces[:, ~passive] - _along(drive, x)
        z, free, lost = _least_torque(times(drive, open_forces), wanted, roots, found)
        x, singular = x + _along(open_forces, z), singular | lost
        open_forces = np.where(singular[:, None, None], 0.0, times(open_forces, free))
    left_over = (forces - einsum("nij,ni->nj", scaled, x)) / found.rate_scale
    multipliers = _shortest(x * found.equation_scale, open_forces * found.equation_scale[:, None], singular)
    multipliers = np.where(J.any(axis=2), multipliers, 0.0)
    over = sizes[:, rank : rank + 1].max(axis=1, initial=0.0) > max(LOST, found.none) * found.largest
    smallest = sizes[:, rank - 1] / found.largest if rank else np.ones(len(tau))
    return TorqueDistribution(multipliers, left_over[:, ~passive], left_over[:, passive], smallest, singular, over)


def _least_torque(B: Floats, wanted: Floats, roots: Floats, found: Structure) -> tuple[Floats, Floats, Mask]:
    """Return z (N, k) with the least weighted torques `wanted - B z`, a basis (N, k, k - b) of the z that do nothing
    to them, and where B has lost rank; z is 0 there."""
    b = found.redundancy
    sizes = svd(B)[1]
    lost: Mask = ~np.all(sizes[:, :b] > LOST * found.usual_redundancy * found.largest, axis=1)
    weighted = B * roots[:, None]
    Q = orthogonal(weighted.transpose(0, 2, 1))
    z = _along(Q[:, :, :b], solved(times(weighted, Q[:, :, :b]), wanted * roots))
    return np.where(lost[:, None], 0.0, z), Q[:, :, b:], lost


def solved(A: Floats, b: Floats) -> Floats:
    """Return (N, k) the least-squares solutions of A x = b, A (N, m, k) of full rank."""
    return least_squares(A, b[:, :, None]).x[:, :, 0]


def _shortest(multipliers: Floats, free: Floats, singular: Mask) -> Floats:
    """Return the multipliers without what lies in the span of `free` (N, m, k); as they are where singular."""
    if not free.shape[2]:
        return multipliers
    changed = multipliers - _along(free, solved(free, multipliers))
    return np.where(singular[:, None], multipliers, changed)


def _divided(values: Floats, sizes: Floats, kept: Mask) -> Floats:
    return np.where(kept, values / np.where(kept, sizes, 1.0), 0.0)


def _along(A: Floats, x: Floats) -> Floats:
    return np.asarray(einsum("nij,nj->ni", A, x))
