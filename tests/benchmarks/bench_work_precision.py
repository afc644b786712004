"""Error against time of simulated motions, in one run: `cd tests && python -m benchmarks.bench_work_precision`.

For each program the least time in which it comes within an error at the end of the motion, by the best of its methods
and settings, which are tried from coarse to fine. Errors are relative to the largest angle or rate of the motion (to 1
for rotation matrices), against power series of the solution in 77 digits. One thread each; robots are read, and machine
code is made, before. SciPy's methods are given plain Python where the equations are short, else Pinocchio's `aba`;
Pinocchio has no integrator: RK4 is called from Python; MuJoCo does all steps in one call.

Every run returns what is compared: angles and rates of robots of hinges, the rotation matrix and the angular velocity
in the body's axes of the free body and of the top.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
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
from robodyn.programs.vectors import rotation_from_rpy
from robodyn.robot.model import Model
from robodyn.scene.scene import Friction, Scene
from robodyn.simulation.methods import METHODS, MethodOptions
from robodyn.simulation.simulate import integrated, simulate

Run = Callable[[], Any]
STEPS = 8
"""Steps per second, which are doubled from there on."""
FREE_BODY = """<mujoco><option gravity="0 0 0"/><worldbody><body><freejoint/>
<inertial pos="0 0 0" mass="12" diaginertia="1 2 3"/></body></worldbody></mujoco>"""
TOP = """<mujoco><option gravity="0 0 -9.81"/><worldbody><body><joint type="ball"/>
<inertial pos="0 0 0.1" mass="1" diaginertia="0.002 0.002 0.004"/></body></worldbody></mujoco>"""


@dataclass(frozen=True)
class System:
    """A motion from an initial state.

    Attributes:
        duration: s.
        observe: what is compared, of q and qd.
        rates: plain Python of the equations, of y = what SciPy integrates; None where Pinocchio's `aba` serves.
        mjcf: MuJoCo's description where it cannot read ours.
    """

    name: str
    model: Model
    scene: Scene
    duration: float
    observe: Callable[[Any, Any], Any] = field(default=lambda q, qd: np.concatenate((q, qd)))
    rates: Callable[[float, Any], Any] | None = None
    mjcf: str = ""

    @property
    def start(self) -> tuple[Any, Any]:
        q = dict.fromkeys(self.model.coordinates, 0.0)
        q |= {"base_qw": 1.0} if self.model.floating else {}
        qd = dict.fromkeys(self.model.rates, 0.0) | dict(self.scene.initial_qd)
        return np.array(list((q | dict(self.scene.initial_q)).values())), np.array(list(qd.values()))

    def reference(self) -> tuple[Any, Any, str]:
        """What is to be observed at the end, the scale of each number, and how that is known."""
        known = motion_reference(self.model, self.duration, partial(simulate, self.model, self.scene))
        q, qd = np.split(known.at(np.array([self.duration]))[0], [self.model.nq])
        expected = self.observe(q, qd)
        half = self.model.nq if expected.size == self.model.nq + self.model.n else 9
        scale = np.concatenate((np.full(half, np.abs(expected[:half]).max()), np.full(expected.size - half, 1.0)))
        scale[half:] = max(np.abs(self.observe(*row)[half:]).max() for row in self._along(known.at))
        if half == self.model.nq:
            scale[:half] = max(np.abs(row[0]).max() for row in self._along(known.at))
        return expected, scale, known.how

    def _along(self, at: Callable[[Any], Any]) -> Iterator[tuple[Any, Any]]:
        for row in at(np.linspace(0.0, self.duration, 200)):
            yield row[: self.model.nq], row[self.model.nq :]


def systems() -> tuple[System, ...]:
    one, two = (robodyn.load(ROBOTS / f"{name}.urdf") for name in ("pendulum", "double_pendulum"))
    ur5 = robodyn.load(path_of("ur5_robot"))
    free, top = robodyn.load(ROBOTS / "rigid_body.urdf", moving_base=True), robodyn.load(ROBOTS / "heavy_top.urdf")
    lean = dict(zip(two.coordinates, (pi / 4, 0.0), strict=True))
    bent = dict(zip(ur5.coordinates, (0.3, -1.0, 1.0, 0.2, 0.5, 0.1), strict=True))
    smooth = {name: Friction() for name in ur5.joint_names}
    flip = Scene(gravity=(0, 0, 0), initial_qd={"base_wx": 1e-3, "base_wy": 1.0, "base_wz": 1e-3}, moving_base=True)
    spin = Scene(initial_q={"nutation": 0.5}, initial_qd={"spin": 50.0})
    return (
        System("pendulum, 10 s", one, Scene(), 10.0, rates=_pendulum),
        System("double pendulum, chaotic, 5 s", two, Scene(initial_q=lean), 5.0),
        System("free body, flip, 20 s", free, flip, 20.0, _of_body, _body, FREE_BODY),
        System("heavy top, 2 s", top, spin, 2.0, _of_top, mjcf=TOP),
        System("UR5, free swing, 1 s", ur5, Scene(initial_q=bent, friction=smooth, joint_limits="ignore"), 1.0),
    )


def ours(system: System, method: str) -> Iterator[tuple[str, Run]]:
    """Settings from coarse to fine."""
    chosen = next(each for each in METHODS if each.name == method)
    a_plan, (q, qd) = plan(system.model, system.scene), system.start
    if chosen.adaptive:
        for digits in range(3, 14):
            how = MethodOptions(chosen, 0.0, 10.0**-digits)
            yield f"rtol 1e-{digits}", partial(_ending, system, integrated, a_plan, how, system.duration, "compiled")
    for k in count(0) if not chosen.adaptive else ():
        steps = max(round(system.duration * STEPS * 2**k), 1)
        run = partial(robodyn.rollouts, system.model, q[None], qd[None], steps, system.duration / steps, every=steps)
        run = partial(run, scene=system.scene, method=method, executor="compiled", threads=1)
        yield f"{steps} steps", partial(_last, system, run)


def scipys(system: System, method: str) -> Iterator[tuple[str, Run]]:
    """By plain Python where equations are short, else by Pinocchio's `aba`, called from Python."""
    q, qd = system.start
    rates, first, observe = system.rates, np.concatenate((q, qd)), system.observe
    if system.model.floating:
        first, observe = np.concatenate((q[3:7], qd[:3])), lambda h, w: _of_body(np.concatenate((q[:3], h)), w)
    split = len(first) - (3 if system.model.floating else system.model.n)
    rates = rates or _by_aba(system)
    for digits in range(3, 14):
        how = {"method": method, "rtol": max(10.0**-digits, 3e-14), "atol": 10.0**-digits}

        def run(how: dict[str, Any] = how) -> Any:
            found = solve_ivp(rates, (0.0, system.duration), first, t_eval=[system.duration], **how)
            return observe(*np.split(found.y[:, -1], [split]))

        yield f"rtol 1e-{digits}", run


