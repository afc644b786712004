"""Momenta and energies of a tree of bodies: for any scalar, for arrays of samples about any point and in any frame, and
as self-checks of the force recursion, with which they share no force and no acceleration; where links are, and how they
move."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from robodyn.dynamics.arrays import arrays_of, results, zero_sources
from robodyn.dynamics.effects import motors
from robodyn.dynamics.effects.effect import Sample, Terms
from robodyn.dynamics.plan import Plan, plan, runner_of
from robodyn.errors import InputError
from robodyn.programs.derivative import along
from robodyn.programs.derivative import jacobian as rates_along
from robodyn.programs.program import trace, traced
from robodyn.programs.run.runner import Runner
from robodyn.programs.scalar import Tape
from robodyn.programs.vectors import IDENTITY, ZERO, Array, Scalar, cross, total, vector
from robodyn.robot.kinematics import REST, Motion, named_links, poses, velocities
from robodyn.robot.model import Model
from robodyn.scene.fit import refuse_others
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.solids.inertia.laws import Inertia
from robodyn.support.floats import Floats
from robodyn.support.wording import alternatives, shown

Point = tuple[float, float, float]

GROUND = "ground"
COLUMNS = (*(f"{name}_{axis}" for name in ("com", "p", "L") for axis in "xyz"), "T", "V")
_KINETIC = (motors.ROTOR, motors.COUPLED, motors.GYROSCOPIC)
"""The effects that store kinetic energy."""


def position_rates(model: Model, q: Sequence[Scalar], qd: Sequence[Scalar]) -> list[Scalar]:
    """Return the rates of q: qd; of a floating joint v, and `h (w_body, 0) / 2` of its quaternion h (x y z w)."""
    rates: list[Scalar] = []
    for joint in model.independent:
        if joint.kind == "floating":
            w, v = qd[joint.rate : joint.rate + 3], qd[joint.rate + 3 : joint.rate + 6]
            x, y, z, s = q[joint.coordinate + 3 : joint.coordinate + 7]
            a, b, c = (0.5 * component for component in w)
            turn = [s * a + y * c - z * b, s * b + z * a - x * c, s * c + x * b - y * a, -(x * a + y * b + z * c)]
            rates += [*v, *turn]
        else:
            rates.append(qd[joint.rate])
    return rates


class TotalMomenta(NamedTuple):
    """Linear and angular momentum, kinetic energy, mass and first moment, about the base's origin, in its axes [SI]."""

    P: Array
    H: Array
    T: Scalar
    m: Scalar
    mc: Array


def momentum_of_bodies(
    parents: Sequence[int], motions: Sequence[Motion], inertias: Sequence[Inertia]
) -> list[tuple[Array, Array]]:
    """Return each body's `P = m v + w x m c` and `H = m c x v + I w`, about its origin and in its axes."""
    return [
        (body.m * v + cross(w, body.mc), cross(body.mc, v) + body.I @ w)
        for (w, v), body in zip(velocities(parents, motions), inertias, strict=True)
    ]


def total_momenta(parents: Sequence[int], motions: Sequence[Motion], inertias: Sequence[Inertia]) -> TotalMomenta:
    """Momenta and energy from velocities alone: no force and no acceleration enters; arguments as for `newton_euler`.
    `T = sum (P . v + H . w) / 2` over the bodies; inward `P_j += R P`, `H_j += R H + p x R P`, and the same for mass
    and first moment. Accuracy: 1e-14 of the sum of the magnitudes that add up to each result."""
    each = momentum_of_bodies(parents, motions, inertias)
    P, H = [body[0] for body in each], [body[1] for body in each]
    m, mc = [body.m for body in inertias], [body.mc for body in inertias]
    twice_T: Scalar = 0.0
    for i, (w, v) in enumerate(velocities(parents, motions)):
        twice_T = twice_T + P[i] @ v + H[i] @ w
    for i in reversed(range(len(parents))):
        if (j := parents[i]) >= 0:
            R, p = motions[i].R, motions[i].p
            P_in = R @ P[i]
            P[j], H[j] = P[j] + P_in, H[j] + R @ H[i] + cross(p, P_in)
            m[j], mc[j] = m[j] + m[i], mc[j] + R @ mc[i] + m[i] * p
    return TotalMomenta(P[0], H[0], 0.5 * twice_T, m[0], mc[0])


