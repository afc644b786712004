"""What the digits of a simulated motion cost: integrators and their steps, errors against a motion found twice, as one
number for angles, lengths, turns and rates."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from math import inf
from time import perf_counter
from typing import Any

import numpy as np

from robodyn.dynamics.momenta import position_rates
from robodyn.dynamics.plan import Plan, plan
from robodyn.errors import InputError
from robodyn.measure.accuracy.ladder import Accuracy, Ladder, Price, Rung, Spread, timed
from robodyn.programs.run.llvm.machine import compiler_problem
from robodyn.robot.model import Model
from robodyn.scene.fit import check_moves
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.simulation.equations import Equations, Steps
from robodyn.simulation.methods import METHODS, Method, MethodOptions, method_named
from robodyn.simulation.result import Simulation
from robodyn.simulation.simulate import integrated, simulate, start_of
from robodyn.simulation.stiff_steps import with_friction
from robodyn.simulation.table import Signal, Source, read_table
from robodyn.support.floats import Floats

_ANGLE, _LENGTH, _TURN, _RATE, _SPEED = range(5)
COMPARED, SAME = 50, 1e-12
"""Records at which motions by different methods are compared; times nearer than this part of them are the same."""
Run = Callable[..., Simulation]  # `simulate` with all but the duration and the method
REFERENCE_MOST = 2e5  # evaluations of an adaptive method, after which another one is tried
CHECKED = 200  # times at which two motions are compared, at most


@dataclass(frozen=True, eq=False)
class MotionError:
    """Differences of states (N, nq + n) relative to the largest of their kind in a motion, `scale`: angles, lengths,
    quaternions (1), angular and linear rates."""

    scale: Floats

    @classmethod
    def over(cls, model: Model, states: Floats) -> MotionError:
        """Args: states: (N, nq + n) of a motion that is nearly right."""
        q, qd = np.full(model.nq, _ANGLE), np.full(model.n, _RATE)
        for joint in model.independent:
            k, i = joint.coordinate, joint.rate
            if joint.kind == "floating":
                q[k : k + 3], q[k + 3 : k + 7], qd[i + 3 : i + 6] = _LENGTH, _TURN, _SPEED
            elif joint.kind == "prismatic":
                q[k], qd[i] = _LENGTH, _SPEED
        kinds = np.concatenate((q, qd))
        largest = np.abs(states).max(axis=0, initial=0.0)
        sizes = np.array([largest[kinds == kind].max(initial=0.0) for kind in range(5)])
        sizes[_TURN] = 1.0
        sizes[sizes == 0.0] = 1.0
        return cls(sizes[kinds])

    def __call__(self, found: Floats, expected: Floats) -> Floats:
        """Return (N,) the largest relative difference at each time; nan where a number is not finite."""
        off: Floats = (np.abs(found - expected) / self.scale).max(axis=1)
        return off


def between_records(motion: Simulation) -> Callable[[Floats], Floats]:
    """Return states (N, nq + n) at any times of a motion, by polynomials between those recorded, of degree 7 where
    steps are of one length; else cubic ones with the slopes of the states, which stay between records that are far
    apart."""
    from scipy.interpolate import CubicHermiteSpline, make_interp_spline

    states = np.hstack((motion.q, motion.qd))
    if motion.step is None:
        slopes = position_rates(motion.model, list(motion.q.T), list(motion.qd.T))
        spline = CubicHermiteSpline(motion.time, states, np.column_stack((*slopes, motion.qdd)))
    else:
        degree = min(7, len(motion.time) - 1)
        spline = make_interp_spline(motion.time, states, k=degree - 1 + degree % 2)
    return lambda times: np.asarray(spline(times), dtype=float)


def apart(coarse: Simulation, fine: Simulation) -> float:
    """Return how far a motion is from a finer one, at times that both record, up to a limit that ends either; where
    there are few of these, at those of the coarser, between records of the other; inf where they end at other limits,
    or are too short."""
    if coarse.ended.rpartition(" at ")[0] != fine.ended.rpartition(" at ")[0]:
        return inf
    end = min(coarse.time[-1], fine.time[-1])
    rows = np.flatnonzero(coarse.time < end if coarse.ended else coarse.time <= end)
    if len(rows) < 2:
        return inf
    times, states = coarse.time[rows], states_of(fine)
    near = np.searchsorted(fine.time, times * (1.0 - SAME))
    shared = np.abs(fine.time[near] - times) <= SAME * times
    few = shared.sum() < 0.5 * min(len(rows), COMPARED)
    expected = between_records(fine)(times) if few else states[near[shared]]
    off = MotionError.over(fine.model, states)(states_of(coarse)[rows if few else rows[shared]], expected)
    late = abs(float(coarse.time[-1] - fine.time[-1])) / float(fine.time[-1]) if coarse.ended else 0.0
    return max(float(off.max()), late)


def seen(motion: Simulation | None) -> list[float]:
    """Return times of some records of a motion, spread over it, at which another one is compared with it."""
    if motion is None:
        return []
    last = len(motion.time) - (2 if motion.ended else 1)
    rows = np.unique(np.linspace(0, max(last, 0), min(last, COMPARED) + 1).astype(int))
    times: list[float] = motion.time[rows[1:]].tolist()
    return times


def states_of(motion: Simulation) -> Floats:
    return np.hstack((motion.q, motion.qd))


@dataclass(frozen=True, eq=False)
class Reference:
    """A motion that is known to a bound; at: states (N, nq + n) at times (N,); error: measures other states, `bound`
    and `bound_at_end` those of `at`, anywhere and at the end."""

    at: Callable[[Floats], Floats]
    error: MotionError
    bound: float
    bound_at_end: float
    how: str


def motion_reference(model: Model, duration: float, run: Run) -> Reference:
    """Return the motion from the scene's initial state, in doubles, joint limits not looked at: by DOP853 (or Radau)
    and by Gauss-Legendre of order 6 (or RK4), whichever gets through, or InputError; bound: their largest difference.
    """

    def first(ways: list[tuple[str, dict[str, Any]]]) -> Simulation:
        problem = ""
        for method, how in ways:
            try:
                return run(duration, method=method, **how)
            except InputError as error:
                problem = error.what
        remedy = "give a shorter --duration, or a softer friction or drive"
        raise InputError(f"no reference: {problem}", remedy=remedy)

    halved = [("gauss6", 16), ("gauss6", 14), ("gauss6", 18), ("rk4", 17)]
    fine = first([(name, {"step": duration / 2**k}) for name, k in halved])
    adaptive = [("dop853", 1e-13), ("radau", 1e-11)]
    other = first([(name, {"rtol": rtol, "most": REFERENCE_MOST}) for name, rtol in adaptive])
    at = between_records(fine)
    some = np.unique(np.linspace(0, len(other.time) - 1, CHECKED).astype(int))
    found = np.hstack((other.q, other.qd))[some]
    measure = MotionError.over(model, found)
    apart = measure(at(other.time[some]), found) + np.finfo(float).eps
    bound, end = float(apart.max()), float(apart[-1])
    ends = f" ({end:.0e} at the end)" if end < 0.1 * bound else ""
    how = f"{fine.method.name} and {other.method.name}, which agree to {bound:.0e}{ends}"
    return Reference(at, measure, bound, end, how)


DURATION, LONGEST = 2.0, 2.0  # s of a motion, where none is given, and that one run may take
STEPS = 1.6e-2, 4e-3, 1e-3, 2.5e-4, 6.25e-5  # s, of methods with a fixed step, while they gain digits
TOLERANCES = 1e-4, 1e-7, 1e-10, 1e-13
MOST = 1e5  # evaluations of an adaptive method: stiff motions are not for every one
GAIN = 0.5  # a shorter step is tried if the one before left less than this share of the error
SEEN = 64  # recorded times at which errors are measured, at most
BEFORE_LIMIT = 0.99  # share of the motion up to a joint's limit that is compared


def simulation_accuracy(
    model: Model, scene: Scene = DEFAULT, duration: float | None = None, table: Source | None = None
) -> Accuracy:
    """True errors of a motion by every integrator at several steps, its drift of energy, and what they cost.

    Errors are those of positions and speeds, at the end and the largest along the way, relative to the largest angle,
    length, rate or speed of the motion, the bound of the reference added. Times are those of the loop alone.

    Args:
        duration: s; by default 2, or that of the table if it is shorter. A motion that reaches a joint's limit is
            compared up to shortly before.
        table: as for `simulate`.

    Raises:
        InputError: the scene does not fit the robot or the table, or no method gets through.
    """
    check_moves(model)
    signal = Signal(scene, model, None if table is None else read_table(table, scene))
    scene, assumed = with_friction(model, signal.scene)
    if duration is None:
        duration = DURATION if signal.table is None else min(DURATION, signal.table.duration)
    followed = partial(simulate, model, table=signal.source)
    notes: list[str] = []
    try:
        motion = followed(scene, duration)
    except InputError:
        motion = followed(scene, duration, method="radau", rtol=1e-8)
    if motion.ended:
        duration = float(f"{BEFORE_LIMIT * motion.time[-1]:.6g}")
        if duration <= 0.0:
            remedy = 'write joint_limits = "ignore" in the scene'
            raise InputError(f"the motion is over at once: {motion.ended}", remedy=remedy)
        notes.append(f"compared up to {duration:g} s: {motion.ended}")
    a_plan = plan(model, replace(scene, joint_limits="ignore"))
    run = partial(followed, a_plan.scene)
    reference = motion_reference(model, duration, run)
    acts, ready, start = {}, {}, start_of(a_plan)
    for method in METHODS:
        found, lost = _tries(a_plan, run, method, duration, reference)
        for how, rung in found:
            acts[rung.name] = partial(integrated, a_plan, *how, signal, start)
            ready[rung.name] = rung
        notes += lost
    rungs = tuple(replace(ready[name], time=time) for name, (_, time) in timed(acts).items())
    ladder = Ladder("simulation", ("end", "way"), reference.how, "motion", rungs)
    traced: dict[str, Callable[[], object]] = {
        "tracing the equations": Equations(a_plan).derivatives,
        "tracing a step, rk4": lambda: Steps(Equations(a_plan), method_named("rk4")).step,
    }
    prices = tuple(Price(name, time) for name, (_, time) in timed(traced).items())
    return Accuracy(f"{model.name}, {duration:g} s", (ladder,), prices, notes=(*assumed, *notes))


def _tries(
    a_plan: Plan, run: Run, method: Method, duration: float, reference: Reference
) -> tuple[list[tuple[tuple[MethodOptions, float, str], Rung]], list[str]]:
    """Return a method at ever shorter steps or tolerances while that helps: input of `integrated`, rung; failures."""
    found: list[tuple[tuple[MethodOptions, float, str], Rung]] = []
    failed: list[str] = []
    why, before, equations = "", inf, Equations(a_plan)
    executor = "auto" if method.adaptive or compiler_problem() else "compiled"
    run = partial(run, method=method.name, executor=executor)
    ways: list[tuple[str, MethodOptions, dict[str, float]]]
    if method.adaptive:
        ways = [(f"rtol {rtol:g}", MethodOptions(method, 0.0, rtol), {"rtol": rtol}) for rtol in TOLERANCES]
    else:
        shorter = [step for step in STEPS if step < duration]
        ways = [(f"{1e3 * step:g} ms", MethodOptions(method, step, 0.0), {"step": step}) for step in shorter]
    for way, options, given in ways:
        name = f"{method.name}, {way}"
        try:
            if not found:
                run(duration / 1024, **given)  # so that machine code is ready
            begin = perf_counter()
            motion = run(duration, most=MOST if method.adaptive else inf, **given)
        except InputError as error:
            failed, why = [*failed, name], error.what
            continue
        took = perf_counter() - begin
        errors = state_errors(motion, reference)
        if not np.isfinite(errors[1]):
            failed, why = [*failed, name], "a number overflows"
            continue
        drift = motion.energy_drift / (float(motion.figures.kinetic.max()) or 1.0)
        if method.adaptive:
            work = motion.evaluations * equations.derivatives().size
        else:
            steps = Steps(equations, method)
            swept = steps.sweep.size * motion.evaluations // len(method.b) if steps.sweep else 0
            work = motion.steps * steps.step.size + swept
        once = Spread(took, took, took, 1)
        found.append(((options, duration, executor), Rung(name, errors, once, float(work), motion.evaluations, drift)))
        if took > LONGEST / 4 or errors[1] > GAIN * before:
            break
        before = errors[1]
    lost = "; ".join(failed) if found else method.name
    return found, [f"left out: {lost}: {why}"] if failed else []


def state_errors(motion: Simulation, reference: Reference) -> tuple[float, float]:
    """Of a motion's state at the end, and the largest at up to 64 recorded times, the reference's bound added."""
    some = np.unique(np.linspace(0, len(motion.time) - 1, SEEN).astype(int))
    states = np.hstack((motion.q, motion.qd))[some]
    errors = reference.error(states, reference.at(motion.time[some]))
    return float(errors[-1]) + reference.bound_at_end, float(errors.max()) + reference.bound
