"""The second job: how a robot moves, from where it begins and what drives it."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf

import numpy as np

from robodyn.dynamics.initial_state import initial_state, limits_at_start
from robodyn.dynamics.loops.closed_start import closed_start, start_notes
from robodyn.dynamics.plan import Plan, plan
from robodyn.errors import InputError
from robodyn.programs.run.stepper import COLUMNS
from robodyn.robot.model import Model
from robodyn.scene.fit import check_moves, refuse_constraints, refuse_others
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.simulation.adaptive import AdaptiveSteps
from robodyn.simulation.balance import Balanced
from robodyn.simulation.conserving import check_free, check_leapfrog
from robodyn.simulation.equations import STATE, Equations, state_runner
from robodyn.simulation.events import Limits
from robodyn.simulation.fixed import FixedSteps, Motion
from robodyn.simulation.joint_use import assumed, deepest, held
from robodyn.simulation.loop_figures import loop_figures
from robodyn.simulation.methods import MethodOptions, choose_method
from robodyn.simulation.result import Figures, Simulation
from robodyn.simulation.singular import passing_notes, start_caveats
from robodyn.simulation.stiff_steps import Free, followed
from robodyn.simulation.stiffness import with_friction
from robodyn.simulation.table import Signal, Source, read_table
from robodyn.support.floats import Floats

DURATION = 10.0
"""s, where none is given and no table says it."""


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

    The torques are those of the scene's drives. A floating base is free, and turns by the exponential map within a
    step. Coulomb friction is `f qd / sqrt(qd^2 + slip_speed^2)`: a joint at rest creeps instead of chattering. There
    is no contact. The motion ends where a joint reaches a limit.

    Args:
        model: of `robodyn.load`, with moving_base=True for a robot that is free.
        duration: s; by default that of the table, else 10.
        table: where the scene's drives, wrenches or initial state name columns: a file, or arrays by name with `time`
            among them, which begins when the simulation does. References are cubic splines through its rows; torques
            and wrenches are straight between them, or held, as the scene says.
        step: s; of a method with a fixed step; by default 1 ms, or less where friction, a drive or a spring needs it,
            and where one of them is stiff and the balance of energy is off.
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
    _check_robot(model, scene)
    options = choose_method(step, rtol, method)._replace(most=most)
    _check_positive(duration=duration, step=step, rtol=rtol)
    signal = Signal(scene, model, None if table is None else read_table(table, scene))
    scene, notes = with_friction(model, signal.scene)
    a_plan = plan(model, scene)
    length = duration or (DURATION if signal.table is None else signal.table.duration)
    begun = initial_state(model, scene)
    start = start_of(a_plan)
    unsure = start_caveats(a_plan, start)

    def made(options: MethodOptions) -> Balanced:
        motion = integrated(a_plan, options, length, executor, signal, start, also)
        return Balanced(motion, _figures(a_plan, motion, executor, signal))

    (motion, figures), options, stiff, caveats = followed(
        a_plan,
        options,
        start[: model.nq],
        length,
        Free(step is None, method is None),
        made,
    )
    loops = loop_figures(a_plan, motion, executor, signal, not options.method.adaptive)
    q, qd = np.split(motion.states[:, : model.nq + model.n], [model.nq], axis=1)
    pushed = deepest(model, motion.time, q, qd)
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
        notes=(
            *model.notes,
            *signal.assumptions,
            *notes,
            *assumed(model, scene),
            *limits_at_start(model, scene),
            *start_notes(model, scene, motion.states[0], begun),
            *stiff,
            *(passing_notes(loops.singular, loops.usual) if loops else []),
            *([f"recorded every {motion.every} steps"] if motion.every > 1 else []),
            *([motion.note] if motion.note else []),
            *map(str, held(model, scene, motion.time, qd)),
            *([f"springs at limits: {pushed or 'no joint reaches a limit'}"] if scene.limit_spring else []),
        ),
    )


def _check_robot(model: Model, scene: Scene) -> None:
    """Raise unless these are a robot that moves, and a scene without contacts, which a simulation does not know."""
    refuse_others(model, scene)
    refuse_constraints(scene, loops=True)
    check_moves(model)


def _check_positive(**numbers: float | None) -> None:
    for name, value in numbers.items():
        if value is not None and not 0.0 < value < np.inf:
            raise InputError(f"{name} is {value:g}", remedy="give a positive number")


def start_of(a_plan: Plan) -> Floats:
    """Return (width,) the state in which a motion begins, its loops closed.

    Raises:
        InputError: they cannot be.
    """
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
    """Return the motion from a state of `start_of`; `also` as for `simulate`."""
    method, limits = options.method, Limits(a_plan.model, a_plan.scene.joint_limits == "stop")
    signal.check_duration(duration)
    limits.check_start(state)
    if method.adaptive:
        steps = AdaptiveSteps(a_plan, method, options.rtol, executor, signal, options.most)
        return steps.motion(state, duration, limits, also)
    if method.leapfrog:
        check_leapfrog(Equations(a_plan))
    if method.keeps:
        check_free(a_plan.model, a_plan.scene, method.name)
    count = int(min(duration / options.step, 1e9)) + len(signal.corners())
    ready = FixedSteps(a_plan, method, executor, count, signal)
    return ready.motion(state, duration, options.step, limits, options.most)


def _figures(a_plan: Plan, motion: Motion, executor: str, signal: Signal) -> Figures:
    n, runner = a_plan.model.n, state_runner(Equations.figures, a_plan, len(signal.curves))
    sources = {STATE: motion.states, COLUMNS: signal.at(motion.time)}
    columns = runner(sources, len(motion.states), executor=executor)
    if not np.isfinite(columns).all():
        raise InputError("accelerations are not finite", remedy="give every link that moves mass and inertia")
    qdd, tau, energy, kinetic, linear, angular = np.split(columns, np.cumsum([n, n, 1, 1, 3]), axis=1)
    return Figures(qdd, tau, energy[:, 0], kinetic[:, 0], linear, angular)