@dataclass(frozen=True)
class View:
    """How momenta are given: L about the "origin" of the frame, "com" or a point in it [m]; the frame is "ground" or a
    link."""

    about: str | Point = "origin"
    frame: str = GROUND

    def check(self, model: Model, scene: Scene = DEFAULT) -> None:
        """Raises InputError if there is no such link or point, or no mass."""
        if self.frame != GROUND and self.frame not in model.links:
            remedy = alternatives(self.frame, [GROUND, *model.links], "frames")
            raise InputError(f"no frame {shown(self.frame)}", remedy=remedy, file=model.file)
        if isinstance(self.about, str) and self.about not in ("origin", "com"):
            raise InputError(f"momentum about {shown(self.about)}", remedy="origin, com, or three coordinates")
        if not isinstance(self.about, str) and not (len(self.about) == 3 and np.isfinite(self.about).all()):
            raise InputError(f"{self.about} is no point", remedy="three finite coordinates in metres")
        if not _mass(model, scene):
            raise InputError("the robot has no mass, so no mass centre", remedy="give a link mass", file=model.file)


@dataclass(frozen=True, eq=False)
class Momenta:
    """Of a robot as a whole, for each sample; all relative to the ground, which does not move.

    Attributes:
        mass: kg.
        com: (..., 3) mass centre in the frame [m].
        linear: (..., 3) linear momentum in the frame's axes [kg m/s].
        angular: (..., 3) angular momentum about the point asked for, in the frame's axes [kg m^2/s].
        kinetic: (...) kinetic energy, that of reflected rotors included [J].
        potential: (...) potential energy of gravity, zero at the ground's origin, and of springs [J].
    """

    mass: float
    com: Floats
    linear: Floats
    angular: Floats
    kinetic: Floats
    potential: Floats


def momenta(
    model: Model,
    q: ArrayLike,
    qd: ArrayLike = 0.0,
    *,
    about: str | ArrayLike = "origin",
    frame: str = GROUND,
    scene: Scene = DEFAULT,
    executor: str = "auto",
    threads: int | None = None,
) -> Momenta:
    """Mass centre, linear and angular momentum, kinetic and potential energy: `p = sum m v`, `L = sum r x m v + I w`.

    `L` about a point c is `L_o - c x p`; velocities are relative to the ground, also where frame or point move with a
    link.

    Args:
        about: "origin" of the frame, "com", or (3,) the coordinates of a point in the frame [m].
        frame: "ground", whose axes gravity is given in, or the name of a link.
        scene: its payloads and rotors count, in L those with an axis; gravity and springs make the potential energy.
        model, q, qd, executor, threads: as for `inverse_dynamics`.

    Raises:
        InputError: a shape that does not fit, no such frame or point, or a robot without mass.

    Accuracy: 1e-14 of the sum of the magnitudes that add up to each result.
    """
    refuse_others(model, scene)
    if not isinstance(about, str):
        try:
            x, y, z = np.asarray(about, dtype=float).tolist()
        except (TypeError, ValueError):
            what = f"{np.asarray(about).tolist()} is no point"
            raise InputError(what, remedy="three finite coordinates in metres") from None
        about = x, y, z
    view = View(about, frame)
    view.check(model, scene)
    columns = dict.fromkeys(scene.columns, 0.0)  # wrenches carry no momentum
    sources, shape = arrays_of(model, {"q": q, "qd": qd}, scene, columns)
    runner = momentum_runner(plan(model, scene, zero_sources(sources)), view)
    found = results(runner, sources, shape, (len(COLUMNS),), None, executor, threads)
    com, linear, angular = (found[..., 3 * k : 3 * k + 3] for k in range(3))
    return Momenta(_mass(model, scene), com, linear, angular, found[..., 9], found[..., 10])


def _mass(model: Model, scene: Scene) -> float:
    return model.total_mass + sum(payload.mass for payload in scene.payloads)


@lru_cache(maxsize=16)
def momentum_runner(a_plan: Plan, view: View) -> Runner:
    """Return `COLUMNS`, ready to run: mass centre, p, L, kinetic and potential energy."""

    def outputs(tape: Tape) -> Iterable[Scalar]:
        sample, terms = a_plan.terms(tape)
        model, joints = sample.model, sample.motions()
        whole = total_momenta(model.parents, joints, terms.inertias)
        if view.frame == GROUND:
            R, p = joints[0].R.T, -(joints[0].R.T @ joints[0].p)
        else:
            body, turn, origin = model.links[view.frame]
            where = poses(model.parents, [REST._replace(R=IDENTITY, p=ZERO), *joints[1:]])[body]
            R, p = where.R @ turn, where.p + where.R @ origin
        centre = whole.mc * (1.0 / whole.m)
        about = {"origin": p, "com": centre}[view.about] if isinstance(view.about, str) else p + R @ view.about
        kinetic, potential = whole.T, 0.0
        for effect in a_plan.effects:
            energy = effect.stored(sample, terms, a_plan.scene, joints)
            if effect in _KINETIC:
                kinetic = kinetic + energy
            else:
                potential = potential + energy
        spinning = motors.angular_momentum(sample, a_plan.scene, joints)
        angular = whole.H + spinning - cross(about, whole.P)
        return [*(R.T @ (centre - p)), *(R.T @ whole.P), *(R.T @ angular), kinetic, potential]

    return runner_of(trace(outputs), a_plan)


