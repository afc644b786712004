"""Where a motion begins: what the scene says, else within the joints' limits, and on the loops of a closed chain."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from robodyn.dynamics.loops.closed_chain import NOTHING, ClosedChain, closed_chain, independent
from robodyn.dynamics.loops.closure import loops_size, moved, unit
from robodyn.dynamics.plan import Plan
from robodyn.errors import InputError
from robodyn.programs.vectors import length, product, rotation_from_rpy
from robodyn.robot.kinematics import Values, coordinates, named
from robodyn.robot.limits import coordinate_ranges
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene
from robodyn.support.floats import Floats
from robodyn.support.linear import min_norm_solution, null_space, range_basis

ROOM = 0.05
"""Of a joint's range, and rad or m at most: what is left to a limit where 0 is none of the positions between limits."""
_NAMED = 8
CLOSED = 1e-13
"""m or rad that a loop may be open at the start, for links of up to a metre."""
MISFIT = 1e-6
"""The same for an equation that was dropped, which no motion of the robot can mend."""
TRIES = 60
LONGEST = 0.3
"""rad or m, of a correction."""
AWAY = 0.1
"""rad or m, to where the rank of J is looked at again."""
LOOKS = 3
FEW = 1e-6
"""Singular values of J that are a smaller part of the largest count as none: loops are closed to rounding there."""


def default_pose(model: Model) -> Floats:
    """Return q (nq,) where a scene says nothing: 0 and no turn, or of joints that may not stand at 0 the nearest
    position within their limits, ROOM away from them, so that gravity does not end the motion where it begins."""
    q = np.zeros(model.nq)
    for joint in model.independent:
        if joint.kind == "floating":
            q[joint.coordinate + 6] = 1.0
    least, largest = coordinate_ranges(model)
    stuck = ((least >= 0.0) | (largest <= 0.0)) & (least <= largest)
    room = np.minimum(ROOM * (largest - least), ROOM)
    return np.where(stuck, np.where(least >= 0.0, least + room, largest - room), q)


def initial_state(model: Model, scene: Scene) -> Floats:
    """Return (width,) q, qd, no work done, and no step yet: what the scene says in numbers, else the default pose."""
    q = dict(zip(model.coordinates, default_pose(model).tolist(), strict=True))
    qd = dict.fromkeys(model.rates, 0.0)
    for values, begun in ((q, scene.initial_q), (qd, scene.initial_qd)):
        for name, entry in begun.items():
            assert not isinstance(entry, str), "a scene of a Signal has its initial state in numbers"
            values[name] = entry
    state = np.array([*q.values(), *qd.values(), 0.0, 0.0])
    for joint in model.independent:
        if joint.kind == "floating":
            h = state[joint.coordinate + 3 : joint.coordinate + 7]
            if not h.any():
                raise InputError(f"the quaternion of {joint.name} is zero", remedy="no turn is qx qy qz qw = 0 0 0 1")
            h /= length(h)
    return state


def begun_at(model: Model, scene: Scene, values: Values) -> Scene:
    """Return the scene with initial positions of the joints in their order, or of coordinates by name."""
    given = named(model, values, model.coordinates if isinstance(values, Mapping) else coordinates(model))
    return replace(scene, initial_q={**scene.initial_q, **given}) if given else scene


def limits_at_start(model: Model, scene: Scene) -> list[str]:
    """Return lines on the joints that begin elsewhere than at 0 for their limits' sake, and on those without room."""
    pose, (least, largest) = default_pose(model), coordinate_ranges(model)
    joints = [joint for joint in model.independent if joint.kind != "floating"]
    moved = [
        f'"{joint.name}" at {pose[joint.coordinate]:.4g} {"m" if joint.kind == "prismatic" else "rad"}'
        for joint in joints
        if pose[joint.coordinate] and joint.name not in scene.initial_q
    ]
    stuck = [f'"{joint.name}"' for joint in joints if largest[joint.coordinate] <= least[joint.coordinate]]
    lines = [f"begun within the limits and not at 0: {_first(moved)}"] if moved and not scene.loops else []
    if stuck and scene.joint_limits == "stop":
        why = "limits, those of joints that mimic it among them, leave no room"
        lines.append(f'{_first(stuck)} cannot move: {why} (joint_limits = "ignore" in a scene does not look)')
    return lines


