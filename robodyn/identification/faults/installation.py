"""How a log was taken: torques that are late, gravity that leans, positions that are misread, by raw samples."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import reduce
from itertools import combinations

import numpy as np

from robodyn.identification.faults.faults import range_basis
from robodyn.identification.log.log import Log, Samples, joined
from robodyn.identification.log.rows import filtered, states
from robodyn.identification.model_selection import Structure, least_squares, whole_system
from robodyn.identification.parameters.regressor_columns import RegressorColumns
from robodyn.programs.vectors import product
from robodyn.scene.scene import Scene
from robodyn.support.floats import Floats, einsum

_SAMPLES, _ROWS, _VALUES = 1 << 17, 3000, 2_000_000
"""Samples that are read, and instants that are compared, of at most so many numbers."""
_MOST, _SHIFTS = 0.15, 60
"""s: delays are looked for up to here, and up to a tenth of a log; so many are compared in either direction."""
CLEAR = 0.6
"""What a delay leaves of the squares at most."""
_BENDS = (0.003, 0.01, 0.03)
"""Of a joint's usual speed times 1 s: displacements over which dry friction may turn its sign, which looks late."""
_LEAN, _ALIKE, _ROUNDS, _SMALL = 1.0, 0.45, 2, 1e-3
"""Degrees that are told, if both halves of a log tell them alike but for a part; rounds; rad of differences."""
_INSTANTS, _JOINTS, _FEWEST, _WHOLE, _CLEAR = 400, 8, 100, 1e-6, 1.0 / 16.0
"""Instants and joints at which other readings of positions are tried; what of a torque that is left out an instant may
hold; and what the right reading leaves at most of the squares of the one at hand, as a product over the joints."""


