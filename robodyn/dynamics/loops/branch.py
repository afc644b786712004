"""Positions of a closed chain along one branch: the coordinates that are not given, from sample to sample."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from robodyn.dynamics.initial_state import closed_by, closed_start, default_pose, initial_state, nearby
from robodyn.dynamics.loops.closed_chain import ClosedChain, closed_chain, independent
from robodyn.dynamics.loops.closure import loops_size, moved, unit
from robodyn.dynamics.plan import Plan, plan, ready
from robodyn.errors import InputError, TrajectoryError
from robodyn.programs.program import traced
from robodyn.programs.scalar import Tape
from robodyn.programs.vectors import Scalar, product, rotation_from_rpy
from robodyn.robot.kinematics import unit_rows
from robodyn.robot.limits import coordinate_ranges
from robodyn.support.floats import Floats, einsum
from robodyn.support.linear import null_space, pseudo_inverse, range_basis
from robodyn.support.wording import count

STARTS = 32
"""From which Newton's method looks for closed configurations, drawn at random but for the first."""
SEARCH_TRIES = 40
APART = 1e-4
"""rad, or of the loops' size: configurations that are farther apart are two."""
SLACK = 1e-6
"""rad or m, that a joint may be beyond its limits."""
UNREACHED = "correct these columns, the loop's points or the links' lengths"


class BlockEquations:
    """phi, J and J' qd of the loops of a plan, for arrays of samples.

    rates: those that move a loop; units: of each equation, "m" or "rad", names: of its loop, scale: of `loops_size` or
    1 rad; shifts: (n,) which rates are those of lengths; weights: what compares them, 1 for rad, 1 / size for m.
    """

    def __init__(self, plan: Plan) -> None:
        self.plan, self.model, self.chain = plan, plan.model, closed_chain(plan)
        self.count = self.chain.count
        rows = self.chain.equations(self.chain.sample(default_pose(self.model).tolist())).J
        self.rates = tuple(sorted({rate for row in rows for rate in row}))
        self.units = tuple(e.unit for closure in self.chain.closures for e in closure.equations)
        self.names = tuple(closure.loop.name for closure in self.chain.closures for _ in closure.equations)
        self.size = loops_size(self.model, self.chain.closures)
        self.scale = np.array([self.size if unit == "m" else 1.0 for unit in self.units])
        shifts = {"floating": [False] * 3 + [True] * 3, "prismatic": [True]}
        self.shifts = np.array([x for joint in self.model.independent for x in shifts.get(joint.kind, [False])])
        self.weights = np.where(self.shifts, 1.0 / self.size, 1.0)

    def places(self, q: Floats) -> tuple[Floats, Floats]:
        """Return phi (N, equations) and J (N, equations, n) at q (N, nq)."""
        columns, m = ready(_place_program, self.plan)({"q": q}, len(q)), self.count
        return columns[:, :m], columns[:, m:].reshape(len(q), m, self.model.n)

    def bias(self, q: Floats, qd: Floats) -> Floats:
        """Return (N, equations) J' qd."""
        return ready(_bias_program, self.plan)({"q": q, "qd": qd}, len(q))

    def moved(self, q: Floats, u: Floats) -> Floats:
        """Return q (N, nq) after displacements u (N, n), which turn floating joints about their bodies' axes."""
        return ready(_moved_program, self.plan)({"q": q, "qd": u}, len(q)) if self.model.quaternions else q + u


@traced
def _place_program(plan: Plan, tape: Tape) -> Iterable[Scalar]:
    chain = closed_chain(plan)
    here = chain.equations(chain.sample(plan.sample(tape).q))
    return [*here.error, *(row.get(rate, 0.0) for row in here.J for rate in range(plan.model.n))]


@traced
def _bias_program(plan: Plan, tape: Tape) -> Iterable[Scalar]:
    chain, sample = closed_chain(plan), plan.sample(tape)
    return chain.equations(chain.sample(sample.q, sample.qd)).bias


@traced
def _moved_program(plan: Plan, tape: Tape) -> Iterable[Scalar]:
    """The displacements are in the place of qd."""
    sample = plan.sample(tape)
    return unit(plan.model, moved(plan.model, sample.q, sample.qd))


