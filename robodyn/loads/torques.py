"""The main job: what every joint carries along a motion.

The room: `accumulate` takes block after block through the recursion and holds the laws against it, `statistics` gathers
peaks and integrals, `error_bars` tells by how much derived accelerations put them off, `constraints` adds loops and
contacts, `sizing` tells what motors and bearings bear, `temperature` how hot motors get, `uncertainty` and
`uncertain_report` what parameters that are uncertain do; here all becomes a `Result`.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, nullcontext
from dataclasses import astuple
from typing import TYPE_CHECKING

import numpy as np

from robodyn.dynamics.plan import Plan, plan
from robodyn.errors import InputError, SceneError
from robodyn.loads.accumulate import Options, TorqueAccumulator
from robodyn.loads.error_bars import bar_caveats, carried
from robodyn.loads.result import JointLoad, Result
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
from robodyn.trajectory.read import TrajectoryReader, read_motion

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

    Blocks of the trajectory go through the traced recursion one after another; integrals are trapezoidal.

    Args:
        trajectory: of `robodyn.motion`, or a file, or a reader of `robodyn.read_motion`, which is read to its end.
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
    opened: AbstractContextManager[Trajectory | TrajectoryReader] = (
        read_motion(trajectory, model, scene) if isinstance(trajectory, (str, os.PathLike)) else nullcontext(trajectory)
    )
    with opened as motion:
        file = getattr(motion, "file", None)
        sized = bool(scene.motor or scene.gear_life) if sizing is None else sizing
        held: ConstraintPass | None = None
        if scene.constrained:
            from robodyn.loads.constraints import ConstraintPass

            held = ConstraintPass(model, scene, executor, threads, motion.followed, file)
        options = Options(reactions, executor, threads, momentum, sized, history)
        run = TorqueAccumulator(model, held.tree if held else scene, options, file, held)
        last: Trajectory | None = None
        for given, left in prefetch(_blocks(motion)):
            if len(given):
                refuse_units(given.caveats, file)
                block = held.take(given) if held else given
                columns, last = run.take(block, left), block
                for sink in sinks:
                    sink(block.given_time, held.written(columns) if held else columns)
    if last is None:
        raise InputError("the trajectory has no samples")
    return _gathered(run, last, explain)


def check_uncertain(scene: Scene) -> None:
    if scene.uncertainty is not None and scene.constrained:
        what = "[uncertainty] gives error bars of open trees alone, and the scene has loops, contacts or passive joints"
        raise SceneError(what, remedy="leave [uncertainty] out")


def _blocks(motion: Trajectory | TrajectoryReader) -> Iterator[tuple[Trajectory, int]]:
    """Yield the blocks, and about how many samples there are from each on: by where the reader is after that one."""
    if isinstance(motion, Trajectory):
        yield motion, len(motion)
        return
    for block in motion.blocks():
        before, whole = block.first_row - 1, 0
        if motion.position_bytes:
            whole = (before + len(block)) * motion.size_bytes // motion.position_bytes
        yield block, max(whole - before, len(block))


@np.errstate(all="ignore")
def _gathered(run: TorqueAccumulator, last: Trajectory, explain: bool) -> Result:
    assert run.choice is not None
    whole = plan(run.model, run.scene, run.zero_columns or frozenset())
    total, checks = run.statistics.integrals, run.checks.report()
    peaks = np.concatenate((run.statistics.torque.kept["value"], run.statistics.base.kept["value"]))
    laws, more = (checks.first_law, checks.second_law, checks.power), run.sizing.figures if run.sizing else ()
    check_figures((*total.totals.values(), astuple(checks.energy_balance), laws, *more), peaks, run.file)
    joints, left = _joints(run, whole)
    base = base_loads(run.statistics)
    constraints = run.constraints.report() if run.constraints else None
    idle, sizing, unsure = list[int](), None, None
    if run.sizing is not None:
        if run.constraints is not None:
            passive = run.constraints.solver.actuation.passive[run.rates]
            idle = [k for k in run.sizing.driven if passive[k]]
        inertias: dict[int, float | None] = dict.fromkeys(idle)
        for k in set(run.sizing.driven).difference(idle):  # by the joint's own torque alone, at its peak
            response = run.bars.response(run.statistics.at_peak[k], own=True)
            inertias[k] = float(np.diag(response)[run.rates.start + k])
        sizing = run.sizing.report(joints, inertias)
    if run.uncertain is not None:
        from robodyn.loads.uncertain_report import Figures

        unsure = Figures(run.uncertain).report(joints, sizing)
    looped = run.constraints is not None and run.constraints.holds_base
    caveats = (
        *last.caveats,
        *(constraints.caveats if constraints else ()),
        *carried(run.model, run.scene, base, joints, checks, looped),
        *run.bars.caveats(joints, left, checks.energy_balance, total.samples, total.duration),
        *bar_caveats(joints, sizing),
        *(unsure.caveats if unsure else ()),
    )
    about = list(run.uncertain.notes if run.uncertain else ())
    for link in dict.fromkeys(payload.link for payload in run.scene.payloads):
        masses = [payload.mass for payload in run.scene.payloads if payload.link == link]
        if len(masses) > 1:  # as of a scene and of the command line
            parts = " + ".join(f"{mass:g}" for mass in masses)
            about.append(f"{len(masses)} payloads on link {shown(link)} add up: {parts} = {sum(masses):g} kg")
    about += [f"nothing drives {shown(joints[k].name)}, so that its [motor] is judged by its speed alone" for k in idle]
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
        warnings=(*(caveat.text for caveat in caveats), *about, *run.model.notes, *last.notes),
        momentum=run.momentum(),
        history=run.history(),
        sizing=sizing,
        limits=coverage(run.joints),
        caveats=caveats,
        origin=last.origin,
        held=last.held,
        constraints=constraints,
        uncertainty=unsure,
    )


def _joints(run: TorqueAccumulator, whole: Plan) -> tuple[tuple[JointLoad, ...], list[float]]:
    gathered, bars, joints = run.statistics, run.bars, []
    each = zip(run.joints, run.model.rates[run.rates], strict=True)
    every_share = shares_at_peaks(whole, gathered.at_peak, run.rates.start)
    for k, ((joint, name), shares) in enumerate(zip(each, every_share, strict=True)):
        uncertainty: tuple[float, float | None] = 0.0, None
        if not bars.unknown:
            noise, guessed = bars.at_peak(k, gathered.at_peak[k], shares)
            peak = abs(float(gathered.torque.kept["value"][k]))
            bar = max(float(gathered.most[k]) - peak, peak - float(gathered.least[k]))
            uncertainty = noise, max(bar, guessed) if bars.guessed else bar
        joints.append(joint_load(gathered, k, joint, name, run.scene, shares, uncertainty))
    return tuple(joints), [joint.error_bar or 0.0 for joint in joints]
