"""Positions of a closed chain along one branch: the coordinates that are not given, from sample to sample."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from robodyn.dynamics.loops.block_equations import BlockEquations
from robodyn.programs.stacked import least_squares
from robodyn.support.floats import Floats
from robodyn.support.sums import einsum

LONGEST = 0.5
"""rad, or of the loops' size: what the given coordinates move in one step, all together."""
SHORTEST = 1e-8
"""Of a step, below which there is no way on."""
MOST = 4096
"""Samples in one step."""
STEPS = 10_000
"""From one sample to the next, at most."""
NEAR = 0.1
"""Of a step, that Newton's corrections may add to what is predicted: another branch is farther away."""
DONE = 1e-9
"""rad, or of the loops' size: a correction after which the next one is nothing."""
TRIES = 10
FEW = 1e-6
"""Ratio of `LeastSquares` below which coordinates follow from nothing."""


class Lost(NamedTuple):
    """Where the branch ends.

    Attributes:
        row: of the block, which is not reached.
        place: (nq,) the last that is.
        singular: whether the coordinates that follow depend on each other there.
    """

    row: int
    place: Floats
    singular: bool


class Corrected(NamedTuple):
    """Samples after Newton's corrections.

    Attributes:
        q: (N, nq). J: (N, equations, rates) there.
        change: (N,) the largest change of a coordinate, in all. closed: (N,) whether corrections have ended.
    """

    q: Floats
    J: Floats
    change: Floats
    closed: Floats


