"""The main job: what every joint carries along a motion.

The room: `accumulate` takes block after block through the recursion, `statistics` gathers peaks and integrals,
`error_bars` tells by how much derived accelerations put them off, `constraints` and `constraint_figures` add loops and
contacts, `sizing` and `motors` what motors and bearings bear, `uncertainty` and `uncertain_report` what parameters that
are uncertain do; `self_checks` holds the laws against them, and here all becomes a `Result`.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import astuple
from typing import TYPE_CHECKING

import numpy as np

from robodyn.dynamics.plan import Plan, plan
from robodyn.errors import InputError, SceneError
from robodyn.loads.accumulate import Options, TorqueAccumulator
from robodyn.loads.error_bars import bar_caveats, carried
from robodyn.loads.result import Checks, JointLoad, Result
from robodyn.loads.statistics import base_loads, check_figures, effect_reports, joint_load, shares_at_peaks
from robodyn.robot.limits import coverage
from robodyn.robot.model import Model
from robodyn.scene.fit import refuse_others
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import Floats
from robodyn.support.threads import prefetch
from robodyn.support.wording import shown
from robodyn.trajectory.motion import Trajectory
from robodyn.trajectory.plausible import refuse_units
from robodyn.trajectory.read import read_motion
from robodyn.trajectory.reader import TrajectoryReader

if TYPE_CHECKING:
    from robodyn.dynamics.momenta import View
    from robodyn.loads.constraints import ConstraintPass


Sink = Callable[[Floats, Floats], None]


def torques(
    model: Model,
    trajectory: Trajectory | TrajectoryReader | str | os.PathLike[str],
    scene: Scene = DEFAULT,
    *,
    reactions: bool = False,
    explain: bool = False,
    sinks: Iterable[Sink] = (),
    executor: str = "auto",
    threads: int | None = None,
    momentum: View | None = None,
    sizing: bool | None = None,
    history: bool = False,
) -> Result:
    """Return what every joint of a robot carries along a motion, with self-checks.

    Blocks of the trajectory go through the traced recursion one after another, in memory that does not depend on their
    number. Integrals over time use the trapezoidal rule.

    Args:
        model: of `robodyn.load`.
        trajectory: of `robodyn.motion`, or a file, or a reader of `robodyn.read_motion`, which is read to its end.
        scene: what surrounds the robot.
        reactions: compute the six components of every joint's wrench for the sinks.
        explain: count the operations that the absence of each effect would save.
        sinks: each is called after every block with time (N,), as the trajectory's table gives it, and the columns of
            `output_names` (N, k).
        executor, threads: as for `inverse_dynamics`.
        sizing: also compute what motors, gears, bearings and the foundation bear; None: where the scene has motors.
        history: keep the course of the motion for plots, in memory that does not depend on its length.
        momentum: also compute mass centre, momenta, energies and power, seen in this way, for sinks and the result.

    Raises:
        InputError: the scene does not fit the robot, the trajectory is wrong or can hardly be in the units that it is
            taken in, or the executor cannot run.

    Where the scene says how uncertain parameters are, the result's `uncertainty` has error bars by the derivatives of
    the recursion, and by draws where these mislead.

    Accuracy: torques as `inverse_dynamics`; shares add up to the peak within 1e-12 of the largest torque.
    """
    refuse_others(model, scene)
    check_uncertain(scene)
    with _opened(trajectory, model, scene) as motion:
        sized = bool(scene.motor) if sizing is None else sizing
        options = Options(reactions, executor, threads, momentum, sized, history)
        held = _constraints(model, scene, options, motion)
        run = TorqueAccumulator(model, held.tree if held else scene, options, getattr(motion, "file", None), held)
        last: Trajectory | None = None
        for given, left in prefetch(_blocks(motion)):
            if len(given):
                refuse_units(given.caveats, getattr(motion, "file", None))
                block = held.take(given) if held else given
                columns, last = run.take(block, left), block
                for sink in sinks:
                    sink(block.given_time, held.written(columns) if held else columns)
    if last is None:
        raise InputError("the trajectory has no samples")
    return gathered_result(run, last, explain)


def check_uncertain(scene: Scene) -> None:
    """Raise where error bars are asked for that are not computed."""
    if scene.uncertainty is not None and scene.constrained:
        what = "[uncertainty] gives error bars of open trees alone, and the scene has loops, contacts or passive joints"
        raise SceneError(what, remedy="leave [uncertainty] out")


def _constraints(
    model: Model, scene: Scene, options: Options, motion: Trajectory | TrajectoryReader
) -> ConstraintPass | None:
    """Return what finds the forces of loops and contacts; None for a tree that stands on nothing."""
    if not scene.constrained:
        return None
    from robodyn.loads.constraints import ConstraintPass

    file = getattr(motion, "file", None)
    return ConstraintPass(model, scene, options.executor, options.threads, motion.followed, file)


def _opened(
    trajectory: Trajectory | TrajectoryReader | str | os.PathLike[str], model: Model, scene: Scene
) -> AbstractContextManager[Trajectory | TrajectoryReader]:
    """Return the motion to run over; a file named here is closed afterwards."""
    if isinstance(trajectory, (str, os.PathLike)):
        return read_motion(trajectory, model, scene)
    return nullcontext(trajectory)


def _blocks(motion: Trajectory | TrajectoryReader) -> Iterator[tuple[Trajectory, int]]:
    """Yield the blocks, and about how many samples there are from each on: by where the reader is after that one."""
    if isinstance(motion, Trajectory):
        yield motion, len(motion)
        return
    for block in motion.blocks():
        yield block, _expected_samples(motion, block)


def _expected_samples(trajectory: TrajectoryReader, block: Trajectory) -> int:
    if not trajectory.position_bytes:
        return len(block)
    before = block.first_row - 1
    whole = (before + len(block)) * trajectory.size_bytes // trajectory.position_bytes
    return max(whole - before, len(block))


@np.errstate(all="ignore")
def gathered_result(run: TorqueAccumulator, last: Trajectory, explain: bool) -> Result:
    """Return everything gathered, with shares and uncertainty at the peaks.

    Args:
        last: its last block. explain: as `torques` has it.
    """
    assert run.choice is not None
    whole = plan(run.model, run.scene, run.zero_columns or frozenset())
    total, checks = run.statistics.integrals, run.checks.report()
    _check(run, checks)
    joints, left = _joints(run, whole)
    base = base_loads(run.statistics)
    constraints = run.constraints.report() if run.constraints else None
    sizing = run.sizing.report(joints, _inertias(run, run.sizing.driven)) if run.sizing else None
    unsure = run.uncertain.report(joints, sizing) if run.uncertain else None
    looped = run.constraints is not None and run.constraints.holds_base
    caveats = (
        *last.caveats,
        *(constraints.caveats if constraints else ()),
        *carried(run.model, run.scene, base, joints, checks.largest_force, checks.largest_moment, looped),
        *run.bars.openness.caveats(joints, left, checks.energy_balance, total.samples, total.duration),
        *bar_caveats(joints, sizing),
        *(unsure.caveats if unsure else ()),
    )
    about = (*(run.uncertain.notes if run.uncertain else ()), *_added(run))
    idle = (
        f"nothing drives {shown(joints[k].name)}, so that its [motor] is judged by its speed alone" for k in _idle(run)
    )
    return Result(
        robot=run.model.name,
        samples=total.samples,
        duration=total.duration,
        gravity=run.scene.gravity,
        joints=joints,
        base_wrench=base,
        effects=effect_reports(whole, explain),
        checks=checks,
        operations=whole.torques().size,
        executor=run.choice.executor,
        reason=run.choice.reason,
        derivation=last.derivation,
        warnings=(*(caveat.text for caveat in caveats), *about, *idle, *run.model.notes, *last.notes),
        momentum=run.momentum.report() if run.momentum else None,
        history=run.history.history(run.statistics.at_peak) if run.history else None,
        sizing=sizing,
        limits=coverage(run.joints),
        caveats=caveats,
        origin=last.origin,
        held=last.held,
        constraints=constraints,
        uncertainty=unsure,
    )


def _added(run: TorqueAccumulator) -> Iterator[str]:
    """Yield which links have several payloads, as of a scene and of the command line, and what these add up to."""
    payloads = run.scene.payloads
    for link in dict.fromkeys(payload.link for payload in payloads):
        masses = [payload.mass for payload in payloads if payload.link == link]
        if len(masses) > 1:
            parts = " + ".join(f"{mass:g}" for mass in masses)
            yield f"{len(masses)} payloads on link {shown(link)} add up: {parts} = {sum(masses):g} kg"


def _check(run: TorqueAccumulator, checks: Checks) -> None:
    """Raise where a square, a power or an integral overflows."""
    peaks = np.concatenate((run.statistics.torque.kept["value"], run.statistics.base.kept["value"]))
    laws = checks.first_law, checks.second_law, checks.power
    more = run.sizing.figures if run.sizing else ()
    totals = run.statistics.integrals.totals.values()
    check_figures((*totals, astuple(checks.energy_balance), laws, *more), peaks, run.file)


def _joints(run: TorqueAccumulator, whole: Plan) -> tuple[tuple[JointLoad, ...], list[float]]:
    """Return the loads of the joints, and what is open of their peaks."""
    gathered = run.statistics
    shares = shares_at_peaks(whole, gathered.at_peak, run.rates.start)
    bars = [_bar(run, k, shares[k]) for k in range(len(run.joints))]
    joints = tuple(
        joint_load(gathered, k, joint, name, run.scene, shares[k], bars[k])
        for k, (joint, name) in enumerate(zip(run.joints, run.model.rates[run.rates], strict=True))
    )
    return joints, [bar or 0.0 for _, bar in bars]


def _bar(run: TorqueAccumulator, k: int, shares: Mapping[str, float]) -> tuple[float, float | None]:
    """Return what noise does to joint k at its peak, and by how much its largest torque may be off."""
    if run.bars.openness.unknown:
        return 0.0, None
    gathered = run.statistics
    noise, guessed = run.bars.at_peak(k, gathered.at_peak.get(k), shares)
    peak = abs(float(gathered.torque.kept["value"][k]))
    bar = max(float(gathered.most[k]) - peak, peak - float(gathered.least[k]))
    return noise, max(bar, guessed) if run.bars.openness.guessed else bar


def _inertias(run: TorqueAccumulator, joints: Sequence[int]) -> dict[int, float | None]:
    """Return what some joints accelerate at their peaks, by their own torque alone [kg m^2 or kg]; None of those that
    nothing drives."""
    rates, idle = {k: run.rates.start + k for k in joints}, _idle(run)
    states = {k: run.statistics.at_peak[k] for k in joints if k not in idle}
    found = {k: float(run.bars.response(state, own=True)[rates[k], rates[k]]) for k, state in states.items()}
    return {k: found.get(k) for k in joints}


def _idle(run: TorqueAccumulator) -> list[int]:
    """Return the joints with motors that nothing drives."""
    if run.sizing is None or run.constraints is None:
        return []
    passive = run.constraints.solver.actuation.passive[run.rates]
    return [k for k in run.sizing.driven if passive[k]]