@lru_cache(maxsize=16)
def block_equations(plan: Plan) -> BlockEquations:
    return BlockEquations(plan)


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
"""Ratio of `pseudo_inverse` below which coordinates follow from nothing."""


class Lost(NamedTuple):
    """Where the branch ends: the row that is not reached, the last place (nq,), and whether the loops are singular."""

    row: int
    place: Floats
    singular: bool


class Corrected(NamedTuple):
    """Samples q (N, nq) after Newton's corrections, J at them, the largest change (N,), and which are closed."""

    q: Floats
    J: Floats
    change: Floats
    closed: Floats


class Branch:
    """What follows of given coordinates: rates `followed` of `given`; `coordinates` are their entries of q."""

    def __init__(self, equations: BlockEquations, followed: Sequence[int]) -> None:
        self.equations = equations
        rates = np.array(equations.rates, dtype=int)
        follows = np.isin(rates, followed)
        self.followed, self.given = rates[follows], rates[~follows]
        coordinates: list[int] = []
        for joint in equations.model.independent:
            numbers, count = (7, 6) if joint.kind == "floating" else (1, 1)
            if any(rate in followed for rate in range(joint.rate, joint.rate + count)):
                coordinates += range(joint.coordinate, joint.coordinate + numbers)
        self.coordinates = np.array(coordinates, dtype=int)

    def corrected(self, q: Floats, tries: int = TRIES) -> Corrected:
        """Return samples near q (N, nq) on the loops, by Newton's method; |phi| is least where too much is given."""
        weights = self.equations.weights[self.followed]
        change, u = np.zeros(len(q)), np.zeros((len(q), self.equations.model.n))
        for _ in range(tries):
            phi, J = self.equations.places(q)
            step = -einsum("nkm,nm->nk", pseudo_inverse(J[:, :, self.followed])[0], phi)
            longest = np.abs(step * weights).max(axis=1, initial=0.0)
            u[:, self.followed] = step * np.minimum(1.0, LONGEST / np.maximum(longest, DONE))[:, None]
            q, change = self.equations.moved(q, u), change + np.minimum(longest, LONGEST)
            if not (longest > DONE).any():
                break
        return Corrected(q, J, change, longest <= DONE)

    def along(self, place: Floats, q: Floats) -> Lost | None:
        """Fill in what follows, from sample to sample; return where that ends, None where it does not. Each step takes
        the samples up to LONGEST away, on the tangent at the last place, which is first `place` (nq,) on the loops,
        bent as its curvature says; where Newton's method leads farther from there, the step is halved."""
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
        """Return samples on the loops, closed where that is near what was predicted of moves (N, given rates). The
        prediction is u = D v + u'' / 2 with J_d u'' = -J' (v, D v); None where J_d does not determine it."""
        equations = self.equations
        inverse, ratio = pseudo_inverse(J[None][:, :, self.followed])
        if ratio[0] <= FEW:
            return None
        u, v = np.zeros((2, len(moves), equations.model.n))
        v[:, self.given] = moves[:, self.given]
        right = -einsum("mg,ng->mn", J[:, self.given], v[:, self.given])
        v[:, self.followed] = product(right.T, inverse[0].T)
        places = np.repeat(place[None], len(u), axis=0)
        u[:, self.followed] = v[:, self.followed] - 0.5 * product(equations.bias(places, v), inverse[0].T)
        guess = targets.copy()
        guess[:, self.coordinates] = equations.moved(places, u)[:, self.coordinates]
        found = self.corrected(guess)
        bound = NEAR * (self._length(moves) + np.abs(u * equations.weights).max(axis=1, initial=0.0)) + 10.0 * DONE
        return found._replace(closed=found.closed & (found.change <= bound))

    def _between(self, a: Floats, b: Floats) -> Floats:
        """Return (N, n) the moves of given coordinates from one sample to the next; continuous joints' are short."""
        from scipy.spatial.transform import Rotation

        moves = np.zeros((len(a), self.equations.model.n))
        for joint in self.equations.model.independent:
            k, i = joint.coordinate, joint.rate
            if joint.kind == "floating":
                moves[:, i + 3 : i + 6] = b[:, k : k + 3] - a[:, k : k + 3]
                if i in self.given:  # what follows has no quaternion yet
                    turns = [Rotation.from_quat(each[:, k + 3 : k + 7]) for each in (a, b)]
                    moves[:, i : i + 3] = (turns[0].inv() * turns[1]).as_rotvec()
            else:
                moves[:, i] = b[:, k] - a[:, k]
                if joint.continuous:
                    moves[:, i] -= 2.0 * np.pi * np.rint(moves[:, i] / (2.0 * np.pi))
        moves[:, self.followed] = 0.0
        return moves

    def _length(self, moves: Floats) -> Floats:
        """(N,) the sum over the given rates."""
        return np.asarray(np.abs(moves[:, self.given] * self.equations.weights[self.given]).sum(axis=1))


