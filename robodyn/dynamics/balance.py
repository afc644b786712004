"""Self-checks of the force recursion by the momentum recursion, which shares no force and no acceleration with it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any

import numpy as np

from robodyn.dynamics.effects.effect import Sample, Terms
from robodyn.dynamics.momenta import dual_state, momentum_of_bodies, total_momenta
from robodyn.dynamics.plan import Plan
from robodyn.programs.derivative import rate_of, value_of
from robodyn.programs.program import traced
from robodyn.programs.scalar import Tape
from robodyn.programs.vectors import Array, Scalar, cross, total
from robodyn.robot.kinematics import Motion, poses, velocities
from robodyn.support.floats import Floats


@traced
def laws(plan: Plan, tape: Tape) -> Iterable[Scalar]:
    """The program of the base wrench that Euler's laws demand, about the base's origin and in its axes, and of the
    power that goes into stored energy; the rates come from dual scalars.

    `f = dP/dt + w x P - m g - sum f_ext`, `n = dH/dt + w x H + v x P - c x m g - sum (n_ext + r x f_ext)`, w and v
    being the base's velocities; dE/dt; and the squared magnitudes of what balances in each of the three, rates of the
    bodies' own momenta and energies and wrenches that act on them: in all 10 outputs.
    """
    sample, terms = plan.terms(tape)
    q, qd = dual_state(sample.model, sample.q, sample.qd, sample.qdd)
    dual = replace(sample, q=tuple(q), qd=tuple(qd))
    parents, joints = sample.model.parents, dual.motions()
    whole, moving = total_momenta(parents, joints, terms.inertias), velocities(parents, joints)
    P, H, mc = (_each(value_of, x) for x in (whole.P, whole.H, whole.mc))
    w, v = (_each(value_of, x) for x in moving[0])
    weight = _each(value_of, joints[0].R).T @ terms.gravity
    f = _each(rate_of, whole.P) + cross(w, P) - whole.m * weight
    n = _each(rate_of, whole.H) + cross(w, H) + cross(v, P) - cross(mc, weight)
    forces: list[Scalar] = []
    moments: list[Scalar] = []
    powers: list[Scalar] = []
    for body, motion in zip(momentum_of_bodies(parents, joints, terms.inertias), moving, strict=True):
        P_rate, H_rate = (_each(rate_of, x) for x in body)
        forces.append(P_rate @ P_rate)
        moments.append(H_rate @ H_rate)
        for rate, velocity in ((P_rate, _each(value_of, motion.v)), (H_rate, _each(value_of, motion.w))):
            parts = rate * velocity
            powers.append(parts @ parts)
    if terms.wrenches:  # about the base's origin, in the base's axes
        where = [motion._replace(R=_each(value_of, motion.R), p=_each(value_of, motion.p)) for motion in joints]
        from_base = poses(parents, [where[0]._replace(R=np.eye(3), p=np.zeros(3)), *where[1:]])
        for i, wrench in terms.wrenches:
            force = from_base[i].R @ wrench.f
            moment = from_base[i].R @ wrench.n + cross(from_base[i].p, force)
            f, n = f - force, n - moment
            forces.append(force @ force)
            moments.append(moment @ moment)
    power = rate_of(stored_energy(plan, dual, terms, joints))
    return [*f, *n, power, total(forces), total(moments), total(powers)]


class LawResiduals:
    """The largest differences between the base wrench and what the laws demand, gathered over samples."""

    def __init__(self, borne: tuple[float, float] = (0.0, 0.0)) -> None:
        """Args: borne: force and moment that balance at least, besides the bodies' momenta."""
        self.samples = 0
        self._worst = np.zeros(3)
        self._scale = np.maximum((*borne, 0.0), np.finfo(float).tiny)

    def update(self, expected: Floats, base: Floats, power: Floats, gross: Floats) -> None:
        """Take in outputs of `laws` (N, 10), base wrench (N, 6), power (N,) supplied and not lost, and (N, n) by
        coordinate."""
        found = np.column_stack((base, power))
        for k, part in enumerate((slice(0, 3), slice(3, 6), slice(6, 7))):
            self._worst[k] = max(self._worst[k], np.abs(expected[:, part] - found[:, part]).max())
            balancing = np.sqrt(expected[:, 7 + k].max())
            self._scale[k] = max(self._scale[k], np.abs(found[:, part]).max(), balancing)
        self._scale[2] = max(self._scale[2], np.abs(gross).max(initial=0.0))
        self.samples += len(base)

    @property
    def relative(self) -> tuple[float, float, float]:
        """Residuals of Euler's first law, second law and the power balance, of the largest that balances in each."""
        first, second, third = (self._worst / self._scale).tolist()
        return first, second, third

    @property
    def largest(self) -> tuple[float, float]:
        """The largest force [N] and moment [N m] that balance."""
        force, moment, _ = self._scale.tolist()
        return force, moment


@traced
def energy(plan: Plan, tape: Tape) -> Iterable[Scalar]:
    """The program of the stored energy [J] and of the power lost [W]."""
    sample, terms = plan.terms(tape)
    joints = sample.motions()
    return [stored_energy(plan, sample, terms, joints), power_lost(plan, sample, terms, joints)]


@traced
def losses(plan: Plan, tape: Tape) -> Iterable[Scalar]:
    sample, terms = plan.terms(tape)
    return [power_lost(plan, sample, terms, sample.motions())]


def stored_energy(plan: Plan, sample: Sample, terms: Terms, joints: list[Motion]) -> Scalar:
    """Kinetic energy and what effects store [J]."""
    energy = total_momenta(sample.model.parents, joints, terms.inertias).T
    for effect in plan.effects:
        energy = energy + effect.stored(sample, terms, plan.scene, joints)
    return energy


def power_lost(plan: Plan, sample: Sample, terms: Terms, joints: list[Motion]) -> Scalar:
    """Power that friction takes, less the power f . v + n . w that wrenches give [W]."""
    power: Scalar = 0.0
    for effect in plan.effects:
        power = power + effect.lost(sample, terms, plan.scene, joints)
    moving = velocities(sample.model.parents, joints) if terms.wrenches else []
    for i, wrench in terms.wrenches:
        power = power - (wrench.f @ moving[i].v + wrench.n @ moving[i].w)
    return power


def _each(part: Callable[[Any], Scalar], array: Array) -> Array:
    out: Array = np.vectorize(part, otypes=[object])(array)
    return out
