"""The equations of motion that a simulation integrates, and the programs made of them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from robodyn.accelerations import accelerations
from robodyn.dynamics.aligned import aligned
from robodyn.dynamics.along import along_motion
from robodyn.dynamics.dual import rate_of
from robodyn.dynamics.momentum import momenta
from robodyn.effects.effect import Sample
from robodyn.effects.rotor_inertia import reflected
from robodyn.model import Model
from robodyn.plan import Plan, applied
from robodyn.scene import Scene
from robodyn.self_checks import power_lost, stored_energy
from robodyn.simulation.turning import local_rates, moved
from robodyn.spatial import Scalar, cross
from robodyn.trace.program import Program, trace
from robodyn.trace.scalar import Tape

STATE = "state"
"""The source of programs whose columns are q, qd, the work done so far and the step."""


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

    def drives(self, q: Sequence[Scalar], qd: Sequence[Scalar]) -> list[Scalar]:
        """The torques that the scene's drives apply."""
        tau: list[Scalar] = [0.0] * self.model.n
        for joint in self.model.independent:
            drive = self.scene.drive.get(joint.name)
            if drive is not None:
                i = joint.rate
                error = (drive.reference - q[joint.coordinate]) if drive.kp else 0.0
                tau[i] = drive.torque + drive.kp * error - drive.kd * qd[i]
        return tau

    def rates(self, q: Sequence[Scalar], u: Sequence[Scalar], qd: Sequence[Scalar]) -> Rates:
        """The rates at a displacement u from q."""
        here = moved(self.model, q, u)
        qdd, work = self.accelerations(here, qd)
        return Rates(local_rates(self.model, u, qd), qdd, work)

    def accelerations(self, q: Sequence[Scalar], qd: Sequence[Scalar]) -> tuple[list[Scalar], Scalar]:
        """qdd and the power that the drives and the surroundings give the robot [W]."""
        sample = Sample(self._aligned, tuple(q), tuple(qd), (0.0,) * self.model.n)
        terms = applied(self.plan.effects, sample, self.scene)
        tau = self.drives(q, qd)
        qdd = accelerations(sample, terms, tau, reflected(self.model, self.scene))
        power: Scalar = 0.0 - power_lost(self.plan, sample, terms, sample.motions())
        for torque, rate in zip(tau, qd, strict=True):
            power = power + torque * rate
        return qdd, power

    def state(self, tape: Tape) -> State:
        """The state that a program is given."""
        nq, n = self.model.nq, self.model.n
        values = [tape.input(STATE, k) for k in range(self.width)]
        return State(values[:nq], values[nq : nq + n], values[-2], values[-1])

    def derivatives(self) -> Program:
        """The program of the rates of (q, qd, work), quaternions being four numbers, for methods that know no turns."""

        def outputs(tape: Tape) -> Iterable[Scalar]:
            state = self.state(tape)
            qdd, work = self.accelerations(state.q, state.qd)
            position, _ = along_motion(self.model, state.q, state.qd, qdd)
            return [*map(rate_of, position), *qdd, work]

        return trace(outputs)

    def figures(self) -> Program:
        """The program of qdd, tau, stored and kinetic energy, linear momentum and that about the centre of mass.

        In the ground's axes: `P = R P_base`, `H_c = R (H_base - c x P_base)`.
        """

        def outputs(tape: Tape) -> Iterable[Scalar]:
            state = self.state(tape)
            qdd, _ = self.accelerations(state.q, state.qd)
            sample = Sample(self.model, tuple(state.q), tuple(state.qd), (0.0,) * self.model.n)
            terms = applied(self.plan.effects, sample, self.scene)
            joints = sample.motions()
            energy = stored_energy(self.plan, sample, terms, joints)
            whole, R = momenta(self.model.parents, joints, terms.inertias), joints[0].R
            P, H = R @ whole.P, R @ (whole.H - cross(whole.mc, whole.P) / whole.m)
            return [*qdd, *self.drives(state.q, state.qd), energy, whole.T, *P, *H]

        return trace(outputs)
