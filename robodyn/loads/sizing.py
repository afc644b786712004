"""How joints, motors, bearings and the foundation are used along a motion, gathered block by block."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from robodyn.dynamics.plan import torque_runner
from robodyn.loads.motors import MotorPass, train_of
from robodyn.loads.result import JointLoad
from robodyn.loads.sizing_result import (
    BearingLoad,
    Component,
    Exceeded,
    FoundationLoad,
    JointSizing,
    Level,
    MotorLoad,
    Sizing,
    Vector,
)
from robodyn.loads.statistics import Extremes, Greatest, Integrals, resultant
from robodyn.programs.run.runner import Runner
from robodyn.programs.vectors import length, product
from robodyn.robot.model import Joint, Model
from robodyn.scene.scene import Scene
from robodyn.support.floats import BEYOND, Floats, steady
from robodyn.trajectory.motion import Trajectory

NAMES = {"revolute": ("fu", "fv", "fa", "mu", "mv"), "prismatic": ("fu", "fv", "mu", "mv", "ma")}
_RESULTANTS = ("radial", "tilting")
_WIDTH = 7


class BearingPass:
    """Peaks and mean squares of the five components that each joint cannot give way to."""

    def __init__(self, model: Model) -> None:
        numbered = enumerate(body.joint for body in model.bodies[1:])
        self.joints = [(k, joint) for k, joint in numbered if joint.kind in NAMES]
        self.frames = [frame(joint.axis) for _, joint in self.joints]
        self.peaks = Greatest(_WIDTH * len(self.joints))
        self.integrals = Integrals()

    def update(self, time: Floats, first_row: int, wrenches: Floats) -> None:
        """Take in a block.

        Args:
            time: (N,) s; first_row: of the data, from 1.
            wrenches: (N, 6 (bodies - 1)) f and m on every body but the base, in its axes.
        """
        rows = [
            _components(joint, turn, wrenches[:, 6 * k : 6 * k + 6])
            for (k, joint), turn in zip(self.joints, self.frames, strict=True)
        ]
        values = np.concatenate(rows) if rows else np.empty((0, len(time)))
        self.peaks.update(time, first_row, np.abs(values), value=values)
        self.integrals.update(time, {"square": values * values})

    def report(self) -> tuple[BearingLoad, ...]:
        """Return the loads so far; those of a motion without duration are their own RMS."""
        peaks = self.peaks
        rms = np.sqrt(self.integrals.mean("square", peaks.score**2))

        def component(at: int, name: str) -> Component:
            unit = "N m" if name.startswith(("m", "t")) else "N"
            value, when = float(peaks.kept["value"][at]), float(peaks.time[at])
            return Component(name, unit, value, when, int(peaks.row[at]), float(rms[at]))

        loads = []
        for i, ((_, joint), turn) in enumerate(zip(self.joints, self.frames, strict=True)):
            parts = [component(_WIDTH * i + k, name) for k, name in enumerate((*NAMES[joint.kind], *_RESULTANTS))]
            u, v, axis = (_vector(row) for row in turn)
            loads.append(BearingLoad(joint.name, joint.kind, (u, v, axis), tuple(parts[:5]), parts[5], parts[6]))
        return tuple(loads)


def frame(axis: Floats) -> Floats:
    """Return (3, 3) rows u, v and the axis, right-handed.

    u and v are the coordinate axes that follow the axis in x, y, z, x if it is along one of them (-v if it is against
    it); otherwise u is at right angles to the axis and to the coordinate axis that it is furthest from.
    """
    along = np.abs(axis)
    if along.max() == 1.0:
        k = int(along.argmax())
        u = np.roll(np.eye(3)[k], 1)
    else:
        u = np.cross(axis, np.eye(3)[int(along.argmin())])
        u /= length(u)
    return np.array([u, np.cross(axis, u), axis])


def _components(joint: Joint, turn: Floats, wrench: Floats) -> Floats:
    """(7, N) the five components, then radial force and tilting moment."""
    f, m = product(turn, wrench[:, :3].T), product(turn, wrench[:, 3:].T)
    kept = (f, m[:2]) if joint.kind == "revolute" else (f[:2], m)
    return np.vstack((*kept, resultant(f[0], f[1]), resultant(m[0], m[1])))


def _vector(row: Floats) -> Vector:
    x, y, z = (float(value) + 0.0 for value in row)
    return x, y, z


PIECE = 8192
"""Samples worked on at a time, so that what belongs to them stays in the cache."""
FOUNDATION = ("fxy", "fz", "mxy", "mz")


class SizingPass:
    """Gathers what `Sizing` tells, block by block."""

    def __init__(self, model: Model, scene: Scene, joints: Sequence[Joint], rates: slice) -> None:
        """Args: joints: those whose loads are reported; rates: their entries of tau."""
        self.model, self.scene, self.rates = model, scene, rates
        found = [(k, train_of(joint, scene)) for k, joint in enumerate(joints)]
        self.driven = [k for k, train in found if train is not None]
        self.motors = MotorPass([train for _, train in found if train is not None])
        self.bearings = BearingPass(model)
        self.static = Greatest(len(joints))
        self.base = Extremes(FOUNDATION)
        self.integrals = Integrals()
        self.slowest = np.zeros(len(joints))

    def take(
        self,
        block: Trajectory,
        loads: Floats,
        static: Floats,
    ) -> None:
        """Take in a block.

        Args:
            loads: (N, k) tau, the base wrench, and the wrenches of all other bodies.
            static: (N, n) torques that hold its poses at rest.
        """
        if block.slowest is not None:
            self.slowest = block.slowest[self.rates]
        for start in range(0, len(block), PIECE):
            k = slice(start, start + PIECE)
            motion = (block.qd[k, self.rates], block.qdd[k, self.rates], static[k, self.rates])
            self._update(block.time[k], block.first_row + start, loads[k], *motion)

    def _update(self, time: Floats, row: int, loads: Floats, *motion: Floats) -> None:
        """Take in a few samples: their loads, and qd, qdd and static torques (N, joints)."""
        n = self.model.n
        tau, qd, qdd, static = (np.ascontiguousarray(x.T) for x in (loads[:, :n][:, self.rates], *motion))
        self.static.update(time, row, np.abs(static), value=static)
        f, m = loads[:, n : n + 3], loads[:, n + 3 : n + 6]
        base = np.column_stack((resultant(f[:, 0], f[:, 1]), f[:, 2], resultant(m[:, 0], m[:, 1]), m[:, 2]))
        self.base.update(time, base)
        pace = np.abs(qd)
        quantities = {
            "moving": (pace > self.slowest[:, None]).astype(float),
            "travel": pace,
            "static square": static * static,
            "base": base.T,
        }
        self.integrals.update(time, quantities)
        self.bearings.update(time, row, loads[:, n + 6 :])
        if self.driven:
            k = self.driven
            self.motors.update(time, row, tau[k], qd[k], qdd[k])

    def static_runner(self) -> Runner:
        """Return the torques of standing still in each pose."""
        rates = frozenset((source, k) for source in ("qd", "qdd") for k in range(self.model.n))
        return torque_runner(self.model, self.scene, rates)

    @property
    def figures(self) -> Iterator[Floats]:
        """All integrals, which are finite unless something overflows."""
        for integrals in (self.integrals, self.motors.integrals, self.bearings.integrals):
            yield from integrals.totals.values()

    def report(self, loads: Sequence[JointLoad], inertias: Mapping[int, float | None]) -> Sizing:
        """Return everything gathered.

        Args:
            loads: of the joints; inertias: of those with motors, what each accelerates at its peak, with its rotor;
                None of those that nothing drives.
        """
        duration = self.integrals.duration
        motors = {k: self._motor(i, duration, inertias[k]) for i, k in enumerate(self.driven)}
        joints = tuple(self._joint(k, load, motors.get(k), duration) for k, load in enumerate(loads))
        return Sizing(joints, self.bearings.report(), self._foundation())

    def _motor(self, i: int, duration: float, inertia: float | None) -> MotorLoad:
        train = self.motors.trains[i]
        own = train.gear * train.gear * train.inertia
        return self.motors.load(i, duration, None if inertia is None else inertia - own)

    def _joint(self, k: int, load: JointLoad, motor: MotorLoad | None, duration: float) -> JointSizing:
        totals = self.integrals.totals
        still = duration <= 0
        peak = float(self.static.kept["value"][k])
        rms = abs(peak) if still else float(np.sqrt(totals["static square"][k] / duration))
        limited = list(self._limited(k, load, motor))
        exceeded = sorted((each for each in limited if each.value > BEYOND * each.limit), key=_severity)
        level: Level = exceeded[0].level if exceeded else "OK" if limited else "no limits"
        moving = abs(load.max_speed) > self.slowest[k]
        return JointSizing(
            name=load.name,
            unit=load.unit,
            duty_cycle=float(moving) if still else min(float(totals["moving"][k]) / duration, 1.0),
            standstill=float(self.slowest[k]),
            mean_speed=abs(load.max_speed) if still else float(totals["travel"][k]) / duration,
            static_peak=peak,
            static_peak_time=float(self.static.time[k]),
            static_rms=rms,
            static_share=rms / load.rms if load.rms else 0.0,
            motor=motor,
            level=level,
            exceeded=tuple(exceeded),
        )

    def _limited(self, k: int, load: JointLoad, motor: MotorLoad | None) -> Iterator[Exceeded]:
        """Yield what has a limit, whether that is exceeded or not."""
        when = load.peak_time, load.peak_row, None, load.seconds_over_effort
        fastest = load.max_speed_time, load.max_speed_row, None, load.seconds_over_velocity
        unit = "rad/s" if load.unit == "N m" else "m/s"
        rows: list[tuple[Any, ...]] = [
            *(() if motor is None else (*_motor_rows(motor), *self._gear_rows(self.driven.index(k), load.unit))),
            ("effort", abs(load.peak), load.effort_limit, load.unit, *when),
            ("velocity", abs(load.max_speed), load.velocity_limit, unit, *fastest),
        ]
        return (Exceeded(*row) for row in rows if row[2] is not None)

    def _gear_rows(self, i: int, unit: str) -> Iterator[tuple[Any, ...]]:
        motor, gear, seconds = self.motors.trains[i].motor, self.motors.gear, self.motors.integrals.totals["over gear"]
        when = float(gear.time[i]), int(gear.row[i]), None, float(seconds[i])
        yield "gear torque", float(gear.score[i]), motor.gear_peak, unit, *when
        yield "mean gear torque", self.motors.mean_gear_torque(i), motor.gear_average, unit

    def _foundation(self) -> tuple[FoundationLoad, ...]:
        figures = self.base.figures
        means = self.integrals.mean("base", figures[2])
        rows = zip(*(values.tolist() for values in (*figures, means)), strict=True)
        return tuple(
            FoundationLoad(name, "N" if name[0] == "f" else "N m", *row)
            for name, row in zip(FOUNDATION, rows, strict=True)
        )


def _motor_rows(motor: MotorLoad) -> Iterator[tuple[Any, ...]]:
    near, fastest = motor.nearest, (motor.max_speed_time, motor.max_speed_row, None, motor.seconds_over_speed)
    if near is not None:
        at_speed = (near.time, near.row, near.speed, motor.seconds_over_peak)
        yield "motor torque", near.torque, near.limit, motor.unit, *at_speed
    yield "motor speed", abs(motor.max_speed), motor.speed_limit, motor.speed_unit, *fastest
    yield "RMS motor torque", motor.rms, motor.continuous_limit, motor.unit, None, None, motor.mean_speed


def _severity(exceeded: Exceeded) -> tuple[bool, float]:
    """Return what breaks before what wears, then by how far in relation to the limit."""
    return exceeded.level != "over peak", -float(steady(exceeded.value / exceeded.limit)) if exceeded.limit else -np.inf
