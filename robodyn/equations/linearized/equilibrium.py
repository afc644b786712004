"""A robot at rest: the torques that hold it, its drives closed, and the state nearest to one that is given."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain
from math import hypot
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robodyn.dynamics.derivatives import inverse_dynamics_derivatives
from robodyn.dynamics.initial_state import FEW, closed_near, independent_equations
from robodyn.dynamics.inverse import bias_forces
from robodyn.dynamics.loops.closed_chain import ClosedChain
from robodyn.dynamics.loops.closure import moved, unit
from robodyn.dynamics.plan import plan
from robodyn.equations.ode import units_of
from robodyn.errors import InputError
from robodyn.programs.derivative import jacobian
from robodyn.programs.program import trace
from robodyn.programs.run.numpy_blocks import NumpyBlocks
from robodyn.programs.scalar import Tape
from robodyn.programs.vectors import Scalar, length, product
from robodyn.robot.model import Model
from robodyn.scene.scene import Entry, Scene
from robodyn.support.floats import Floats, first_largest
from robodyn.support.linear import eigen, min_norm_solution, null_space, range_basis

_ROUNDED = 4.0 * float(np.finfo(float).eps)
"""Four roundings, of q no more than 1e-10 of the torque that they change."""
_NEWTON_STEPS = 4.0
"""Of Newton's, to be on the far side of an equilibrium: where two meet, at a fold, each of his goes half the way."""
_LONGEST_STEP = 0.1
"""rad, or the same part of the robot's reach [m]."""


class Drives(NamedTuple):
    """tau = torque + kp (reference - q) + kd (speed - qd), by rate: (n,) each, zero where nothing drives."""

    torque: Floats
    kp: Floats
    kd: Floats
    reference: Floats
    speed: Floats

    def at(self, positions: Floats, qd: Floats) -> Floats:
        """Return the torques [N m or N] at these positions (n,) of joints by rate."""
        return self.torque + self.kp * (self.reference - positions) + self.kd * (self.speed - qd)


def positions(model: Model, q: Floats) -> Floats:
    """Return (n,) the positions of hinges and slides by rate, zero for a floating base."""
    out = np.zeros(model.n)
    for joint in model.independent:
        if joint.kind != "floating":
            out[joint.rate] = q[joint.coordinate]
    return out


class Balance(NamedTuple):
    """What is missing at a configuration, beside what the loops carry.

    Attributes:
        missing: (n,) torques [N m or N].
        directions: (n, k) in which it can move, columns orthonormal.
        stiffness: (n, n) how torques change with q where what the loops carry stays the same.
        scale: (n,) at each joint the largest of the torques that balance, or that the weight could make, or that
            change by 1e-10 of it where q is rounded [N m or N].
    """

    missing: Floats
    directions: Floats
    stiffness: Floats
    scale: Floats

    @property
    def parts(self) -> Floats:
        """(n,) how much is missing, of what balances."""
        return np.abs(self.missing) / np.where(self.scale > 0.0, self.scale, 1.0)

    @property
    def part(self) -> float:
        return float(self.parts.max(initial=0.0))