def mujocos(system: System, integrator: str) -> Iterator[tuple[str, Run]]:
    """All steps in one call, in C."""
    spec = mujoco.MjSpec.from_string(system.mjcf or bare_description(system.model))
    spec.compiler.boundinertia = 2e-15
    for joint in spec.joints:
        joint.limited = 0
    model = spec.compile()
    model.opt.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator.upper()}")
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    model.dof_damping[:] = model.dof_frictionloss[:] = 0.0
    data = mujoco.MjData(model)
    mujoco.set_mju_user_warning(lambda _: None)  # steps that are too long are not told in a file
    for k in count(0):
        steps = max(round(system.duration * STEPS * 2**k), 1)

        def run(steps: int = steps) -> Any:
            mujoco.mj_resetData(model, data)
            data.qpos[:], data.qvel[:] = _mujoco_state(system)
            model.opt.timestep = system.duration / steps
            mujoco.mj_step(model, data, steps)
            if not system.mjcf:
                return system.observe(data.qpos.copy(), data.qvel.copy())
            return np.concatenate((_matrix(np.roll(data.qpos[-4:], -1)), data.qvel[-3:]))

        yield f"{steps} steps", run


def pinocchios(system: System) -> Iterator[tuple[str, Run]]:
    """RK4 from Python around `aba`."""
    if system.model.floating:
        return
    rates, (q, qd) = _by_aba(system), system.start
    for k in count(0):
        steps = max(round(system.duration * STEPS * 2**k), 1)

        def run(steps: int = steps) -> Any:
            y, h = np.concatenate((q, qd)), system.duration / steps
            for _ in range(steps):
                a = rates(0.0, y)
                b = rates(0.0, y + 0.5 * h * a)
                c = rates(0.0, y + 0.5 * h * b)
                y = y + h / 6 * (a + 2 * b + 2 * c + rates(0.0, y + h * c))
            return system.observe(*np.split(y, [system.model.nq]))

        yield f"{steps} steps", run


def _last(system: System, run: Callable[[], Any]) -> Any:
    found = run()
    return system.observe(found.q[-1, 0], found.qd[-1, 0])


def _ending(system: System, run: Callable[..., Any], *how: Any) -> Any:
    state, model = run(*how)[0].states[-1], system.model
    return system.observe(state[: model.nq], state[model.nq : model.nq + model.n])


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


def _pendulum(_: float, y: Any) -> tuple[float, float]:
    return y[1], -9.81 * cos(y[0])


def _body(_: float, y: Any) -> tuple[float, ...]:
    """Quaternion x y z w and angular velocity of a body with moments 1, 2, 3."""
    x, y_, z, s, a, b, c = y.tolist()
    half = (s * a + y_ * c - z * b, s * b + z * a - x * c, s * c + x * b - y_ * a, -x * a - y_ * b - z * c)
    return (*(0.5 * part for part in half), -b * c, c * a, -a * b / 3)


