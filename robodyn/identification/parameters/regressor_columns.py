"""Columns that are filtered along a log: those of bodies, by the traced recursion, and those of motors."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from robodyn.dynamics.inverse import inverse_dynamics
from robodyn.dynamics.regressor import INERTIAL, regressor
from robodyn.identification.log.log import Log, Samples
from robodyn.identification.log.rows import filtered
from robodyn.programs.vectors import product
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene, Vector
from robodyn.support.floats import Floats, einsum

PARAMETERS = ("viscous", "coulomb", "offset", "stribeck", "rotor", "load")
"""Of a motor. `coulomb` and `offset` are half the difference and half the sum of friction forwards and backwards, which
no motion tells from a torque sensor's offset; `stribeck` is the torque of breakaway; `load` is the part of the torque
through the gear that is friction."""
_WAITING = 1024  # rows that are added to a factor at a time
_OUTLIER = 3.0  # standard deviations above which a residual counts as if it were there (Huber)
LAGS = 12  # rows apart up to which residuals are taken for correlated


@dataclass(frozen=True, eq=False)
class Motor:
    """A motor that turns with a sum of joints' rates, s = direction . qd, and drives them with torques alike; scale:
    largest |s| of the motion; stribeck: speeds at which its excess may decay, to compare [rad/s]; loaded: whether
    friction that grows with load is compared, of a joint's own motor alone."""

    name: str
    direction: Floats
    scale: float
    stribeck: tuple[float, ...] = ()
    loaded: bool = False

    @property
    def column_names(self) -> tuple[str, ...]:
        """The names of the columns that are filtered, of which those of the parameters are sums."""
        decaying = (f"{kind}@{speed:.17g}" for speed in self.stribeck for kind in ("sign", "square"))
        return ("viscous", "sign", "square", "rotor", *decaying, *(("load",) if self.loaded else ()))

    def sign(self, qd: Floats, slip_speed: float) -> Floats:
        """Return (k,) the sign of s, smoothed as friction is."""
        speed = product(qd, self.direction)
        return np.asarray(speed / np.hypot(speed, slip_speed) if slip_speed else np.sign(speed))

    def columns(self, qd: Floats, qdd: Floats, slip_speed: float, transmitted: Floats) -> Iterator[Floats]:
        """Yield (k,) the column of each: s, sign(s), sign(s)^2, its acceleration, signs times exp(-(s / v)^2). The
        last, if it is loaded, is sign(s) |torque that passes the gear|, of which the joints transmit (k, n)."""
        speed, sign = product(qd, self.direction), self.sign(qd, slip_speed)
        yield from (speed, sign, sign * sign, product(qdd, self.direction))
        for each in self.stribeck:
            decay = np.exp(-((speed / each) ** 2))
            yield from (sign * decay, sign * sign * decay)
        if self.loaded:
            yield sign * np.abs(product(transmitted, self.direction))


@dataclass(frozen=True)
class Shape:
    """How a motor is modelled: the speed of Stribeck's excess, None without, and whether friction grows with load."""

    stribeck: float | None = None
    load: bool = False

    def kinds(self) -> list[str]:
        """Return which of `PARAMETERS` there are."""
        there = {"stribeck": self.stribeck is not None, "load": self.load}
        return [kind for kind in PARAMETERS if there.get(kind, True)]

    def matrix(self, motor: Motor) -> Floats:
        """Return (columns, parameters) which sums of the columns of a motor are the columns of its parameters."""
        there, kinds = motor.column_names, self.kinds()
        found = np.zeros((len(there), len(kinds)))
        of = {"viscous": "viscous", "coulomb": "sign", "offset": "square", "rotor": "rotor", "load": "load"}
        for column, kind in enumerate(kinds):
            if kind in of:
                found[there.index(of[kind]), column] = 1.0
        if self.stribeck is not None:
            sign, square = (there.index(f"{kind}@{self.stribeck:.17g}") for kind in ("sign", "square"))
            found[sign, kinds.index("coulomb")] = found[square, kinds.index("offset")] = -1.0
            found[sign, kinds.index("stribeck")] = 1.0
        return found

    def names(self, motor: Motor) -> tuple[str, ...]:
        return tuple(f"{motor.name}.{kind}" for kind in self.kinds())


