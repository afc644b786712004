"""Error against time of simulated motions, in one run: `cd tests && python -m benchmarks.bench_work_precision`.

For each program the least time in which it comes within an error at the end of the motion, by the best of its methods
and settings, tried from coarse to fine. Errors are relative to the largest angle or rate of the motion,
against the two most accurate methods, which must agree. One thread; robots are read, and machine code made, before.
SciPy's methods are given plain Python for the pendulum, else Pinocchio's `aba`; Pinocchio has no integrator: RK4 is
called from Python; MuJoCo does all steps in one call.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import count
from math import cos, pi, sin
from time import perf_counter
from typing import Any, NamedTuple

import mujoco
import numpy as np
import pinocchio as pin
from benchmarks.pinocchio_runs import bare_description
from helpers.example_robots import path_of
from helpers.machine import machine
from helpers.markdown_tables import main, table
from helpers.oracles import ROBOTS
from scipy.integrate import solve_ivp

import robodyn
from robodyn.dynamics.plan import plan
from robodyn.measure.accuracy.ladder import timed
from robodyn.measure.accuracy.simulation import motion_reference
from robodyn.robot.model import Model
from robodyn.scene.scene import Friction, Scene
from robodyn.simulation.methods import METHODS, MethodOptions
from robodyn.simulation.simulate import integrated, simulate

Run = Callable[[], Any]
STEPS = 8
"""Steps per second, which are doubled from there on."""


@dataclass(frozen=True)
class System:
    """A motion of a robot of hinges from an initial state.

    Attributes:
        duration: s.
        rates: plain Python of the equations, of y = (q, qd); None where Pinocchio's `aba` serves.
    """

    name: str
    model: Model
    scene: Scene
    duration: float
    rates: Callable[[float, Any], Any] | None = None

    @property
    def start(self) -> Any:
        """q and qd."""
        q, qd = (dict.fromkeys(names, 0.0) for names in (self.model.coordinates, self.model.rates))
        return np.array([*(q | dict(self.scene.initial_q)).values(), *(qd | dict(self.scene.initial_qd)).values()])

    def reference(self) -> tuple[Any, Any, str]:
        """q and qd at the end, the scale of each number, and how that is known."""
        known = motion_reference(self.model, self.duration, partial(simulate, self.model, self.scene))
        path = known.at(np.linspace(0.0, self.duration, 200))
        scale = [np.full(self.model.n, np.abs(half).max()) for half in np.split(path, 2, axis=1)]
        return path[-1], np.concatenate(scale), known.how

    def steps(self) -> Iterator[int]:
        """Numbers of steps, each twice the one before."""
        return (max(round(self.duration * STEPS * 2**k), 1) for k in count(0))


def systems() -> tuple[System, ...]:
    one, two = (robodyn.load(ROBOTS / f"{name}.urdf") for name in ("pendulum", "double_pendulum"))
    ur5 = robodyn.load(path_of("ur5_robot"))
    lean = dict(zip(two.coordinates, (pi / 4, 0.0), strict=True))
    bent = dict(zip(ur5.coordinates, (0.3, -1.0, 1.0, 0.2, 0.5, 0.1), strict=True))
    smooth = {name: Friction() for name in ur5.joint_names}
    return (
        System("pendulum, 10 s", one, Scene(), 10.0, lambda _, y: (y[1], -9.81 * cos(y[0]))),
        System("double pendulum, chaotic, 5 s", two, Scene(initial_q=lean), 5.0),
        System("UR5, free swing, 1 s", ur5, Scene(initial_q=bent, friction=smooth, joint_limits="ignore"), 1.0),
    )


def ours(system: System, method: str) -> Iterator[tuple[str, Run]]:
    """Settings from coarse to fine."""
    chosen = next(each for each in METHODS if each.name == method)
    a_plan, (q, qd) = plan(system.model, system.scene), np.split(system.start, 2)
    if chosen.adaptive:
        for digits in range(3, 14):
            how = MethodOptions(chosen, 0.0, 10.0**-digits)
            yield f"rtol 1e-{digits}", partial(_ending, integrated, a_plan, how, system.duration, "compiled")
        return
    for steps in system.steps():
        run = partial(robodyn.rollouts, system.model, q[None], qd[None], steps, system.duration / steps, every=steps)
        run = partial(run, scene=system.scene, method=method, executor="compiled", threads=1)
        yield f"{steps} steps", partial(_last, run)


def _last(run: Callable[[], Any]) -> Any:
    found = run()
    return np.concatenate((found.q[-1, 0], found.qd[-1, 0]))


def _ending(run: Callable[..., Any], a_plan: Any, *how: Any) -> Any:
    return run(a_plan, *how)[0].states[-1][: 2 * a_plan.model.n]


def scipys(system: System, method: str) -> Iterator[tuple[str, Run]]:
    """By plain Python where equations are short, else by Pinocchio's `aba`, called from Python."""
    rates = system.rates or _by_aba(system)
    for digits in range(3, 14):
        how = {"method": method, "rtol": max(10.0**-digits, 3e-14), "atol": 10.0**-digits}

        def run(how: dict[str, Any] = how) -> Any:
            return solve_ivp(rates, (0.0, system.duration), system.start, t_eval=[system.duration], **how).y[:, -1]

        yield f"rtol 1e-{digits}", run


