"""Velocities and accelerations that a table gives: held against its positions, and how far each can be trusted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from robodyn.errors import Caveat
from robodyn.support.floats import Floats, median
from robodyn.support.wording import figure, shown
from robodyn.trajectory.derivatives.groups import Group, straight
from robodyn.trajectory.motion import NOISE, Sampling, Trajectory, cut

if TYPE_CHECKING:
    from robodyn.trajectory.derivatives.derive import Plan

PIECES, ROWS = 4, 1024  # of a table, that are compared
OFTEN, BEYOND = 0.1, 2.0
"""Share of rows in which accelerations are off by more than so many bars: they are not those of the positions."""
SPEED_OFF = 0.05  # of the rms of velocities from the positions: given ones that are off by more are not these
DOUBTED = 0.02  # of the rms of accelerations: where they are off by less, the error bars say enough
ROUNDING = 1e-6  # of the rms of accelerations: what they may be off by in any case
ALMOST = 1e-2  # of their distance from derivatives of the positions: so near velocities are to simple differences
BETTER = 0.25
"""Of what derivatives of positions leave unexplained of their steps: where what is given leaves less, it is right."""
CLEAR = 0.2  # of the rms of accelerations: where positions leave more open, they do not tell velocities either
EXPLAINED = 0.5  # of squares of what accelerations are off by: if a delay explains more, they lag
_MOVES, _EVEN, _EXACT = 1e-3, 1e-6, 1e-8
"""Of the largest acceleration: rows that accelerate; of steps or accelerations: what is equal; and of speeds."""
KIND = "by velocities and accelerations that are not those of the positions"


def consistent(groups: Sequence[Group], pieces: Sequence[Trajectory]) -> Floats | None:
    """(n,) what accelerations are off by from differences of velocities, None if anything may be wrong: with equal
    steps h, of exact data, `_unexplained_steps` and Simpson's rule must hold in half of the rows that accelerate."""
    found = np.zeros(pieces[0].qdd.shape[1])
    for group in groups:
        if group.kind == "quaternion" or not (group.velocity and group.acceleration):
            return None
        v = group.velocity[0][1]
        for each in pieces:
            qd, qdd, steps = each.qd[:, v], each.qdd[:, v], np.diff(each.time)
            h, off = float(steps.mean()), np.abs(_unexplained_steps(group, each))
            rate = np.abs(qd[2:] - qd[:-2] - h / 3.0 * (qdd[2:] + 4.0 * qdd[1:-1] + qdd[:-2]))
            speed, level = np.abs(qd).max(), np.abs(qdd).max()
            moves = np.abs(qdd[1:-1]) > _MOVES * level
            if not moves.any():
                continue
            apart = median(rate[moves]) / (2.0 * h)
            uneven = np.abs(steps - h).max() > _EVEN * h
            if uneven or median(off[1:][moves]) > _EXACT * h * speed or apart > _EVEN * level:
                return None
            found[v] = max(found[v], apart)
    return found


@dataclass(frozen=True)
class GivenRates:
    """What is given, against the positions. own: how the same is derived from the positions. wrong: columns of qdd that
    positions contradict; their bars are those of what positions tell. open, noise: (n,) of the others: what positions
    leave open, and the standard deviation of their noise."""

    own: Plan
    wrong: NDArray[np.intp]
    open: Floats
    noise: Floats
    caveats: tuple[Caveat, ...]

    @property
    def halo(self) -> int:
        return self.own.halo if len(self.wrong) or self.caveats else 0

    def trusted(self, samples: Trajectory, known: Sampling | None, rows: slice) -> Sampling:
        """How far accelerations of some rows of a block can be trusted, of which those are known that are derived."""
        qdd = samples.qdd[rows]
        if known is None:
            known = Sampling(np.zeros_like(qdd), np.zeros_like(qdd), np.zeros(qdd.shape[1]), (qdd**2).sum(axis=0))
        off, noise = np.maximum(known.off, self.open), np.maximum(known.noise, self.noise)
        if not self.halo:
            return replace(known, off=off, noise=noise)
        from robodyn.trajectory.derivatives.derive import derive

        mine, _, bars = derive(samples, self.own)
        off[:, self.wrong] = np.maximum(known.off, bars[rows])[:, self.wrong]
        return replace(known, off=off, noise=noise, other=(mine.qd[rows], mine.qdd[rows]))