def _of_body(q: Any, qd: Any) -> Any:
    return np.concatenate((_matrix(q[3:7]), qd[:3]))


def _matrix(h: Any) -> Any:
    x, y, z, s = h / np.linalg.norm(h)
    rows = (1 - 2 * (y * y + z * z), 2 * (x * y - z * s), 2 * (x * z + y * s))
    rows += (2 * (x * y + z * s), 1 - 2 * (x * x + z * z), 2 * (y * z - x * s))
    return np.array((*rows, 2 * (x * z - y * s), 2 * (y * z + x * s), 1 - 2 * (x * x + y * y)))


def _of_top(q: Any, qd: Any) -> Any:
    """Precession about z, nutation about y, spin about z."""
    turn, lean, spin = (rotation_from_rpy(0, 0, q[0]), rotation_from_rpy(0, q[1], 0), rotation_from_rpy(0, 0, q[2]))
    R = (turn @ lean @ spin).astype(float)
    w = qd[0] * (lean @ spin).T[:, 2] + qd[1] * spin.T[:, 1] + qd[2] * np.array((0.0, 0.0, 1.0))
    return np.concatenate((R.ravel(), w.astype(float)))


def _mujoco_state(system: System) -> tuple[Any, Any]:
    q, qd = system.start
    if not system.mjcf:
        return q, qd
    if system.model.floating:
        return np.array((0, 0, 0, 1.0, 0, 0, 0)), np.concatenate((qd[3:], qd[:3]))
    return np.array((cos(q[1] / 2), 0.0, sin(q[1] / 2), 0.0)), system.observe(q, qd)[9:]


TARGETS = 1e-6, 1e-10
COARSEST, FINEST = 1e-3, 1e-12
LONGEST = 0.5
"""Seconds of a run, beyond which nothing finer is tried."""
WORTH = 30.0
"""A setting this many times slower than the quickest that is as good is not measured again."""
OURS = "rk4", "gauss6", "dop853"
SCIPY = "RK45", "DOP853", "LSODA", "Radau"
MUJOCO = "Euler", "RK4", "implicitfast"


class Point(NamedTuple):
    """A setting of a method of a program, its error and seconds."""

    program: str
    method: str
    setting: str
    error: float
    seconds: float

    @property
    def name(self) -> str:
        return f"{self.method}, {self.setting}"


def families(system: System) -> Iterator[tuple[str, str, Iterable[tuple[str, Run]]]]:
    for method in OURS:
        yield "robodyn", method, ours(system, method)
    for method in SCIPY:
        yield "SciPy", method, scipys(system, method)
    for method in MUJOCO:
        yield "MuJoCo", method, mujocos(system, method)
    yield "Pinocchio", "aba and RK4", pinocchios(system)


def points(system: System) -> tuple[list[Point], str]:
    """Every setting that is worth its time, its error at the end, and the reference."""
    expected, scale, how = system.reference()
    tried, runs = [], {}
    for program, method, settings in families(system):
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


def cheapest(found: Iterable[Point], program: str, target: float) -> Point | None:
    good = [point for point in found if point.program == program and point.error <= target]
    return min(good, key=lambda point: point.seconds, default=None)


def row(system: System, found: list[Point], target: float) -> tuple[str, ...]:
    best = {name: cheapest(found, name, target) for name in ("robodyn", "SciPy", "MuJoCo", "Pinocchio")}
    own, others = best.pop("robodyn"), [point for point in best.values() if point]
    ratio = f"{min(point.seconds for point in others) / own.seconds:.0f}" if own and others else "-"
    return system.name, f"{target:g}", *map(_cell, (own, *best.values())), ratio


def _cell(point: Point | None) -> str:
    return "-" if point is None else f"{1e3 * point.seconds:.3g} ms ({point.method})"


def report(every: int) -> str:
    """Args: every: 1 for more targets, and a line for each method that meets them."""
    rows, references, lines = [], [], []
    targets = (COARSEST, *TARGETS, FINEST) if every else TARGETS
    for system in systems():
        found, how = points(system)
        rows += [row(system, found, target) for target in targets]
        if every:
            lines += [(system.name, p.program, p.name, f"{p.error:.1e}", f"{1e3 * p.seconds:.3g}") for p in found]
        references.append(how)
    head = ("motion", "error", "robodyn", "SciPy", "MuJoCo", "Pinocchio", "next best / robodyn")
    text = table(head, rows, left=(0,))
    text += "\n" + table(("motion", "program", "setting", "error", "ms"), lines, left=(0, 1, 2)) if lines else ""
    text += f"\nReferences: {'; '.join(sorted(set(references)))}. "
    return text + machine("pin", "mujoco", "scipy", "llvmlite")


if __name__ == "__main__":
    main(report, __doc__, every=0)
