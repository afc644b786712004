"""Least squares of many effects at once, and the honest covariance of what they come to."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from math import log
from typing import NamedTuple

import numpy as np

from robodyn.identification.dependent_columns import (
    DEPENDENT,
    depended_on,
    independent,
    least_squares,
    pseudoinverse,
    wald,
)
from robodyn.identification.fault_columns import DELAY, GAIN, OFFSET, OWN, Evidence, columns, rms
from robodyn.identification.long_run import score_covariance, variance_of_sums, window_length
from robodyn.support.floats import Floats
from robodyn.support.sums import einsum

TOGETHER = 0.1
"""The probability with which noise must explain all effects that are taken for zero."""
BLURRED = 0.03
"""Standard error of a gain, were it the only effect, beyond which neither it nor a delay is looked for."""
CLEAR = 0.05
"""Of a step, the standard error of a delay up to which it is looked for all the same."""
_ROUNDS, _SETTLED = 12, 1e-4
_HALVINGS, _SLACK = 6, 1.0 + 1e-6
ROUNDING = 1e-5
"""Of the measured torques: none is known better, nor are accelerations from positions."""
_LEAST = 0.2
"""Of the variance of noise that is taken to be left by a fit, at least."""
_FAR = 2.0
"""Samples that a delay may move from where the search begins."""


class Effect(NamedTuple):
    """What may explain residuals.

    Attributes:
        kind: one of `OWN`, or "payload".
        joint: whose; None of a payload.
        places: of its parameters among all (see `Evidence`).
    """

    kind: str
    joint: int | None
    places: tuple[int, ...]


def blurred(evidence: Evidence, start: Floats) -> set[int]:
    """Return the places of gains and delays that can hardly be told: where computed torques are next to nothing.

    As the torque that they change is itself estimated there, tests of them would mean nothing. The noise is what each
    joint by itself leaves, with a payload of its own.
    """
    found: set[int] = set()
    for j, each in enumerate(columns(evidence, start)[0]):
        size = rms(each)
        basis, values, _ = np.linalg.svd(each / np.where(size > 0.0, size, 1.0), full_matrices=False)
        basis = basis[:, values > DEPENDENT * values[0]]
        target = evidence.shifted(j, start[len(OWN) * j + DELAY])[:, None]
        rest = target - einsum("ka,ia,ib->kb", basis, basis, target, optimize=True)
        two = each[:, [GAIN, DELAY]]
        scores = np.diag(score_covariance([two], rest, [(0, 1)], 2))
        errors = np.sqrt(np.abs(scores)) / np.maximum(len(two) * rms(two) ** 2, 1e-300)
        if errors[0] > BLURRED or size[GAIN] == 0.0:
            found |= {len(OWN) * j + GAIN, len(OWN) * j + DELAY}
        elif errors[1] > 0.5 * evidence.step or size[DELAY] == 0.0:
            found.add(len(OWN) * j + DELAY)
    return found


def _precedence(effect: Effect) -> bool:
    """Return False for what is told where effects cannot be told apart: the offset of a joint with a constant load."""
    return effect.kind != OWN[OFFSET]


class Fit:
    """The parameters of some faults, fitted.

    Attributes:
        theta, covariance: of all parameters, zero of those that are not fitted or cannot be told.
        fitted: the places of those that are; told: of these the ones that no dependent column could change.
        residual: (N, n).
        heights: where the rows of each joint begin in `rows`, and where those of the last end.
    """

    def __init__(self, evidence: Evidence, start: Floats, faults: Sequence[Effect], rounds: int = _ROUNDS) -> None:
        wanted = [place for effect in sorted(faults, key=_precedence) for place in effect.places]
        self._places = [evidence.places(j) for j in range(evidence.joints)]
        self.heights = np.cumsum([0, *(len(each) + 1 for each in self._places)])
        self.theta = np.where(np.isin(np.arange(len(start)), wanted), start, 0.0)
        self.residual = columns(evidence, self.theta)[1]
        self.fitted: set[int] = {*wanted}
        for _ in range(rounds):
            weights = weights_of(self.residual, evidence.measured)
            found, left = columns(evidence, self.theta)
            rows = self.rows(found, left, weights)
            self.fitted = independent(rows, [place for place in wanted if place in self.fitted])
            step = least_squares(rows, self.fitted)
            moved = rows[:, :-1] * step
            self._move(evidence, step, left / weights, weights)
            lost = self._away(evidence, self.theta, start)
            wanted = [place for place in wanted if place not in lost]
            self.theta[lost] = 0.0
            self.residual = columns(evidence, self.theta)[1]
            if np.abs(moved).max(initial=0.0) <= _SETTLED * np.sqrt(len(left)):
                break
        self._wanted = wanted
        self._judge(evidence, weights)

    def _judge(self, evidence: Evidence, weights: Floats) -> None:
        """Find the covariance of what was fitted, and which of it can be told."""
        found, self.residual = columns(evidence, self.theta)
        self._triangles = self.rows(found, self.residual, weights)
        scaled = [each / weight for each, weight in zip(found, weights, strict=True)]
        bread = np.zeros((len(self.theta), len(self.theta)))
        places = sorted(self.fitted)
        inverse = pseudoinverse(self._triangles[:, places])
        bread[np.ix_(places, places)] = einsum("ia,ja->ij", inverse, inverse)
        scores = score_covariance(scaled, self.residual / weights, self._places, len(self.theta), bread)
        rounding = np.repeat(ROUNDING * rms(evidence.measured) / weights, np.diff(self.heights))
        rounded = self._triangles[:, :-1] * rounding[:, None]
        self._scores = scores + einsum("ka,kb->ab", rounded, rounded)
        self._grow = np.ones(len(self.theta))
        self.covariance = self._covariance(self.fitted)
        self._grow = self._bursts(scaled, self.residual / weights, bread)
        self.covariance *= np.outer(self._grow, self._grow)
        self.told = self.fitted - depended_on(self._triangles, self.fitted, {*self._wanted} - self.fitted)

    def _move(self, evidence: Evidence, step: Floats, before: Floats, weights: Floats) -> None:
        """Make a step, or as small a part of it as makes less of what is left: gains times loads are not linear."""
        at = np.where(np.isin(np.arange(len(step)), [*self.fitted]), self.theta, 0.0)
        for part in 0.5 ** np.arange(_HALVINGS):
            self.theta = at + part * step
            after = columns(evidence, self.theta)[1] / weights
            if einsum("ki,ki", after, after) <= einsum("ki,ki", before, before) * _SLACK:
                return

    def _bursts(self, scaled: Sequence[Floats], residual: Floats, bread: Floats) -> Floats:
        """Return by how much errors are larger than those of steady noise: residuals may be large where columns are."""
        parts = sum(
            einsum("kp,pq->kq", columns * residual[:, [j]], bread[places])
            for j, (columns, places) in enumerate(zip(scaled, self._places, strict=True))
        )
        variance, steady = variance_of_sums(np.asarray(parts), window_length(residual)), np.diag(self.covariance)
        return np.asarray(np.sqrt(np.maximum(variance / np.where(steady > 0.0, steady, np.inf), 1.0)))

    def clear_delays(self, evidence: Evidence) -> set[int]:
        """Return the places of delays that the torque of fitted effects shows well."""
        errors = self._alone()
        delays = range(DELAY, len(OWN) * evidence.joints, len(OWN))
        return {place for place in delays if errors[place] < CLEAR * evidence.step}

    def _alone(self) -> Floats:
        """Return the standard error of each parameter, were it the only one."""
        sizes = einsum("ij,ij->j", self._triangles, self._triangles)[:-1]
        return np.asarray(np.sqrt(np.abs(np.diag(self._scores))) / np.where(sizes > 0.0, sizes, 1e-300))

    @staticmethod
    def _away(evidence: Evidence, theta: Floats, start: Floats) -> list[int]:
        """Return the places of delays that left the place where the search began: nothing there tells of one."""
        delays = range(DELAY, len(OWN) * evidence.joints, len(OWN))
        return [place for place in delays if abs(theta[place] - start[place]) > _FAR * evidence.step]

    def rows(self, found: Sequence[Floats], left: Floats, weights: Floats) -> Floats:
        """Return a triangular factor of each joint's columns and residual, below each other, among all parameters."""
        rows = []
        for j, (each, places) in enumerate(zip(found, self._places, strict=True)):
            factor = np.linalg.qr(np.column_stack((each, left[:, j])) / weights[j], mode="r")
            row = np.zeros((len(factor), len(self.theta) + 1))
            row[:, [*places, len(self.theta)]] = factor
            rows.append(row)
        return np.concatenate(rows)

    def _covariance(self, told: Collection[int]) -> Floats:
        places = sorted(told)
        found = np.zeros((len(self.theta), len(self.theta)))
        if places:
            inverse = pseudoinverse(self._triangles[:, places])
            bread = einsum("ia,ja->ij", inverse, inverse)
            found[np.ix_(places, places)] = bread @ self._scores[np.ix_(places, places)] @ bread
            found[places, places] = np.abs(found[places, places])  # tapers may leave what is next to 0 negative
        return found * np.outer(self._grow, self._grow)

    def needed(self, faults: Sequence[Effect]) -> list[Effect]:
        """Return the faults that are left when as many as possible are taken for zero, all together by Wald's test.

        Of effects that would do equally well those of one parameter are left.
        """
        kept, dropped = sorted(faults, key=lambda effect: -len(effect.places)), list[Effect]()
        while kept:
            chances = [self._log_chance([*dropped, effect]) for effect in kept]
            best = int(np.argmax(chances))
            if chances[best] < log(TOGETHER):
                break
            dropped.append(kept.pop(best))
        return kept

    def sure(self, faults: Sequence[Effect], level: float) -> bool:
        """Return whether noise makes some faults with less than this probability."""
        return self._log_chance(faults) < log(level)

    def _log_chance(self, faults: Sequence[Effect]) -> float:
        """Return the logarithm of the probability that noise alone explains as much beside all others (Wald's test)."""
        from scipy.stats import chi2

        theta, covariance, fitted = self.theta, self.covariance, self.fitted
        mine = {place for effect in faults for place in effect.places}
        if self.told != self.fitted:
            others = [place for place in self._wanted if place not in mine]
            fitted = independent(self._triangles, [*others, *(place for place in self._wanted if place in mine)])
            explained = einsum("ij,j->i", self._triangles[:, :-1], theta)
            theta = least_squares(np.column_stack((self._triangles[:, :-1], explained)), fitted)
            covariance = self._covariance(fitted)
        return float(chi2.logsf(*wald(theta, covariance, sorted(mine & fitted))))


def weights_of(left: Floats, measured: Floats) -> Floats:
    """Return the RMS of each joint's residual, at least `ROUNDING` of its measured torque."""
    size, floor = rms(left), ROUNDING * rms(measured)
    return np.where(size > floor, size, np.where(floor > 0.0, floor, 1.0))
