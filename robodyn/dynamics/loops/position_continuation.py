"""Motions of closed chains of which not all coordinates are given: the others follow, block by block."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from robodyn.dynamics.initial_state import check_dropped, nearby
from robodyn.dynamics.loops.branch import FEW, OFF, UNREACHED, Branch, begin, block_equations, given, search, singular
from robodyn.dynamics.plan import Plan
from robodyn.errors import Caveat, TrajectoryError
from robodyn.support.floats import Floats, einsum
from robodyn.support.linear import pseudo_inverse

RATES = ("", "/s", "/s^2")
SHARE = 0.05
"""Of the largest sum of |J_k qd_k| along the motion, or of |J_k qdd_k| and |J_k qd_k| max |qd|: rates that miss by more
are not those of a closed chain."""
NOTED = 1e-3
"""rad, or of the loops' size, from which on it is said that loops are open."""
ENTRIES = 2_000_000
"""Of J in one piece of a block: some 50 MB of work."""
ROUNDING = 1e-12
"""Of the largest sum of terms in a sample: what is smaller is what rounding leaves of a rate that is 0."""
BACK = 1e-4
"""Ratio of `pseudo_inverse` where a row that is not reached is one at which what follows turns back."""


class Misfit(NamedTuple):
    """The largest |phi| of a loop, or of a derivative, as a share of the loops' size or of 1 rad, and when [s]."""

    share: float
    size: float
    unit: str
    loop: str
    time: float


class Whole(NamedTuple):
    """Samples with all coordinates; `bars` for each that was given, (N, n) of all coordinates."""

    q: Floats
    qd: Floats
    qdd: Floats
    bars: tuple[Floats, ...]