@dataclass(frozen=True, eq=False)
class RobotAtRest:
    """A robot in a scene at rest, its drives closed; tree: the scene without its loops; chain: what they close, None
    without any; tied: (n,) whether a joint lies in a loop, and carries what others in loops weigh."""

    model: Model
    tree: Scene
    drives: Drives
    chain: ClosedChain | None
    tied: NDArray[np.bool_]

    @cached_property
    def turns(self) -> NDArray[np.bool_]:
        """(n,) whether a rate is a turn, and not a shift."""
        return np.array([unit != "N" for unit in units_of(self.model)])

    @cached_property
    def lengths(self) -> Floats:
        """(n,) 1 for turns and the robot's reach [m] for shifts: how far is as far as one radian."""
        return np.where(self.turns, 1.0, max(self.model.reach, 1e-9))

    @cached_property
    def carried(self) -> Floats:
        """(n,) the mass beyond each joint, payloads included [kg]; of one in a loop all of it."""
        model = self.model
        masses = [body.inertia.m for body in model.bodies]
        for payload in self.tree.payloads:
            masses[model.links[payload.link].body] += payload.mass
        for k in reversed(range(1, len(masses))):
            masses[model.parents[k]] += masses[k]
        out = np.full(model.n, masses[0])
        for body, mass in zip(reversed(model.bodies), reversed(masses), strict=True):
            if body.joint.kind in ("revolute", "prismatic") and not self.tied[body.joint.rate]:
                out[body.joint.rate] = mass
        return out

    @cached_property
    def _change_of_loops(self) -> NumpyBlocks:
        """d (J^T multipliers) / dq along each joint's first coordinate; bases do not move."""
        loops, model = self.chain, self.model
        assert loops is not None

        def outputs(tape: Tape) -> Iterable[Scalar]:
            q = [tape.input("q", k) for k in range(model.nq)]
            carried: list[Scalar] = [0.0] * model.n
            for k, row in enumerate(loops.equations(loops.sample(q)).J):
                for rate, entry in row.items():
                    carried[rate] += entry * tape.input("multipliers", k)
            return chain(*jacobian(carried, [{q[joint.coordinate]: 1.0} for joint in model.independent]))

        return NumpyBlocks(trace(outputs), {"q": model.nq, "multipliers": loops.count})

    def balance(self, q: Floats) -> Balance:
        """Return what is missing at q; InputError where the torques are not finite.

        With loops `missing = bias - drives - J^T lambda` is as short as it can be, and across all rows of J; its
        derivative has that of J^T lambda in it, lambda being constant.
        """
        model = self.model
        bias = bias_forces(model, q, 0.0, scene=self.tree, executor="numpy")
        at = positions(model, q)
        given = self.drives.at(at, np.zeros(model.n))
        weight = hypot(*self.tree.gravity) * self.carried * np.where(self.turns, model.reach, 1.0)
        rates = inverse_dynamics_derivatives(model, q, 0.0, 0.0, scene=self.tree, executor="numpy")
        missing, stiffness = bias - given, rates.dq + np.diag(self.drives.kp)
        rounded = _ROUNDED / 1e-10 * np.abs(np.diag(stiffness) * at)
        scale = np.maximum.reduce([np.abs(bias), np.abs(given), weight, rounded])
        if not np.isfinite(scale).all():
            raise overflow(model)
        if self.chain is None:
            return Balance(missing, np.eye(model.n), stiffness, scale)
        J = self.chain.jacobian(self.chain.sample(q.tolist()))
        multipliers = min_norm_solution(J.T, missing, FEW)
        N = null_space(J, FEW).T
        change = self._change_of_loops({"q": q[None], "multipliers": multipliers[None]}, 1)
        stiffness[:, [joint.rate for joint in model.independent]] -= change.reshape(model.n, -1)
        scale = np.where(self.tied, (scale * self.lengths)[self.tied].max(initial=0.0) / self.lengths, scale)
        return Balance(product(N, product(N.T, missing)), N, stiffness, scale)

    def moved(self, q: Floats, step: Floats) -> Floats | None:
        """Return q after a small move along the rates, loops closed again; None where they do not close."""
        if self.chain is not None:
            return closed_near(self.chain, q, step)
        return np.array(unit(self.model, moved(self.model, q.tolist(), step.tolist())), dtype=float)


def overflow(model: Model) -> InputError:
    return InputError("the equations overflow at this state", remedy="smaller numbers", file=model.file)


def robot_at_rest(model: Model, scene: Scene, q: Floats) -> RobotAtRest:
    """Return the robot; q, at which loops are closed, says which of their equations depend on each other. InputError
    where its base moves and loops are closed; more motions are possible at q than nearby; or none is."""

    def number(entry: Entry | None, otherwise: float) -> float:
        """There is no table: a reference that follows one is where the joint stands, a torque or a speed is zero."""
        return otherwise if entry is None or isinstance(entry, str) else float(entry)

    tree, drives = replace(scene, loops=()), Drives(*(np.zeros(model.n) for _ in Drives._fields))
    for joint in model.independent:
        drive = scene.drive.get(joint.name)
        if drive is not None:
            k = joint.rate
            drives.torque[k] = number(drive.torque, 0.0)
            drives.kp[k], drives.kd[k] = drive.kp, drive.kd
            drives.reference[k] = number(drive.reference, float(q[joint.coordinate]))
            drives.speed[k] = number(drive.speed, 0.0)
    if not scene.loops:
        return RobotAtRest(model, tree, drives, None, np.zeros(model.n, dtype=bool))
    if model.floating:
        remedy = 'bolt the base down: leave out motion = "moving"'
        raise InputError("a closed chain on a base that moves is not linearized", remedy=remedy, file=model.file)
    begun = dict(zip(model.coordinates, q.tolist(), strict=True))
    chain = independent_equations(plan(model, replace(scene, initial_q=begun, initial_qd={})))
    ways = len(null_space(chain.jacobian(chain.sample(q.tolist())), FEW))
    if ways > model.n - chain.count:
        what = f"the loops allow {ways} motions here and {model.n - chain.count} nearby, so that nothing is linear"
        raise InputError(what, remedy="begin elsewhere (--at)", file=model.file)
    if not ways:
        raise InputError("nothing can move: the loops hold all joints", file=model.file)
    tied = np.zeros(model.n, dtype=bool)
    for loop in scene.loops:
        for k in _beyond(model, loop.link) ^ _beyond(model, loop.to):
            joint = model.bodies[k].joint
            if joint.kind in ("revolute", "prismatic"):
                tied[joint.rate] = True
    return RobotAtRest(model, tree, drives, chain, tied)


