"""A motion that shows a robot's parameters: what `robodyn excite` finds.

1. `motion.py` takes limits of joints from the description, and makes series of waves within them.
2. Base parameters that such motions can show are told by random states.
3. `landscape.py` says how much a motion tells, with slopes, and searches for one that tells much.
4. The motion is made smaller until it keeps all limits between samples too, and compared with plain waves.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import exp
from typing import NamedTuple

import numpy as np

from robodyn.dynamics.inverse import inverse_dynamics
from robodyn.dynamics.plan import plan
from robodyn.dynamics.regressor import regressor
from robodyn.errors import InputError
from robodyn.identification.excitation.landscape import Landscape, on_grid, programs_of, search
from robodyn.identification.excitation.motion import (
    PERIOD_SAMPLES,
    Bounds,
    Fourier,
    Motion,
    bounds_of,
    plain_waves,
    within_limits,
)
from robodyn.identification.parameters.base import Base, structural_base
from robodyn.identification.parameters.regressor_columns import stacked
from robodyn.robot.model import Model
from robodyn.scene.fit import refuse_constraints, refuse_load
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import LARGEST, Floats, einsum

PERIOD, HARMONICS, RATE = 10.0, 5, 200.0  # [s], of the series, and rows per second
MOST_HARMONICS = 20
NOISE = 0.01  # of the effort limit: standard deviation of a torque that is measured, where none is given
_STARTS, _MANY = 4, 32
"""Places where the search begins, at most; fewer where so many joints move in all of them together."""
_FINE, _ROOM = 32, 0.99
"""Samples of a period per harmonic of the search, and the part of the effort limits that it may use, so that what lies
between its samples keeps them too."""
_SLIP = 0.02  # of the lowest speed limit: where Coulomb friction turns in the search, which needs slopes
_APART = 1e-5  # of a column's length: what a motion shows less of depends on the others, see `Base.within`


class Information(NamedTuple):
    """What the torques of a motion tell of the base parameters, `rank` of which it shows: the condition of the base
    columns at unit length, rows weighted by 1 / noise, the log-determinant of sum Y^T W Y, in SI units, and (r,)
    standard errors by least squares, with noise that is independent from row to row."""

    rank: int
    condition: float
    log_determinant: float
    standard_errors: Floats


@dataclass(frozen=True)
class JointSwing:
    """What a joint does: `centre + sum sine_k sin(k w t) + cosine_k cos(k w t)`; what it reaches at any time; its
    bounds: limits of position, less a margin, None if it has no room; noise: standard deviation of its torque."""

    name: str
    unit: str
    moves: bool
    centre: float
    sine: tuple[float, ...]
    cosine: tuple[float, ...]
    least: float
    largest: float
    bounds: tuple[float, float] | None
    speed: float
    speed_limit: float
    acceleration: float
    acceleration_limit: float
    effort: float
    effort_limit: float | None
    noise: float


@dataclass(frozen=True, eq=False)
class Excitation:
    """A motion that shows parameters.

    Attributes:
        base: the base parameters that motions of these joints can show; values: theirs in the description.
        information, plain: of this motion, and of plain waves of the same period within the same limits.
        motion, torques: q, qd and qdd (3, N, n), a period with both its ends, `rate` rows per second; and what they
            take (N, n).
    """

    model: Model
    series: Fourier
    rate: float
    joints: tuple[JointSwing, ...]
    base: Base
    values: Floats
    information: Information
    plain: Information
    notes: tuple[str, ...]
    motion: Floats
    torques: Floats

    @property
    def gain(self) -> float:
        """How many times smaller standard errors are than those of plain waves, in the geometric mean."""
        gained = self.information.log_determinant - self.plain.log_determinant
        return exp(gained / (2 * self.base.rank)) if gained < float("inf") else gained

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(f"{kind}_{name}" for kind in ("q", "qd", "qdd") for name in self.model.joint_names)

    @property
    def time(self) -> Floats:
        return np.asarray(np.arange(self.motion.shape[1]) / self.rate)

    @property
    def columns(self) -> Floats:
        """(N, 3 n)."""
        return self.motion.transpose(1, 0, 2).reshape(self.motion.shape[1], -1)


def excite(
    model: Model,
    scene: Scene = DEFAULT,
    *,
    period: float = PERIOD,
    harmonics: int = HARMONICS,
    rate: float = RATE,
    joints: Sequence[str] = (),
    max_acceleration: float | None = None,
    noise: Sequence[float] | Mapping[str, float] | None = None,
    seed: int = 0,
) -> Excitation:
    """Return a motion whose torques tell the base parameters well, within all limits, at rest at both ends.

    Method: Fourier series (Swevers and others 1997) with the largest `log det sum Y^T W Y` of base columns Y that is
    found (D-optimality; W = 1 / noise^2), by a barrier method with exact slopes from up to four places.

    Args:
        model, scene: a tree on a fixed base; Coulomb friction and springs of the scene count.
        period: [s], of one period, which is the motion. harmonics: of the series, 2 to `MOST_HARMONICS`.
        rate: rows per second.
        joints: those that move; all if none is named. The others are held at 0, or mid-range where 0 is beyond limits.
        max_acceleration: of every joint [rad/s^2, m/s^2]; None: the speed limit over 0.25 s.
        noise: standard deviation of measured torques [N m, N], one for all, one each, or by joint; else 1 % of the
            effort limit, or of the root mean square at random states where there is none.
        seed: of the places where the search begins.

    Raises:
        InputError: the base floats, no joint can move, or efforts allow no motion; numbers that make no sense.
        SceneError: closed chains and contacts.

    Accuracy: |q - middle|, |qd|, |qdd| at no time exceed their bounds (Ehlich and Zeller's bound between samples);
        torques neither, as far as second differences tell what lies between samples.
    """
    _check(scene, period, harmonics, rate)
    refuse_constraints(scene)
    refuse_load(scene)
    bounds = bounds_of(model, scene, tuple(joints), max_acceleration)
    rows, theta, rms = _random_rows(model, scene, bounds)
    base = structural_base(model, scene).within(rows, _APART)
    if not base.rank:
        raise InputError("no parameter shows in the torques of such motions", remedy="move other joints: --joints")
    deviations = _deviations(model, bounds, noise, rms)
    series = Fourier(period, harmonics)
    slip = max(scene.slip_speed, _SLIP * float(bounds.speed[list(bounds.moving)].min()))
    programs = programs_of(plan(model, replace(scene, slip_speed=slip)), base.independent, len(base.names))
    landscape = Landscape(programs, bounds, series, deviations, _FINE * harmonics, _ROOM)
    starts = max(1, min(_STARTS, _MANY // len(bounds.moving)))
    x = on_grid(landscape.combinations(search(landscape, starts, seed)))
    found = within_limits(Motion(model, scene, bounds, series, x))
    count = max(2 * harmonics + 1, round(period * rate))
    plain = plain_waves(found)
    motion = found.at(series.even(count + 1) * ((count + 1) / count))
    return Excitation(
        model=model,
        series=series,
        rate=count / period,
        joints=_swings(model, bounds, found, deviations),
        base=base,
        values=base.values(theta),
        information=_information(model, scene, base, found, deviations, count),
        plain=_information(model, scene, base, plain, deviations, count),
        notes=bounds.notes,
        motion=motion,
        torques=inverse_dynamics(model, *motion, scene=scene, executor="numpy"),
    )


def _check(scene: Scene, period: float, harmonics: int, rate: float) -> None:
    if scene.columns:
        remedy = "leave such wrenches out, or give them numbers"
        raise InputError(f"the scene takes {scene.columns[0]!r} from a motion that is still to be found", remedy=remedy)
    if not 2 <= harmonics <= MOST_HARMONICS:
        what = f"{harmonics} harmonics: one cannot begin and end at rest"
        raise InputError(f"{what}, and more than {MOST_HARMONICS} are not offered", remedy=f"2 to {MOST_HARMONICS}")
    if not (period > 0.0 and rate > 0.0 and np.isfinite(period * rate)):
        raise InputError(f"a period of {period:g} s at {rate:g} /s is none", remedy="give positive numbers")
    if not 4 * harmonics <= period * rate <= 1e7:
        what = f"a period of {period:g} s at {rate:g} /s has {period * rate:.4g} rows"
        raise InputError(what, remedy=f"{4 * harmonics} rows, four of the fastest wave, to ten million")


def _random_rows(model: Model, scene: Scene, bounds: Bounds) -> tuple[Floats, Floats, Floats]:
    """Return rows of the regressor at random states that a motion may have, its parameters, and the RMS of torques."""
    rng = np.random.default_rng(4)
    k = list(bounds.moving)
    samples = 3 * 13 * len(model.bodies) // len(k) + 20
    motion = np.zeros((3, samples, model.n))
    motion[0] = bounds.home
    limits = np.array([bounds.half, bounds.speed, bounds.acceleration])[:, None, k]
    motion[:, :, k] = limits * rng.uniform(-1.0, 1.0, (3, samples, len(k)))
    motion[0][:, k] += bounds.middle[k]
    found = regressor(model, *motion, scene=scene, executor="numpy")
    tau = einsum("tip,p->ti", found.Y, found.theta) + found.rest
    if not (np.isfinite(tau).all() and np.abs(found.Y).max(initial=0.0) < LARGEST):
        raise InputError("the torques of such motions are beyond all numbers", remedy="check gravity and limits")
    return stacked([found.Y.reshape(-1, len(found.names))]), found.theta, np.sqrt((tau * tau).mean(axis=0))


def _deviations(
    model: Model, bounds: Bounds, noise: Sequence[float] | Mapping[str, float] | None, rms: Floats
) -> Floats:
    size = np.where(np.isfinite(bounds.effort), bounds.effort, rms)
    found = NOISE * np.where(size > 0.0, size, 1.0)
    if isinstance(noise, Mapping):
        if unknown := [name for name in noise if name not in model.joint_names]:
            what = f"noise is given for {unknown[0]!r}, which is no joint"
            raise InputError(what, remedy=", ".join(model.joint_names))
        found = np.array([noise.get(name, own) for name, own in zip(model.joint_names, found.tolist(), strict=True)])
    elif noise is not None:
        if len(noise) not in (1, model.n):
            raise InputError(f"noise has {len(noise)} numbers, the robot {model.n} joints", remedy="one, or one each")
        found = np.zeros(model.n) + np.array(noise, dtype=float)
    if not (found > 0.0).all():
        raise InputError(f"noise is {found.min():g}", remedy="it is positive [N m, N]")
    return found


def _information(model: Model, scene: Scene, base: Base, motion: Motion, deviations: Floats, rows: int) -> Information:
    samples = min(rows, PERIOD_SAMPLES * motion.series.harmonics)
    Y = regressor(model, *motion.at(motion.series.even(samples)), scene=scene, executor="numpy").Y
    R = stacked([(Y / deviations[:, None]).reshape(-1, len(base.names)) * np.sqrt(rows / samples)])
    shown = base.within(R, _APART)
    if shown.rank < base.rank:
        return Information(shown.rank, np.inf, -np.inf, np.full(base.rank, np.inf))
    diagonal = np.diagonal(stacked([R[:, base.independent]]))
    errors = base.estimate(R, np.zeros(len(R))).standard_errors
    return Information(base.rank, shown.condition, 2.0 * float(np.log(np.abs(diagonal)).sum()), errors)


def _swings(model: Model, bounds: Bounds, found: Motion, deviations: Floats) -> tuple[JointSwing, ...]:
    peaks, own = found.peaks(), list(bounds.moving)
    centre, (sine, cosine) = bounds.home.copy(), np.zeros((2, model.n, found.series.harmonics))
    centre[own], sine[own], cosine[own] = found.series.coefficients(found.x)
    figures = {**peaks._asdict(), "centre": centre, "noise": deviations}
    figures |= {"speed_limit": bounds.speed, "acceleration_limit": bounds.acceleration}
    return tuple(
        JointSwing(
            name=joint.name,
            unit="N" if joint.kind == "prismatic" else "N m",
            moves=k in bounds.moving,
            sine=tuple(sine[k].tolist()),
            cosine=tuple(cosine[k].tolist()),
            bounds=(float(middle - half), float(middle + half)) if half > 0.0 else None,
            effort_limit=float(bounds.effort[k]) if np.isfinite(bounds.effort[k]) else None,
            **{name: float(values[k]) for name, values in figures.items()},
        )
        for k, (joint, middle, half) in enumerate(zip(model.independent, bounds.middle, bounds.half, strict=True))
    )
