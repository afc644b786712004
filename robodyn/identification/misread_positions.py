"""Gross faults of logs: positions of joints exchanged, and positions with the wrong sign."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations

import numpy as np

from robodyn.identification.log import Log
from robodyn.identification.rows import filtered
from robodyn.identification.samples import Samples
from robodyn.identification.structure import Structure, least_squares, whole_system
from robodyn.programs.vectors import product
from robodyn.support.floats import Floats

_ROWS, _JOINTS = 400, 8
_FEWEST, _WHOLE = 100, 1e-6
_CLEAR = 1.0 / 16.0
"""What the right reading leaves at most of the squares of the one at hand, as a product over the joints."""


def misread(logs: Sequence[Log], cutoff: float, structure: Structure, sigma: Floats) -> list[str]:
    """Return in words how positions are misread, if the torques tell.

    Of the joints that are explained worst, every position with the other sign, with and without its torque's, and every
    two exchanged, with and without their torques, are put in the place of those of the log, and base parameters and
    motors are fitted anew. The best one counts if the squares that it leaves, multiplied over the joints, are less
    than `_CLEAR` of those as they are. Robots with joints whose positions are quaternions are left out.

    Args:
        logs: that are fitted; sigma: (joints,) of residuals as they are [N m].
    """
    model = structure.atoms.model
    if model.nq != model.n:
        return []
    rows = _rows(logs, cutoff)
    if len(rows.time) < _FEWEST:
        return []
    before = _left(rows, structure, sigma)
    size = np.array([np.sum(rows.tau[:, j] ** 2) for j in structure.atoms.measured]) / sigma**2
    worst = sorted(np.argsort(-before / np.maximum(size, 1e-300), kind="stable")[:_JOINTS].tolist())
    best, words = np.log(_CLEAR), []
    for order, sign, torques, said in _readings(model.rates, [structure.atoms.measured[place] for place in worst]):
        tau = rows.tau[:, order] * sign if torques else rows.tau
        q, qd, qdd = (each[:, order] * sign for each in (rows.q, rows.qd, rows.qdd))
        after = _left(Samples(rows.time, q, qd, qdd, tau, True), structure, sigma)
        ratio = float(np.log(after / before).sum())
        if ratio < best:
            best, words = ratio, [said]
    return words


def _readings(names: Sequence[str], joints: Sequence[int]) -> Iterator[tuple[list[int], Floats, bool, str]]:
    """Yield which rate's columns are read as each rate's, with which sign, whether torques go along, and the words."""
    as_is = list(range(len(names)))
    for torques, what, verb in ((False, "the measured position", "s"), (True, "position and torque", "")):
        for j in joints:
            sign = np.where(np.arange(len(names)) == j, -1.0, 1.0)
            yield as_is, sign, torques, f"{what} of {names[j]} ha{verb or 've'} the wrong sign"
        for i, j in combinations(joints, 2):
            order = as_is.copy()
            order[i], order[j] = j, i
            said = f"{what}{verb} of {names[i]} and {names[j]} are exchanged"
            yield order, np.ones(len(names)), torques, said


def _rows(logs: Sequence[Log], cutoff: float) -> Samples:
    """Return some hundred instants of the logs, around which no torque is left out: all through the same filter."""

    def motion(samples: Samples) -> Floats:
        lost = np.repeat(np.isnan(samples.tau).any(axis=1, keepdims=True), samples.q.shape[1], axis=1)
        return np.stack((samples.q, samples.qd, samples.qdd, lost), axis=1)

    parts = [rows for log in logs for rows in filtered(log, cutoff, motion)]
    time, motions, tau = (np.concatenate([getattr(part, name) for part in parts]) for name in parts[0]._fields)
    whole = np.flatnonzero(np.abs(motions[:, 3]).max(axis=1) < _WHOLE)
    some = whole[:: 1 + len(whole) // _ROWS]
    q, qd, qdd, _ = motions[some].swapaxes(0, 1)
    return Samples(time[some], q, qd, qdd, tau[some], True)


def _left(rows: Samples, structure: Structure, sigma: Floats) -> Floats:
    """Return (joints,) the squares that least squares leave, not less than rounding."""
    atoms, shape = structure.atoms, structure.shape
    parts, pairs = np.split(atoms.compute(rows), np.cumsum(atoms.widths)[:-1], axis=1), []
    for j, used, columns, scale in zip(atoms.measured, atoms.used, parts, sigma, strict=True):
        pairs.append((product(columns[:, :-2], shape[used]) / scale, (rows.tau[:, j] - columns[:, -2]) / scale))
    theta = _possible(*whole_system([np.column_stack(pair) for pair in pairs], structure.names), structure.names)
    return np.array([np.sum((product(Y, theta) - z) ** 2) + 1e-20 * np.sum(z * z) + 1e-300 for Y, z in pairs])


def _possible(R: Floats, z: Floats, names: Sequence[str]) -> Floats:
    """Return least squares in which viscous and Coulomb friction and rotors are not negative."""
    from scipy.optimize import nnls

    signed = np.array([name.rpartition(".")[2] in ("viscous", "coulomb", "rotor") for name in names])
    free, bound = R[:, ~signed], R[:, signed]
    right = np.column_stack((bound, z))
    rest = right - product(free, least_squares(free, right))
    lengths = np.linalg.norm(rest[:, :-1], axis=0)
    lengths[lengths == 0.0] = 1.0
    theta = np.zeros(len(names))
    theta[signed] = nnls(rest[:, :-1] / lengths, rest[:, -1])[0] / lengths
    theta[~signed] = least_squares(free, z - product(bound, theta[signed]))
    return theta
