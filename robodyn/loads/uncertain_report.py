"""What is reported of uncertain parameters: bars, shares of variance, and probabilities that limits are kept."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robodyn.loads.drawn import Drawn
from robodyn.loads.result import JointLoad
from robodyn.loads.sizing_result import JointSizing, MotorLoad, Sizing
from robodyn.loads.uncertain_figures import DRAWS, Figures
from robodyn.loads.uncertain_quantities import DRIVE
from robodyn.loads.uncertainty import UncertaintyPass
from robodyn.loads.uncertainty_result import Bar, Uncertain, UncertainJoint, UncertainLimit, UncertainLoad
from robodyn.support.floats import BEYOND, ranked


class _Limit(NamedTuple):
    """A limit with what is held against it; kept: whether each draw keeps to it."""

    shown: UncertainLimit
    kept: NDArray[np.bool_]


def uncertain(gathered: UncertaintyPass, joints: Sequence[JointLoad], sizing: Sizing | None) -> Uncertain:
    """Return everything gathered.

    Args:
        joints: loads, with limits; sizing: of motors, if asked for.
    """
    return _Report(gathered).uncertain(joints, sizing)


class _Report:
    def __init__(self, gathered: UncertaintyPass) -> None:
        self.gathered, self.figures = gathered, Figures(gathered)
        self.places = {(figure.owner, figure.name): k for k, figure in enumerate(gathered.of.figures)}

    def uncertain(self, joints: Sequence[JointLoad], sizing: Sizing | None) -> Uncertain:
        sized = sizing.joints if sizing else (None,) * len(joints)
        found, kept = [], []
        for joint, size in zip(joints, sized, strict=True):
            limits = list(self._limits(joint, size))
            found.append(self._joint(joint, size.motor if size else None, limits))
            kept += limits
        each = self.gathered.found.each
        base = tuple(self._component(k) for k, figure in enumerate(self.gathered.of.figures) if not figure.owner)
        return Uncertain(
            parameters={variation.name: variation.deviation for variation in each},
            draws=DRAWS,
            joints=tuple(found),
            base=base,
            bearings=self._bearings(),
            suffices=_together(kept),
            lasting=_together([limit for limit in kept if abs(limit.shown.figure.value) <= BEYOND * limit.shown.limit]),
        )

    def _joint(self, joint: JointLoad, motor: MotorLoad | None, limits: Sequence[_Limit]) -> UncertainJoint:
        return UncertainJoint(
            load=self._load(joint.name, self.places[joint.name, "tau"], joint.unit),
            motor=self._load(joint.name, self.places[joint.name, "motor"], motor.unit, motor.peak) if motor else None,
            limits=tuple(limit.shown for limit in limits),
            suffices=_together(limits),
        )

    def _bearings(self) -> dict[str, tuple[UncertainLoad, ...]]:
        """Return by joint what its bearing transmits."""
        found: dict[str, tuple[UncertainLoad, ...]] = {}
        for k, figure in enumerate(self.gathered.of.figures):
            if figure.owner and figure.name not in DRIVE:
                found[figure.owner] = (*found.get(figure.owner, ()), self._component(k))
        return found

    def _component(self, k: int) -> UncertainLoad:
        name = self.gathered.of.figures[k].name
        return self._load(name, k, "N m" if name.startswith(("m", "t")) else "N")

    def _load(self, name: str, k: int, unit: str, signed: float = 0.0) -> UncertainLoad:
        """Return peak and RMS of figure k; signed: its peak, where the sign is not in its columns."""
        peak, rms = self.figures.peak(k), self.figures.rms(k)
        peak = peak._replace(value=-peak.value) if signed < 0.0 < peak.value else peak
        return UncertainLoad(
            name,
            unit,
            peak.bar(),
            rms.bar(),
            self._shares(peak),
            self._shares(rms),
        )

    def _shares(self, figure: Drawn) -> Mapping[str, float]:
        """Return the share of each parameter in a variance, largest first; nothing where there is no variance."""
        whole = float(figure.parts.sum())
        if not whole > 0.0:
            return {}
        found: dict[str, float] = {}
        for variation, part in zip(self.gathered.found.each, figure.parts.tolist(), strict=True):
            found[variation.name] = found.get(variation.name, 0.0) + part / whole
        return dict(ranked(found.items(), key=lambda item: item[1]))

    def _limits(self, joint: JointLoad, sizing: JointSizing | None) -> Iterator[_Limit]:
        """Yield the limits of a joint and its motor; speeds are sure."""
        if joint.effort_limit is not None:
            yield self._peak_limit("effort", self.places[joint.name, "tau"], joint.effort_limit, joint.unit)
        if joint.velocity_limit is not None:
            speed = "rad/s" if joint.unit == "N m" else "m/s"
            yield _sure("velocity", joint.max_speed, joint.velocity_limit, speed)
        if sizing is not None and sizing.motor is not None:
            yield from self._motor_limits(joint, sizing.motor)

    def _motor_limits(self, joint: JointLoad, motor: MotorLoad) -> Iterator[_Limit]:
        figures = self.figures
        names = [self.gathered.of.joints[k] for k, _ in self.gathered.of.trains]
        i = names.index(joint.name)
        given = self.gathered.of.trains[i][1].motor
        use, shaft, gear = (self.places[joint.name, name] for name in ("use", "motor", "gear"))
        if motor.nearest is not None:
            yield self._peak_limit("motor torque", use, 1.0, "of the peak curve")
        if motor.speed_limit is not None:
            yield _sure("motor speed", motor.max_speed, motor.speed_limit, motor.speed_unit)
        if motor.continuous_limit is not None:
            yield self._limit("RMS motor torque", figures.rms(shaft), motor.continuous_limit, motor.unit)
        if given.gear_peak is not None:
            yield self._peak_limit("gear torque", gear, given.gear_peak, joint.unit)
        if given.gear_average is not None:
            yield self._limit("mean gear torque", figures.cubic(i), given.gear_average, joint.unit)

    def _peak_limit(self, quantity: str, k: int, limit: float, unit: str) -> _Limit:
        return self._limit(quantity, self.figures.peak(k), limit, unit)

    def _limit(self, quantity: str, figure: Drawn, limit: float, unit: str) -> _Limit:
        shown = UncertainLimit(quantity, figure.bar(), limit, unit, figure.within(limit))
        return _Limit(shown, self.figures.magnitudes(figure) <= BEYOND * limit)


def _sure(quantity: str, value: float, limit: float, unit: str) -> _Limit:
    """Return a limit of what no parameter changes."""
    kept = abs(value) <= BEYOND * limit
    shown = UncertainLimit(quantity, Bar(value, 0.0, value, value, "linear"), limit, unit, float(kept))
    return _Limit(shown, np.full(DRAWS, kept))


def _together(limits: Sequence[_Limit]) -> float | None:
    """Return the probability that all limits are kept: by draws of all of them, for they depend on each other."""
    if not limits:
        return None
    unsure = [limit for limit in limits if limit.shown.probability < 1.0]
    if len(unsure) < 2:
        return unsure[0].shown.probability if unsure else 1.0
    return float(np.logical_and.reduce([limit.kept for limit in unsure]).mean())
