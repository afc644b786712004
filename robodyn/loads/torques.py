"""The main job: what every joint carries along a motion."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING

from robodyn.errors import InputError, SceneError
from robodyn.loads.accumulate import Options, TorqueAccumulator
from robodyn.loads.gathered_result import gathered_result
from robodyn.loads.result import Result
from robodyn.robot.model import Model
from robodyn.scene.fit import refuse_others
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import Floats
from robodyn.support.threads import prefetch
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