class Branch:
    """What follows of given coordinates.

    Attributes:
        followed, given: rates of the loops; own, others: the same as columns of J.
        coordinates: entries of q that follow.
    """

    def __init__(self, equations: BlockEquations, followed: Sequence[int]) -> None:
        self.equations = equations
        self.followed = np.array([rate for rate in equations.rates if rate in followed], dtype=int)
        self.given = np.array([rate for rate in equations.rates if rate not in followed], dtype=int)
        self.own = np.array([k for k, rate in enumerate(equations.rates) if rate in followed], dtype=int)
        self.others = np.array([k for k, rate in enumerate(equations.rates) if rate not in followed], dtype=int)
        self.coordinates = np.array([k for joint in _joints(equations, followed) for k in joint], dtype=int)

    def corrected(self, q: Floats, tries: int = TRIES) -> Corrected:
        """Return samples near the loops with the coordinates that follow on them, by Newton's method.

        Where more is given than needed, |phi| is least.

        Args:
            q: (N, nq). tries: corrections at most.
        """
        weights = self.equations.weights[self.followed]
        change, u = np.zeros(len(q)), np.zeros((len(q), self.equations.model.n))
        for _ in range(tries):
            phi, J = self.equations.places(q)
            step = least_squares(J[:, :, self.own], -phi[:, :, None]).x[:, :, 0]
            longest = np.abs(step * weights).max(axis=1, initial=0.0)
            u[:, self.followed] = step * np.minimum(1.0, LONGEST / np.maximum(longest, DONE))[:, None]
            q, change = self.equations.moved(q, u), change + np.minimum(longest, LONGEST)
            if not (longest > DONE).any():
                break
        return Corrected(q, J, change, longest <= DONE)

    def along(self, place: Floats, q: Floats) -> Lost | None:
        """Fill in what follows, from sample to sample; return where that ends, None where it does not.

        Each step takes the samples up to LONGEST away: those on the tangent at the last place, bent as its curvature
        says, are near enough for Newton's method to lead nowhere else; else the step is halved.

        Args:
            place: (nq,) on the loops, where the motion comes from. q: (N, nq).
        """
        reached = np.concatenate(((0.0,), np.cumsum(self._length(self._between(q[:-1], q[1:])))))
        k, steps, longest, J = 0, 0, LONGEST, self.equations.places(place[None])[1][0]
        while k < len(q):
            first = self._between(place[None], q[k : k + 1])
            away = float(self._length(first)[0])
            whole = away <= longest
            if whole:
                last = int(np.searchsorted(reached, reached[k] + longest - away, side="right"))
                targets = q[k : min(max(last, k + 1), k + MOST)]
                moves = np.cumsum(np.concatenate((first, self._between(targets[:-1], targets[1:]))), axis=0)
            else:
                moves = first * (longest / away)
                targets = self.equations.moved(place[None], moves)
            found = self._step(place, J, moves, targets)
            if found is None:
                return Lost(max(k - 1, 0), place, True)
            good = int(np.argmin(np.append(found.closed, False)))
            if good:
                place, J = found.q[good - 1], found.J[good - 1]
            if whole:
                q[k : k + good, self.coordinates] = found.q[:good, self.coordinates]
                k += good
            steps = 0 if whole and good else steps + 1
            if good == len(targets):
                longest = min(2.0 * longest, LONGEST)
            else:
                longest = 0.5 * (longest if good else min(longest, away))
            if longest < SHORTEST or steps > STEPS:
                return Lost(k, place, False)
        return None

    def _step(self, place: Floats, J: Floats, moves: Floats, targets: Floats) -> Corrected | None:
        """Return samples on the loops; closed where that is near what was predicted; None if that is not possible."""
        u = self._predicted(place, J, moves)
        if u is None:
            return None
        guess = targets.copy()
        ahead = self.equations.moved(np.repeat(place[None], len(u), axis=0), u)
        guess[:, self.coordinates] = ahead[:, self.coordinates]
        found = self.corrected(guess)
        weights = self.equations.weights
        bound = NEAR * (self._length(moves) + np.abs(u * weights).max(axis=1, initial=0.0)) + 10.0 * DONE
        return found._replace(closed=found.closed & (found.change <= bound))

    def _predicted(self, place: Floats, J: Floats, moves: Floats) -> Floats | None:
        """Return (N, n) what follows of moves (N, given rates): u = D v + u'' / 2, with J_d u'' = -J' (v, D v)."""
        u = np.zeros((len(moves), self.equations.model.n))
        v = np.zeros_like(u)
        v[:, self.given] = moves[:, self.given]
        right = -einsum("mg,ng->mn", J[:, self.others], v[:, self.given])
        straight = least_squares(J[None][:, :, self.own], right[None])
        if straight.ratio[0] <= FEW:
            return None
        v[:, self.followed] = straight.x[0].T
        bias = self.equations.bias(np.repeat(place[None], len(u), axis=0), v)
        bent = least_squares(J[None][:, :, self.own], -bias.T[None]).x[0].T
        u[:, self.followed] = v[:, self.followed] + 0.5 * bent
        return u

    def _between(self, a: Floats, b: Floats) -> Floats:
        """Return (N, n) the moves of given coordinates from one sample to the next; continuous joints' are short."""
        moves = np.zeros((len(a), self.equations.model.n))
        for joint in self.equations.model.independent:
            k, i = joint.coordinate, joint.rate
            if joint.kind == "floating":
                moves[:, i + 3 : i + 6] = b[:, k : k + 3] - a[:, k : k + 3]
                moves[:, i : i + 3] = _turn(a[:, k + 3 : k + 7], b[:, k + 3 : k + 7])
            else:
                moves[:, i] = b[:, k] - a[:, k]
                if joint.continuous:
                    moves[:, i] -= 2.0 * np.pi * np.rint(moves[:, i] / (2.0 * np.pi))
        moves[:, self.followed] = 0.0
        return moves

    def _length(self, moves: Floats) -> Floats:
        """Return (N,) the sum over the given rates."""
        total: Floats = np.abs(moves[:, self.given] * self.equations.weights[self.given]).sum(axis=1)
        return total


def _joints(equations: BlockEquations, rates: Sequence[int]) -> list[range]:
    """Return the coordinates of each joint that has one of these rates."""
    found = []
    for joint in equations.model.independent:
        numbers, count = (7, 6) if joint.kind == "floating" else (1, 1)
        if any(rate in rates for rate in range(joint.rate, joint.rate + count)):
            found.append(range(joint.coordinate, joint.coordinate + numbers))
    return found


def _turn(a: Floats, b: Floats) -> Floats:
    """Return (N, 3) rotation vectors from unit quaternions a to b, in the axes of a's body."""
    v = a[:, 3:] * b[:, :3] - b[:, 3:] * a[:, :3] - np.cross(a[:, :3], b[:, :3])
    w = (a * b).sum(axis=1, keepdims=True)
    sine = np.sqrt((v * v).sum(axis=1, keepdims=True))
    angle = 2.0 * np.arctan2(sine, np.abs(w))
    return np.where(w < 0.0, -1.0, 1.0) * v * np.where(sine > 0.0, angle / np.where(sine > 0.0, sine, 1.0), 2.0)