def mujocos(system: System, integrator: str) -> Iterator[tuple[str, Run]]:
    """All steps in one call, in C."""
    spec = mujoco.MjSpec.from_string(bare_description(system.model))
    spec.compiler.boundinertia = 2e-15
    for joint in spec.joints:
        joint.limited = 0
    model = spec.compile()
    model.opt.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator.upper()}")
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    model.dof_damping[:] = model.dof_frictionloss[:] = 0.0
    data = mujoco.MjData(model)
    mujoco.set_mju_user_warning(lambda _: None)  # steps that are too long are not told in a file
    for steps in system.steps():

        def run(steps: int = steps) -> Any:
            mujoco.mj_resetData(model, data)
            data.qpos[:], data.qvel[:] = np.split(system.start, 2)
            model.opt.timestep = system.duration / steps
            mujoco.mj_step(model, data, steps)
            return np.concatenate((data.qpos, data.qvel))

        yield f"{steps} steps", run


def pinocchios(system: System) -> Iterator[tuple[str, Run]]:
    """RK4 from Python around `aba`."""
    rates = _by_aba(system)
    for steps in system.steps():

        def run(steps: int = steps) -> Any:
            y, h = system.start, system.duration / steps
            for _ in range(steps):
                a = rates(0.0, y)
                b = rates(0.0, y + 0.5 * h * a)
                c = rates(0.0, y + 0.5 * h * b)
                y = y + h / 6 * (a + 2 * b + 2 * c + rates(0.0, y + h * c))
            return y

        yield f"{steps} steps", run


def _by_aba(system: System) -> Callable[[float, Any], Any]:
    model = pin.buildModelFromXML(bare_description(system.model))
    data, n = model.createData(), model.nv
    still, flat = np.zeros(n), model.nq == model.nv
    turning = [joint.nq == 2 for joint in model.joints[1:]]

    def rates(_: float, y: Any) -> Any:
        q, v = y[:n], y[n:]
        if not flat:
            parts = [(cos(x), sin(x)) if turns else (x,) for x, turns in zip(q.tolist(), turning, strict=True)]
            q = np.array([x for part in parts for x in part])
        return np.concatenate((v, pin.aba(model, data, q, v, still)))

    return rates


TARGETS = 1e-6, 1e-10
COARSEST, FINEST = 1e-3, 1e-12
LONGEST = 0.5
"""Seconds of a run, beyond which nothing finer is tried."""
WORTH = 30.0
"""A setting this many times slower than the quickest that is as good is not measured again."""
FAMILIES = {
    "robodyn": (ours, ("rk4", "gauss6", "dop853")),
    "SciPy": (scipys, ("RK45", "DOP853", "LSODA", "Radau")),
    "MuJoCo": (mujocos, ("Euler", "RK4", "implicitfast")),
    "Pinocchio": (lambda system, _: pinocchios(system), ("aba and RK4",)),
}


class Point(NamedTuple):
    """A setting of a method of a program, its error and seconds."""

    program: str
    method: str
    setting: str
    error: float
    seconds: float


def points(system: System) -> tuple[list[Point], str]:
    """Every setting that is worth its time, its error at the end, and the reference."""
    expected, scale, how = system.reference()
    tried, runs = [], {}
    for program, method, settings in (
        (program, method, make(system, method)) for program, (make, methods) in FAMILIES.items() for method in methods
    ):
        best, worse = np.inf, 0
        for setting, run in settings:
            run()
            begin = perf_counter()
            with np.errstate(all="ignore"):
                error = float((np.abs(run() - expected) / scale).max())
            seconds = perf_counter() - begin
            tried.append(Point(program, method, setting, error, seconds))
            runs[tried[-1]] = run
            worse = 0 if error < 0.5 * best else worse + 1
            best = min(best, error)
            if seconds > LONGEST or worse > 3 or best < FINEST:
                break
    good = [point for point in tried if point.error <= COARSEST]
    kept = [point for point in good if point.seconds <= WORTH * _least(good, point)]
    times = timed({str(k): runs[point] for k, point in enumerate(kept)})
    return [point._replace(seconds=times[str(k)][1].median) for k, point in enumerate(kept)], how


def _least(tried: Iterable[Point], point: Point) -> float:
    same = [each for each in tried if each.program == point.program]
    return min(each.seconds for each in same if each.error <= point.error)


def row(system: System, found: list[Point], target: float) -> tuple[str, ...]:
    best: dict[str, Point | None] = {}
    for name in FAMILIES:
        good = [point for point in found if point.program == name and point.error <= target]
        best[name] = min(good, key=lambda point: point.seconds, default=None)
    cells = ["-" if point is None else f"{1e3 * point.seconds:.3g} ms ({point.method})" for point in best.values()]
    own, others = best.pop("robodyn"), [point for point in best.values() if point]
    ratio = f"{min(point.seconds for point in others) / own.seconds:.0f}" if own and others else "-"
    return system.name, f"{target:g}", *cells, ratio


def report() -> str:
    rows, references = [], set()
    for system in systems():
        found, how = points(system)
        rows += [row(system, found, target) for target in TARGETS]
        references.add(how)
    head = ("motion", "error", "robodyn", "SciPy", "MuJoCo", "Pinocchio", "next best / robodyn")
    text = table(head, rows, left=(0,)) + f"\nReferences: {'; '.join(sorted(references))}. "
    return text + machine("pin", "mujoco", "scipy", "llvmlite")


if __name__ == "__main__":
    main(report, __doc__)
