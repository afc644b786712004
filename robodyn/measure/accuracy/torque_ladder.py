"""What the digits of torques cost, and what effects and derivatives that are left out or derived cost."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from robodyn.dynamics.plan import Plan, plan, runner_of
from robodyn.errors import InputError
from robodyn.loads.figures import REMEDY
from robodyn.measure.accuracy.derivative_ladder import FEWEST, derivative_ladder, rate_ladder
from robodyn.measure.accuracy.ladder import Accuracy, EffectPrice, Ladder, Price, Rung
from robodyn.measure.speed.executors import Executor, available, compile_anew, laid_out
from robodyn.measure.timing import Spread, timed
from robodyn.programs.program import Program
from robodyn.programs.run.double_double import BLOCK, DoubleDouble
from robodyn.programs.run.multiprecision import Multiprecision, context_of
from robodyn.programs.run.numpy_blocks import NumpyBlocks
from robodyn.robot.model import Model
from robodyn.scene.fit import check_moves
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.extras import need
from robodyn.support.floats import first_largest
from robodyn.trajectory.motion import Trajectory
from robodyn.trajectory.read import read_motion, sources_of

SAMPLES = 16
"""Of the motion, evenly spaced, on which errors are measured."""
DIGITS = 50
FEWER_DIGITS = 20

Sources = Mapping[str, np.ndarray[Any, Any]]


@np.errstate(all="ignore")
def torque_accuracy(model: Model, samples: Trajectory, scene: Scene = DEFAULT) -> Accuracy:
    """Return errors of the torques of a motion by every executor against 50 digits, their times, and what effects cost.

    An error is the largest difference of a torque over the largest torque, on at most 16 samples. Times are for one
    sample of the whole motion, by one thread.

    Raises:
        InputError: mpmath is not installed, nothing of the robot can move, or a torque overflows.
    """
    check_moves(model)
    need("true errors of torques", "mpmath")
    a_plan = plan(model, scene)
    program, sources = a_plan.torques(), laid_out(sources_of(samples, scene), "F", np.float64)
    widths = runner_of(program, a_plan).widths
    ways = (Executor("numpy float32", np.float32, NumpyBlocks), *available())
    executors, notes = _executor_ladder(program, widths, ways, sources, len(samples))
    ladders = [executors]
    try:
        ladders.append(derivative_ladder(a_plan, samples))
    except InputError as error:
        notes.append(f"derivatives: {error.what}")
    if len(samples) >= FEWEST * 2:
        ladders.append(rate_ladder(a_plan, samples))
    acts: dict[str, Callable[[], object]] = {"tracing the recursion": a_plan.torques}
    for way in ways:
        if way.ready is not NumpyBlocks:
            acts[f"machine code, {way.name}"] = partial(compile_anew, program, widths, way.dtype)
    prices = tuple(Price(name, time) for name, (_, time) in timed(acts).items())
    return Accuracy(model.name, tuple(ladders), prices, _effects(a_plan, sources, len(samples)), tuple(notes))


def file_accuracy(model: Model, scene: Scene, trajectory: str, **reading: Any) -> Accuracy:
    """`torque_accuracy` of the first block of a trajectory in a file, 32768 samples.

    Args:
        reading: as for `read_motion`.

    Raises:
        InputError: the trajectory is wrong or empty, or what `torque_accuracy` raises.
    """
    with read_motion(trajectory, model, scene, **reading) as reader:
        for block in reader.blocks():
            if len(block):
                found = torque_accuracy(model, block, scene)
                return replace(found, notes=(*(f"warning: {caveat.text}" for caveat in block.caveats), *found.notes))
    raise InputError("the trajectory has no samples", file=trajectory)


def _executor_ladder(
    program: Program, widths: Mapping[str, int], ways: tuple[Executor, ...], sources: Sources, count: int
) -> tuple[Ladder, list[str]]:
    """Return the ladder, and which executors are left out, and why."""
    reference, digits = (Multiprecision(program, digits=digits) for digits in (DIGITS, FEWER_DIGITS))
    acts: dict[str, Callable[[], Any]] = {}
    for way in ways:
        run, given = way.ready(program, widths), laid_out(sources, "F", way.dtype)
        out = np.empty((count, len(program.outputs)), way.dtype, "F")
        name = way.name if "float" in way.name else f"{way.name} float64"
        acts[name] = partial(run, given, count, out, *(() if way.ready is NumpyBlocks else (1,)))
    results = timed(acts, 1 / count)
    if not np.isfinite(results["numpy float64"][0]).all():
        raise InputError("the torques of some samples overflow", remedy=REMEDY)
    rows = np.unique(np.linspace(0, count - 1, SAMPLES).astype(int))
    few = {name: values[rows] for name, values in sources.items()}
    expected = reference(few, len(rows))
    found = {name: (tau[rows], time) for name, (tau, time) in results.items()}
    found["double-double"] = _pairs(program, sources, count, rows)
    name = f"mpmath, {FEWER_DIGITS} digits"
    found |= timed({name: partial(digits, few, len(rows))}, 1 / len(rows))
    finite = {name: each for name, each in found.items() if np.isfinite(each[0].astype(float)).all()}
    rungs = [Rung(name, (_error(tau, expected),), time, float(program.size)) for name, (tau, time) in finite.items()]
    against = f"{DIGITS} digits on {len(rows)} of {count} samples"
    notes = [f"{name}: the torques overflow" for name in found.keys() - finite.keys()]
    return Ladder("torques", ("torque",), against, "sample", tuple(rungs)), notes


def _pairs(program: Program, sources: Sources, count: int, rows: Any) -> tuple[Any, Spread]:
    """Return the torques of some rows as mpmath numbers, and the time for a sample of up to a block."""
    run, few = DoubleDouble(program), min(count, BLOCK)
    given = {name: values[:few] for name, values in sources.items()}
    ((_, time),) = timed({"": partial(run, given, few)}, 1 / few).values()
    high, low = run({name: values[rows] for name, values in sources.items()}, len(rows))
    convert = np.frompyfunc(context_of(DIGITS).mpf, 1, 1)
    return convert(high) + convert(low), time


def _error(tau: Any, expected: Any) -> float:
    """max |tau - expected| / max |expected|, in the arithmetic of what is expected."""
    largest = abs(expected).max()
    difference = abs(expected - tau.astype(object)).max()
    return float(difference / largest) if largest else float(difference)


def _effects(a_plan: Plan, sources: Sources, count: int) -> tuple[EffectPrice, ...]:
    """Price each by its own program, not by subtraction; the largest torque of each at any joint."""
    model, total = a_plan.model, a_plan.torques().size
    found = []
    for effect in a_plan.effects:
        share = a_plan.share(effect)
        tau = abs(NumpyBlocks(share, runner_of(share, a_plan).widths)(sources, count)).max(axis=0)
        place = first_largest(tau)
        saved = total - a_plan.without(effect).size
        found.append(EffectPrice(effect.name, float(tau[place]), _unit(model, place), model.rates[place], saved))
    return tuple(found)


def _unit(model: Model, place: int) -> str:
    """Of an entry of tau; a floating joint has three moments, then three forces."""
    joint = max((joint for joint in model.independent if joint.rate <= place), key=lambda joint: joint.rate)
    forces = joint.kind == "prismatic" or place - joint.rate >= 3
    return "N" if forces else "N m"
