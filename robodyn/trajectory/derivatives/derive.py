"""Missing velocities and accelerations: how each is derived, the deriving, and what too few samples leave open.

The steps: `groups.py` tells which columns are derived from which; `derivative_selection.py` chooses a method for each
by the noise in it; `estimates.py` derives with error bars, from `differentiate.py`; `given_rates.py` holds what the
table gives against its positions.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from robodyn.errors import TrajectoryError
from robodyn.support.floats import Floats, median
from robodyn.trajectory.derivatives.derivative_selection import Selection, select
from robodyn.trajectory.derivatives.estimates import NOISY, Rate, estimated
from robodyn.trajectory.derivatives.groups import Group, source, straight, turns_ahead
from robodyn.trajectory.motion import FEW, Derivation, JointDerivation, Sampling, Trajectory


@dataclass(frozen=True)
class Plan:
    """The groups to derive, how each is derived and trusted, and the account of it."""

    groups: tuple[Group, ...]
    selections: tuple[Selection, ...]
    derivation: Derivation
    notes: tuple[str, ...]

    @property
    def halo(self) -> int:
        """Neighbours that a block needs on either side."""
        return max((selection.halo for selection in self.selections), default=0)

    @property
    def resolutions(self) -> dict[int, tuple[float, float]]:
        """Of columns of q that are derived one by one: step of their grid, and standard deviation of their noise."""
        pairs = zip(self.groups, self.selections, strict=True)
        return {x.rows[0]: (s.noise.quantum, s.noise.sigma) for x, s in pairs if x.source == "q" and len(x.rows) == 1}


def plan(groups: Sequence[Group], pieces: Sequence[Trajectory], mode: str, encoder_error: float = 0.0) -> Plan:
    """How to derive each group.

    Args:
        groups: what is missing.
        pieces: runs of consecutive samples that stand for the table.
        mode: "auto" (see `derivative_selection.select`), "spline", "savgol" or "central".
        encoder_error: amplitude of errors of positions that repeat with the angle.
    """
    selections, accounts, notes = [], [], []
    for group in groups:
        runs = [(piece.time, getattr(piece, group.source)[:, group.rows], straight(group, piece)) for piece in pieces]
        with np.errstate(all="ignore"):
            found = select(runs, group.order, mode, encoder_error if group.source == "q" else 0.0)
        text, noise = found.method.text, found.noise
        turn = 2.0 if group.kind == "quaternion" else 1.0  # w = 2 vec(conj(Q) Qd) doubles the noise of Q's components
        rates = (text if group.velocity else "given", text if group.acceleration else "given")
        selections.append(found)
        accounts.append(JointDerivation(group.name, *rates, group.source, noise.quantum, noise.sigma, turn * found.std))
        notes += [f"{group.name}: {noise.warning}"] * bool(noise.warning)
    return Plan(tuple(groups), tuple(selections), Derivation(tuple(accounts)), tuple(notes))


def derive(samples: Trajectory, plan: Plan) -> tuple[Trajectory, Floats, Floats]:
    """The samples with the missing columns of qd and qdd filled in.

    Returns:
        The samples, and (N, n) each of qdd: the standard deviation that comes of noise, and by how much it may be off.

    Raises:
        TrajectoryError: a derivative is not finite, because stamps almost coincide; or a pause in the stamps is longer
            than the window that smooths.
    """
    _refuse_pauses(samples, plan.selections)
    qd, qdd = samples.qd.copy(order="F"), samples.qdd.copy(order="F")
    noise, off = np.zeros_like(qdd), np.zeros_like(qdd)
    with np.errstate(all="ignore"):
        for group, selection in zip(plan.groups, plan.selections, strict=True):
            values = source(group, samples)
            turns = turns_ahead(values) if group.kind == "continuous" else None
            first, second = estimated(samples.time, values, turns, selection, samples.first_row - 1)
            if group.kind == "quaternion":
                first, second = _of_body(values, first), _of_body(values, second)
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


def _refuse_pauses(samples: Trajectory, selections: Sequence[Selection]) -> None:
    """A polynomial through the ends of two recordings means nothing, and its equations are singular."""
    steps = np.diff(samples.time)
    methods = [selection.method for selection in selections]
    window = min((method.window for method in methods if method.kind in {"savgol", "local"}), default=0)
    if window and len(steps) and steps.max() > window * median(steps):
        row = samples.first_row + int(np.argmax(steps)) + 1
        what = f"row {row}: a pause of {steps.max():.6g} s is longer than the window that smooths the noise"
        raise TrajectoryError(what, remedy="split the trajectory there, or use --derivatives central")


def _of_body(Q: Floats, rate: Rate) -> Rate:
    """2 vec(conj(Q) rate) (N, 3) of unit quaternions x y z w: with Qd it is w, with Qdd it is wd, in body axes.

    The parts of the rate along Q, which come from noise in the norm, drop out. Each component is off by what all
    together are.
    """
    vector, scalar, value = Q[:, :3], Q[:, 3:], rate.value
    body = 2.0 * (scalar * value[:, :3] - value[:, 3:] * vector - np.cross(vector, value[:, :3]))
    noise, off = (np.repeat(2.0 * np.sqrt((part**2).sum(axis=1, keepdims=True)), 3, axis=1) for part in rate[1:])
    return Rate(body, 0.5 * noise, off)


def sampling(samples: Trajectory, plan: Plan, noise: Floats, off: Floats, rows: slice) -> Sampling:
    """By how much derived accelerations of some rows may be off.

    In a table of fewer than 24 rows, any motion that rests in every row is within the bars.

    Args:
        samples: a block, derived, with its neighbours; noise, off: of its derived accelerations (N, n).
    """
    if few := len(samples) < FEW:
        off = np.maximum(off, _guess(samples, plan) + np.abs(samples.qdd))
    derived = {column for group in plan.groups for _, column in group.acceleration}
    off[:, [column for column in range(off.shape[1]) if column not in derived]] = 0.0
    off, noise, qdd = off[rows], noise[rows], samples.qdd[rows]
    with np.errstate(over="ignore"):
        off_squares, squares = ((values**2).sum(axis=0) for values in (off, qdd))
    if len(samples) >= NOISY:  # errors of noisy columns come of noise, not of the number of samples
        pairs = zip(plan.groups, plan.selections, strict=True)
        off_squares[[column for group, own in pairs if own.noisy for _, column in group.acceleration]] = 0.0
    return Sampling(off, noise, off_squares, squares, few and any(group.velocity for group in plan.groups))


def _guess(samples: Trajectory, plan: Plan) -> Floats:
    """(N, n) the largest accelerations of a motion that rests in every row: 6 |dq| / h^2, 2 |dqd| / h."""
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