def _beyond(model: Model, link: str) -> set[int]:
    k, out = model.links[link].body if link in model.links else -1, set()
    while k >= 0:
        out.add(k)
        k = model.parents[k]
    return out


_STEPS, _HALVINGS = 60, 12
_NEAR, _NEARLY = 1e-12, 1e-10
"""Parts of the torques that balance: from where on one step is the last, and what is enough."""
_DEPENDENT = 1e-10
"""Directions in which the torques change by less than this part of the most are left alone: nothing holds there."""
_AROUND = 0.5
"""rad, or the same part of the robot's reach [m]: what Newton's method finds farther away is not near."""
_SINKS, _LONGEST = 400, 0.3
"""Steps downhill at most, and how long each may be, as `_AROUND`."""
_FAR = 4.0 * np.pi
"""As `_AROUND`: what has gone two turns downhill goes on for ever."""
_HOLD = "give the joint a drive with kp or a spring, or begin elsewhere (--at)"
_SUNK = 1e-5
"""A part of the torques that balance, from which Newton's method ends it."""


def equilibrium_near(robot: RobotAtRest, q: Floats) -> Floats:
    """Return q (nq,) at which the robot stays at rest; InputError, naming the joint farthest from balance, if none.

    Method: Newton's, the shortest step that makes the linear torques vanish, halved until it helps, which finds what is
    near, stable or not. Where there is nothing near, the robot sinks, as if through something viscous, to a state that
    is stable: Newton's steps with the absolute values of the stiffness' eigenvalues, which lead downhill past saddles
    (Dauphin et al., "Identifying and attacking the saddle point problem", 2014). Newton's method ends it.

    Accuracy: what is left of the torques is at most 1e-10 of those that balance, most often 1e-12.
    """
    elsewhere = None if robot.chain else robot.moved(q, 0.1 + 0.618 * np.arange(1.0, robot.model.n + 1.0) % 1.0)
    if elsewhere is not None:  # is a torque missing at every configuration, of a free base, or of a slide not held?
        here, there = robot.balance(q), robot.balance(elsewhere)
        nothing = _NEAR * np.minimum(here.scale, there.scale)
        changes = (np.maximum(np.abs(here.stiffness), np.abs(there.stiffness)) * robot.lengths).max(axis=1)
        constant = (changes <= nothing) & (np.abs(here.missing - there.missing) <= nothing) & (here.parts > _NEARLY)
        if constant.any():
            left = here._replace(missing=np.where(constant, here.missing, 0.0))
            what = f"there is no equilibrium: {_most(robot, left)} stay unbalanced at every configuration"
            floats = robot.model.floating and constant[:6].any()
            remedy = "a free base falls: bolt it down, or leave out --equilibrium" if floats else _HOLD
            raise InputError(what, remedy=remedy)
    found, here = _by_newton(robot, q, _AROUND)
    if here.part > _NEARLY:
        found, here = _by_newton(robot, _sunk(robot, q), _LONGEST)
    if here.part > _NEARLY:
        raise InputError(f"no equilibrium is found: {_most(robot, here)} stay unbalanced", remedy=_HOLD)
    # coordinates that rounding alone has moved stay where they were, or at 0, if that is as good
    plain = np.where(np.abs(found - q) <= _NEAR, q, np.where(np.abs(found) <= _NEAR, 0.0, found))
    return plain if robot.balance(plain).part <= max(here.part, _NEAR) else found


