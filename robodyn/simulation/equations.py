"""The equations of motion that a simulation integrates, what they conserve, and a Runge-Kutta step as programs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np

from robodyn.dynamics.effects.effect import Effect, Sample
from robodyn.dynamics.effects.motors import angular_momentum
from robodyn.dynamics.effects.rigid_bodies import PAYLOAD
from robodyn.dynamics.forward import accelerations
from robodyn.dynamics.initial_state import independent_equations
from robodyn.dynamics.loops.closure import local_rates, moved, unit
from robodyn.dynamics.momenta import TotalMomenta, position_rates, power_lost, stored_energy, total_momenta
from robodyn.dynamics.plan import Plan, applied, runner_of
from robodyn.dynamics.recursions.articulated_body import aligned
from robodyn.errors import InputError
from robodyn.programs.program import Program, trace, traced
from robodyn.programs.run.runner import Runner
from robodyn.programs.run.stepper import COLUMNS
from robodyn.programs.scalar import Tape
from robodyn.programs.vectors import Array, Scalar, cross, total
from robodyn.robot.kinematics import Motion
from robodyn.robot.model import Model
from robodyn.scene.scene import GROUND, Entry, Scene
from robodyn.simulation.methods import Method
from robodyn.simulation.table import LOAD, RATE, REFERENCE, Curve, curves
from robodyn.solids.inertia.laws import Inertia
from robodyn.support.floats import Floats

STATE = "state"  # the source of programs whose columns are q, qd, the work done so far and the step
Given = Mapping[Curve, Scalar]  # the values of a scene's curves at one moment
REST = 2.0**-16
"""Times the square of positions (and 1) per step; what is left of that in a step is less than their rounding."""


class Rates(NamedTuple):
    """Rates of u (a step's coordinates), of qd, and of the work done on the robot."""

    u: list[Scalar]
    qd: list[Scalar]
    work: Scalar


class State(NamedTuple):
    """q (nq), qd (n), the work done on the robot since the start [J], the step [s], and P and H where they are kept."""

    q: Sequence[Scalar]
    qd: Sequence[Scalar]
    work: Scalar
    step: Scalar
    kept: Sequence[Scalar] = ()


class Equations:
    """`u' = qd`, `qd' = M^-1 (tau - bias)`, `work' = tau qd - losses` of a model in a scene."""

    def __init__(self, plan: Plan) -> None:
        self.plan, self.model, self.scene = plan, plan.model, plan.scene
        self.width = self.model.nq + self.model.n + 2  # of a state
        self.chain = independent_equations(plan) if self.scene.loops else None
        self.curves = curves(self.scene)
        self._aligned = aligned(self.model)

    def settled(self, q: Sequence[Scalar], qd: Sequence[Scalar]) -> tuple[list[Scalar], list[Scalar]]:
        """The state after a step, with unit quaternions and on the loops."""
        q = unit(self.model, q)
        return (q, list(qd)) if self.chain is None else self.chain.settled(q, qd)

    def given(self, tape: Tape, node: int = 0) -> Given:
        """The curves at one of the moments of a program."""
        return {curve: tape.input(COLUMNS, k) for k, curve in enumerate(self.curves, node * len(self.curves))}

    def drives(self, q: Sequence[Scalar], qd: Sequence[Scalar], given: Given) -> list[Scalar]:
        """The torques that the scene's drives apply."""

        def value(entry: Entry, kind: str) -> Scalar:
            return given[Curve(entry, kind)] if isinstance(entry, str) else entry

        tau: list[Scalar] = [0.0] * self.model.n
        for joint in self.model.independent:
            drive = self.scene.drive.get(joint.name)
            if drive is None:
                continue
            torque, i = value(drive.torque, LOAD), joint.rate
            if drive.kp:
                torque = torque + drive.kp * (value(drive.reference, REFERENCE) - q[joint.coordinate])
            if drive.kd:
                if drive.speed is not None:
                    speed = value(drive.speed, REFERENCE)
                else:
                    speed = value(drive.reference, RATE) if isinstance(drive.reference, str) else 0.0
                torque = torque + drive.kd * (speed - qd[i])
            tau[i] = torque
        return tau

    def rates(self, q: Sequence[Scalar], u: Sequence[Scalar], qd: Sequence[Scalar], given: Given) -> Rates:
        """The rates at a displacement u from q."""
        qdd, work = self.accelerations(moved(self.model, q, u), qd, given)
        return Rates(local_rates(self.model, u, qd), qdd, work)

    def sample(self, model: Model, q: Sequence[Scalar], qd: Sequence[Scalar], given: Given) -> Sample:
        """A sample without accelerations, as effects read it."""
        columns = {curve.column: value for curve, value in given.items() if curve.kind == LOAD}
        return Sample(model, tuple(q), tuple(qd), (0.0,) * model.n, columns)

    def accelerations(
        self, q: Sequence[Scalar], qd: Sequence[Scalar], given: Given, effects: Sequence[Effect] | None = None
    ) -> tuple[list[Scalar], Scalar]:
        """qdd and the power that the drives and the surroundings give the robot [W]; effects of the plan if None."""
        sample = self.sample(self._aligned, q, qd, given)
        terms = applied(self.plan.effects if effects is None else effects, sample, self.scene)
        tau = self.drives(q, qd, given)
        if self.chain is None:
            qdd = accelerations(sample, terms, tau, self.scene)
        else:
            qdd, _ = self.chain.accelerations(sample, terms, tau)
        if terms.load:
            sample = replace(sample, qdd=tuple(qdd))
            terms = applied(self.plan.effects, sample, self.scene)
        power: Scalar = 0.0 - power_lost(self.plan, sample, terms, sample.motions())
        for torque, rate in zip(tau, qd, strict=True):
            power = power + torque * rate
        return qdd, power

    def state(self, tape: Tape) -> State:
        nq, n = self.model.nq, self.model.n
        values = [tape.input(STATE, k) for k in range(self.width)]
        return State(values[:nq], values[nq : nq + n], values[-2], values[-1])

    @traced
    def derivatives(self, tape: Tape) -> Iterable[Scalar]:
        """The program of the rates of (q, qd, work), quaternions being four numbers, for methods that know no turns."""
        state = self.state(tape)
        qdd, work = self.accelerations(state.q, state.qd, self.given(tape))
        return [*position_rates(self.model, state.q, state.qd), *qdd, work]

    @traced
    def figures(self, tape: Tape) -> Iterable[Scalar]:
        """The program of qdd, tau, stored and kinetic energy, linear momentum and that about the centre of mass."""
        state, given = self.state(tape), self.given(tape)
        qdd, _ = self.accelerations(state.q, state.qd, given)
        sample = self.sample(self.model, state.q, state.qd, given)
        terms = applied(self.plan.effects, sample, self.scene)
        joints = sample.motions()
        energy = stored_energy(self.plan, sample, terms, joints)
        whole = self._momentum(sample, joints, terms.inertias)
        return [*qdd, *self.drives(state.q, state.qd, given), energy, whole.T, *whole.P, *whole.H]

    def _momentum(self, sample: Sample, joints: list[Motion], inertias: Sequence[Inertia]) -> TotalMomenta:
        """P and H in the ground's axes, H about the centre of mass: `R P_base`, `R (H_base - c x P_base)`."""
        whole, R = total_momenta(self.model.parents, joints, inertias), joints[0].R
        spinning = angular_momentum(sample, self.scene, joints)
        return whole._replace(P=R @ whole.P, H=R @ (whole.H + spinning - cross(whole.mc, whole.P) / whole.m))

    def momentum(self, q: Sequence[Scalar], qd: Sequence[Scalar]) -> TotalMomenta:
        """The momenta of the bodies and payloads in the ground's axes, H about the centre of mass."""
        sample = self.sample(self.model, q, qd, {})
        return self._momentum(sample, sample.motions(), applied([PAYLOAD], sample, self.scene).inertias)

    def with_momenta(self, P: Array, H: Array, q: Sequence[Scalar], qd: list[Scalar]) -> list[Scalar]:
        """qd with other rates of the floating base, so that the momenta at q are P and H: `A dw + m R_0 dv = dP`,
        `B dw = dH`, columns k of A and B being those of a unit of its angular velocity k, R_0 the axes of v."""
        base = next(body for body in self.model.bodies if body.joint.kind == "floating")
        first, n = base.joint.rate, self.model.n
        now = self.momentum(q, qd)
        units = [self.momentum(q, [float(i == first + k) for i in range(n)]) for k in range(3)]
        a, b, c = (unit.H for unit in units)
        normals, dH = (cross(b, c), cross(c, a), cross(a, b)), H - now.H
        dw = [(normal @ dH) / (a @ normals[0]) for normal in normals]
        dP = P - now.P - sum(unit.P * part for unit, part in zip(units, dw, strict=True))
        R = base.joint.R if base.parent < 0 else self.model.bodies[0].joint.R @ base.joint.R
        change = [*dw, *(R.T @ dP * (1.0 / now.m))]
        return [x + change[i - first] if first <= i < first + 6 else x for i, x in enumerate(qd)]

    def needs_speed(self, effects: Sequence[Effect]) -> bool:
        """Whether accelerations by these effects, drives and loops depend on speeds."""
        nq, n = self.model.nq, self.model.n

        def outputs(tape: Tape) -> Iterable[Scalar]:
            state = self.state(tape)
            return self.accelerations(state.q, state.qd, self.given(tape), effects)[0]

        return bool({(STATE, nq + i) for i in range(n)} & trace(outputs).inputs)


@lru_cache(maxsize=16)
def state_runner(program: Callable[[Equations], Program], plan: Plan, columns: int = 0) -> Runner:
    """A program of a state and so many curves, ready to run."""
    equations = Equations(plan)
    return runner_of(program(equations), plan, {STATE: equations.width, COLUMNS: columns})


def is_free(model: Model, scene: Scene) -> bool:
    """Whether nothing but gravity acts on the robot from outside, so that its momenta are known."""
    bodies = model.bodies
    roots = [body for body in bodies if body.parent < 0]
    if roots[0].joint.kind == "fixed" and not roots[0].inertia.m:
        roots = [body for body in bodies if body.parent == 0]
    alone = len(roots) == 1 and roots[0].joint.kind == "floating"
    tied = any(loop.to == GROUND for loop in scene.loops)
    return alone and not scene.wrenches and not scene.fluid_density and not tied


def check_applies(plan: Plan, method: Method) -> None:
    """Raise if a method keeps momenta of a robot that is not free, or leaps where accelerations depend on speeds."""
    scene = plan.scene
    if method.keeps_momenta and not is_free(plan.model, scene):
        what = f"{method.name} does not apply: the momenta of a robot that is held or pushed from outside change"
        raise InputError(what, remedy='--method rk4, or [base] motion = "moving" in the scene')
    if method.leapfrog and Equations(plan).needs_speed(plan.effects):
        undriven = Equations(replace(plan, scene=replace(scene, drive={})))
        causes = [effect.name for effect in plan.effects if undriven.needs_speed([effect])]
        causes = ["loops"] if scene.loops else causes
        causes += ["drives with kd"] * any(drive.kd for drive in scene.drive.values())
        what = f"verlet does not apply: accelerations depend on speeds ({', '.join(causes)})"
        raise InputError(what, remedy="--method gauss2 keeps energy too, whatever forces there are")


class Steps:
    """The programs of a method for the equations of a robot. Both read and write a state and its stages.

    Of an implicit method the stages `K_i` (rates of u, qd and work) follow the state: `sweep` puts
    `f(y + h sum_j A_ij K_j)` in place of every K_i, until they stay, and tells their change, relative to the stages or
    to a small part of positions per step; `step` ends the step and keeps them as a guess for the next one.

    Attributes:
        width: numbers that both programs read, and write but for the change.
        columns: numbers that both read for each step of a motion with curves: these at every moment of the method, and
            the step's length, which the state keeps where there are none.
    """

    def __init__(self, equations: Equations, method: Method) -> None:
        self.equations, self.method = equations, method
        stages, curves = len(method.b) if method.implicit else 0, len(equations.curves)
        self.kept = slice(equations.width, equations.width + 6 * method.keeps_momenta)
        self.width = self.kept.stop + stages * (2 * equations.model.n + 1)
        self.columns = curves * len(method.moments) + 1 if curves else 0

    def begin(self, states: Floats) -> Floats:
        """(N, width) what the programs read first, from states (N, that of the equations); stages begin with zeros."""
        slots, nq, n = np.zeros((len(states), self.width)), self.equations.model.nq, self.equations.model.n
        slots[:, : states.shape[1]] = states
        if self.method.keeps_momenta:
            whole = (self.equations.momentum(state[:nq].tolist(), state[nq : nq + n].tolist()) for state in states)
            slots[:, self.kept] = [[*one.P, *one.H] for one in whole]
        return slots

    @cached_property
    def step(self) -> Program:
        """The program of the state (and stages) after a step."""

        def outputs(tape: Tape) -> Iterable[Scalar]:
            state, given = self._state(tape), self._curves(tape)
            if self.method.leapfrog:
                return self._leap(state, given[0])
            if self.method.implicit:
                stages = self._stages(tape)
                return [*self._end(state, stages), *_flat(stages)]
            stages = []
            for row, now in zip(self.method.A, given, strict=True):
                stages.append(self._stage(state, stages, row[: len(stages)], now))
            return self._end(state, stages)

        return trace(outputs)

    @cached_property
    def sweep(self) -> Program | None:
        """The program of the state, the stages after a sweep and the square of their change; None if explicit."""
        if not self.method.implicit:
            return None

        def outputs(tape: Tape) -> Iterable[Scalar]:
            state, old, given = self._state(tape), self._stages(tape), self._curves(tape)
            new = [self._stage(state, old, row, now) for row, now in zip(self.method.A, given, strict=True)]
            before, after = _flat(old), _flat(new)
            change = total((a - b) * (a - b) for a, b in zip(after, before, strict=True))
            floor = (REST + REST * total(x * x for x in state.q)) / (state.step * state.step)
            size = total(x * x for x in after)
            return [*state.q, *state.qd, state.work, state.step, *after, change / (size + floor)]

        return trace(outputs)

    def _state(self, tape: Tape) -> State:
        state = self.equations.state(tape)
        state = state._replace(kept=[tape.input(STATE, k) for k in range(self.kept.start, self.kept.stop)])
        return state._replace(step=tape.input(COLUMNS, self.columns - 1)) if self.columns else state

    def _curves(self, tape: Tape) -> list[Given]:
        moments = self.method.moments
        return [self.equations.given(tape, moments.index(node)) for node in self.method.nodes]

    def _stages(self, tape: Tape) -> list[Rates]:
        n, at = self.equations.model.n, self.kept.stop
        stages = []
        for first in range(at, at + len(self.method.b) * (2 * n + 1), 2 * n + 1):
            values = [tape.input(STATE, first + k) for k in range(2 * n + 1)]
            stages.append(Rates(values[:n], values[n:-1], values[-1]))
        return stages

    def _stage(self, state: State, stages: Sequence[Rates], row: Sequence[float], given: Given) -> Rates:
        """The rates at `y + h sum_j row_j K_j`."""
        h, n = state.step, self.equations.model.n
        u = [h * rate for rate in _sums(row, [K.u for K in stages], n)]
        gains = _sums(row, [K.qd for K in stages], n)
        return self.equations.rates(state.q, u, [x + h * gain for x, gain in zip(state.qd, gains, strict=True)], given)

    def _leap(self, state: State, given: Given) -> list[Scalar]:
        """The state after half a step at the old speed, an acceleration and half a step at the new speed."""
        h, equations, half = state.step, self.equations, [0.5 * state.step * x for x in state.qd]
        qdd = equations.rates(state.q, half, [0.0] * len(half), given).qd
        mean = [x + 0.5 * h * a for x, a in zip(state.qd, qdd, strict=True)]
        qd = [x + h * a for x, a in zip(state.qd, qdd, strict=True)]
        power = equations.rates(state.q, half, mean, given).work
        u = [h * x for x in mean]
        return [*unit(equations.model, moved(equations.model, state.q, u)), *qd, state.work + h * power, h]

    def _end(self, state: State, stages: Sequence[Rates]) -> list[Scalar]:
        h, b, model = state.step, self.method.b, self.equations.model
        gains = _sums(b, [K.qd for K in stages], model.n)
        qd = [x + h * gain for x, gain in zip(state.qd, gains, strict=True)]
        u = [h * rate for rate in (qd if self.method.semi else _sums(b, [K.u for K in stages], model.n))]
        work = _sums(b, [[K.work] for K in stages], 1)[0]
        q, qd = self.equations.settled(moved(model, state.q, u), qd)
        kept: list[Scalar] = []
        if self.method.keeps_momenta:
            P, H = np.array(state.kept[:3]), np.array(state.kept[3:])
            P = P + np.array(self.equations.scene.gravity) * (self.equations.momentum(q, qd).m * h)
            qd, kept = self.equations.with_momenta(P, H, q, qd), [*P, *H]
        return [*q, *qd, state.work + h * work, h, *kept]


def _flat(stages: Iterable[Rates]) -> list[Scalar]:
    return [x for K in stages for x in (*K.u, *K.qd, K.work)]


def _sums(weights: Sequence[float], stages: Sequence[Sequence[Scalar]], n: int) -> list[Scalar]:
    totals: list[Scalar] = [0.0] * n
    for weight, values in zip(weights, stages, strict=True):
        if weight:
            totals = [so_far + weight * value for so_far, value in zip(totals, values, strict=True)]
    return totals
