"""Torques that hold a robot at rest, with its drives closed by their gains."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from math import hypot
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robodyn.dynamics.derivatives import inverse_dynamics_derivatives
from robodyn.dynamics.inverse import bias_forces
from robodyn.dynamics.loops.closed_chain import ClosedChain
from robodyn.dynamics.loops.closed_start import FEW, closed_near, independent_equations
from robodyn.dynamics.loops.closure import moved, unit
from robodyn.dynamics.plan import plan
from robodyn.equations.ode import units_of
from robodyn.errors import InputError
from robodyn.programs.dual import Dual, rate_of
from robodyn.programs.linear import min_norm_solution, null_space
from robodyn.programs.vectors import product
from robodyn.robot.model import Model
from robodyn.scene.parts import Entry, Loop
from robodyn.scene.scene import Scene
from robodyn.support.floats import Floats


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


def drives_of(model: Model, scene: Scene, q: Floats) -> Drives:
    """Return the drives of a scene. There is no table: a reference that follows one is where the joint stands at q, a
    torque or a speed that does is zero."""
    found = Drives(*(np.zeros(model.n) for _ in Drives._fields))
    for joint in model.independent:
        drive = scene.drive.get(joint.name)
        if drive is not None:
            k, here = joint.rate, float(q[joint.coordinate])
            found.torque[k] = _number(drive.torque, 0.0)
            found.kp[k], found.kd[k] = drive.kp, drive.kd
            found.reference[k] = _number(drive.reference, here)
            found.speed[k] = _number(drive.speed, 0.0)
    return found


def following(scene: Scene) -> list[str]:
    """Return the joints whose drives follow a table."""
    return [name for name, drive in scene.drive.items() if drive.columns]


def _number(entry: Entry | None, otherwise: float) -> float:
    return otherwise if entry is None or isinstance(entry, str) else float(entry)


def positions(model: Model, q: Floats) -> Floats:
    """Return (n,) the positions of hinges and slides by rate, zero for a floating base."""
    out = np.zeros(model.n)
    for joint in model.independent:
        if joint.kind != "floating":
            out[joint.rate] = q[joint.coordinate]
    return out


_ROUNDED = 4.0 * float(np.finfo(float).eps) / 1e-10
"""Four roundings of q are no more than 1e-10 of the torque that they change."""


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
        """The largest of these."""
        return float(self.parts.max(initial=0.0))


@dataclass(frozen=True, eq=False)
class Standing:
    """A robot in a scene at rest, its drives closed.

    Attributes:
        tree: the scene without its loops; chain: what they close, None without any.
        tied: (n,) whether a joint lies in a loop, and carries what others in loops weigh.
    """

    model: Model
    tree: Scene
    drives: Drives
    chain: ClosedChain | None
    tied: NDArray[np.bool_]

    @cached_property
    def units(self) -> tuple[str, ...]:
        return units_of(self.model)

    @cached_property
    def turns(self) -> NDArray[np.bool_]:
        """(n,) whether a rate is a turn, and not a shift."""
        return np.array([unit != "N" for unit in self.units])

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

    def balance(self, q: Floats) -> Balance:
        """Return what is missing at q.

        With loops `missing = bias - drives - J^T lambda` is as short as it can be, and across all rows of J; its
        derivative has that of J^T lambda in it, lambda being constant.

        Raises:
            InputError: the torques are not finite.
        """
        model = self.model
        bias = bias_forces(model, q, 0.0, scene=self.tree, executor="numpy")
        at = positions(model, q)
        given = self.drives.at(at, np.zeros(model.n))
        weight = hypot(*self.tree.gravity) * self.carried * np.where(self.turns, model.reach, 1.0)
        rates = inverse_dynamics_derivatives(model, q, 0.0, 0.0, scene=self.tree, executor="numpy")
        missing, stiffness = bias - given, rates.dq + np.diag(self.drives.kp)
        rounded = _ROUNDED * np.abs(np.diag(stiffness) * at)
        scale = np.maximum.reduce([np.abs(bias), np.abs(given), weight, rounded])
        if not np.isfinite(scale).all():
            raise overflow(model)
        if self.chain is None:
            return Balance(missing, np.eye(model.n), stiffness, scale)
        J = self.chain.jacobian(self.chain.sample(q.tolist()))
        multipliers = min_norm_solution(J.T, missing, FEW)
        N = null_space(J, FEW).T
        scale = np.where(self.tied, (scale * self.lengths)[self.tied].max(initial=0.0) / self.lengths, scale)
        return Balance(product(N, product(N.T, missing)), N, stiffness - _carried(self.chain, q, multipliers), scale)

    def moved(self, q: Floats, step: Floats) -> Floats | None:
        """Return q after a small move along the rates, loops closed again; None where they do not close."""
        if self.chain is not None:
            return closed_near(self.chain, q, step)
        return np.array(unit(self.model, moved(self.model, q.tolist(), step.tolist())), dtype=float)


def overflow(model: Model) -> InputError:
    """Return the error of numbers that are not finite."""
    return InputError("the equations overflow at this state", remedy="smaller numbers", file=model.file)


def standing(model: Model, scene: Scene, q: Floats) -> Standing:
    """Return the robot; q, at which loops are closed, says which of their equations depend on each other.

    Raises:
        InputError: its base moves and loops are closed; more motions are possible at q than nearby; or none is.
    """
    tree, drives = replace(scene, loops=()), drives_of(model, scene, q)
    if not scene.loops:
        return Standing(model, tree, drives, None, np.zeros(model.n, dtype=bool))
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
    return Standing(model, tree, drives, chain, _tied(model, scene.loops))


def _tied(model: Model, loops: tuple[Loop, ...]) -> NDArray[np.bool_]:
    """Return (n,) which joints lie in a loop: between its two links."""
    out = np.zeros(model.n, dtype=bool)
    for loop in loops:
        for k in _beyond(model, loop.link) ^ _beyond(model, loop.to):
            joint = model.bodies[k].joint
            if joint.kind in ("revolute", "prismatic"):
                out[joint.rate] = True
    return out


def _beyond(model: Model, link: str) -> set[int]:
    """Return the bodies from this link to the base."""
    k, out = model.links[link].body if link in model.links else -1, set()
    while k >= 0:
        out.add(k)
        k = model.parents[k]
    return out


def _carried(chain: ClosedChain, q: Floats, multipliers: Floats) -> Floats:
    """Return d (J^T lambda) / dq (n, n), by dual numbers along each coordinate; bases do not move."""
    n = chain.model.n
    out = np.zeros((n, n))
    for joint in chain.model.independent:
        at: list[float | Dual] = list(q.tolist())
        at[joint.coordinate] = Dual(float(q[joint.coordinate]), 1.0)
        for row, multiplier in zip(chain.equations(chain.sample(at)).J, multipliers.tolist(), strict=True):
            for rate, entry in row.items():
                out[rate, joint.rate] += float(rate_of(entry)) * multiplier
    return out
