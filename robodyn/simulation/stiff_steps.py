"""How fast the stiffest friction, drive or spring of a scene settles, and motions by steps that follow it and keep the
balance of energy and work, which tells of steps that are too long where nothing else does."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from functools import lru_cache
from math import floor, log10
from typing import NamedTuple

import numpy as np

from robodyn.dynamics.effects.friction import joints_with_friction
from robodyn.dynamics.effects.motors import along, coupled_motors
from robodyn.dynamics.inverse import inverse_dynamics
from robodyn.dynamics.plan import Plan
from robodyn.errors import Caveat, InputError
from robodyn.programs.vectors import product
from robodyn.robot.model import Joint, Model
from robodyn.scene.scene import Friction, Scene
from robodyn.simulation.integrate import SHORTER, Motion
from robodyn.simulation.methods import Method, MethodOptions, TooMuchError, method_named
from robodyn.simulation.result import Figures
from robodyn.support.floats import Floats, first_largest

SLIP_SPEED = 1e-3  # rad/s, where a joint has Coulomb friction and the scene gives none
FRICTION = "Coulomb friction near rest"
CONTRACTION = 0.45  # 46 sweeps then end in rounding
STEEPEST = 1e200  # a slope beyond which steeper is no stiffer, so that nothing overflows
MOST_UNASKED = 1e5
"""Steps, where one shorter than usual is chosen, or evaluations by dop853: rather than more of them, radau."""
MOST_EVER = 1e9  # Evaluations that dop853 is left to: hours. A motion that would take more is not one of a robot
LOOKED_AT = 1e5
"""Rows of the mass matrices that a motion is looked at in, about; those around the stiffest come on top."""
KEPT = 1e-3  # of the energy that a motion turns over: by more than this its balance may not be off
ROUNDING = 1e-10  # of the stored energy, whose zero is arbitrary: what is less is rounding
TOO_LONG = "by steps that are too long for it (STEP TOO LONG)"
DRIFTS = "by steps that do not keep the energy (ENERGY DRIFTS)"
"""The kinds of caveats about steps that are kept though they are too long, and about motions whose balance is off."""
Chosen = tuple[MethodOptions, tuple[str, ...]]  # by which method and step a motion is followed, and notes about that


@lru_cache(maxsize=16)
def with_friction(model: Model, scene: Scene) -> tuple[Scene, tuple[str, ...]]:
    """The scene with a slip speed if some joint has Coulomb friction, and notes about it."""
    steepest = max((friction.dry for _, _, friction in _rubbing(model, scene)), default=0.0)
    if not steepest and not scene.loaded:
        return scene, ()
    chosen = scene.slip_speed or SLIP_SPEED
    given = scene if scene.slip_speed else replace(scene, slip_speed=chosen)
    if not steepest:
        return given, (f"friction that grows with load is regularised, qd / sqrt(qd^2 + {chosen:g}^2)",)
    said = f"Coulomb friction is regularised, f qd / sqrt(qd^2 + {chosen:g}^2)"
    return given, (f"{said}: up to {steepest / chosen:.3g} N m s/rad near rest",)


class Stiffest(NamedTuple):
    """The fastest rate [1/s] at which something in a scene settles or swings, of those (N,) `along` the configurations
    looked at; what it is, and at which joint."""

    rate: float
    cause: str
    joint: str
    along: Floats

    def longest(self, method: Method) -> float:
        """The longest stable step of a method [s]."""
        return reach(method) / self.rate

    def __str__(self) -> str:
        return f'{self.cause} of "{self.joint}" settles at {self.rate:.3g}/s'

    def remedy(self, method: Method, step: float, slip_speed: float) -> str:
        longest = self.longest(method)
        slip = f", or slip_speed = {2.0 * slip_speed * step / longest:.1g} in the scene"
        return f"give --step {rounded(0.5 * longest):g}, or --method radau{slip if self.cause == FRICTION else ''}"


def stiffest(a_plan: Plan, q: Floats) -> Stiffest | None:
    """The stiffest of what a scene has at q (N, nq) or (nq,), None if nothing: the largest eigenvalue of M^-1 D for
    slopes D of torques over speeds, friction near rest too, or the root of that of M^-1 K over positions."""
    q, model = np.atleast_2d(q), a_plan.model
    damping = [*_damping(a_plan, q)]
    stiffness = [
        *_slopes_of([body.joint for body in model.bodies], a_plan.scene.spring, "stiffness", "the spring"),
        *_slopes_of(model.independent, a_plan.scene.drive, "kp", "the drive's kp"),
        *_slopes_of(*_limited(a_plan), "stiffness", "the limit spring"),
    ]
    if not damping and not stiffness:
        return None
    # M by inverse dynamics of unit accelerations at rest: a short program, where M's has n^2 entries
    inert = replace(
        a_plan.scene, gravity=(0.0, 0.0, 0.0), spring={}, wrenches=(), immersed=(), limit_spring=None, loops=()
    )
    units, many = np.tile(np.eye(model.n), (len(q), 1)), np.repeat(q, model.n, axis=0)
    columns = inverse_dynamics(model, many, 0.0, units, scene=inert, executor="numpy").reshape(len(q), model.n, model.n)
    M = 0.5 * (columns + columns.transpose(0, 2, 1))
    found = [_fastest(M, slopes, power) for slopes, power in ((damping, 1.0), (stiffness, 0.5)) if slopes]
    return max((each for each in found if each is not None), key=lambda each: each.rate, default=None)


class Slope(NamedTuple):
    """A torque's slope over a speed or position `along . q` [N m s/rad or N m/rad], of a joint or motor."""

    name: str
    along: Mapping[int, float]
    cause: str
    value: float


