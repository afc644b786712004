"""The equations of motion that a simulation integrates, and the programs made of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import NamedTuple

from robodyn.dynamics.balance import power_lost, stored_energy
from robodyn.dynamics.effects.effect import Effect, Sample
from robodyn.dynamics.effects.motors import angular_momentum
from robodyn.dynamics.forward import accelerations
from robodyn.dynamics.loops.closed_chain import ClosedChain
from robodyn.dynamics.loops.closed_start import independent_equations
from robodyn.dynamics.loops.closure import local_rates, moved, unit
from robodyn.dynamics.plan import Plan, applied, runner_of
from robodyn.dynamics.recursions.elimination import aligned
from robodyn.dynamics.recursions.momentum import momenta, position_rates
from robodyn.programs.program import Program, traced
from robodyn.programs.run.runner import Runner
from robodyn.programs.run.stepper import COLUMNS
from robodyn.programs.scalar import Tape
from robodyn.programs.vectors import Scalar, cross
from robodyn.robot.model import Model
from robodyn.scene.parts import Entry
from robodyn.scene.scene import Scene
from robodyn.simulation.table import LOAD, RATE, REFERENCE, Curve, curves

STATE = "state"
"""The source of programs whose columns are q, qd, the work done so far and the step."""
Given = Mapping[Curve, Scalar]
"""The values of a scene's curves at one moment."""


class Rates(NamedTuple):
    """What a state changes at: u and qd of one step's coordinates, and the work done on the robot."""

    u: list[Scalar]
    qd: list[Scalar]
    work: Scalar


class State(NamedTuple):
    """q (nq), qd (n), the work done on the robot since the start [J], and the step [s]."""

    q: Sequence[Scalar]
    qd: Sequence[Scalar]
    work: Scalar
    step: Scalar


@dataclass(frozen=True, eq=False)
class Equations:
    """`u' = qd`, `qd' = M^-1 (tau - bias)`, `work' = tau qd - losses` of a model in a scene."""

    plan: Plan

    @property
    def model(self) -> Model:
        return self.plan.model

    @property
    def scene(self) -> Scene:
        return self.plan.scene

    @cached_property
    def width(self) -> int:
        """Numbers in a state."""
        return self.model.nq + self.model.n + 2

    @cached_property
    def _aligned(self) -> Model:
        return aligned(self.model)

    @cached_property
    def chain(self) -> ClosedChain | None:
        """The scene's loops, if it has any."""
        return independent_equations(self.plan) if self.scene.loops else None

    def settled(self, q: Sequence[Scalar], qd: Sequence[Scalar]) -> tuple[list[Scalar], list[Scalar]]:
        """Return the state after a step, with unit quaternions and on the loops."""
        q = unit(self.model, q)
        return (q, list(qd)) if self.chain is None else self.chain.settled(q, qd)

    @cached_property
    def curves(self) -> tuple[Curve, ...]:
        """What the scene takes from a table at every moment."""
        return curves(self.scene)

    def given(self, tape: Tape, node: int = 0) -> Given:
        """Return the curves at one of the moments for which a program is given them."""
        first = node * len(self.curves)
        return {curve: tape.input(COLUMNS, k) for k, curve in enumerate(self.curves, first)}

    def drives(self, q: Sequence[Scalar], qd: Sequence[Scalar], given: Given) -> list[Scalar]:
        """Return the torques that the scene's drives apply."""
        tau: list[Scalar] = [0.0] * self.model.n
        for joint in self.model.independent:
            drive = self.scene.drive.get(joint.name)
            if drive is None:
                continue
            torque, i = _value(drive.torque, LOAD, given), joint.rate
            if drive.kp:
                torque = torque + drive.kp * (_value(drive.reference, REFERENCE, given) - q[joint.coordinate])
            if drive.kd:
                moving = isinstance(drive.reference, str)
                slope = given[Curve(str(drive.reference), RATE)] if moving and drive.speed is None else 0.0
                speed = slope if drive.speed is None else _value(drive.speed, REFERENCE, given)
                torque = torque + drive.kd * (speed - qd[i])
            tau[i] = torque
        return tau

    def rates(self, q: Sequence[Scalar], u: Sequence[Scalar], qd: Sequence[Scalar], given: Given) -> Rates:
        """Return the rates at a displacement u from q."""
        here = moved(self.model, q, u)
        qdd, work = self.accelerations(here, qd, given)
        return Rates(local_rates(self.model, u, qd), qdd, work)

    def sample(self, model: Model, q: Sequence[Scalar], qd: Sequence[Scalar], given: Given) -> Sample:
        """Return a sample without accelerations, as effects read it."""
        columns = {curve.column: value for curve, value in given.items() if curve.kind == LOAD}
        return Sample(model, tuple(q), tuple(qd), (0.0,) * model.n, columns)

    def accelerations(
        self, q: Sequence[Scalar], qd: Sequence[Scalar], given: Given, effects: Sequence[Effect] | None = None
    ) -> tuple[list[Scalar], Scalar]:
        """qdd and the power that the drives and the surroundings give the robot [W].

        Args:
            effects: those of the plan if None.
        """
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
        """Return the state that a program is given."""
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
        """Return the program of qdd, tau, stored and kinetic energy, linear momentum and that about the centre of mass.

        In the ground's axes: `P = R P_base`, `H_c = R (H_base - c x P_base)`.
        """
        state, given = self.state(tape), self.given(tape)
        qdd, _ = self.accelerations(state.q, state.qd, given)
        sample = self.sample(self.model, state.q, state.qd, given)
        terms = applied(self.plan.effects, sample, self.scene)
        joints = sample.motions()
        energy = stored_energy(self.plan, sample, terms, joints)
        whole, R = momenta(self.model.parents, joints, terms.inertias), joints[0].R
        spinning = angular_momentum(sample, self.scene, joints)
        P, H = R @ whole.P, R @ (whole.H + spinning - cross(whole.mc, whole.P) / whole.m)
        return [*qdd, *self.drives(state.q, state.qd, given), energy, whole.T, *P, *H]


@lru_cache(maxsize=16)
def state_runner(program: Callable[[Equations], Program], plan: Plan, columns: int = 0) -> Runner:
    """Return a program of a state and so many curves, ready to run."""
    equations = Equations(plan)
    return runner_of(program(equations), plan, {STATE: equations.width, COLUMNS: columns})


def _value(entry: Entry, kind: str, given: Given) -> Scalar:
    return given[Curve(entry, kind)] if isinstance(entry, str) else entry