def against_positions(
    groups: Sequence[Group], pieces: Sequence[Trajectory], lacking: Plan | None, encoder_error: float
) -> GivenRates:
    """How what is given agrees with derivatives of the positions; `lacking` is how what is not given is derived."""
    from robodyn.trajectory.derivatives.derivative_selection import estimate
    from robodyn.trajectory.derivatives.derive import derive, plan

    picked = np.unique(np.linspace(0, len(pieces) - 1, PIECES).astype(int))
    some = [cut(pieces[k], 0, min(ROWS, len(pieces[k]))) for k in picked]
    theirs = [piece if lacking is None else derive(piece, lacking)[0] for piece in some]
    own = plan(groups, pieces, "auto", encoder_error)
    ours, _, bars = zip(*(derive(piece, own) for piece in some), strict=True)
    off_qd = np.concatenate([a.qd - b.qd for a, b in zip(theirs, ours, strict=True)])
    off_qdd = np.concatenate([a.qdd - b.qdd for a, b in zip(theirs, ours, strict=True)])
    wrong: list[int] = []
    said: list[tuple[str, str]] = []
    open_, noise = np.zeros(some[0].qdd.shape[1]), np.zeros(some[0].qdd.shape[1])
    for group in groups:
        faults, clear, differences = [], False, False
        if group.kind != "quaternion" and group.velocity:  # of neighbouring positions, not what all positions say
            k = group.velocity[0][1]
            apart_qd = [each.qd[:, k] - np.gradient(straight(group, each)[:, 0], each.time) for each in theirs]
            differences = _rms(np.concatenate(apart_qd)) < ALMOST * _rms(off_qd[:, k])
            # a given vibration is not held against derivatives that take it for noise
            steps = [_rms(np.concatenate([_unexplained_steps(group, x) for x in each])) for each in (theirs, ours)]
            if not differences and steps[0] < BETTER * steps[1]:
                continue
        for _, k in group.acceleration:
            bar, apart = np.concatenate(bars)[:, k], off_qdd[:, k]
            level = _rms(np.concatenate([each.qdd[:, k] for each in ours]))
            noise[k] = estimate([(x.time, x.qdd[:, [k]], x.qdd[:, [k]]) for x in theirs]).sigma
            open_[k] = median(bar) + NOISE * noise[k]
            clear = open_[k] < CLEAR * level
            if differences or np.mean(np.abs(apart) > BEYOND * bar + ROUNDING * level) > OFTEN:
                wrong.append(k)
                noise[k] = _rms(apart)
                rate = np.concatenate([np.gradient(x.qdd[:, k], x.time) for x in ours])  # off by -lag times this
                square = float((rate * rate).sum())
                lag = -float((rate * apart).sum()) / square if square else 0.0
                lags = lag > 0.0 and lag * lag * square > EXPLAINED * float((apart * apart).sum())
                late = f", {figure(1e3 * lag, 2)} ms late" if lags else ""
                fault = f"accelerations are off by {figure(noise[k], 2)} of {figure(level, 2)} (rms){late}"
                faults += [fault] if noise[k] > DOUBTED * level else []
        for _, k in group.velocity:
            off, level = _rms(off_qd[:, k]), _rms(np.concatenate([each.qd[:, k] for each in ours]))
            if clear and off > SPEED_OFF * level:
                faults.append(f"velocities are off by {figure(off, 2)} of {figure(level, 2)} (rms)")
        said += [(group.name, fault) for fault in faults[:1]]
    others = f"; so are those of {len(said) - 1} more" if len(said) > 1 else ""
    remedy = "--derivatives anew derives them from the positions instead"
    caveats = (
        Caveat(KIND, f"{shown(name)}: the {fault} from what its positions say{others}; {remedy}")
        for name, fault in said[:1]
    )
    return GivenRates(own, np.array(wrong, dtype=np.intp), open_, noise, tuple(caveats))


def _unexplained_steps(group: Group, samples: Trajectory) -> Floats:
    """(N - 1,) dq - h (qd0 + qd1) / 2 + h^2 (qdd1 - qdd0) / 12 of steps dq in times h: h^5 / 720 times the fifth
    derivative if velocities and accelerations are those of the positions."""
    v, h = group.velocity[0][1], np.diff(samples.time)
    qd, qdd = samples.qd[:, v], samples.qdd[:, v]
    moved = 0.5 * h * (qd[1:] + qd[:-1]) - h * h / 12.0 * (qdd[1:] - qdd[:-1])
    return np.asarray(np.diff(straight(group, samples)[:, 0]) - moved)


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2)))
