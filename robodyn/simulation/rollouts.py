"""Many motions of one robot at once, a vector of them in each step of machine code."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from robodyn.dynamics.arrays import arrays_of
from robodyn.dynamics.plan import plan
from robodyn.errors import InputError
from robodyn.programs.run.stepper import LANES, SINGLE, CompiledSteps, NumpySteps
from robodyn.robot.model import Model
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.simulation.integrate import SHORTER, stepper, steps_of
from robodyn.simulation.loop_figures import check_closed
from robodyn.simulation.methods import method_named
from robodyn.simulation.stiff_steps import with_friction
from robodyn.simulation.table import Piece, Signal, Source, pieces, read_table
from robodyn.support.floats import Floats
from robodyn.support.threads import cores, in_threads

TOGETHER = 64  # rollouts whose states go through all steps together: they stay in the first cache
PIECE = 256  # steps at a time whose columns of a table are spread over the rollouts


class Rollouts(NamedTuple):
    """Records of N motions at K times [s]: q (K, N, nq), qd (K, N, n) and the work (K, N) done on each robot [J]."""

    time: Floats
    q: Floats
    qd: Floats
    work: Floats


def rollouts(
    model: Model,
    q: ArrayLike,
    qd: ArrayLike,
    steps: int,
    step: float,
    *,
    every: int = 1,
    scene: Scene = DEFAULT,
    table: Source | None = None,
    method: str = "rk4",
    executor: str = "auto",
    threads: int | None = None,
) -> Rollouts:
    """The motions from N initial states, recorded every `every` steps; joint limits are not looked at.

    Coulomb friction is regularised as by `simulate`; whether the step follows it is not looked at either.

    Args:
        q, qd: (N, nq) and (N, n), as for `forward_dynamics`; of a closed chain they have to close its loops. Which of
            the loops' equations imply others is judged where the scene begins, or at the first row if it does not say.
        steps, step: how many, a multiple of `every`, and how long [s].
        table: where the scene's drives or wrenches name columns, as for `simulate`: all motions follow it.
        method: one with steps of a fixed length.
        executor, threads: as for `inverse_dynamics`.

    Raises:
        InputError: shapes or numbers do not fit; a motion cannot be followed.

    Accuracy: of an explicit method, each motion is the same to the last bit however many go with it.
    """
    chosen = method_named(method)
    if chosen.adaptive or step <= 0 or every < 1 or steps < 1 or steps % every:
        raise InputError(f"{steps} steps of {step:g} s by {method}, recorded every {every}", remedy="fixed steps only")

    sources, shape = arrays_of(model, {"q": q, "qd": qd}, scene)
    if len(shape) != 1:
        raise InputError(f"the initial states have shape {shape}", remedy="give a row for each motion")
    signal = Signal(scene, model, None if table is None else read_table(table, scene))
    scene, _ = with_friction(model, signal.scene)
    if scene.loops and not scene.initial_q:
        scene = replace(scene, initial_q=dict(zip(model.coordinates, sources["q"][0].tolist(), strict=True)))
    a_plan, count, workers = plan(model, scene), shape[0], cores(threads)
    if scene.loops:
        check_closed(a_plan, sources["q"], sources["qd"])
    lanes = SINGLE if count == 1 else LANES
    run = stepper(a_plan, chosen, executor, steps * -(-count // LANES), lanes)
    own = model.nq + model.n + 2
    first = steps_of(a_plan, chosen).begin(np.hstack((sources["q"], sources["qd"], np.tile([0.0, step], (count, 1)))))
    signal.check_duration(steps * step)
    rows = pieces(signal.corners(), step, steps, PIECE) if signal.curves else ()
    given = [(each, signal.in_steps(each, chosen.moments)) for each in rows]

    def part(start: int) -> Floats:
        begun = first[start : start + TOGETHER]
        slots = np.empty((steps // every + 1, run.width, -(-len(begun) // run.lanes) * run.lanes))
        slots[0] = begun[-1][:, None]
        slots[0, :, : len(begun)] = begun.T
        if not _filled(run, slots, every, given):
            what = f"a motion of rows {start} to {start + len(begun) - 1} cannot be followed"
            raise InputError(what, remedy=SHORTER)
        return slots[:, : own - 1, : len(begun)]

    starts = range(0, count, TOGETHER)
    parts = in_threads(part, starts, min(workers, len(starts)))
    states = np.concatenate(parts, axis=2).transpose(0, 2, 1)
    time: Floats = np.arange(float(len(states))) * (every * step)
    return Rollouts(time, states[:, :, : model.nq], states[:, :, model.nq : -1], states[:, :, -1])


def _filled(run: CompiledSteps | NumpySteps, slots: Floats, every: int, given: list[tuple[Piece, Floats]]) -> bool:
    """Fill the slots from the first, in steps that may be given curves; tell whether they could be."""
    if not given:
        return run(slots, every).steps == every * (len(slots) - 1) and bool(np.isfinite(slots[-1]).all())
    now = slots[0]
    for steps, columns in given:
        after = np.empty((len(columns) + 1, *now.shape))
        after[0] = now
        if run(after, 1, columns).steps < len(columns) or not np.isfinite(after[-1]).all():
            return False
        rows = np.flatnonzero((steps.whole > 0) & (steps.whole % every == 0))
        slots[steps.whole[rows] // every] = after[1 + rows]
        now = after[-1]
    return True