class Follow:
    """Completes a motion, block after block: what is not given follows from the loops."""

    def __init__(self, plan: Plan, followed: Sequence[str] = (), file: str | None = None) -> None:
        """Args: followed: joints that follow from the others; TrajectoryError if one is in no loop."""
        self.plan, self.file = plan, file
        self.equations = block_equations(plan)
        joints = [joint for joint in plan.model.independent if joint.name in followed]
        rates = [joint.rate + k for joint in joints for k in range(6 if joint.kind == "floating" else 1)]
        strange = [plan.model.rates[rate] for rate in rates if rate not in self.equations.rates]
        if strange:
            what = f"no column says where {strange[0]!r} is, and it is in no loop that could tell"
            raise TrajectoryError(what, remedy=f"give q_{strange[0]}, or --hold {strange[0]}=rest", file=file)
        self.branch = Branch(self.equations, rates)
        self._chosen: list[str] = []
        self.misfits: list[Misfit] = []
        self._left, self._sums = np.zeros((2, 3, self.equations.count))
        self._place: Floats | None = None
        self._sign, self._time = 0.0, 0.0
        self._crossed: list[float] = []

    @property
    def notes(self) -> tuple[str, ...]:
        """Which of several branches was taken, and a loop that is open."""
        notes = [*self._chosen]
        for each in self.misfits[:1]:
            if each.share > NOTED:
                notes.append(f'loop "{each.loop}" is open by up to {each.size:.2g} {each.unit} ({each.time:.4g} s)')
        return tuple(notes)

    @property
    def caveats(self) -> tuple[Caveat, ...]:
        """What makes the motion so far doubtful: ways that part, rates that do not go with the loops."""
        found = []
        for order, what in ((1, "velocities"), (2, "accelerations")):
            if self.misfits and (self._left[order] > SHARE * self._sums[order].max(initial=0.0)).any():
                misfit = self.misfits[order]
                said = (
                    f'the {what} given open loop "{misfit.loop}" at {misfit.size:.3g} {misfit.unit} '
                    f"({misfit.time:.4g} s); leave columns out that follow from the loops"
                )
                found.append(Caveat(f"by {what} that the loops do not allow", said))
        if self._crossed:
            times = ", ".join(f"{time:.4g}" for time in self._crossed[:4]) + (", ..." if self._crossed[4:] else "")
            said = (
                f"the loops are singular where the motion passes at {times} s ({len(self._crossed)} in all): ways "
                "part there, and it is assumed to go straight on; columns of more joints would tell"
            )
            found.append(Caveat("by one of several motions that are possible (assumed)", said))
        return tuple(found)

    @np.errstate(all="ignore")
    def take(
        self, time: Floats, q: Floats, qd: Floats, qdd: Floats, bars: Sequence[Floats] = (), first_row: int = 1
    ) -> Whole:
        """Return the samples with what follows: positions along one branch from the block before, rates by

            J_d qd_d = -J_g qd_g,   J_d qdd_d = -J_g qdd_g - J' qd.

        Args:
            time: (N,) s. q: (N, nq). qd, qdd: (N, n); entries of what follows do not count. first_row: as messages
                count.
            bars: (N, n) standard deviations of the given accelerations, each apart from the others; those of what
                follows are sqrt(sum (D_dg bar_g)^2) with D = -J_d^+ J_g.

        Raises:
            TrajectoryError: too little is given, the loops do not close or are singular in a row, or are missed by more
                than OFF.

        Accuracy: |phi| <= 1e-13 of the loops' size; rates 1e-12 of the largest where the loops are well conditioned.
        """
        q, qd, qdd = (np.array(each, dtype=float, order="F") for each in (q, qd, qdd))
        whole = Whole(q, qd, qdd, tuple(bar.copy() for bar in bars))
        try:
            self._close(time, q, first_row)
            pieces = max(ENTRIES // max(self.equations.count * self.plan.model.n, 1), 1)
            for k in range(0, len(time), pieces):
                rows = slice(k, k + pieces)
                part = Whole(q[rows], qd[rows], qdd[rows], tuple(bar[rows] for bar in whole.bars))
                self._rates(time[rows], part, first_row + k)
        except TrajectoryError as error:
            raise TrajectoryError(error.what, remedy=error.remedy, file=self.file) from None
        return whole

    def _close(self, time: Floats, q: Floats, first_row: int) -> None:
        branch, chain = self.branch, self.equations.chain
        if self._place is None:
            self._place = q[0].copy()
            if len(branch.followed):
                self._place, self._chosen = begin(branch, q[0], _where(first_row, time[0]))
            for place in nearby(chain, self._place)[:1] if chain.dropped else []:
                check_dropped(chain, place)
        lost = branch.along(self._place, q) if len(branch.followed) else None
        if lost is not None:
            where = _where(first_row + lost.row, time[lost.row])
            if lost.singular:
                raise singular(branch, where)
            places, missed = search(branch, q[lost.row], lost.place, OFF)
            values = given(branch, q[lost.row])
            if not len(places):
                raise TrajectoryError(f"{where}: {missed} at least with {values}, out of reach", remedy=UNREACHED)
            if pseudo_inverse(self.equations.places(places[:1])[1][:, :, branch.followed])[1][0] <= BACK:
                raise singular(branch, where)
            what = f"{where}: the loops close with {values}, but no way leads there from the row before"
            raise TrajectoryError(what, remedy="give more rows, or columns of more joints")
        self._place = q[-1].copy()

    def _rates(self, time: Floats, part: Whole, first_row: int) -> None:
        branch, equations = self.branch, self.equations
        phi, J = equations.places(part.q)
        shares = np.abs(phi) / equations.scale
        beyond = ~(shares <= OFF).all(axis=1)
        if beyond.any():
            k = int(np.argmax(beyond))
            worst = int(np.argmax(shares[k]))
            unit, least = equations.units[worst], OFF * equations.scale[worst]
            raise TrajectoryError(
                f'{_where(first_row + k, time[k])}: loop "{equations.names[worst]}" is open by '
                f"{abs(phi[k, worst]):.3g} {unit} with these columns, more than {least:.3g} {unit}",
                remedy="correct the columns, or leave some out: what is left out follows from the loops"
                + ("; columns of more joints than needed are given" if len(branch.followed) else ""),
            )
        if len(branch.followed):
            own, others = J[:, :, branch.followed], J[:, :, branch.given]
            inverse, ratio = pseudo_inverse(own)
            self._watch(time, ratio, own, first_row)
            change = -einsum("ndm,nmg->ndg", inverse, others)
            part.qd[:, branch.followed] = _times(change, part.qd[:, branch.given])
            right = equations.bias(part.q, part.qd) + einsum("nmg,ng->nm", others, part.qdd[:, branch.given])
            part.qdd[:, branch.followed] = -_times(inverse, right)
            for bar in part.bars:
                squares = einsum("ndg,ng->nd", change**2, bar[:, branch.given] ** 2)
                bar[:, branch.followed] = np.sqrt(squares)
        if phi.size:
            self._measure(time, phi, J, part)

    def _measure(self, time: Floats, phi: Floats, J: Floats, part: Whole) -> None:
        """Keep the largest that is left of phi (N, equations), phi' = J qd and phi'' = J qdd + J' qd, and of the sums
        of the magnitudes of their terms."""
        of, bias = self.equations, self.equations.bias(part.q, part.qd)
        J, qd, qdd = (each[..., list(of.rates)] for each in (J, part.qd, part.qdd))
        fast = einsum("nmk,nk->nm", np.abs(J), np.abs(qd))
        turning = fast * np.abs(qd).max(axis=1, keepdims=True, initial=0.0)
        sums = (phi, fast, einsum("nmk,nk->nm", np.abs(J), np.abs(qdd)) + turning)
        left = (phi, einsum("nmk,nk->nm", J, qd), einsum("nmk,nk->nm", J, qdd) + bias)
        found = []
        for values, per in zip(left, RATES, strict=True):
            shares = np.abs(values) / of.scale
            k, m = (int(i) for i in np.unravel_index(int(np.argmax(shares)), shares.shape))
            size, unit = float(abs(values[k, m])), f"{of.units[m]}{per}"
            found.append(Misfit(float(shares[k, m]), size, unit, of.names[m], float(time[k])))
        before = self.misfits or found
        self.misfits = [new if new.share > old.share else old for old, new in zip(before, found, strict=True)]
        self._left = np.maximum(self._left, [np.abs(values).max(axis=0) for values in left])
        self._sums = np.maximum(self._sums, [values.max(axis=0) for values in sums])

    def _watch(self, time: Floats, ratio: Floats, own: Floats, first_row: int) -> None:
        """Raise where the loops are singular; remember where they have been between rows: det J_d changes its sign."""
        if (ratio <= FEW).any():
            k = int(np.argmax(ratio <= FEW))
            raise singular(self.branch, _where(first_row + k, time[k]))
        if len(self.branch.followed) == self.equations.count:
            sign = np.sign(np.linalg.det(own))
            signs = np.append(self._sign or sign[0], sign)
            times = np.append(self._time, time)
            self._crossed += [float(0.5 * (times[k] + times[k + 1])) for k in np.flatnonzero(signs[1:] != signs[:-1])]
            self._sign, self._time = float(sign[-1]), float(time[-1])


def _times(A: Floats, x: Floats) -> Floats:
    """A x of each sample; what rounding leaves of nothing beside the largest sum of its terms is 0."""
    found, terms = einsum("nij,nj->ni", A, x), einsum("nij,nj->ni", np.abs(A), np.abs(x))
    return np.where(np.abs(found) <= ROUNDING * terms.max(axis=1, keepdims=True, initial=0.0), 0.0, found)


def _where(row: int, time: float) -> str:
    return f"row {row}, {time:.6g} s"