def _rubbing(model: Model, scene: Scene) -> Iterator[tuple[str, Mapping[int, float], Friction]]:
    """Yield the names of what has friction, with which rates it turns, and the friction."""
    for _, joint, friction in joints_with_friction(model, scene):
        yield joint.name, {joint.rate: joint.multiplier}, friction
    for motor, turned in coupled_motors(model, scene):
        yield motor.name, along(turned), motor.friction


def _damping(a_plan: Plan, q: Floats) -> Iterator[Slope]:
    """Slopes over speeds; of friction that grows with load under the largest weight at q (N, nq)."""
    model, scene = a_plan.model, a_plan.scene
    for name, rates, friction in _rubbing(model, scene):
        if scene.slip_speed and friction.dry:
            yield Slope(name, rates, FRICTION, friction.dry / scene.slip_speed)
        if friction.viscous:
            yield Slope(name, rates, "viscous friction", friction.viscous)
    yield from _slopes_of(model.independent, scene.drive, "kd", "the drive's kd")
    yield from _slopes_of(*_limited(a_plan), "damping", "the limit spring's damping")
    if scene.slip_speed and scene.loaded:
        held = inverse_dynamics(model, q, 0.0, 0.0, scene=replace(scene, wrenches=()), executor="numpy")
        for _, joint, friction in joints_with_friction(model, scene):
            if friction.load:
                weight = float(np.abs(held[:, joint.rate]).max())
                yield Slope(
                    joint.name, {joint.rate: joint.multiplier}, FRICTION, friction.load * weight / scene.slip_speed
                )


def _limited(a_plan: Plan) -> tuple[list[Joint], Mapping[str, object]]:
    """The joints with limits, and the spring that each has there."""
    joints = [b.joint for b in a_plan.model.bodies if b.joint.lower is not None or b.joint.upper is not None]
    return joints, dict.fromkeys((joint.name for joint in joints), a_plan.scene.limit_spring)


def _slopes_of(joints: Iterable[Joint], given: Mapping[str, object], which: str, cause: str) -> Iterator[Slope]:
    """Yield what drives or springs of joints, given by name, have of a kind."""
    for joint in joints:
        value = getattr(given.get(joint.name), which, 0.0)
        if value > 0:
            yield Slope(joint.name, {joint.rate: joint.multiplier}, cause, value)