@traced
def laws(plan: Plan, tape: Tape) -> Iterable[Scalar]:
    """The program of the base wrench that Euler's laws demand, about the base's origin and in its axes, and of the
    power that goes into stored energy; rates are derivatives along the motion.

    `f = dP/dt + w x P - m g - sum f_ext`, `n = dH/dt + w x H + v x P - c x m g - sum (n_ext + r x f_ext)`, w and v
    being the base's velocities; dE/dt; and the squared magnitudes of what balances in each of the three, rates of the
    bodies' own momenta and energies and wrenches that act on them: in all 10 outputs.
    """
    sample, terms = plan.terms(tape)
    model, parents = sample.model, sample.model.parents
    state = [("q", k) for k in range(model.nq)] + [("qd", k) for k in range(model.n)]
    rates = [*position_rates(model, sample.q, sample.qd), *sample.qdd]
    direction = {tape.input(*each): rate for each, rate in zip(state, rates, strict=True) if rate != 0.0}
    # what moves is an input also where it is zero throughout
    here = [
        tape.input(*each) if rate != 0.0 else x
        for each, rate, x in zip(state, rates, sample.q + sample.qd, strict=True)
    ]
    sample = replace(sample, q=tuple(here[: model.nq]), qd=tuple(here[model.nq :]))
    joints = sample.motions()
    whole, moving = total_momenta(parents, joints, terms.inertias), velocities(parents, joints)
    bodies = momentum_of_bodies(parents, joints, terms.inertias)
    power, *rates = along(
        [stored_energy(plan, sample, terms, joints), *whole.P, *whole.H, *np.ravel(bodies)], direction
    )
    (P_rate, H_rate), *of_bodies = np.array(rates, dtype=object).reshape(-1, 2, 3)
    weight = joints[0].R.T @ terms.gravity
    f = P_rate + cross(moving[0].w, whole.P) - whole.m * weight
    n = H_rate + cross(moving[0].w, whole.H) + cross(moving[0].v, whole.P) - cross(whole.mc, weight)
    forces: list[Scalar] = []
    moments: list[Scalar] = []
    powers: list[Scalar] = []
    for (P_rate, H_rate), motion in zip(of_bodies, moving, strict=True):
        forces.append(P_rate @ P_rate)
        moments.append(H_rate @ H_rate)
        for rate, velocity in ((P_rate, motion.v), (H_rate, motion.w)):
            parts = rate * velocity
            powers.append(parts @ parts)
    if terms.wrenches:  # about the base's origin, in the base's axes
        from_base = poses(parents, [joints[0]._replace(R=np.eye(3), p=np.zeros(3)), *joints[1:]])
        for i, wrench in terms.wrenches:
            force = from_base[i].R @ wrench.f
            moment = from_base[i].R @ wrench.n + cross(from_base[i].p, force)
            f, n = f - force, n - moment
            forces.append(force @ force)
            moments.append(moment @ moment)
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


class LinkPose(NamedTuple):
    """R (..., 3, 3) takes components in the link's axes to the ground's; p (..., 3) is the link's origin there [m]."""

    R: Floats
    p: Floats


def forward_kinematics(
    model: Model, q: ArrayLike, link: str, *, executor: str = "auto", threads: int | None = None
) -> LinkPose:
    """Return where a link is at q (..., nq), as for `inverse_dynamics`: outwards `R_i = R_j R(q_i)`,
    `p_i = p_j + R_j p`. InputError if there is no such link.

    Accuracy: 1e-14 of the longest chain of offsets, for chains of up to 100 bodies.
    """
    sources, shape = arrays_of(model, {"q": q})
    found = results(_place_runner(model, link), sources, shape, (12,), None, executor, threads)
    return LinkPose(found[..., :9].reshape(*shape, 3, 3), found[..., 9:])


