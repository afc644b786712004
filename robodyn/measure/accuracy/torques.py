"""What the digits of torques cost, and what deriving accelerations and leaving out effects or samples cost; torques as
accurate as asked."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Literal

import numpy as np
from numpy.typing import DTypeLike, NDArray

from robodyn.dynamics.plan import Plan, plan, runner_of
from robodyn.errors import InputError
from robodyn.loads.result import Promise, Result
from robodyn.loads.statistics import REMEDY
from robodyn.measure.accuracy.ladder import (
    ROUNDING,
    Accuracy,
    EffectPrice,
    Ladder,
    Price,
    Rung,
    refuse_beyond_doubles,
    timed,
)
from robodyn.programs.program import Program
from robodyn.programs.run.compiled_blocks import CompiledBlocks, kernel_of
from robodyn.programs.run.double_double import BLOCK, double_double
from robodyn.programs.run.llvm.machine import Function, compiler_problem, machine_code
from robodyn.programs.run.multiprecision import Multiprecision, context_of
from robodyn.programs.run.numpy_blocks import NumpyBlocks
from robodyn.programs.run.runner import PAIRS
from robodyn.robot.model import Model
from robodyn.scene.fit import check_moves
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.extras import need
from robodyn.support.floats import Floats, first_largest
from robodyn.trajectory.motion import Derivation, Trajectory
from robodyn.trajectory.options import MODES
from robodyn.trajectory.read import motion, read_motion, sources_of

LADDER_SAMPLES = 16  # of the motion, evenly spaced, on which errors are measured
DIGITS, FEWER_DIGITS = 50, 20

Sources = Mapping[str, np.ndarray[Any, Any]]
Ways = dict[str, tuple[Any, Callable[..., Any]]]
"""By its name each executor that runs here, its type of numbers, and what makes it ready from a program and widths."""
EVERY, FEWEST = (1, 2, 4, 8), 32  # of so many samples one is kept, and samples that are left at least
PROMISE_SAMPLES, PROMISE_DIGITS = 64, 40
"""Of the motion, evenly spaced, on which errors are measured; of what they are measured against."""
MARGIN = 4.0  # of what the largest error elsewhere may be, of that among the samples


def compile_anew(program: Program, widths: Mapping[str, int], dtype: Any = np.float64) -> None:
    """Make machine code of a program and load it, whatever the cache holds."""
    Function(machine_code(kernel_of(program, widths, dtype)), "kernel")


def laid_out(sources: Mapping[str, Floats], order: Literal["F", "C"], dtype: DTypeLike) -> dict[str, NDArray[Any]]:
    """Return the same numbers with contiguous columns ("F") or rows ("C")."""
    return {name: np.asarray(values, dtype, order) for name, values in sources.items()}


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
    ways: Ways = {"numpy float32": (np.float32, NumpyBlocks), "numpy float64": (np.float64, NumpyBlocks)}
    acts: dict[str, Callable[[], object]] = {"tracing the recursion": a_plan.torques}
    if not compiler_problem():
        for name, dtype in (("compiled", np.float64), ("compiled float32", np.float32)):
            ways[name if name.endswith("32") else "compiled float64"] = dtype, CompiledBlocks
            acts[f"machine code, {name}"] = partial(compile_anew, program, widths, dtype)
    executors, notes = _executor_ladder(program, widths, ways, sources, len(samples))
    ladders = [executors]
    try:
        ladders.append(derivative_ladder(a_plan, samples))
    except InputError as error:
        notes.append(f"derivatives: {error.what}")
    if len(samples) >= FEWEST * 2:
        ladders.append(rate_ladder(a_plan, samples))
    prices = tuple(Price(name, time) for name, (_, time) in timed(acts).items())
    # each effect by its own program, not by subtraction; the largest torque of each at any joint
    total, effects = a_plan.torques().size, []
    forces = {joint.rate for joint in model.independent if joint.kind == "prismatic"}
    forces |= {joint.rate + k for joint in model.independent if joint.kind == "floating" for k in (3, 4, 5)}
    for effect in a_plan.effects:
        share = a_plan.share(effect)
        tau = abs(NumpyBlocks(share, runner_of(share, a_plan).widths)(sources, len(samples))).max(axis=0)
        place, saved = first_largest(tau), total - a_plan.without(effect).size
        unit = "N" if place in forces else "N m"
        effects.append(EffectPrice(effect.name, float(tau[place]), unit, model.rates[place], saved))
    return Accuracy(model.name, tuple(ladders), prices, tuple(effects), tuple(notes))


def file_accuracy(model: Model, scene: Scene, trajectory: str, **reading: Any) -> Accuracy:
    """`torque_accuracy` of the first block of a trajectory in a file, 32768 samples, read as by `read_motion`."""
    block = first_block(model, scene, trajectory, **reading)
    found = torque_accuracy(model, block, scene)
    return replace(found, notes=(*(f"warning: {caveat.text}" for caveat in block.caveats), *found.notes))


def first_block(model: Model, scene: Scene, trajectory: str, **reading: Any) -> Trajectory:
    """Return the first samples of a trajectory in a file."""
    with read_motion(trajectory, model, scene, **reading) as reader:
        for block in reader.blocks():
            if len(block):
                return block
    raise InputError("the trajectory has no samples", file=trajectory)


def _executor_ladder(
    program: Program, widths: Mapping[str, int], ways: Ways, sources: Sources, count: int
) -> tuple[Ladder, list[str]]:
    """Return the ladder, and which executors are left out, and why."""
    reference, digits = (Multiprecision(program, digits=digits) for digits in (DIGITS, FEWER_DIGITS))
    acts: dict[str, Callable[[], Any]] = {}
    for name, (dtype, ready) in ways.items():
        run, given = ready(program, widths, dtype=dtype), laid_out(sources, "F", dtype)
        acts[name] = partial(run, given, count, np.empty((count, len(program.outputs)), dtype, "F"))
    results = timed(acts, 1 / count)
    if not np.isfinite(results["numpy float64"][0]).all():
        raise InputError("the torques of some samples overflow", remedy=REMEDY)
    rows = np.unique(np.linspace(0, count - 1, LADDER_SAMPLES).astype(int))
    few = {name: values[rows] for name, values in sources.items()}
    expected = reference(few, len(rows))
    found = {name: (tau[rows], time) for name, (tau, time) in results.items()}
    pairs, block = partial(double_double, program), min(count, BLOCK)
    given = {name: values[:block] for name, values in sources.items()}
    ((_, time),) = timed({"": partial(pairs, given, block)}, 1 / block).values()
    high, low = map(np.frompyfunc(context_of(DIGITS).mpf, 1, 1), pairs(few, len(rows)))
    found["double-double"] = high + low, time
    found |= timed({f"mpmath, {FEWER_DIGITS} digits": partial(digits, few, len(rows))}, 1 / len(rows))
    largest = abs(expected).max() or 1  # in the arithmetic of what is expected
    rungs, notes = [], []
    for name, (tau, time) in found.items():
        if np.isfinite(tau.astype(float)).all():
            error = float(abs(expected - tau.astype(object)).max() / largest)
            rungs.append(Rung(name, (error,), time, float(program.size)))
        else:
            notes.append(f"{name}: the torques overflow")
    against = f"{DIGITS} digits on {len(rows)} of {count} samples"
    return Ladder("torques", ("torque",), against, "sample", tuple(rungs)), notes


def derivative_ladder(a_plan: Plan, samples: Trajectory) -> Ladder:
    """Return torques with accelerations by each scheme against the torques of the motion they were derived from; raise
    InputError if it is too short, or has floating joints and no accelerations. Where the accelerations are not given, a
    smooth motion like the given one takes its place, with white noise of the size that was found in the data: the truth
    is known, and the data are as bad."""
    if samples.derivation is None:
        truth, data, against = samples, samples.q, "the velocities and accelerations given"
    else:
        truth = like(a_plan.model, samples)
        data, against = noisy(a_plan.model, truth.q, samples.derivation)
    expected = torques(a_plan, truth)
    scale = np.abs(expected).max() or 1.0
    derived: Any = partial(motion, a_plan.model, truth.time, data, columns=truth.extra)
    acts = {mode: partial(derived, derivatives=mode) for mode in MODES if mode not in ("given", "anew")}
    rungs = []
    for name, (found, time) in timed(acts, 1 / len(truth)).items():
        off = np.abs(torques(a_plan, found) - expected).max(axis=1) / scale
        quarter = len(off) // 4
        rungs.append(Rung(name, (float(off[quarter : len(off) - quarter].max()), float(off.max())), time))
    return Ladder("derivatives", ("middle", "whole"), against, "sample", tuple(rungs))


def torques(a_plan: Plan, samples: Trajectory) -> Floats:
    """Return (N, n) of a motion, by NumPy."""
    program = a_plan.torques()
    run = NumpyBlocks(program, runner_of(program, a_plan).widths)
    return np.asarray(run(sources_of(samples, a_plan.scene), len(samples)), dtype=float)


def like(model: Model, samples: Trajectory) -> Trajectory:
    """Return a motion whose accelerations are splines through the derived ones, with its exact velocities and
    positions, half-way between the samples, so that no spline through its positions is the motion itself."""
    from scipy.interpolate import CubicSpline

    if any(joint.kind == "floating" for joint in model.independent):
        raise InputError("a floating joint without accelerations has none that are known to compare with")
    time = samples.time
    qdd = CubicSpline(time, samples.qdd)
    qd = qdd.antiderivative()
    q = qd.antiderivative()
    off = (samples.q - q(time) - samples.qd[0] * (time - time[0])[:, None]).mean(axis=0)
    between = 0.5 * (time[1:] + time[:-1])
    moved = q(between) + samples.qd[0] * (between - time[0])[:, None] + off
    extra = {name: 0.5 * (column[1:] + column[:-1]) for name, column in samples.extra.items()}
    return motion(model, between, moved, samples.qd[0] + qd(between), qdd(between), columns=extra)


def noisy(model: Model, q: Floats, derivation: Derivation) -> tuple[Floats, str]:
    """Positions with the noise that was found in those of a motion, on the same grids; and what was done, in words."""
    found = {joint.name: joint for joint in derivation.joints}
    sigma, grid = (
        np.array([getattr(found.get(name), part, 0.0) for name in model.coordinates]) for part in ("noise", "quantum")
    )
    data = q + sigma * np.random.default_rng(0).standard_normal(q.shape)
    fine = grid > 0.0
    data[:, fine] = grid[fine] * np.round(data[:, fine] / grid[fine])
    size = f"noise of {sigma.max():.1e} as in it" if sigma.any() else "as free of noise"
    return data, f"a smooth motion like the given one, with {size}" if sigma.any() else f"a motion like it, {size}"


def rate_ladder(a_plan: Plan, samples: Trajectory) -> Ladder:
    """Return the largest change of a joint's peak torque, relative to the largest peak, where samples are left out, and
    accelerations that are not given derived from what is left. Times are per sample of the data."""
    full = _peaks(a_plan, samples, 1)
    acts = {str(k): partial(_peaks, a_plan, samples, k) for k in EVERY if len(samples) >= FEWEST * k}
    size = a_plan.torques().size
    rate = (len(samples) - 1) / (samples.time[-1] - samples.time[0])
    names = {"1": "every sample", "2": "every 2nd"}
    rungs = []
    for k, (peaks, time) in timed(acts, 1 / len(samples)).items():
        change = float(np.abs(peaks - full).max() / (full.max() or 1.0))
        name = f"{names.get(k, f'every {k}th')}, {rate / int(k):.4g} Hz"
        rungs.append(Rung(name, (change,), time, size / int(k)))
    return Ladder("sample rate", ("peak torque",), "the peaks at the full rate", "sample", tuple(rungs))


def _peaks(a_plan: Plan, samples: Trajectory, every: int) -> Floats:
    rows = slice(None, None, every)
    extra = {name: column[rows] for name, column in samples.extra.items()}
    time, q, qd, qdd = (part[rows] for part in (samples.time, samples.q, samples.qd, samples.qdd))
    left = replace(samples, time=time, q=q, qd=qd, qdd=qdd, extra=extra)
    if samples.derivation is not None:
        given = all(joint.velocity == "given" for joint in samples.derivation.joints)
        left = motion(a_plan.model, time, q, qd if given else None, columns=extra)
    found: Floats = np.abs(torques(a_plan, left)).max(axis=0)
    return found


@dataclass(frozen=True)
class Arithmetic:
    """The cheapest arithmetic for a target: its executor, None for any, and error, relative to the largest torque."""

    target: float
    executor: str | None
    expected: float

    def fulfilled(self, result: Result) -> Result:
        """The result with what it promises: the error of the arithmetic, and of noise in derived accelerations."""
        largest = max((abs(joint.peak) for joint in result.joints), default=0.0)
        derived = result.derivation is not None and largest > 0.0
        noise = max((joint.error_bar or 0.0 for joint in result.joints), default=0.0) / largest if derived else 0.0
        name = "pairs of doubles" if self.executor else "doubles"
        said = f"{self.target:g} asked: {name} are within {self.expected:.0e} of the largest torque"
        met = noise <= self.target
        if noise:
            said += f", and noise in derived accelerations is within {noise:.0e} of it (95 %)"
            said += "" if met else "; no arithmetic helps: give accelerations, or quieter positions"
        return replace(result, accuracy=Promise(self.target, max(self.expected, noise), met, said))


def arithmetic_within(model: Model, samples: Trajectory, scene: Scene, target: float) -> Arithmetic:
    """Doubles if their error is within the target, else pairs of doubles, whose sums are rounded at last.

    The error of doubles is four times the largest among 64 samples of the motion, against 40 digits.

    Raises:
        InputError: mpmath is not installed, or no result in doubles can be that accurate.

    Accuracy: covers the error of every sample in 95 of 100 random motions.
    """
    refuse_beyond_doubles(target)
    need("accuracies that are promised", "mpmath")
    a_plan = plan(model, scene)
    program, sources = a_plan.torques(), sources_of(samples, scene)
    rows = np.unique(np.linspace(0, len(samples) - 1, PROMISE_SAMPLES).astype(int))
    few = {name: values[rows] for name, values in sources.items()}
    exact = Multiprecision(program, digits=PROMISE_DIGITS)(few, len(rows))
    found = NumpyBlocks(program, runner_of(program, a_plan).widths)(few, len(rows))
    largest = abs(exact).max() if exact.size else 0
    error = float(abs(exact - found.astype(object)).max() / largest) if largest else 0.0
    expected = MARGIN * max(error, ROUNDING)
    return Arithmetic(target, None, expected) if expected <= target else Arithmetic(target, PAIRS, ROUNDING)
