"""What a simulation yields: the motion, the torques that drove it, and what should have stayed as it was."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from robodyn.dynamics.effects.effect import Effect, Verdict
from robodyn.robot.limits import Coverage, Excess, within
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene
from robodyn.simulation.conserving import is_free
from robodyn.simulation.joint_use import JointUse, caveats, joint_use, limits_checked
from robodyn.simulation.loop_figures import LoopFigures
from robodyn.simulation.methods import Method
from robodyn.support.caveats import Caveat
from robodyn.support.floats import Floats


@dataclass(frozen=True)
class Figures:
    """At the recorded times, N of them.

    Attributes:
        qdd, tau: (N, n) accelerations, and torques of the drives.
        energy, kinetic: (N,) stored energy, kinetic and potential of gravity and springs; the kinetic part [J].
        linear, angular: (N, 3) momentum, and angular momentum about the centre of mass, in the ground's axes.
    """

    qdd: Floats
    tau: Floats
    energy: Floats
    kinetic: Floats
    linear: Floats
    angular: Floats


@dataclass(frozen=True, eq=False)
class Simulation:
    """The simulated motion of a robot.

    Attributes:
        scene: as it was integrated, with the slip speed of friction.
        step: of a fixed-step method [s].
        rtol: of an adaptive one.
        time, q, qd: (N,), (N, nq), (N, n), the first as the scene says.
        work: (N,) done by drives and wrenches, less what friction took [J].
        steps: how many were done.
        evaluations: of the equations of motion; each sweep of an implicit step takes as many as the method has stages.
        effects: of every effect whether it is on, and why.
        loops: of a closed chain, what its loops carry and how far they come apart.
        ended: why the motion ended before its time; empty if it did not.
        shaky: why the numbers may not be right.
        notes: what was assumed.
        target, expected_error: the accuracy that was asked for, and what was measured; None where none was.
    """

    model: Model
    scene: Scene
    method: Method
    step: float | None
    rtol: float | None
    time: Floats
    q: Floats
    qd: Floats
    work: Floats
    figures: Figures
    steps: int
    evaluations: int
    executor: str
    effects: tuple[tuple[Effect, Verdict], ...]
    loops: LoopFigures | None = None
    ended: str = ""
    shaky: tuple[Caveat, ...] = ()
    notes: tuple[str, ...] = ()
    target: float | None = None
    expected_error: float | None = None

    @property
    def qdd(self) -> Floats:
        return self.figures.qdd

    @property
    def tau(self) -> Floats:
        return self.figures.tau

    @cached_property
    def joints(self) -> tuple[JointUse, ...]:
        """What each hinge and slide reaches."""
        return tuple(
            joint_use(joint, joint.name in self.scene.drive, self.time, self.qd[:, joint.rate], self.tau[:, joint.rate])
            for joint in self.model.independent
            if joint.kind != "floating"
        )

    @property
    def exceeded(self) -> tuple[Excess, ...]:
        """Every limit of speed and effort that the motion exceeds."""
        return tuple(excess for joint in self.joints for excess in joint.exceeded)

    @cached_property
    def limits(self) -> tuple[Coverage, ...]:
        """Which limits the motion is held against."""
        return limits_checked(self.model, self.scene)

    @cached_property
    def caveats(self) -> tuple[Caveat, ...]:
        """What else keeps "No limit is exceeded" from being the whole truth."""
        return (*self.shaky, *caveats(self.model, self.scene, self.time, self.q, self.qd))

    @property
    def within_limits(self) -> bool | None:
        """False if a limit of speed or effort is exceeded; None if some could not be checked or something is in doubt.

        A position is never beyond its limit: the motion ends there, or a spring pushes back.
        """
        return within(bool(self.exceeded), self.limits, self.caveats)

    @property
    def energy_drift(self) -> float:
        """max |E - E_0 - work| over the motion [J]."""
        energy = self.figures.energy
        return float(np.abs(energy - energy[0] - (self.work - self.work[0])).max())

    @property
    def free(self) -> bool:
        """Whether nothing but gravity acts on the robot from outside, so that its momenta are known."""
        return is_free(self.model, self.scene)

    @property
    def momentum_drift(self) -> tuple[float, float]:
        """Of a free robot, max |P - P_0 - m g t| [N s] and max |H_c - H_c0| [N m s] over the motion."""
        weight = sum(payload.mass for payload in self.scene.payloads) + self.model.total_mass
        impulse = weight * np.outer(self.time - self.time[0], self.scene.gravity)
        linear, angular = self.figures.linear, self.figures.angular
        largest = (np.abs(x).max() for x in (linear - linear[0] - impulse, angular - angular[0]))
        first, second = map(float, largest)
        return first, second

    @property
    def names(self) -> tuple[str, ...]:
        """Names of `columns`: `q_`, `qd_`, `qdd_` of coordinates and rates, `tau_` of joints, `fx_` .. of loops."""
        q = [f"q_{name}" for name in self.model.coordinates]
        rates = [f"{kind}_{name}" for kind in ("qd", "qdd") for name in self.model.rates]
        tau = (f"tau_{self.model.rates[i]}" for i in self.driven)
        return (*q, *rates, *tau, *(self.loops.columns if self.loops else ()))

    @property
    def driven(self) -> list[int]:
        """The places in tau of hinges and slides: nothing drives a floating joint."""
        return [joint.rate for joint in self.model.independent if joint.kind != "floating"]

    @property
    def columns(self) -> Floats:
        """(N, k) in the order of `names`, which `robodyn torques` reads."""
        loops = [self.loops.wrenches.reshape(len(self.time), -1)] if self.loops else []
        return np.hstack((self.q, self.qd, self.qdd, self.tau[:, self.driven], *loops))