def jacobian(
    model: Model,
    q: ArrayLike,
    link: str,
    point: Sequence[float] = (0.0, 0.0, 0.0),
    *,
    executor: str = "auto",
    threads: int | None = None,
) -> Floats:
    """Return J (..., 6, n) with (w, v) = J qd: velocities of a link and of its point, in the ground's axes.

    A force f at the point and a moment m on the link do `J^T (m, f)` along the coordinates. The point is in the link's
    frame [m]; rows are wx wy wz vx vy vz [rad/s, m/s], columns as `model.rates`. InputError for a link or point that is
    none.

    Accuracy: 1e-14 of the largest entry of its three rows, for chains of up to 100 bodies.
    """
    at = tuple(float(x) for x in point)
    if len(at) != 3 or not np.isfinite(at).all():
        raise InputError(f"{at} is no point", remedy="three finite coordinates in metres")
    sources, shape = arrays_of(model, {"q": q})
    return results(_place_runner(model, link, at), sources, shape, (6, model.n), None, executor, threads)


class CentreOfMass(NamedTuple):
    """Mass m [kg]; mass centre c (..., 3) in the frame [m]; J (..., 3, n), with c_dot = J qd relative to the ground, in
    the frame's axes."""

    m: float
    c: Floats
    J: Floats


def centre_of_mass(
    model: Model,
    q: ArrayLike,
    links: Sequence[str] | None = None,
    frame: str = GROUND,
    *,
    executor: str = "auto",
    threads: int | None = None,
) -> CentreOfMass:
    """Return mass and mass centre of a robot, or of some links, and its Jacobian: `c = sum m_i c_i / sum m_i`, so that
    the linear momentum is P = m J qd.

    Args:
        q: (..., nq), as for `inverse_dynamics`. links: each with all that is fixed to it, as one body; none is all.
        frame: "ground" or the name of a link.

    Raises:
        InputError: a link or frame that is none, or no mass.

    Accuracy: c 1e-14 of the longest chain of offsets, J of its largest entry, for chains of up to 100 bodies.
    """
    View("com", frame).check(model)
    names = model.links if links is None else named_links(model, links)
    bodies = tuple(sorted({model.links[name].body for name in names}))
    m = sum(float(model.bodies[i].inertia.m) for i in bodies)
    if not m:
        raise InputError("the links have no mass, so no mass centre", remedy="name others", file=model.file)
    sources, shape = arrays_of(model, {"q": q})
    runner = _centre_runner(model, bodies, m, frame)
    found = results(runner, sources, shape, (3 + 3 * model.n,), None, executor, threads)
    return CentreOfMass(m, found[..., :3], found[..., 3:].reshape(*shape, 3, model.n))


@lru_cache(maxsize=16)
def _centre_runner(model: Model, bodies: tuple[int, ...], m: float, frame: str) -> Runner:
    a_plan = plan(model, DEFAULT)

    def outputs(tape: Tape) -> Iterable[Scalar]:
        sample = a_plan.sample(tape)
        model, joints = sample.model, sample.motions()
        where, moving = poses(model.parents, joints), velocities(model.parents, joints)
        centre, speed, R, p = ZERO, ZERO, IDENTITY, ZERO
        for i in bodies:
            body, (w, v) = model.bodies[i].inertia, moving[i]
            centre = centre + where[i].R @ body.mc + where[i].p * body.m
            speed = speed + where[i].R @ (v * body.m + cross(w, body.mc))
        if frame != GROUND:
            carrier, turn, origin = model.links[frame]
            R, p = where[carrier].R @ turn, where[carrier].p + where[carrier].R @ origin
        J = rates_along(list(R.T @ speed * (1.0 / m)), [{rate: 1.0} for rate in sample.qd])
        return [*(R.T @ (centre * (1.0 / m) - p)), *(x for row in J for x in row)]

    return runner_of(trace(outputs), a_plan)


@lru_cache(maxsize=16)
def _place_runner(model: Model, link: str, point: tuple[float, ...] | None = None) -> Runner:
    named_links(model, [link])
    a_plan = plan(model, DEFAULT)

    def outputs(tape: Tape) -> Iterable[Scalar]:
        sample = a_plan.sample(tape)
        body, R, p = sample.model.links[link]
        joints = sample.motions()
        where = poses(model.parents, joints)[body]
        if point is None:
            return [*(where.R @ R).ravel(), *(where.p + where.R @ p)]
        w, v = velocities(model.parents, joints)[body]
        motion = [*(where.R @ w), *(where.R @ (v + cross(w, p + R @ vector(*point))))]
        return [x for row in rates_along(motion, [{rate: 1.0} for rate in sample.qd]) for x in row]

    return runner_of(trace(outputs), a_plan)
