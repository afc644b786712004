"""From gathered derivatives to error bars, shares of variance, and probabilities that limits are kept.

The first term of a figure is its derivative. It is tried with a few draws of the parameters, for which the loads at the
samples that were kept are linear. Where the first term misses them, because the peak is then at another sample, or a
load that is small is made by the errors themselves, the figure is drawn often instead.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robodyn.loads.result import JointLoad, MotorLoad, Sizing
from robodyn.loads.uncertainty import DRIVE, Figure, UncertaintyPass
from robodyn.loads.uncertainty_result import Bar, Uncertain, UncertainJoint, UncertainLimit, UncertainLoad
from robodyn.programs.vectors import product
from robodyn.support.floats import BEYOND, Floats, einsum, ranked

NEAR = 1.959963984540054  # standard errors on either side that hold 95 % of a normal figure


class Drawn(NamedTuple):
    """A figure with its sign, its standard error to first order, the gradient (m,) of its magnitude by x, what each
    parameter adds to its variance, in some unit (k,), and draws of its magnitude where the gradient alone would
    mislead."""

    value: float
    error: float
    gradient: Floats
    parts: Floats
    curved: Floats | None = None

    def bar(self) -> Bar:
        sign = -1.0 if self.value < 0.0 else 1.0
        if self.curved is None:
            reach = NEAR * self.error
            return Bar(self.value, self.error, self.value - reach, self.value + reach, "linear")
        low, high = np.quantile(sign * self.curved, (0.025, 0.975)).tolist()
        return Bar(self.value, float(self.curved.std(ddof=1)), low, high, "draws")

    def within(self, limit: float) -> float:
        if self.curved is not None:
            return float((self.curved <= BEYOND * limit).mean())
        if self.error <= 1e-12 * max(abs(self.value), abs(limit)):
            return float(abs(self.value) <= BEYOND * limit)
        return normal((limit - abs(self.value)) / self.error)


def normal(u: float) -> float:
    """Probability that a standard normal number is below u."""
    return 0.5 * math.erfc(-u / math.sqrt(2.0))


_Limit = tuple[UncertainLimit, NDArray[np.bool_]]  # a limit, and (draws,) whether each draw keeps to it


DRAWS, SEED = 20_000, 19
TRIED = 400  # draws with which the first term is tried
SHIFT, SCATTER = 0.01, 0.03
"""Of the standard error: the mean and the standard deviation of what the first term may miss."""
TOGETHER = 1000  # draws that are evaluated together
FEW = 128  # samples of which the higher orders of a mean are
FAR = 6.0  # standard errors within which a sample may become the peak
TINY = 1e-300


class Figures:
    """Figures of a motion, of everything that a pass has gathered."""

    def __init__(self, gathered: UncertaintyPass) -> None:
        self.of = gathered
        self.some = slice(None, None, -(-len(gathered.kept.time) // FEW))
        self.x = gathered.found.even_draws(DRAWS, SEED)
        self._peaks: dict[int, Drawn] = {}
        self._rms: dict[int, Drawn] = {}

    def peak(self, k: int) -> Drawn:
        if k not in self._peaks:
            of, figure = self.of, self.of.of.figures[k]
            at = of.at[k][: len(figure.columns)]
            value = at[0, 0] if len(at) == 1 else figure.size(at[:, 0])
            kept = np.concatenate((at[:, None], of.kept.columns[figure.columns]), 1)
            spread = np.sqrt(of.found.variance(kept[..., 1:]).sum(0))
            sizes = figure.size(kept[..., 0])
            magnitudes = _magnitudes(figure, kept[:, sizes + FAR * spread >= (sizes - FAR * spread).max()])

            def drawn(x: Floats) -> Floats:
                return np.asarray(magnitudes(x).max(axis=1))

            self._peaks[k] = self._figure(float(value), figure.gradient(at[:, 0], at[:, 1:]), at[:, 1:], drawn)
        return self._peaks[k]

    def rms(self, k: int) -> Drawn:
        """Return the RMS of figure k; its magnitude in a motion without duration."""
        totals, duration = self.of.integrals.totals, self.of.integrals.duration
        if duration <= 0.0:
            found = self.peak(k)
            return found._replace(value=abs(found.value))
        if k not in self._rms:
            figure = self.of.of.figures[k]
            square, slope = (totals[name][k] / duration for name in ("square", "product"))
            self._rms[k] = self._mean(figure, 2, float(square), 2.0 * slope, _shares(self.of.kept.time[self.some]))
        return self._rms[k]

    def cubic(self, i: int) -> Drawn:
        totals, of = self.of.integrals.totals, self.of.of
        travel = float(totals["travel"][i]) or 1.0
        figure = [figure for figure in of.figures if figure.name == "gear"][i]
        share = _shares(self.of.kept.time[self.some]) * self.of.kept.pace[of.trains[i][0], self.some]
        cube, slope = float(totals["wear"][i]) / travel, 3.0 * totals["wear change"][i] / travel
        return self._mean(figure, 3, cube, slope, share / (share.sum() + TINY))

    def _mean(self, figure: Figure, power: int, whole: float, slope: Floats, share: Floats) -> Drawn:
        """Return the power mean of a figure's magnitude; whole, slope (m,): mean of the power at all samples and its
        derivative; share: of each of some samples, of which the higher orders are."""
        kept = self.of.kept.columns[figure.columns, self.some]
        root, magnitudes = np.cbrt if power == 3 else np.sqrt, _magnitudes(figure, kept)
        size, at = float(root(np.array(whole))), kept[..., 0]
        own = power * einsum("cn,cnm->m", figure.half(at) * figure.size(at) ** (power - 2) * share, kept[..., 1:])
        before = product(figure.size(at) ** power, share)

        def drawn(x: Floats) -> Floats:
            change = product(magnitudes(x) ** power, share) - before + product(x, slope - own)
            return np.asarray(root(np.maximum(whole + change, 0.0)))

        gradient = slope / (power * size ** (power - 1)) if size else np.zeros(len(slope))
        return self._figure(size, gradient, kept[..., 1:].reshape(-1, len(slope)), drawn)

    def _figure(self, value: float, gradient: Floats, rows: Floats, drawn: Callable[[Floats], Floats]) -> Drawn:
        """Return a figure, of which rows (n, m) are all derivatives, drawn where its first term is not all."""
        error = math.sqrt(float(self.of.found.variance(gradient)))
        missed = drawn(self.x[:TRIED]) - abs(value) - product(self.x[:TRIED], gradient)
        small = abs(float(missed.mean())) <= SHIFT * error and float(missed.std()) <= SCATTER * error
        if small or float(np.abs(missed).max()) <= 1e-12 * abs(value):
            return Drawn(value, error, gradient, self._parts(gradient[None]))
        curved = [drawn(self.x[k : k + TOGETHER]) for k in range(0, DRAWS, TOGETHER)]
        return Drawn(value, error, gradient, self._parts(rows), np.concatenate(curved))

    def _parts(self, rows: Floats) -> Floats:
        """Return (k,) what each parameter adds to the variance of what has these derivatives (n, m), in all."""
        L = self.of.found.factor
        return np.asarray((rows * (rows if L is None else product(product(rows, L), L.T))).sum(0))

    def report(self, joints: Sequence[JointLoad], sizing: Sizing | None) -> Uncertain:
        places = {(figure.owner, figure.name): k for k, figure in enumerate(self.of.of.figures)}
        sized = sizing.joints if sizing else (None,) * len(joints)
        found, kept = [], []
        for joint, size in zip(joints, sized, strict=True):
            at = {name: places[joint.name, name] for name in DRIVE if (joint.name, name) in places}
            motor = size.motor if size else None
            limits = list(self._limits(joint, motor, at))
            kept += limits
            load = self._load(joint.name, at["tau"], joint.unit)
            shaft = self._load(joint.name, at["motor"], motor.unit, motor.peak) if motor else None
            found.append(UncertainJoint(load, shaft, tuple(limit for limit, _ in limits), _together(limits)))
        components: dict[str, list[UncertainLoad]] = {"": []}
        for k, figure in enumerate(self.of.of.figures):
            if figure.name not in DRIVE:
                unit = "N m" if figure.name.startswith(("m", "t")) else "N"
                components.setdefault(figure.owner, []).append(self._load(figure.name, k, unit))
        base = tuple(components.pop(""))
        return Uncertain(
            parameters={variation.name: variation.deviation for variation in self.of.found.each},
            draws=DRAWS,
            joints=tuple(found),
            base=base,
            bearings={name: tuple(loads) for name, loads in components.items()},
            suffices=_together(kept),
            lasting=_together([each for each in kept if abs(each[0].figure.value) <= BEYOND * each[0].limit]),
        )

    def _load(self, name: str, k: int, unit: str, signed: float = 0.0) -> UncertainLoad:
        """Return peak and RMS of figure k; signed: its peak, where the sign is not in its columns."""
        peak, rms = self.peak(k), self.rms(k)
        peak = peak._replace(value=-peak.value) if signed < 0.0 < peak.value else peak
        return UncertainLoad(name, unit, peak.bar(), rms.bar(), self._shares(peak), self._shares(rms))

    def _shares(self, figure: Drawn) -> Mapping[str, float]:
        """Return the share of each parameter in a variance, largest first; nothing where there is no variance."""
        whole = float(figure.parts.sum())
        if not whole > 0.0:
            return {}
        found: dict[str, float] = {}
        for variation, part in zip(self.of.found.each, figure.parts.tolist(), strict=True):
            found[variation.name] = found.get(variation.name, 0.0) + part / whole
        return dict(ranked(found.items(), key=lambda item: item[1]))

    def _limits(self, joint: JointLoad, motor: MotorLoad | None, at: Mapping[str, int]) -> Iterator[_Limit]:
        """Yield the limits of a joint and its motor; speeds are sure. at: places of the figures of `DRIVE`."""
        if joint.effort_limit is not None:
            yield self._limit("effort", self.peak(at["tau"]), joint.effort_limit, joint.unit)
        if joint.velocity_limit is not None:
            speed = "rad/s" if joint.unit == "N m" else "m/s"
            yield _sure("velocity", joint.max_speed, joint.velocity_limit, speed)
        if motor is None:
            return
        i = [self.of.of.joints[k] for k, _ in self.of.of.trains].index(joint.name)
        given = self.of.of.trains[i][1].motor
        if motor.nearest is not None:
            yield self._limit("motor torque", self.peak(at["use"]), 1.0, "of the peak curve")
        if motor.speed_limit is not None:
            yield _sure("motor speed", motor.max_speed, motor.speed_limit, motor.speed_unit)
        if (heat := motor.heat) is not None:  # by the parameters as they are
            hottest = 2.0 * heat.winding_limit if heat.winding is None else max(heat.winding, heat.winding_once or 0.0)
            yield _sure("winding temperature", hottest, heat.winding_limit, "degC")
        elif motor.continuous_limit is not None:
            yield self._limit("RMS motor torque", self.rms(at["motor"]), motor.continuous_limit, motor.unit)
        if given.gear_peak is not None:
            yield self._limit("gear torque", self.peak(at["gear"]), given.gear_peak, joint.unit)
        if given.gear_average is not None:
            yield self._limit("mean gear torque", self.cubic(i), given.gear_average, joint.unit)

    def _limit(self, quantity: str, figure: Drawn, limit: float, unit: str) -> _Limit:
        sizes = figure.curved
        if sizes is None:
            sizes = abs(figure.value) + product(self.x, figure.gradient)
        return UncertainLimit(quantity, figure.bar(), limit, unit, figure.within(limit)), sizes <= BEYOND * limit


def _magnitudes(figure: Figure, kept: Floats) -> Callable[[Floats], Floats]:
    """Return what finds magnitudes (draws, n) for draws of x, of columns with derivatives (1 or 2, n, 1 + m)."""
    flat = kept.reshape(-1, kept.shape[-1])
    used = np.flatnonzero(flat[:, 1:].any(axis=0))

    def sizes(x: Floats) -> Floats:
        loads = flat[:, 0] + product(x[:, used], flat[:, 1:][:, used].T)
        return figure.size(np.moveaxis(loads.reshape(len(x), len(kept), -1), 1, 0))

    return sizes


def _shares(time: Floats) -> Floats:
    """Return the share of the time that each of some samples stands for."""
    if len(time) < 2:
        return np.ones(len(time))
    weights = np.gradient(time)
    weights[[0, -1]] *= 0.5
    return np.asarray(weights / weights.sum())


def _sure(quantity: str, value: float, limit: float, unit: str) -> _Limit:
    kept = abs(value) <= BEYOND * limit
    sure = Bar(value, 0.0, value, value, "linear")
    return UncertainLimit(quantity, sure, limit, unit, float(kept)), np.full(DRAWS, kept)


def _together(limits: Sequence[_Limit]) -> float | None:
    """Return the probability that all limits are kept: by draws of all of them, for they depend on each other."""
    if not limits:
        return None
    unsure = [(limit, kept) for limit, kept in limits if limit.probability < 1.0]
    if len(unsure) < 2:
        return unsure[0][0].probability if unsure else 1.0
    return float(np.logical_and.reduce([kept for _, kept in unsure]).mean())