class Raw:
    """Some instants of logs that are fitted, each until a time `stop` [s]; `late` (n,) is how late torques are [s]."""

    def __init__(self, logs: Sequence[Log], cutoff: float, regressor: RegressorColumns, stop: Sequence[float]) -> None:
        self.regressor, self.logs, self.cutoff = regressor, logs, cutoff
        self.whole = [_until(log, cutoff, end) for log, end in zip(logs, stop, strict=True)]
        count = min(_ROWS, _VALUES // sum(regressor.widths)) // len(logs)
        self.some = [slice(None, None, 1 + len(each.time) // max(count, 1)) for each in self.whole]
        few = reduce(joined, (each.cut(own, True) for each, own in zip(self.whole, self.some, strict=True)))
        self.few = few._replace(tau=np.zeros_like(few.tau))  # torques that are left out may be there some time later
        self.late = np.zeros(regressor.model.n)

    def delays(self) -> Floats:
        """Return (n,) the delay of each torque that leaves least of it [s]; 0 unless it is clear.

        Each torque some time later is fitted by all columns of its joint, free of other joints, and by dry friction
        that turns its sign over a displacement.
        """
        step = self.logs[0].step
        reach = min(_MOST, 0.1 * min(log.stop - log.start for log in self.logs))
        step *= max(1, round(reach / (_SHIFTS * step)))
        shifts = np.asarray(step * np.arange(-int(reach / step), int(reach / step) + 1), dtype=float)
        pairs = zip(self.whole, self.some, self.logs, strict=True)
        slow = np.concatenate([_presliding(whole, log.step)[own] for whole, own, log in pairs])
        parts = self.regressor.by_joint(self.regressor.compute(self.few))
        for j, columns in zip(self.regressor.measured, parts, strict=True):
            late = self._later(shifts, j)
            there = np.isfinite(late).all(axis=1)
            if there.sum() > 2 * columns.shape[1]:
                own = np.concatenate([columns[:, :-2], slow[:, j]], axis=1)[there]
                self.late[j] = _best(shifts, own, late[there] - columns[there, -2:-1])
        return self.late

    def leaning(self, structure: Structure, theta: Floats, sigma: Floats, scene: Scene) -> list[str]:
        """Return in words how gravity leans beside that of the scene, if both halves of the instants tell it alike. Two
        angles about axes across gravity are fitted with all parameters, to first order, and anew near the fit."""
        g = np.array(scene.gravity, dtype=float)
        if not g.any():
            return []
        across = np.linalg.svd(g[None])[2][1:] * np.linalg.norm(g)
        angles, halves = np.zeros(2), np.zeros((2, 2))
        for _ in range(_ROUNDS):
            here = g + angles @ across
            Y, z = self._weighted(structure, sigma, here)
            leans = [self._weighted(structure, sigma, here + _SMALL * way)[0] - Y for way in across]
            rows = np.column_stack((Y, *(each @ theta / _SMALL for each in leans), z))
            names, half = (*structure.names, "lean.first", "lean.second"), len(rows) // 2
            parts = rows[:half], rows[half:]
            halves = angles + [least_squares(*whole_system([part], names))[-2:] for part in parts]
            found = least_squares(*whole_system([rows], names))
            theta, angles = found[:-2], angles + found[-2:]
        size = float(np.linalg.norm(angles))
        differ = float(np.linalg.norm(halves - angles, axis=1).max())
        if not _LEAN < np.degrees(size) < 90.0 or differ > _ALIKE * size:
            return []
        way = g + angles @ across
        said = ",".join(f"{x:.3g}" for x in way * np.linalg.norm(g) / np.linalg.norm(way))
        what = f"torques fit gravity that leans by {np.degrees(np.arctan(size)):.2g} degrees"
        return [f"{what}: does the base stand tilted? then --gravity {said}"]

    def misread(self, structure: Structure, sigma: Floats) -> list[str]:
        """Return in words how positions are misread, if the torques tell.

        Of the joints that are explained worst, every position with the other sign, with and without its torque's, and
        every two exchanged, with and without their torques, are put in the place of those of the log, and base
        parameters and motors are fitted anew. The best one counts if the squares that it leaves, multiplied over the
        joints, are less than `_CLEAR` of those as they are. Joints whose positions are quaternions are left out.
        """
        model, measured = self.regressor.model, self.regressor.measured
        if model.nq != model.n:
            return []
        rows = _instants([replace(log, delays=self.late) for log in self.logs], self.cutoff)
        if len(rows.time) < _FEWEST:
            return []
        before = _left_by_joint(rows, structure, sigma)
        size = np.array([np.sum(rows.tau[:, j] ** 2) for j in measured]) / sigma**2
        worst = sorted(np.argsort(-before / np.maximum(size, 1e-300), kind="stable")[:_JOINTS].tolist())
        best, words = np.log(_CLEAR), []
        for order, sign, torques, said in _readings(model.rates, [measured[place] for place in worst]):
            q, qd, qdd = (each[:, order] * sign for each in (rows.q, rows.qd, rows.qdd))
            along = rows.tau[:, order] * sign if torques else rows.tau
            after = _left_by_joint(Samples(rows.time, q, qd, qdd, along, True), structure, sigma)
            ratio = float(np.log(after / before).sum())
            if ratio < best:
                best, words = ratio, [said]
        return words

    def _weighted(self, structure: Structure, sigma: Floats, gravity: Floats) -> tuple[Floats, Floats]:
        """Return columns of the parameters (k, p) and torques (k,) of all instants, joint by joint in each."""
        regressor, shape = structure.regressor.under(tuple(gravity.tolist())), structure.shape
        parts = regressor.by_joint(regressor.compute(self.few))
        Y, z = [], []
        for j, used, columns, scale in zip(regressor.measured, regressor.used, parts, sigma, strict=True):
            late = self._later(self.late[j : j + 1], j)
            there = np.isfinite(late)
            Y.append(np.where(there, columns[:, :-2] @ shape[used], 0.0) / scale)
            z.append(np.where(there, late - columns[:, -2:-1], 0.0)[:, 0] / scale)
        return np.stack(Y, axis=1).reshape(-1, len(structure.names)), np.stack(z, axis=1).ravel()

    def _later(self, shifts: Floats, j: int) -> Floats:
        """Return (k, shifts) the torque of a joint later than at the instants, NaN outside of the log."""
        found = []
        for each, own in zip(self.whole, self.some, strict=True):
            found.append(np.interp(each.time[own, None] + shifts, each.time, each.tau[:, j], np.nan, np.nan))
        return np.concatenate(found)


def _until(log: Log, cutoff: float, stop: float) -> Samples:
    """Return the samples of a log until some time, not more than some hundred thousand."""
    found: list[Samples] = []
    for part in states(log, cutoff):
        found.append(part.cut(slice(0, int(np.searchsorted(part.time, stop))), part.begins))
        if part.time[-1] >= stop or sum(len(each.time) for each in found) > _SAMPLES:
            break
    return reduce(joined, found)


def _presliding(whole: Samples, step: float) -> Floats:
    """Return (k, n, `_BENDS`) the sign of dry friction that turns over a displacement s: dz/dq = (sign(qd) - z) / s."""
    size = np.sqrt(np.mean(whole.qd**2, axis=0))
    s = np.multiply.outer(np.where(size > 0.0, size, 1.0), _BENDS)
    stay = np.exp(-step * np.abs(whole.qd)[..., None] / s)
    z, found = np.zeros(s.shape), np.empty(stay.shape)
    for k, sign in enumerate(np.sign(whole.qd)[..., None]):
        z = sign + (z - sign) * stay[k]
        found[k] = z
    return found


def _best(shifts: Floats, columns: Floats, targets: Floats) -> float:
    """Return where columns (k, w) leave least of targets (k, shifts), if that is inside and much less than at 0. The
    least is that of a parabola between the shifts."""
    Q = range_basis(columns)
    rest = targets - Q @ (Q.T @ targets)
    left = einsum("ks,ks->s", rest, rest)
    k = int(np.argmin(left))
    if not 0 < k < len(shifts) - 1 or left[k] > CLEAR * left[len(left) // 2]:
        return 0.0
    before, least, after = left[k - 1 : k + 2]
    bend = before - 2.0 * least + after
    place = 0.5 * (before - after) / bend if bend > 0.0 else 0.0
    return float(f"{shifts[k] + place * (shifts[1] - shifts[0]):.3g}")


def _readings(names: Sequence[str], joints: Sequence[int]) -> Iterator[tuple[list[int], Floats, bool, str]]:
    """Yield which rate's columns are read as each rate's, with which sign, whether torques go along, and the words."""
    as_is, ahead = list(range(len(names))), np.ones(len(names))
    for torques, what, has in ((False, "the measured position", "has"), (True, "position and torque", "have")):
        for j in joints:
            sign = np.where(np.arange(len(names)) == j, -1.0, 1.0)
            yield as_is, sign, torques, f"{what} of {names[j]} {has} the wrong sign"
        for i, j in combinations(joints, 2):
            order = as_is.copy()
            order[i], order[j] = j, i
            yield order, ahead, torques, f"{what if torques else what + 's'} of {names[i]} and {names[j]} are exchanged"


def _instants(logs: Sequence[Log], cutoff: float) -> Samples:
    """Return some hundred instants of the logs, around which no torque is left out: all through the same filter."""

    def motion(samples: Samples) -> Floats:
        lost = np.repeat(np.isnan(samples.tau).any(axis=1, keepdims=True), samples.q.shape[1], axis=1)
        return np.stack((samples.q, samples.qd, samples.qdd, lost), axis=1)

    parts = [rows for log in logs for rows in filtered(log, cutoff, motion)]
    time, motions, tau = (np.concatenate([getattr(part, name) for part in parts]) for name in parts[0]._fields)
    whole = np.flatnonzero(np.abs(motions[:, 3]).max(axis=1) < _WHOLE)
    some = whole[:: 1 + len(whole) // _INSTANTS]
    q, qd, qdd, _ = motions[some].swapaxes(0, 1)
    return Samples(time[some], q, qd, qdd, tau[some], True)


def _left_by_joint(rows: Samples, structure: Structure, sigma: Floats) -> Floats:
    """Return (joints,) the squares that least squares leave, not less than rounding."""
    regressor, shape = structure.regressor, structure.shape
    parts, pairs = regressor.by_joint(regressor.compute(rows)), []
    for j, used, columns, scale in zip(regressor.measured, regressor.used, parts, sigma, strict=True):
        pairs.append((product(columns[:, :-2], shape[used]) / scale, (rows.tau[:, j] - columns[:, -2]) / scale))
    R, z = whole_system([np.column_stack(pair) for pair in pairs], structure.names)
    theta = least_squares(R, z, structure.driving)
    return np.array([np.sum((product(Y, theta) - z) ** 2) + 1e-20 * np.sum(z * z) + 1e-300 for Y, z in pairs])
