"""A robot near one state, with the drives of a scene closed: x' = A x + B u, or the same in steps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import hypot, inf

import numpy as np

from robodyn.dynamics.derivatives import inverse_dynamics_derivatives
from robodyn.dynamics.effects.friction import joints_with_friction
from robodyn.dynamics.effects.motors import coupled_motors
from robodyn.dynamics.inverse import bias_forces
from robodyn.equations.dae.dae import begun, closed_state
from robodyn.equations.linearized.equilibrium import (
    RobotAtRest,
    equilibrium_near,
    overflow,
    positions,
    robot_at_rest,
    stiffness_in_doubt,
)
from robodyn.equations.linearized.modes import Modes, SmallMotion, modes_of
from robodyn.equations.ode import check_equations
from robodyn.errors import InputError
from robodyn.programs.vectors import product
from robodyn.robot.kinematics import Values, beyond_limits, configuration, rates
from robodyn.robot.limits import Excess, held_beyond
from robodyn.robot.model import Model
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import Floats
from robodyn.support.linear import eigen
from robodyn.support.wording import Cell, Shown, count, figure, listed, shown

_LOST = 1.0 / float(np.finfo(float).eps)
_BALANCED = 1e-9
"""Of the torques that balance: where less is missing, it is an equilibrium."""
_CLEAR = 0.1
"""Of the largest: a joint that moves less than so with what is left is no coordinate of a closed chain."""


@dataclass(frozen=True, eq=False, repr=False)
class Linearized(Shown):
    """x' = A x + B u near one state, x and u being differences from those of the state.

    Attributes:
        states: names of the entries of x, "q_elbow" and then "qd_elbow"; of a floating base turns about its axes and
            shifts along the ground's; of a closed chain those of as many joints as can move by themselves.
        inputs: names of the entries of u, torques beside those of the drives.
        A, B: (2 k, 2 k), (2 k, n).
        q, qd: (nq,), (n,) the state.
        drive: (n,) torques of the drives there [N m or N].
        held: (n,) torques that were added so that the robot does not accelerate [N m or N]; zero at an equilibrium.
        balanced: whether it is an equilibrium.
        motion: the equations of second order, and what modes rest on.
        step: s, where A and B are those of steps.
    """

    robot: str
    model: Model
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    A: Floats
    B: Floats
    q: Floats
    qd: Floats
    drive: Floats
    held: Floats
    balanced: bool
    motion: SmallMotion
    warnings: tuple[str, ...]
    step: float | None = None

    def _lines(self) -> Sequence[str]:
        sizes = f"{count(len(self.states), 'state')}, {count(len(self.inputs), 'input')}"
        steps = "" if self.step is None else f", in steps of {figure(self.step, 6)} s"
        about = "an equilibrium" if self.balanced else "a state that added torques hold"
        return (
            f"Linearized {shown(self.robot)}: {sizes}{steps}",
            f"about {about}; {count(len(self.warnings), 'warning')}",
        )

    def _table(self) -> tuple[Sequence[str], Sequence[Sequence[Cell]]]:
        head = ("mode", "frequency [Hz]", "damping ratio", "time constant [s]", "eigenvalue [1/s]", "+- i")
        names = ("frequency", "damping_ratio", "time_constant", "real", "imag")
        modes = enumerate(self.modes.modes)
        return head, [[str(k), *(float(getattr(mode, name)) for name in names)] for k, mode in modes]

    @cached_property
    def exceeded(self) -> tuple[Excess, ...]:
        """Limits of the description that the state exceeds: its positions, and the effort that holds it at rest."""
        return held_beyond(self.model, self.q, self.drive + self.held) if self.motion.at_rest else ()

    @property
    def stable(self) -> bool | None:
        """Whether it stays there: False too where limits do not allow the state; None where it is not decided."""
        return False if self.exceeded else self.modes.stable

    @property
    def verdict(self) -> str:
        return "beyond limits" if self.exceeded else self.modes.verdict

    @cached_property
    def modes(self) -> Modes:
        """How it moves by itself, drives closed.

        `modes.modes`, the slowest first, have `frequency` [Hz], `damping_ratio`, `time_constant` [s], `real`, `imag`,
        the `error` of both [1/s], and `shape`. `modes.stable` is True, False, or None where that is not decided;
        `modes.verdict` says why, and `modes.margin` by how much [1/s].
        """
        return modes_of(self.motion)


def in_steps(found: Linearized, step: float) -> Linearized:
    """Return the same with A and B of x(t + step) = A x(t) + B u, where u is constant from one step to the next.

    By the exponential of ((A, B), (0, 0)) step, in powers of it halved until it is small (Taylor's series of order 18,
    squared again): both matrices at once, A singular or not. Van Loan 1978.

    Raises:
        InputError: the step is no positive finite number, or a mode grows beyond all numbers within it, or rounding
            leaves nothing: an angle is off by as many roundings as it has radians.
    """
    if isinstance(step, str) or not 0.0 < step < inf:
        raise InputError(f"the step is {step!r}, no positive finite number of seconds")
    size, inputs = found.B.shape
    whole = np.zeros((size + inputs, size + inputs))
    whole[:size, :size], whole[:size, size:] = found.A * step, found.B * step
    with np.errstate(all="ignore"):
        lost = not (np.isfinite(whole).all() and np.abs(found.A).max() * step < _LOST)
        # exp(X) = 1 + F by Taylor's series of a part of X, squared as (1 + F)^2 - 1 = 2 F + F F: beside 1 what is slow
        # would be lost
        size_of = max(float(np.abs(whole).sum(axis=1).max()), 2.0**-60)
        halvings = 0 if lost else max(0, int(np.ceil(np.log2(size_of))) + 1)
        term, out = np.eye(len(whole)), np.zeros_like(whole)
        for k in range(1, 19):
            term = product(term, whole / 2.0**halvings) / k
            out = out + term
        for _ in range(halvings):
            out = 2.0 * out + product(out, out)
        E = np.eye(len(whole)) + out
    if lost or not np.isfinite(E).all():
        raise InputError(f"the motion overflows within a step of {step:g} s", remedy="give shorter steps")
    return replace(found, A=E[:size, :size], B=E[:size, size:], step=step)


def linearize(
    model: Model,
    scene: Scene = DEFAULT,
    at: Values | None = None,
    qd: Values = (),
    *,
    equilibrium: bool = False,
    step: float | None = None,
) -> Linearized:
    """Return the linear equations near a state.

    `M dq'' = -(d ID/dq + kp) dq - (d ID/d qd + kd) dq' + du`, all derivatives exact. Without `equilibrium` the robot is
    held where it is put: whatever torque is missing there is added, constant. With it, the nearest state at rest is
    looked for that drives and springs hold and joints without either reach by themselves. Drives that follow a table
    have their references where the joints are put.

    With loops the same on the manifold of configurations that they allow: M, d ID/d qd and `d (ID - J^T lambda)/dq`,
    lambda being constant, times N from the right and N^T from the left, with J N = 0.

    Args:
        at: coordinates in order or by name; the rest begins at the scene's initial values, else at zero, and moves so
            that loops close. A base that moves stands upright at the ground's origin, or where the scene puts it.
        qd: of the joints, likewise, the rest zero. A base that moves is at rest, and so is a closed chain.
        equilibrium: whether to look for one near `at`.
        step: s, for A and B of x(t + step) = A x(t) + B u, where u is constant from one step to the next.

    Raises:
        InputError: there are no equations, there is no equilibrium, the mass matrix is singular, or what comes out is
            not finite.

    Accuracy: A and B within cond(M) times 1e-14 of their largest entries, by blocks, where M does not cancel: it is
        off by roundings of m r^2, r being how far a link's mass is from its origin.
    """
    check_equations(model, scene)
    with np.errstate(all="ignore"):
        speeds = rates(model, qd)
        if not scene.loops:
            q, _ = begun(model.coordinates, configuration(model, () if at is None else at), at, scene.initial_q)
        elif speeds.any():
            raise InputError("closed chains are linearized at rest", remedy="leave out the speeds (--qd)")
        else:
            q, speeds = closed_state(model, replace(scene, initial_qd={}), at, ())
        robot = robot_at_rest(model, scene, q)
        if equilibrium:
            if speeds.any():
                raise InputError("an equilibrium is at rest", remedy="leave out the speeds, or do not look for one")
            q = equilibrium_near(robot, q)
        found = _near(robot, q, speeds)
        if not all(np.isfinite(part).all() for part in (found.A, found.B, found.held, found.motion.weight)):
            raise overflow(model)
        found = replace(found, warnings=(*_left_out(robot, scene, speeds, equilibrium), *found.warnings))
        return found if step is None else in_steps(found, step)


def _near(robot: RobotAtRest, q: Floats, qd: Floats) -> Linearized:
    model, moves = robot.model, bool(qd.any())
    balance = robot.balance(q)
    given = inverse_dynamics_derivatives(model, q, qd, 0.0, scene=robot.tree, executor="numpy")
    drive = robot.drives.at(positions(model, q), qd)
    held, stiffness = balance.missing, balance.stiffness
    if moves:
        held = bias_forces(model, q, qd, scene=robot.tree, executor="numpy") - drive
        stiffness = given.dq + np.diag(robot.drives.kp)
    balanced = not moves and balance.part <= _BALANCED
    second = given.dqdd, given.dqd + np.diag(robot.drives.kd), stiffness
    own, N = list(range(model.n)), np.asarray(np.eye(model.n))
    if robot.chain is not None:
        # the rates that are coordinates, driven ones and then first ones before others, and N in terms of them
        N, left, own = balance.directions, balance.directions.copy(), []
        order = sorted(range(model.n), key=lambda k: (not robot.drives.kp[k] and not robot.drives.torque[k], k))
        for _ in range(N.shape[1]):
            sizes = np.sqrt((left * left).sum(axis=1))
            k = next(k for k in order if sizes[k] >= _CLEAR * sizes.max())
            own.append(k)
            left -= np.outer(product(left, left[k] / sizes[k]), left[k] / sizes[k])
            left[k] = 0.0
        own.sort()
        N = np.asarray(np.linalg.solve(N[own].T, N.T).T)
        second = tuple(product(N.T, each, N) for each in second)
    M, damping, stiffness = second
    names = [model.rates[k] for k in own]
    if not np.isfinite(M).all():
        raise overflow(model)
    size = np.sqrt(np.abs(np.diag(M)))
    massless = [name for name, each in zip(names, size, strict=True) if not each]
    moments = np.zeros(1) if massless else np.abs(eigen(M / size / size[:, None])[0])  # scaled to a unit diagonal
    k, least, most = len(M), float(moments.min()), float(moments.max())
    if least <= k * np.finfo(float).eps * most:
        what = f"the mass matrix is singular{f': nothing moves with {listed(massless)}' if massless else ''}"
        raise InputError(what, remedy="give every moving link a mass, or the joint a rotor", file=model.file)
    solved = np.linalg.solve(M, np.hstack((-stiffness, -damping, N.T)))
    A, B = np.zeros((2 * k, 2 * k)), np.zeros((2 * k, model.n))
    A[:k, k:] = np.eye(k)
    A[k:], B[k:] = solved[:, : 2 * k], solved[:, 2 * k :]
    doubt = stiffness_in_doubt(robot, q, balance, own) if balanced else np.zeros_like(M)
    # what a joint carries, of mass m, is nearer to its axis than I allows, m r^2 <= I: it makes at most g sqrt(m I)
    weight = hypot(*robot.tree.gravity) * np.sqrt(robot.carried[own] * np.abs(np.diag(M)))
    inertia = np.diag(given.dqdd).copy()
    return Linearized(
        robot=model.name,
        model=model,
        states=(*(f"q_{name}" for name in names), *(f"qd_{name}" for name in names)),
        inputs=tuple(f"tau_{name}" for name in model.rates),
        A=A,
        B=B,
        q=q,
        qd=qd,
        drive=drive,
        held=np.zeros(model.n) if balanced else held,
        balanced=balanced,
        motion=SmallMotion(N, M, damping, stiffness, doubt, A, inertia, weight, most / least, not moves),
        warnings=(*beyond_limits(model, q), *model.notes),
    )


def _left_out(robot: RobotAtRest, scene: Scene, qd: Floats, equilibrium: bool) -> list[str]:
    """Return what the scene says that the state has not, and what holds in truth and is not linear."""
    out = []
    if tabled := [name for name, drive in scene.drive.items() if drive.columns]:
        out = [f"drives of {listed(tabled)} follow a table: their references are taken where the joints are put"]
    moving = [name for name, value in scene.initial_qd.items() if value]
    if moving and not equilibrium and not qd.any():
        out.append(
            f"initial qd of {listed(moving)} in the scene is left out: linearized at rest (--qd gives joints speeds)"
        )
    rubs = joints_with_friction(robot.model, robot.tree)
    dry = [joint.name for _, joint, friction in rubs if friction.dry and not qd[joint.rate]]
    for motor, turned in coupled_motors(robot.model, robot.tree):
        if motor.friction.dry and not sum(share * joint.multiplier * qd[joint.rate] for _, joint, share in turned):
            dry.append(motor.name)
    if dry and not scene.slip_speed:
        out.append(
            f"Coulomb friction of {listed(dry)} is left out: at rest it jumps; slip_speed in the scene makes it smooth"
        )
    return out
