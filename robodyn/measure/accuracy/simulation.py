"""What the digits of a simulated motion cost: integrators and their steps, errors against a motion found twice."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from math import inf
from time import perf_counter
from typing import Any

import numpy as np

from robodyn.dynamics.plan import Plan, plan
from robodyn.errors import InputError
from robodyn.measure.accuracy.ladder import Accuracy, Ladder, Price, Rung, Spread, timed
from robodyn.measure.accuracy.motion_error import MotionError, between_records
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

Run = Callable[..., Simulation]
"""`simulate` with all but the duration and the method."""
REFERENCE_MOST = 2e5
"""Evaluations of an adaptive method, after which another one is tried."""
CHECKED = 200
"""Times at which two motions are compared, at most."""


@dataclass(frozen=True, eq=False)
class Reference:
    """A motion that is known to a bound.

    Attributes:
        at: states (N, nq + n) at times (N,); error: measures other states.
        bound, bound_at_end: of the error of `at`, anywhere and at the end, measured like those.
    """

    at: Callable[[Floats], Floats]
    error: MotionError
    bound: float
    bound_at_end: float
    how: str


def motion_reference(model: Model, duration: float, run: Run) -> Reference:
    """Return the motion of a robot from its scene's initial state, in doubles; joint limits are not looked at.

    By DOP853 (or Radau) and by a Gauss-Legendre method of order 6 (or RK4), each the first of its kind that gets
    through, or InputError is raised. The bound is the largest difference of the two.
    """
    halved = [("gauss6", 16), ("gauss6", 14), ("gauss6", 18), ("rk4", 17)]
    fine = _first(run, duration, [(name, {"step": duration / 2**k}) for name, k in halved])
    other = _first(
        run,
        duration,
        [("dop853", {"rtol": 1e-13, "most": REFERENCE_MOST}), ("radau", {"rtol": 1e-11, "most": REFERENCE_MOST})],
    )
    at = between_records(fine)
    some = np.unique(np.linspace(0, len(other.time) - 1, CHECKED).astype(int))
    found = np.hstack((other.q, other.qd))[some]
    measure = MotionError.over(model, found)
    apart = measure(at(other.time[some]), found) + np.finfo(float).eps
    bound, end = float(apart.max()), float(apart[-1])
    ends = f" ({end:.0e} at the end)" if end < 0.1 * bound else ""
    how = f"{fine.method.name} and {other.method.name}, which agree to {bound:.0e}{ends}"
    return Reference(at, measure, bound, end, how)


def _first(run: Run, duration: float, ways: list[tuple[str, dict[str, Any]]]) -> Simulation:
    """Return the first of some simulations that gets through."""
    problem: InputError | None = None
    for method, how in ways:
        try:
            return run(duration, method=method, **how)
        except InputError as error:
            problem = error
    assert problem is not None
    raise InputError(f"no reference: {problem.what}", remedy="give a shorter --duration, or a softer friction or drive")


DURATION, LONGEST = 2.0, 2.0
"""s of a motion, where none is given, and that one run may take."""
STEPS = 1.6e-2, 4e-3, 1e-3, 2.5e-4, 6.25e-5
"""s, of methods with a fixed step, while they gain digits."""
TOLERANCES = 1e-4, 1e-7, 1e-10, 1e-13
MOST = 1e5
"""Evaluations of an adaptive method: stiff motions are not for every one."""
GAIN = 0.5
"""A shorter step is tried if the one before left less than this share of the error."""
SEEN = 64
"""Recorded times at which errors are measured, at most."""
BEFORE_LIMIT = 0.99
"""Share of the motion up to a joint's limit that is compared."""


def simulation_accuracy(
    model: Model, scene: Scene = DEFAULT, duration: float | None = None, table: Source | None = None
) -> Accuracy:
    """True errors of a motion by every integrator at several steps, its drift of energy, and what they cost.

    Errors are those of positions and speeds, at the end and the largest along the way, relative to the largest angle,
    length, rate or speed of the motion; each has the bound of the reference added, so none is below the truth. Times
    are those of the loop, without machine code being made and without the figures that `simulate` reports.

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
    duration, notes = _until_limit(partial(followed, scene), duration)
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
    """Return a method at ever shorter steps or tolerances as long as that helps, and what failed.

    Of each that gets through what `integrated` is given, and its rung with the time of one run.
    """
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


def _until_limit(run: Run, duration: float) -> tuple[float, list[str]]:
    """Return how long the motion is, and notes about it."""
    try:
        motion = run(duration)
    except InputError:
        motion = run(duration, method="radau", rtol=1e-8)
    if not motion.ended:
        return duration, []
    until = float(f"{BEFORE_LIMIT * motion.time[-1]:.6g}")
    if until <= 0.0:
        remedy = 'write joint_limits = "ignore" in the scene'
        raise InputError(f"the motion is over at once: {motion.ended}", remedy=remedy)
    return until, [f"compared up to {until:g} s: {motion.ended}"]