def _first(names: list[str]) -> str:
    return ", ".join(names[:_NAMED]) + (f" and {len(names) - _NAMED} more" if len(names) > _NAMED else "")


def closed_start(plan: Plan, state: Floats) -> Floats:
    """A state (width,) with positions and speeds on the loops, by Newton's steps, each the shortest that there is;
    InputError if the loops do not close.

    Coordinates that the scene gives stay as they are if the others alone can close the loops; else as many as can be,
    those before the others that the scene gives first. Likewise speeds. Accuracy: CLOSED.
    """
    chain = closed_chain(plan).resisting()
    model, scene = plan.model, plan.scene
    q, qd = state[: model.nq], state[model.nq : model.nq + model.n]

    def others(kept: Sequence[int]) -> list[int]:
        return [rate for rate in range(model.n) if rate not in kept]

    rates_of: dict[str, range] = {}  # of each coordinate, those of its joint
    for joint in model.independent:
        numbers, rates = (7, 6) if joint.kind == "floating" else (1, 1)
        for name in model.coordinates[joint.coordinate : joint.coordinate + numbers]:
            rates_of[name] = range(joint.rate, joint.rate + rates)
    placed = list(dict.fromkeys(rate for name in scene.initial_q for rate in rates_of[name]))
    closed = _keeping(placed, lambda kept: closed_by(chain, q, others(kept)))
    if closed is None:
        errors = np.abs(np.array(chain.equations(chain.sample(q.tolist())).error, dtype=float))
        rows = [(closure.loop.name, equation.unit) for closure in chain.closures for equation in closure.equations]
        name, unit_of = rows[int(np.argmax(errors))]
        what = f'loop "{name}" does not close: it is open by {errors.max():.3g} {unit_of} at the start'
        remedy = "give [initial] q nearer to where it closes, or leave out coordinates that are to be found"
        raise InputError(what, remedy=remedy)
    check_dropped(chain, closed)
    given = [model.rates.index(name) for name in scene.initial_qd]
    sample = chain.sample(closed.tolist(), qd.tolist())
    J, rate_of_error = chain.jacobian(sample), np.array(chain.equations(sample).rate, dtype=float)

    def rolling_by(kept: Sequence[int]) -> Floats | None:
        change = _least_change(J, rate_of_error, others(kept))
        left = np.abs(product(J, change) + rate_of_error).max(initial=0.0)
        return qd + change if left <= CLOSED * _reach(chain) * max(1.0, np.abs(qd).max(initial=0.0)) else None

    rolling = _keeping(given, rolling_by)
    if rolling is None:
        raise InputError("the loops allow no speeds near those given", remedy="give [initial] qd of fewer joints")
    return np.array([*closed, *rolling, *state[model.nq + model.n :]])


def _keeping(given: Sequence[int], found: Callable[[Sequence[int]], Floats | None]) -> Floats | None:
    """What is found with as many of the given kept as can be, the first before the others; None if nothing is."""
    best, low, high = found(given), 0, len(given)
    if best is not None:
        return best
    while low < high:
        middle = (low + high) // 2
        one = found(given[:middle])
        best, low, high = (best, low, middle) if one is None else (one, middle + 1, high)
    return best


def start_notes(model: Model, scene: Scene, begun: Floats, asked: Floats) -> list[str]:
    """Return which of the positions and speeds that a scene gives had to change for the loops to close."""
    names = [*model.coordinates, *model.rates]
    given = [name in scene.initial_q for name in model.coordinates] + [name in scene.initial_qd for name in model.rates]
    changed = [k for k, mine in enumerate(given) if mine and scene.loops and abs(begun[k] - asked[k]) > MISFIT]
    kinds = ["q" if k < model.nq else "qd" for k in changed]
    moved = [f"{kind} {names[k]} {asked[k]:.6g} -> {begun[k]:.6g}" for kind, k in zip(kinds, changed, strict=True)]
    return [f"the loops close only with other values than given: {', '.join(moved)}"] if moved else []