def search(branch: Branch, q: Floats, near: Floats, tolerance: float) -> tuple[Floats, str]:
    """Return closed configurations (k, nq) with the given coordinates of q (nq,), and in words the least that loops
    miss by, `tolerance` in rad or of the loops' size being none. Those within the limits and nearest to `near` (nq,)
    come first. Newton's method looks from displacements of what follows up to half a turn, or twice the loops' size."""
    equations, own = branch.equations, branch.coordinates
    reach = np.where(equations.shifts, 2.0 * equations.size, np.pi)
    moves = np.random.default_rng(0).uniform(-1.0, 1.0, (STARTS, equations.model.n)) * reach
    moves[0] = 0.0
    guesses = np.repeat(q[None], STARTS, axis=0)
    guesses[:, own] = equations.moved(np.repeat(near[None], STARTS, axis=0), moves)[:, own]
    found = branch.corrected(guesses, SEARCH_TRIES)
    phi = np.abs(equations.places(found.q)[0]) / equations.scale
    left = phi.max(axis=1, initial=0.0)
    best = int(np.argmin(left))
    worst = int(np.argmax(phi[best]))
    missed = f"{phi[best, worst] * equations.scale[worst]:.3g} {equations.units[worst]}"
    places = found.q[found.closed & (left <= tolerance)]
    for joint in equations.model.independent:
        k = joint.coordinate
        if joint.kind == "revolute" and k in own:
            places[:, k] -= 2.0 * np.pi * np.rint((places[:, k] - near[k]) / (2.0 * np.pi))
    places = places[[_welds_hold(equations.chain, place) for place in places]]
    least, largest = coordinate_ranges(equations.model)
    beyond = np.maximum(least[own] - places[:, own], places[:, own] - largest[own]).max(axis=1, initial=0.0) > SLACK
    away = np.abs(places[:, own] - near[own]).max(axis=1, initial=0.0)
    kept: list[int] = []  # places that are apart; equally near ones as they were found
    for k in np.lexsort((np.arange(len(places)), np.round(away, 6), beyond)).tolist():
        if all(np.abs(places[k, own] - places[other, own]).max(initial=0.0) > APART for other in kept):
            kept.append(k)
    return np.asarray(places[kept]), f'loop "{equations.names[worst]}" misses by {missed}'


def _welds_hold(chain: ClosedChain, q: Floats) -> bool:
    """Whether no weld is half a turn from where it should be, where its equations hold too."""
    welds = [k for k, closure in enumerate(chain.closures) if closure.loop.kind == "weld"]
    places = chain.equations(chain.sample(q.tolist())).places if welds else []
    turns = [product(places[k].B, rotation_from_rpy(*chain.closures[k].loop.rpy).T) for k in welds]
    return all(float(np.trace(turn)) > 1.0 for turn in turns)


TRIALS = 6
"""Configurations at which the rank of J is looked at before one that is closed is known."""
OFF = 1e-2
"""rad, or of the loops' size: what given coordinates may miss of closing the loops.

Encoders of 12 bits, rounded degrees and links that were measured to 1e-3 of their lengths miss by a few 1e-3; an offset
of a degree, a wrong sign or unit misses by more than this. Torques are off by about the same share.
"""
CLOSED = 1e-9
"""The same where coordinates follow that are free to close them."""
SHOWN = 3