def _fastest(M: Floats, slopes: list[Slope], power: float) -> Stiffest | None:
    """The root, or the first power, of the largest eigenvalue of M^-1 S, and the slope that is most of it."""
    W = np.zeros((M.shape[1], len(slopes)))
    for k, slope in enumerate(slopes):
        for rate, share in slope.along.items():
            W[rate, k] = share * np.sqrt(min(slope.value, STEEPEST))
    try:
        values, vectors = np.linalg.eigh(product(W.T, np.linalg.inv(M), W))
    except np.linalg.LinAlgError:
        return None
    largest = values.max(axis=1, initial=0.0)
    if not np.isfinite(largest).all() or not largest.any():
        return None
    row = first_largest(largest)
    most = slopes[first_largest(np.abs(vectors[row, :, -1]))]
    return Stiffest(float(largest[row]) ** power, most.cause, most.name, largest**power)


def reach(method: Method) -> float:
    """The longest step times rate that a method with fixed steps follows: of an explicit one to the end of
    `|1 - x b^T (1 + x A)^-1 1| <= 1`; 2 where the new speed moves the position; of an implicit one where each sweep
    leaves CONTRACTION of the error, x times the spectral radius of A."""
    if method.semi or method.leapfrog:
        return 2.0
    A, b = np.array(method.A), np.array(method.b)
    if method.implicit:
        return CONTRACTION / float(np.abs(np.linalg.eigvals(A)).max())
    one, low, high = np.ones(len(b)), 0.5, 10.0
    while high - low > 1e-9:
        x = 0.5 * (low + high)
        stable = abs(1.0 - x * product(b, np.linalg.solve(np.eye(len(b)) + x * A, one))) <= 1.0
        low, high = (x, high) if stable else (low, x)
    return low


def rounded(step: float) -> float:
    """The largest of 1, 2 and 5 times a power of ten that is no more than this."""
    power = 10.0 ** floor(log10(step))
    return float(f"{max(k for k in (1, 2, 5) if k * power <= step * (1 + 1e-12)) * power:.1g}")


class Free(NamedTuple):
    """What the caller leaves open."""

    step: bool
    method: bool


def stiff_steps(
    a_plan: Plan,
    options: MethodOptions,
    q: Floats,
    duration: float,
    free: Free,
    made: Callable[[MethodOptions], tuple[Motion, Figures]],
) -> tuple[Motion, Figures, Chosen, list[Caveat]]:
    """The motion that is `made` by steps that follow the stiffest of a scene where steps or method are open, from q
    (nq,) on, its figures, how it was found, and what makes it doubtful.

    What is stiff is looked at where the motion begins, and then along all of it: where steps were too long, the motion
    is made again with shorter ones, or by Radau's method where many would be needed; and so it is where something is
    stiff and the balance of energy and work is off, as of steps that are stable on a spring, but take its energy.
    """
    fastest = None if options.method.name == "radau" else stiffest(a_plan, q)
    free, most = Free(free.step, free.method and not a_plan.scene.loops), options.most
    notes: tuple[str, ...] = ()
    if fastest is not None and not options.method.adaptive:
        if free.step and options.step > 0.5 * fastest.longest(options.method):
            options, notes = _shorter(options, fastest, 0.0, duration, free)
    elif fastest is not None and free.method and fastest.rate * duration > MOST_UNASKED:
        options, notes = _by_radau(options, str(fastest))
    elif options.method.adaptive and free.method:
        options = options._replace(most=min(options.most, MOST_UNASKED))
    while True:
        try:
            motion, figures = made(options)
        except InputError as error:
            options, notes = _instead(a_plan, (options, notes), error, fastest, duration, free, most)
            options = options._replace(most=most)
            continue
        fixed = not options.method.adaptive
        outgrown = _outgrown(a_plan, options, motion) if fixed else None
        if outgrown is not None and free.step:
            options, notes = _shorter(options, *outgrown, duration, free)
            continue
        off, share = _energy_imbalance(motion, figures)
        if share > KEPT and fastest is not None and free.step and fixed:
            finer = rounded(0.25 * options.step)
            why = f"steps of {options.step:g} s are off by {100 * share:.2g} % of the energy"
            if duration / finer <= MOST_UNASKED:
                options, notes = options._replace(step=finer), (f"{why}: those of {finer:g} s keep it",)
                continue
            if free.method:
                options, notes = _by_radau(options, why)
                continue
        caveats = []
        if outgrown is not None:
            here, since = outgrown
            when = f" from {since:.4g} s on" if since else ""
            remedy = here.remedy(options.method, options.step, a_plan.scene.slip_speed)
            follows = f"which {options.method.name} follows with steps of up to {here.longest(options.method):.2g} s"
            said = f"STEP TOO LONG{when}: {here}, {follows}; with {options.step:.3g} s it chatters ({remedy})"
            caveats.append(Caveat(TOO_LONG, said))
        if share > KEPT:
            shorter = f"give --step {rounded(0.25 * options.step):g}, or --method radau"
            remedy = shorter if fixed else "give a smaller --rtol"
            said = f"ENERGY DRIFTS: stored energy and work part by {off:.3g} J, {100 * share:.2g} % of what the "
            caveats.append(Caveat(DRIFTS, f"{said}motion turns over, and more than {100 * KEPT:g} % ({remedy})"))
        return motion, figures, (options, notes), caveats