PLAIN = Shape()


class RegressorColumns:
    """Columns by joint: of each joint those alone that its torque can show.

    Attributes:
        bodies: (b,) names of the parameters of bodies, as `robodyn.regressor` has them; described: their values.
        names: (a,) of all columns: those of bodies, then `MOTOR.ATOM` of every motor.
        used: for each measured joint the columns that are not always zero, as places in `names`; widths: how many
            columns of `compute` belong to it, two more than these.
    """

    def __init__(
        self,
        model: Model,
        scene: Scene,
        measured: Sequence[int],
        motors: Sequence[Motor],
        slip_speed: float,
        bodies: Floats | None = None,
    ) -> None:
        """Args: bodies: their parameters, by which torques through gears are known; None: the description's."""
        self.model, self.measured, self.motors, self.slip_speed = model, tuple(measured), tuple(motors), slip_speed
        self._described = replace(scene, slip_speed=slip_speed)
        self._scene = replace(scene, payloads=(), friction={}, rotor={}, motor={}, coupled=())
        self._payloads = scene.payloads
        states = np.random.default_rng(20).uniform(-2.0, 2.0, (3, 8, model.n))
        found = regressor(model, *states, scene=self._scene)
        self._inertial = [k for k, name in enumerate(found.names) if name.rpartition(".")[2] in INERTIAL]
        self.bodies = tuple(found.names[k] for k in self._inertial)
        self.described = found.theta[self._inertial]
        self._transmitting = self.described if bodies is None else bodies
        self._loads: dict[int, float] = {}
        seen = np.asarray(found.Y[:, :, self._inertial].any(axis=0))
        self._of_bodies = [np.flatnonzero(seen[j]) for j in self.measured]
        self.names = (
            *self.bodies,
            *(f"{motor.name}.{column}" for motor in self.motors for column in motor.column_names),
        )
        self.used = [
            np.concatenate([of_bodies, *(each for _, _, each in self._of_motors(j))]).astype(int)
            for j, of_bodies in zip(self.measured, self._of_bodies, strict=True)
        ]
        self.widths = [len(each) + 2 for each in self.used]

    def near(self, bodies: Floats, loads: Mapping[int, float]) -> RegressorColumns:
        """Return the columns that are linear near a fit (bodies (b,), loads by places of motors), exact there. With m =
        load sign(s), t = Y theta + what is known: t + m |t| is about (1 + m0 sign(t0)) t + (m - m0) |t0|."""
        found = copy(self)
        found._transmitting, found._loads = bodies, dict(loads)
        return found

    def under(self, gravity: Vector) -> RegressorColumns:
        found = copy(self)
        found._scene = replace(self._scene, gravity=gravity)
        return found

    def _of_motors(self, j: int) -> Iterator[tuple[int, float, NDArray[np.intp]]]:
        """Yield place, share and columns of each motor that acts on a joint."""
        start = len(self.bodies)
        for k, motor in enumerate(self.motors):
            stop = start + len(motor.column_names)
            if motor.direction[j]:
                yield k, float(motor.direction[j]), np.arange(start, stop)
            start = stop

    def by_joint(self, values: Floats) -> list[Floats]:
        """Return the columns of each measured joint of what `compute` returns."""
        return np.split(values, np.cumsum(self.widths)[:-1], axis=1)

    def compute(self, samples: Samples) -> Floats:
        """Return (k, sum of widths): of each measured joint its columns (zero where its torque is left out), what is
        known (springs, wrenches, payloads), and the description's torque by `inverse_dynamics` in the scene."""
        motion = samples.q, samples.qd, samples.qdd
        found = regressor(self.model, *motion, scene=self._scene)
        Y, known = found.Y, found.rest
        if self._payloads:
            bare = Scene(gravity=self._scene.gravity)
            scenes = replace(bare, payloads=self._payloads), bare
            loaded, empty = (inverse_dynamics(self.model, *motion, scene=scene) for scene in scenes)
            known = known + loaded - empty
        described = inverse_dynamics(self.model, *motion, scene=self._described)
        passed = known + einsum("kjb,b->kj", Y[:, :, self._inertial], self._transmitting)
        for k, load in self._loads.items():
            j = int(np.flatnonzero(self.motors[k].direction)[0])
            m = load * self.motors[k].sign(samples.qd, self.slip_speed)
            along = 1.0 + m * np.sign(passed[:, j])
            Y[:, j] *= along[:, None]
            known[:, j] = known[:, j] * along - m * np.abs(passed[:, j])
        motors = [list(motor.columns(samples.qd, samples.qdd, self.slip_speed, passed)) for motor in self.motors]
        columns: list[Floats] = []
        there = np.isfinite(samples.tau)
        for j, of_bodies in zip(self.measured, self._of_bodies, strict=True):
            own = [Y[:, j, np.asarray(self._inertial)[of_bodies]]]
            own += [share * column[:, None] for k, share, _ in self._of_motors(j) for column in motors[k]]
            own += [known[:, j : j + 1], described[:, j : j + 1]]
            columns.append(np.where(there[:, j : j + 1], np.concatenate(own, axis=1), 0.0))
        return np.concatenate(columns, axis=1)


