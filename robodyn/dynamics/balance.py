"""Self-checks of the force recursion by the momentum recursion, which shares no force and no acceleration with it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from robodyn.dynamics.effects.effect import Sample, Terms
from robodyn.dynamics.plan import Plan
from robodyn.dynamics.recursions.momentum import dual_state, momenta, momentum_of_bodies
from robodyn.programs.derivative import rate_of, value_of
from robodyn.programs.program import traced
from robodyn.programs.scalar import Tape
from robodyn.programs.vectors import Array, Scalar, cross
from robodyn.robot.kinematics import Motion, poses, velocities
from robodyn.support.floats import Floats


@traced
def laws(plan: Plan, tape: Tape) -> Iterable[Scalar]:
    """The program of the base wrench that Euler's laws demand, and of the power that goes into stored energy.

    `f = dP/dt + w x P - m g - sum f_ext`, `n = dH/dt + w x H + v x P - c x m g - sum (n_ext + r x f_ext)`, about the
    base's origin and in its axes, w and v being the base's velocities; the rates come from dual scalars. Then dE/dt,
    and the squared magnitudes of what balances in each of the three: the rates of the bodies' own momenta and energies,
    and the wrenches that act on them: in all 10 outputs.
    """
    sample, terms = plan.terms(tape)
    q, qd = dual_state(sample.model, sample.q, sample.qd, sample.qdd)
    dual = replace(sample, q=tuple(q), qd=tuple(qd))
    joints = dual.motions()
    power = rate_of(stored_energy(plan, dual, terms, joints))
    return [*_base_wrench(dual, terms, joints), power, *_magnitudes(sample, terms, joints)]


def _magnitudes(sample: Sample, terms: Terms, joints: list[Motion]) -> list[Scalar]:
    parents = sample.model.parents
    force: Scalar = 0.0
    moment: Scalar = 0.0
    power: Scalar = 0.0
    bodies = zip(momentum_of_bodies(parents, joints, terms.inertias), velocities(parents, joints), strict=True)
    for (P, H), (w, v) in bodies:
        P_rate, H_rate = _each(rate_of, P), _each(rate_of, H)
        force, moment = force + P_rate @ P_rate, moment + H_rate @ H_rate
        for rate, velocity in ((P_rate, _each(value_of, v)), (H_rate, _each(value_of, w))):
            parts = rate * velocity
            power = power + parts @ parts
    for f, n in _wrenches_about_base(sample.model.parents, terms, joints):
        force, moment = force + f @ f, moment + n @ n
    return [force, moment, power]


class LawResiduals:
    """The largest differences between the base wrench and what the laws demand, gathered over samples."""

    def __init__(self, borne: tuple[float, float] = (0.0, 0.0)) -> None:
        """Args: borne: force and moment that balance at least, besides the bodies' momenta."""
        self.samples = 0
        self._worst = np.zeros(3)
        self._scale = np.maximum((*borne, 0.0), np.finfo(float).tiny)

    def update(self, expected: Floats, base: Floats, power: Floats, gross: Floats) -> None:
        """Take in samples: outputs of `laws` (N, 10), base wrench (N, 6), power (N,) supplied and not lost, and (N, n)
        at each coordinate."""
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
    total = momenta(sample.model.parents, joints, terms.inertias).T
    for effect in plan.effects:
        total = total + effect.stored(sample, terms, plan.scene, joints)
    return total


def power_lost(plan: Plan, sample: Sample, terms: Terms, joints: list[Motion]) -> Scalar:
    """Power that friction takes, less the power f . v + n . w that wrenches give [W]."""
    total: Scalar = 0.0
    for effect in plan.effects:
        total = total + effect.lost(sample, terms, plan.scene, joints)
    moving = velocities(sample.model.parents, joints) if terms.wrenches else []
    for i, wrench in terms.wrenches:
        total = total - (wrench.f @ moving[i].v + wrench.n @ moving[i].w)
    return total


def _base_wrench(sample: Sample, terms: Terms, joints: list[Motion]) -> list[Scalar]:
    parents = sample.model.parents
    whole = momenta(parents, joints, terms.inertias)
    P, H, mc = (_each(value_of, x) for x in (whole.P, whole.H, whole.mc))
    base = velocities(parents[:1], joints[:1])[0]
    w, v = _each(value_of, base.w), _each(value_of, base.v)
    weight = _each(value_of, joints[0].R).T @ terms.gravity
    f = _each(rate_of, whole.P) + cross(w, P) - whole.m * weight
    n = _each(rate_of, whole.H) + cross(w, H) + cross(v, P) - cross(mc, weight)
    for force, moment in _wrenches_about_base(parents, terms, joints):
        f, n = f - force, n - moment
    return [*f, *n]


def _wrenches_about_base(parents: tuple[int, ...], terms: Terms, joints: list[Motion]) -> Iterator[tuple[Array, Array]]:
    """Yield force and moment of each wrench about the base's origin, in the base's axes."""
    if not terms.wrenches:
        return
    where = [motion._replace(R=_each(value_of, motion.R), p=_each(value_of, motion.p)) for motion in joints]
    from_base = poses(parents, [where[0]._replace(R=np.eye(3), p=np.zeros(3)), *where[1:]])
    for i, wrench in terms.wrenches:
        force = from_base[i].R @ wrench.f
        yield force, from_base[i].R @ wrench.n + cross(from_base[i].p, force)


def _each(part: Callable[[Any], Scalar], array: Array) -> Array:
    out: Array = np.vectorize(part, otypes=[object])(array)
    return out