def begin(branch: Branch, q: Floats, where: str) -> tuple[Floats, list[str]]:
    """Return the closed configuration (nq,) of the first row, and notes; TrajectoryError where there is none, or too
    little is given.

    It is that to which the given coordinates lead from where a simulation of the scene begins, in a straight line; else
    the one nearest to this. Those within the joints' limits come first. Initial positions of the scene that are columns
    count as nothing said.
    """
    equations, model, scene = branch.equations, branch.equations.model, branch.equations.plan.scene
    drawn = np.random.default_rng(0).uniform(-1.0, 1.0, (TRIALS, model.nq))
    _refuse_few(branch, list(equations.places(unit_rows(model, drawn))[1][:, :, branch.followed]))
    numbers = {name: entry for name, entry in scene.initial_q.items() if not isinstance(entry, str)}
    begun = replace(scene, initial_q=numbers, initial_qd={})
    near, led = initial_state(model, begun), q[None].copy()
    try:
        near = closed_start(plan(model, begun), near)[: model.nq]
    except InputError:
        near = near[: model.nq]
    else:
        near = led[0] if branch.along(near, led) is None else near
    places, missed = search(branch, q, near, CLOSED if len(branch.followed) == equations.count else OFF)
    if not len(places):
        guess = q.copy()
        guess[branch.coordinates] = near[branch.coordinates]
        closed = closed_by(equations.chain, guess, branch.followed.tolist())
        if closed is None:
            raise TrajectoryError(f"{where}: {missed} at least with {given(branch, q)}", remedy=UNREACHED)
        places = closed[None]
    J = equations.places(places[:1])[1][0][:, branch.followed]
    if len(range_basis(J, FEW)) < len(branch.followed):
        rows = [equations.places(each[None])[1][0] for each in nearby(equations.chain, places[0])]
        _refuse_few(branch, [J, *(row[:, branch.followed] for row in rows)])
        raise singular(branch, where)
    names = [model.coordinates[k] for k in branch.coordinates]
    if len(places) < 2 or any(name in scene.initial_q for name in names):
        return places[0], []
    taken, other = (
        ", ".join(f"{name} = {place[k]:.4g}" for name, k in zip(names[:SHOWN], branch.coordinates, strict=False))
        for place in places[:2]
    )
    ways = f"the loops close in {len(places)} ways or more at the first row"
    return places[0], [f"{ways}: taken is {taken}, not {other} ([initial] q in the scene chooses)"]


def singular(branch: Branch, where: str) -> TrajectoryError:
    names = [f"q_{branch.equations.model.rates[rate]}" for rate in branch.followed]
    what = f"{where}: the loops are singular, so that {', '.join(names)} do not follow from the other columns there"
    return TrajectoryError(what, remedy=f"give {' or '.join(names[:SHOWN])} as well, or leave the rows there out")


def given(branch: Branch, q: Floats) -> str:
    model = branch.equations.model
    joints = [joint for joint in model.independent if joint.rate in branch.given and joint.kind != "floating"]
    shown = [f"q_{joint.name} = {q[joint.coordinate]:.6g}" for joint in joints[:SHOWN]]
    return ", ".join(shown) + (" ..." if len(joints) > SHOWN else "") if shown else "the columns given"


def _refuse_few(branch: Branch, matrices: Sequence[Floats]) -> None:
    """Raise if no J_d (equations, followed) determines all that is to follow."""
    best = max(matrices, key=lambda J: len(range_basis(J, FEW)))
    rank, k = len(range_basis(best, FEW)), len(branch.followed)
    if rank == k:
        return
    free = null_space(best, FEW) if rank else np.eye(k)
    names = [branch.equations.model.rates[rate] for rate in branch.followed]
    actuated = branch.equations.plan.scene.actuated or ()
    order = sorted(range(k), key=lambda i: names[i] not in actuated)
    chosen = [order[i] for i in independent(np.ascontiguousarray(free.T[order]), FEW)]
    if k - rank == 1:
        chosen = [i for i in order if np.abs(free[:, i]).max() > FEW]
    others = chosen[1:] if k - rank == 1 else []
    what = f"{count(k - rank, 'freedom')} of the loops follow{'s' if k - rank == 1 else ''} from no column"
    columns = ", ".join(f"q_{names[i]}" for i in sorted(chosen) if i not in others)
    instead = f", or one of {', '.join(f'q_{names[i]}' for i in others[:SHOWN])}" if others else ""
    followed = ", ".join(f"q_{name}" for name in names)
    raise TrajectoryError(f"{what}: {followed} have none", remedy=f"give {columns}{instead}")