def _most(robot: RobotAtRest, here: Balance) -> str:
    k = first_largest(here.parts)
    return f"{abs(here.missing[k]):.3g} {units_of(robot.model)[k]} at {robot.model.rates[k]}"


def _by_newton(robot: RobotAtRest, q: Floats, around: float) -> tuple[Floats, Balance]:
    """Return where it ends, within this distance, and what is not balanced there."""
    here, gone = robot.balance(q), np.zeros(robot.model.n)
    for _ in range(_STEPS):
        last, step = here.part <= _NEAR, newton_step(robot, here)
        scale = np.where(here.scale > 0.0, here.scale, 1.0)
        for part in (step * 0.5**halving for halving in range(_HALVINGS)):
            if (np.abs(gone + part) <= around * robot.lengths).all() and (tried := robot.moved(q, part)) is not None:
                there = robot.balance(tried)
                if length(there.missing / scale) < length(here.missing / scale):
                    q, here, gone = tried, there, gone + part
                    break
        else:
            break
        if last:
            break
    return q, here


def newton_step(robot: RobotAtRest, here: Balance) -> Floats:
    """Return the shortest step (n,) after which nothing would be missing if torques were linear."""
    N = _scaled(robot, here)
    return np.asarray(
        product(N, min_norm_solution(product(N.T, here.stiffness, N), -product(N.T, here.missing), _DEPENDENT))
    )


def _scaled(robot: RobotAtRest, here: Balance) -> Floats:
    """Return the directions in coordinates in which all joints are about as stiff."""
    stiff = here.scale / robot.lengths
    stiff = np.where(stiff > 0.0, stiff, 1.0)
    root = np.sqrt(stiff)[:, None]
    return here.directions / root if robot.chain is None else range_basis((here.directions * root).T, 0.0).T / root


def _sunk(robot: RobotAtRest, q: Floats) -> Floats:
    """Return q after steps downhill, each accepted if the torques do work along it."""
    here, longest, gone = robot.balance(q), _LONGEST, np.zeros(robot.model.n)
    for _ in range(_SINKS):
        if here.part <= _SUNK or (np.abs(gone) > _FAR * robot.lengths).any():
            break
        # the step that ends along each principal direction of the stiffness where its torque would vanish
        N = _scaled(robot, here)
        S = product(N.T, here.stiffness, N)
        values, V = eigen(0.5 * (S + S.T))
        D = product(N, V.T)
        torque, far = product(D.T, here.missing), np.abs(D / robot.lengths[:, None]).max(axis=0)
        felt = np.abs(torque) > _NEAR * product(np.abs(D).T, here.scale)
        with np.errstate(divide="ignore", invalid="ignore"):
            lengths = np.where(felt, np.clip(-torque / np.abs(values), -longest / far, longest / far), 0.0)
        step = np.asarray(product(D, lengths))
        tried = robot.moved(q, step)
        there = None if tried is None else robot.balance(tried)
        if tried is None or there is None or product(here.missing + there.missing, step) >= 0.0:
            longest *= 0.25
            continue
        q, here, longest, gone = tried, there, min(2.0 * longest, _LONGEST), gone + step
    return q


def along(stiffness: Floats, directions: Floats, own: list[int]) -> Floats:
    """Return the stiffness (k, k) of the coordinates `own` of motions in these directions (n, k)."""
    N = np.linalg.solve(directions[own].T, directions.T).T
    return np.asarray(product(N.T, stiffness, N))


def stiffness_in_doubt(robot: RobotAtRest, q: Floats, here: Balance, own: list[int]) -> Floats:
    """Return how the stiffness (k, k) changes on the way to where the equilibrium may be, which is off by what is
    missing and by rounding: next to nothing, but near a fold, where a stable equilibrium meets an unstable one."""
    missing = np.where(np.abs(here.missing) < _ROUNDED * here.scale, _ROUNDED * here.scale, here.missing)
    step = _NEWTON_STEPS * newton_step(robot, here._replace(missing=missing))
    step /= max(1.0, float(np.abs(step / robot.lengths).max(initial=0.0)) / _LONGEST_STEP)
    if (there := robot.moved(q, step)) is None:
        return np.zeros((len(own), len(own)))
    other = robot.balance(there)
    return along(other.stiffness, other.directions, own) - along(here.stiffness, here.directions, own)