class Triangle:
    """R with R^T R = A^T A of all rows A (k, c) that were added, `count` of them, by QR: no squares lose digits."""

    def __init__(self, columns: int) -> None:
        self.count, self._new = 0, 0
        self._parts = [np.zeros((0, columns))]

    def add(self, rows: Floats) -> None:
        self._parts.append(rows)
        self.count += len(rows)
        self._new += len(rows)
        if self._new >= _WAITING:
            self._parts, self._new = [self.R], 0

    @property
    def R(self) -> Floats:
        """(at most c, c)."""
        if len(self._parts) > 1:
            self._parts = [stacked(self._parts)]
        return self._parts[0]


def stacked(parts: list[Floats]) -> Floats:
    """Return the triangular factor of rows (k, c) of which there may be many, one below another."""
    return np.asarray(np.linalg.qr(np.concatenate(parts), mode="r"))


class Gathered:
    """Factors of the rows [columns, torque] of every joint in every fold. parts: fold -> joint -> factor; channels: of
    each joint the rows for `told` that are fitted without a guess. squares: (folds, joints) of the measured torques
    [N^2 m^2]; described: of the description's residuals."""

    def __init__(self, folds: int, regressor: RegressorColumns) -> None:
        self.regressor = regressor
        self.parts = [[Triangle(width - 1) for width in regressor.widths] for _ in range(folds)]
        self.squares = np.zeros((folds, len(regressor.widths)))
        self.described = np.zeros_like(self.squares)
        self.channels = [Triangle(4 + len(regressor.widths)) for _ in regressor.widths]


@dataclass(eq=False)
class Guess:
    """A first fit: values by column (a,), and the standard deviation of each joint's residual [N m]; moments: of the
    rows that are fitted, and of their residuals as far as they are no outliers."""

    values: Floats
    sigma: Floats
    moments: Moments

    def weights(self, columns: Sequence[Floats], residuals: Floats, fit: NDArray[np.bool_]) -> Floats:
        """Return (k, joints) the square roots of Huber's weights; add the rows that are fitted to the moments."""
        huber = np.minimum(1.0, _OUTLIER / np.maximum(np.abs(residuals) / self.sigma, 1e-300))
        self.moments.add([each[fit] for each in columns], (residuals * huber)[fit])
        return np.sqrt(huber)


