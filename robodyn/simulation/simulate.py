"""The second job: how a robot moves, from where it begins and what drives it. The door to this room.

1. `table.py`: what a table says between its rows. `equations.py`: the equations of motion and what they conserve.
   The latter makes programs of one step, too, by the integrators of `methods.py`.
2. `integrate.py` makes many steps, fixed or adaptive, `events.py` tells where these reach limits; `rollouts.py` makes
   many motions at once.
3. `stiff_steps.py` tells how fast the stiffest settles and chooses steps that follow it.
4. `loop_figures.py` and `result.py`: what comes out.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf

import numpy as np

from robodyn.dynamics.initial_state import closed_start, initial_state, limits_at_start, start_notes
from robodyn.dynamics.plan import Plan, plan
from robodyn.errors import InputError
from robodyn.programs.run.stepper import COLUMNS
from robodyn.robot.base_guess import untouched
from robodyn.robot.model import Model
from robodyn.scene.fit import check_moves, refuse_constraints, refuse_others
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.simulation.equations import STATE, Equations, check_applies, is_free, state_runner
from robodyn.simulation.events import Limits
from robodyn.simulation.integrate import AdaptiveSteps, FixedSteps, Motion
from robodyn.simulation.loop_figures import loop_figures, start_caveats
from robodyn.simulation.methods import MethodOptions, choose_method
from robodyn.simulation.result import Figures, Simulation, deepest, held
from robodyn.simulation.stiff_steps import Free, stiff_steps, with_friction
from robodyn.simulation.table import Signal, Source, read_table
from robodyn.support.floats import Floats

DURATION = 10.0  # s, where none is given and no table says it


def simulate(
    model: Model,
    scene: Scene = DEFAULT,
    duration: float | None = None,
    *,
    table: Source | None = None,
    step: float | None = None,
    rtol: float | None = None,
    method: str | None = None,
    executor: str = "auto",
    most: float = inf,
    also: Sequence[float] = (),
) -> Simulation:
    """The motion of a robot: M(q) qdd + c + g + friction + springs - J^T w = tau, from the scene's initial state.

    The torques are those of the scene's drives. A floating base is free. Coulomb friction is
    `f qd / sqrt(qd^2 + slip_speed^2)`: a joint at rest creeps instead of chattering. There is no contact. The motion
    ends where a joint reaches a limit.

    Args:
        model: of `robodyn.load`, with moving_base=True for a robot that is free.
        duration: s; by default that of the table, else 10.
        table: where the scene's drives, wrenches or initial state name columns: a file, or arrays by name with `time`
            among them, which begins when the simulation does. What it says between rows: see `Signal`.
        step: s; of a method with a fixed step; by default 1 ms, or less where friction, a drive or a spring needs it.
        rtol: of an adaptive method.
        method: a name that `robodyn simulate --help` lists; by default "rk4", "radau" where that needs
            too many steps, with `rtol` "dop853".
        executor: "numpy", "compiled", or "auto": the quicker.
        most: evaluations of the equations of motion that it may take.
        also: times at which an adaptive method is recorded too, besides the ends of its steps [s].

    Raises:
        TooMuchError: it takes more.
        InputError: the scene does not fit the robot or the table; a joint begins beyond a limit; a number is out of
            range; the method does not apply, or does not get through.

    Accuracy: the error of each method falls with its order until rounding, some 1e-14 of the largest per step.
    """
    refuse_others(model, scene)
    refuse_constraints(scene, loops=True)
    check_moves(model)
    options = choose_method(step, rtol, method)._replace(most=most)
    for name, value in {"duration": duration, "step": step, "rtol": rtol}.items():
        if value is not None and not 0.0 < value < np.inf:
            raise InputError(f"{name} is {value:g}", remedy="give a positive number")
    signal = Signal(scene, model, None if table is None else read_table(table, scene))
    scene, notes = with_friction(model, signal.scene)
    a_plan = plan(model, scene)
    length = duration or (DURATION if signal.table is None else signal.table.duration)
    start = start_of(a_plan)
    unsure = start_caveats(a_plan, start)

    def made(options: MethodOptions) -> tuple[Motion, Figures]:
        motion = integrated(a_plan, options, length, executor, signal, start, also)
        sources = {STATE: motion.states, COLUMNS: signal.at(motion.time)}
        runner = state_runner(Equations.figures, a_plan, len(signal.curves))
        columns = runner(sources, len(motion.states), executor=executor)
        if not np.isfinite(columns).all():
            raise InputError("accelerations are not finite", remedy="give every link that moves mass and inertia")
        ends = np.cumsum([model.n, model.n, 1, 1, 3])
        qdd, tau, energy, kinetic, linear, angular = np.split(columns, ends, axis=1)
        return motion, Figures(qdd, tau, energy[:, 0], kinetic[:, 0], linear, angular)

    free = Free(step is None, method is None)
    motion, figures, (options, stiff), caveats = stiff_steps(a_plan, options, start[: model.nq], length, free, made)
    loops = loop_figures(a_plan, motion, executor, signal, not options.method.adaptive)
    q, qd = np.split(motion.states[:, : model.nq + model.n], [model.nq], axis=1)
    falls = is_free(model, scene) and any(scene.gravity) and (scene.held or not untouched(model))
    pushed = deepest(model, motion.time, q, qd)
    said = [
        *model.notes,
        *signal.assumptions,
        *notes,
        *["the base is free, and nothing but gravity acts on it from outside: it falls freely"] * falls,
        *limits_at_start(model, scene),
        *start_notes(model, scene, motion.states[0], initial_state(model, scene)),
        *stiff,
        *(loops.notes if loops else ()),
        *[f"recorded every {motion.every} steps"] * (motion.every > 1),
        *[motion.note] * bool(motion.note),
        *map(str, held(model, scene, motion.time, qd)),
        *[f"springs at limits: {pushed or 'no joint reaches a limit'}"] * (scene.limit_spring is not None),
    ]
    return Simulation(
        model=model,
        scene=scene,
        method=options.method,
        step=None if options.method.adaptive else float(motion.states[0, -1]),
        rtol=options.rtol if options.method.adaptive else None,
        time=motion.time,
        q=q,
        qd=qd,
        work=motion.states[:, -2],
        figures=figures,
        steps=motion.steps,
        evaluations=motion.evaluations,
        executor=motion.executor,
        effects=a_plan.verdicts,
        loops=loops,
        ended=motion.ended,
        shaky=(*unsure, *caveats),
        notes=tuple(said),
    )


def start_of(a_plan: Plan) -> Floats:
    """(width,) the state in which a motion begins, its loops closed; raises if they cannot be."""
    state = initial_state(a_plan.model, a_plan.scene)
    return closed_start(a_plan, state) if a_plan.scene.loops else state


def integrated(
    a_plan: Plan,
    options: MethodOptions,
    duration: float,
    executor: str,
    signal: Signal,
    state: Floats,
    also: Sequence[float] = (),
) -> Motion:
    """The motion from a state of `start_of`; `also` as for `simulate`."""
    method, limits = options.method, Limits(a_plan.model, a_plan.scene.joint_limits == "stop")
    signal.check_duration(duration)
    limits.check_start(state)
    if method.adaptive:
        adaptive = AdaptiveSteps(a_plan, method, options.rtol, executor, signal, options.most)
        return adaptive.motion(state, duration, limits, also)
    check_applies(a_plan, method)
    count = int(min(duration / options.step, 1e9)) + len(signal.corners())
    fixed = FixedSteps(a_plan, method, executor, count, signal)
    return fixed.motion(state, duration, options.step, limits, options.most)
