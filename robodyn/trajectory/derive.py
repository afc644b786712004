"""Missing velocities and accelerations: how each is derived, the deriving, and what too few samples leave open."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from robodyn.errors import TrajectoryError
from robodyn.support.floats import Floats, median
from robodyn.trajectory.adaptive import Rate
from robodyn.trajectory.choose import Diagnosis, diagnose
from robodyn.trajectory.derivatives import Method
from robodyn.trajectory.estimates import NOISY, Trust, estimated, reach
from robodyn.trajectory.groups import Group
from robodyn.trajectory.motion import FEW, Derivation, JointDerivation, Sampling, Trajectory


@dataclass(frozen=True)
class Plan:
    """The groups to derive with the method of each and how it is trusted, and the account of it."""

    groups: tuple[Group, ...]
    methods: tuple[Method, ...]
    trusts: tuple[Trust, ...]
    derivation: Derivation
    notes: tuple[str, ...]

    @property
    def halo(self) -> int:
        """Neighbours that a block needs on either side."""
        own = max((method.halo for method in self.methods), default=0)
        return max(own, *(reach(trust) for trust in self.trusts)) if self.trusts else 0

    @property
    def resolutions(self) -> dict[int, tuple[float, float]]:
        """Of columns of q that are derived one by one: step of their grid, and standard deviation of their noise."""
        pairs = zip(self.groups, self.derivation.joints, strict=True)
        return {x.rows[0]: (own.quantum, own.noise) for x, own in pairs if x.source == "q" and len(x.rows) == 1}


def plan(groups: Sequence[Group], pieces: Sequence[Trajectory], mode: str, encoder_error: float = 0.0) -> Plan:
    """How to derive each group.

    Args:
        groups: what is missing.
        pieces: runs of consecutive samples that stand for the table.
        mode: "auto" (see `choose.diagnose`), "spline", "savgol" or "central".
        encoder_error: amplitude of errors of positions that repeat with the angle.
    """
    with np.errstate(all="ignore"):
        found = [_diagnose(group, pieces, mode, encoder_error) for group in groups]
    accounts = tuple(_account(group, diagnosis) for group, diagnosis in zip(groups, found, strict=True))
    notes = tuple(f"{group.name}: {d.warning}" for group, d in zip(groups, found, strict=True) if d.warning)
    methods, trusts = tuple(each.method for each in found), tuple(each.trust for each in found)
    return Plan(tuple(groups), methods, trusts, Derivation(accounts), notes)


def _diagnose(group: Group, pieces: Sequence[Trajectory], mode: str, encoder_error: float) -> Diagnosis:
    order = 2 if group.acceleration and group.source == "q" else 1
    runs = [(piece.time, _raw(group, piece), straight(group, piece)) for piece in pieces]
    return diagnose(runs, order, mode, encoder_error if group.source == "q" else 0.0)


def _account(group: Group, found: Diagnosis) -> JointDerivation:
    text = found.method.text
    turn = 2.0 if group.kind == "quaternion" else 1.0  # w = 2 vec(conj(Q) Qd) doubles the noise of Q's components
    return JointDerivation(
        name=group.name,
        velocity=text if group.velocity else "given",
        acceleration=text if group.acceleration else "given",
        source=group.source,
        quantum=found.quantum,
        noise=found.noise,
        std=turn * found.std,
    )


def derive(samples: Trajectory, plan: Plan) -> tuple[Trajectory, Floats, Floats]:
    """Return the samples with the missing columns of qd and qdd filled in.

    Returns:
        The samples, and (N, n) each of qdd: the standard deviation that comes of noise, and by how much it may be off.

    Raises:
        TrajectoryError: a derivative is not finite, because stamps almost coincide; or a pause in the stamps is longer
            than the window that smooths.
    """
    _refuse_pauses(samples, plan.methods)
    qd, qdd = samples.qd.copy(order="F"), samples.qdd.copy(order="F")
    noise, off = np.zeros_like(qdd), np.zeros_like(qdd)
    with np.errstate(all="ignore"):
        for group, first, second in _rates(samples, plan):
            for component, column in group.velocity:
                qd[:, column] = first.value[:, component]
            highest = first if group.source == "qd" else second
            for component, column in group.acceleration:
                for whole, part in zip((qdd, noise, off), highest, strict=True):
                    whole[:, column] = part[:, component]
    for values in (qd, qdd):
        if not np.isfinite(values).all():
            row = samples.first_row + int(np.argwhere(~np.isfinite(values))[0][0])
            raise TrajectoryError(f"row {row}: the derivative is not finite", remedy="are two stamps almost equal?")
    return replace(samples, qd=qd, qdd=qdd), noise, off


def _rates(samples: Trajectory, plan: Plan) -> Iterator[tuple[Group, Rate, Rate]]:
    """Every group with the first and second derivatives of its source, those of one kind and method together."""
    alike: dict[tuple[str, Method, Trust], list[Group]] = {}
    for group, method, trust in zip(plan.groups, plan.methods, plan.trusts, strict=True):
        alike.setdefault((group.kind, method, trust), []).append(group)
    for (kind, method, trust), groups in alike.items():
        values = np.concatenate([_source(group, samples) for group in groups], axis=1)
        turns = _turns(values) if kind == "continuous" else None
        rates, start = estimated(samples.time, values, turns, method, trust, samples.first_row - 1), 0
        for group in groups:
            own = slice(start, start + len(group.rows))
            first, second = (Rate(*(part[:, own] for part in rate)) for rate in rates)
            if kind == "quaternion":
                first, second = _of_body(values[:, own], first), _of_body(values[:, own], second)
            yield group, first, second
            start = own.stop


def _refuse_pauses(samples: Trajectory, methods: Sequence[Method]) -> None:
    """A polynomial through the ends of two recordings means nothing, and its equations are singular."""
    steps = np.diff(samples.time)
    window = min((method.window for method in methods if method.kind in {"savgol", "local"}), default=0)
    if window and len(steps) and steps.max() > window * median(steps):
        row = samples.first_row + int(np.argmax(steps)) + 1
        what = f"row {row}: a pause of {steps.max():.6g} s is longer than the window that smooths the noise"
        raise TrajectoryError(what, remedy="split the trajectory there, or use --derivatives central")


def _raw(group: Group, samples: Trajectory) -> Floats:
    values: Floats = getattr(samples, group.source)
    return values[:, group.rows]


def _source(group: Group, samples: Trajectory) -> Floats:
    """The columns to differentiate (N, c), quaternions with continuous sign."""
    values = _raw(group, samples)
    if group.kind == "quaternion":
        flips = (values[1:] * values[:-1]).sum(axis=1) < 0.0
        sign = np.where(np.concatenate(([0], np.cumsum(flips))) % 2, -1.0, 1.0)
        return values * sign[:, None]
    return values


def straight(group: Group, samples: Trajectory) -> Floats:
    """The same with turns of 2 pi undone."""
    values = _source(group, samples)
    return values - 2.0 * math.pi * _turns(values) if group.kind == "continuous" else values


def _turns(angles: Floats) -> Floats:
    """Whole turns that angles (N, c) are ahead of the shorter way from each to the next.

    Angles that are made to add up would depend on the turns before, and on where a block begins, in their last digits.
    """
    jumps = np.rint(np.diff(angles, axis=0) / (2.0 * math.pi))
    return np.concatenate((np.zeros((1, angles.shape[1])), np.cumsum(jumps, axis=0)))


def _of_body(Q: Floats, rate: Rate) -> Rate:
    """Return the rates in body axes of those of quaternions; each component is off by what all together are."""
    noise, off = (np.repeat(2.0 * np.sqrt((part**2).sum(axis=1, keepdims=True)), 3, axis=1) for part in rate[1:])
    return Rate(_body_rates(Q, rate.value), 0.5 * noise, off)


def _body_rates(Q: Floats, rate: Floats) -> Floats:
    """2 vec(conj(Q) rate) (N, 3) of unit quaternions x y z w: with Qd it is w, with Qdd it is wd, in body axes.

    The parts of the rate along Q, which come from noise in the norm, drop out.
    """
    vector, scalar = Q[:, :3], Q[:, 3:]
    return 2.0 * (scalar * rate[:, :3] - rate[:, 3:] * vector - np.cross(vector, rate[:, :3]))


def sampling(samples: Trajectory, plan: Plan, noise: Floats, off: Floats, rows: slice) -> Sampling:
    """Return by how much derived accelerations of some rows may be off.

    In a table of fewer than 24 rows, any motion that rests in every row is within the bars.

    Args:
        samples: a block, derived, with its neighbours; noise, off: of its derived accelerations (N, n).
    """
    if few := len(samples) < FEW:
        off = np.maximum(off, _guess(samples, plan) + np.abs(samples.qdd))
    off[:, _given(plan, off.shape[1])] = 0.0
    off, noise, qdd = off[rows], noise[rows], samples.qdd[rows]
    with np.errstate(over="ignore"):
        off_squares, squares = ((values**2).sum(axis=0) for values in (off, qdd))
    if len(samples) >= NOISY:
        off_squares[_noisy(plan)] = 0.0
    guessed = few and any(group.velocity for group in plan.groups)
    return Sampling(off, noise, off_squares, squares, guessed)


def _given(plan: Plan, width: int) -> list[int]:
    """Return the columns of qdd that are not derived."""
    derived = {column for group in plan.groups for _, column in group.acceleration}
    return [column for column in range(width) if column not in derived]


def _noisy(plan: Plan) -> list[int]:
    """Return the columns of qdd whose errors come of noise, not of the number of samples."""
    pairs = zip(plan.groups, plan.trusts, strict=True)
    return [column for group, trust in pairs if trust.noisy for _, column in group.acceleration]


def _guess(samples: Trajectory, plan: Plan) -> Floats:
    """Return (N, n) the largest accelerations of a motion that rests in every row: 6 |dq| / h^2, 2 |dqd| / h."""
    guess, steps = np.zeros_like(samples.qdd), np.diff(samples.time)[:, None]
    for group in plan.groups:
        moved = np.abs(np.diff(straight(group, samples), axis=0))
        if group.kind == "quaternion":
            moved = 2.0 * np.sqrt((moved**2).sum(axis=1, keepdims=True)) * np.ones(3)
        needed = 2.0 * moved / steps if group.source == "qd" else 6.0 * moved / steps**2
        for component, column in group.acceleration:
            guess[:-1, column] = needed[:, component]
            guess[1:, column] = np.maximum(guess[1:, column], needed[:, component])
    return guess