def gather(
    log: Log, cutoff: float, edges: Sequence[float], plain: Gathered, weighted: Gathered, guess: Guess | None = None
) -> None:
    """Add the rows of a log to the factors of folds that end at `edges` [s]; with a guess also by Huber's weights."""
    regressor = plain.regressor
    if guess is not None:
        guess.moments.restart()
    for rows in filtered(log, cutoff, regressor.compute):
        folds = np.searchsorted(np.asarray(edges), rows.time, side="right")
        fit, tau = folds < len(edges), rows.tau[:, regressor.measured]
        parts, described = [], []
        for columns, own in zip(regressor.by_joint(rows.values), tau.T, strict=True):
            parts.append(np.column_stack((columns[:, :-2], own - columns[:, -2])))
            described.append(columns[:, -1] - own)
        if guess is not None:
            pairs = zip(parts, regressor.used, strict=True)
            off = np.stack([part[:, :-1] @ guess.values[used] - part[:, -1] for part, used in pairs], axis=1)
            weights = guess.weights([part[:, :-1] for part in parts], off, fit)
        else:
            for joint, (j, used) in enumerate(zip(regressor.measured, regressor.used, strict=True)):
                names = [regressor.names[k] for k in used]
                own = [names.index(f"{regressor.model.rates[j]}.{kind}") for kind in ("viscous", "sign", "rotor")]
                channels = np.column_stack((parts[joint][:, own], described[joint] + tau[:, joint], tau))
                plain.channels[joint].add(channels[fit])
        for fold in np.unique(folds).tolist():
            own = folds == fold
            plain.squares[fold] += (tau[own] ** 2).sum(axis=0)
            plain.described[fold] += [(each[own] ** 2).sum() for each in described]
            for joint, part in enumerate(parts):
                plain.parts[fold][joint].add(part[own])
                if guess is not None:
                    weighted.squares[fold, joint] += float((part[own, -1] ** 2).sum())
                    weighted.parts[fold][joint].add(part[own] * weights[own, joint, None])


class Moments:
    """Sums of products of rows that are some rows apart: of each measured joint (2 LAGS + 1, a, a) sum over k of
    x_k x_(k + lag)^T, and (LAGS + 1, joints) of the residuals; count: rows of each joint."""

    def __init__(self, regressor: RegressorColumns) -> None:
        widths = [len(used) for used in regressor.used]
        self.columns = [np.zeros((2 * LAGS + 1, width, width)) for width in widths]
        self.residuals = np.zeros((LAGS + 1, len(widths)))
        self.count = 0
        self.restart()

    def restart(self) -> None:
        self._columns = [np.zeros((0, each.shape[1])) for each in self.columns]
        self._residuals = np.zeros((0, len(self.columns)))

    def add(self, columns: Sequence[Floats], residuals: Floats) -> None:
        """Add consecutive rows: of each joint (k, a), and (k, joints) residuals."""
        self.count += len(residuals)
        for j, (new, sums) in enumerate(zip(columns, self.columns, strict=True)):
            self._columns[j] = whole = np.concatenate([self._columns[j][-2 * LAGS :], new])
            for lag, (first, second) in enumerate(_apart(whole, len(new), 2 * LAGS)):
                sums[lag] += first.T @ second
        self._residuals = whole = np.concatenate([self._residuals[-LAGS:], residuals])
        for lag, (first, second) in enumerate(_apart(whole, len(residuals), LAGS)):
            self.residuals[lag] += einsum("kj,kj->j", first, second)


def _apart(whole: Floats, new: int, lags: int) -> Iterator[tuple[Floats, Floats]]:
    """Yield by lag the rows of which the later one is among the last `new`, and these."""
    for lag in range(min(lags + 1, len(whole))):
        first = max(len(whole) - new - lag, 0)
        yield whole[first : len(whole) - lag], whole[first + lag :]