def closed_by(chain: ClosedChain, q: Floats, free: Sequence[int]) -> Floats | None:
    """q with the loops closed by moving the free coordinates alone; None if that fails."""
    for _ in range(TRIES):
        sample = chain.sample(q.tolist())
        here, J = chain.equations(sample), chain.jacobian(sample)
        error, at = np.array(here.error, dtype=float), 0
        for closure, place in zip(chain.closures, here.places, strict=True):
            if closure.loop.kind == "weld":  # by the turn that is left, as its equations hold at half a turn too
                from scipy.spatial.transform import Rotation

                turn = rotation_from_rpy(*closure.loop.rpy)
                left = Rotation.from_matrix(product(place.B, turn.T).astype(float)).as_rotvec()
                for k, equation in enumerate(closure.equations, at):
                    if equation.unit == "rad":
                        axis = equation.moment(turn)
                        error[k] = product(axis, left)
                        for rate, twist in place.columns.items():
                            J[k, rate] = product(axis, twist.w)
            at += len(closure.equations)
        if np.abs(error).max(initial=0.0) <= CLOSED * _reach(chain):
            return q
        step = _least_change(J, error, free)
        q = _displaced(chain, q, step * min(1.0, LONGEST / (np.abs(step).max(initial=0.0) + 1e-300)))
    return None


def _least_change(J: Floats, error: Floats, free: Sequence[int]) -> Floats:
    """The shortest change of the free rates that takes an error away; those that move no loop stay as they are."""
    change, each = np.zeros(J.shape[1]), np.abs(J).max(axis=0, initial=0.0)
    moving = [rate for rate in free if each[rate] > NOTHING * each.max(initial=0.0)]
    change[moving] = min_norm_solution(J[:, moving], -error, NOTHING)
    return change


def _displaced(chain: ClosedChain, q: Floats, moves: Floats) -> Floats:
    return np.array(unit(chain.model, moved(chain.model, q.tolist(), moves.tolist())), dtype=float)


def closed_near(chain: ClosedChain, q: Floats, moves: Floats) -> Floats | None:
    return closed_by(chain, _displaced(chain, q, moves), range(chain.model.n))


def _reach(chain: ClosedChain) -> float:
    """m; the longest offset of the loops, at least 1."""
    return max(1.0, loops_size(chain.model, chain.closures))


def check_dropped(chain: ClosedChain, q: Floats) -> None:
    motions = chain.sample(q.tolist()).motions()
    for closure, equation in chain.dropped:
        place = closure.relative(chain.model, motions)
        error = float(equation.of(place.d, place.B))
        if abs(error) > MISFIT * _reach(chain):
            raise InputError(
                f'loop "{closure.loop.name}" cannot close: it misses by {abs(error):.3g} {equation.unit} '
                f"{equation.about} of {closure.loop.to}, wherever the joints stand",
                remedy='correct "point" and "to_point", or name the "directions" along which it is held',
            )


@lru_cache(maxsize=16)
def independent_equations(plan: Plan) -> ClosedChain:
    """The closed chain without equations that depend on others where the motion begins and at closed places nearby:
    steps leave the loops by a little, and there these contradict each other. Where the rank is less at the start alone,
    as for four-bars that lie flat, all are kept."""
    chain = closed_chain(plan).resisting()
    try:
        begun = closed_start(plan, initial_state(plan.model, plan.scene))[: plan.model.nq]
    except InputError:
        return chain
    J = chain.jacobian(chain.sample(begun.tolist()))
    rank = len(range_basis(J, FEW))
    others = (chain.jacobian(chain.sample(q.tolist())) for q in nearby(chain, begun))
    if rank == chain.count or any(len(range_basis(other, FEW)) > rank for other in others):
        return chain
    return chain.keeping(independent(J, FEW))


def nearby(chain: ClosedChain, q: Floats) -> list[Floats]:
    """Return closed places that motions which the loops allow lead to from the closed place q (nq,)."""
    free = null_space(chain.jacobian(chain.sample(q.tolist())), FEW)
    drawn = product(np.random.default_rng(0).normal(size=(LOOKS, len(free))), free)
    places = [closed_near(chain, q, AWAY * u / max(float(np.abs(u).max(initial=0.0)), 1e-300)) for u in drawn]
    return [place for place in places if place is not None]