def _energy_imbalance(motion: Motion, figures: Figures) -> tuple[float, float]:
    """max |E - E_0 - work| [J], and its share of what is turned over: energy, work, what drives give and take."""
    work, n = motion.states[:, -2], figures.tau.shape[1]
    power = np.abs(figures.tau * motion.states[:, -2 - n : -2]).sum(axis=1)
    driven = float((0.5 * (power[1:] + power[:-1]) * np.diff(motion.time)).sum())
    largest = float(max(figures.kinetic.max(), np.ptp(figures.energy), np.ptp(work), driven))
    off = figures.drift(work)
    return off, off / max(largest, ROUNDING * float(np.abs(figures.energy).max()), 1e-300)


def _shorter(options: MethodOptions, fastest: Stiffest, since: float, duration: float, free: Free) -> Chosen:
    """Steps half as long as the stiffest allows, or Radau's."""
    step = rounded(0.5 * fastest.longest(options.method))
    if free.method and duration / step > MOST_UNASKED:
        return _by_radau(options, _when(fastest, since))
    return options._replace(step=step), (f"{_when(fastest, since)}: steps of {step:g} s follow it",)


def _by_radau(options: MethodOptions, why: str) -> Chosen:
    return options._replace(method=method_named("radau")), (f"{why}: radau follows it",)


def _when(fastest: Stiffest, since: float) -> str:
    return f"{fastest} on the way, too fast for the steps before from {since:.4g} s on" if since else str(fastest)


def _instead(
    a_plan: Plan, chosen: Chosen, error: InputError, fastest: Stiffest | None, duration: float, free: Free, most: float
) -> Chosen:
    """Radau's after another failed, or that without a bound if nothing stiff held it up; raises if neither helps."""
    options, _ = chosen
    if isinstance(error, TooMuchError) and free.method and options.most < most:
        here = stiffest(a_plan, error.state[: a_plan.model.nq])
        if here is not None and here.rate * duration > MOST_UNASKED:
            return _by_radau(options, _when(here, error.time))
        if options.most * duration > MOST_EVER * error.time:
            raise error
        return chosen
    if fastest is None or error.remedy != SHORTER:
        raise error
    if free.method and free.step:
        return _by_radau(options, f"{options.method.name} does not get through ({error.what})")
    if options.step > fastest.longest(options.method):
        remedy = fastest.remedy(options.method, options.step, a_plan.scene.slip_speed)
        raise InputError(error.what, remedy=remedy) from None
    raise error


def _outgrown(a_plan: Plan, options: MethodOptions, motion: Motion) -> tuple[Stiffest, float] | None:
    """The stiffest of a motion whose steps were too long for it, and since when [s]; None if they were not."""
    q, every = motion.states[:, : a_plan.model.nq], int(np.ceil(len(motion.time) * a_plan.model.n / LOOKED_AT))
    rows = np.arange(0, len(q), every)
    found = stiffest(a_plan, q[rows])
    if found is not None and every > 1:
        middle = rows[int(np.argmax(found.along))]
        near = np.arange(max(middle - every, 0), min(middle + every + 1, len(q)))
        rows = np.union1d(rows, near)
        found = stiffest(a_plan, q[rows])
    if found is None or options.step <= found.longest(options.method):
        return None
    return found, float(motion.time[rows[int(np.argmax(found.along * options.step > reach(options.method)))]])
