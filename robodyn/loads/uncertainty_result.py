"""How sure the figures of a motion are where parameters are uncertain: frozen data that reports turn into text."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from robodyn.errors import Caveat

Method = Literal["linear", "draws"]
SURE = 0.95  # a verdict that holds with a smaller probability is in doubt


@dataclass(frozen=True)
class Bar:
    """A figure and how sure it is.

    Attributes:
        value: for the parameters as given, with its sign; a figure is compared by its magnitude.
        standard_error; low, high: an interval that holds the figure in 95 % of cases.
        method: "linear": by the derivatives of the figure; "draws": of the linear loads at all samples that may become
            the figure's, for the derivatives alone would mislead.
    """

    value: float
    standard_error: float
    low: float
    high: float
    method: Method


@dataclass(frozen=True)
class UncertainLimit:
    """A limit of a joint, and the probability that the motion keeps to it; "motor torque" is a share of what the peak
    curve allows then, others are as `Exceeded.quantity`."""

    quantity: str
    figure: Bar
    limit: float
    unit: str
    probability: float


@dataclass(frozen=True)
class UncertainLoad:
    """Peak and RMS of a load, of a joint, of its motor, of a component of a bearing's load or of the base wrench.
    `shares` are by parameter, of the variance of the peak, largest first; they add up to 1. Correlated parameters share
    what they make together, which may be negative."""

    name: str
    unit: str
    peak: Bar
    rms: Bar
    shares: Mapping[str, float]
    rms_shares: Mapping[str, float]


@dataclass(frozen=True)
class UncertainJoint:
    """A joint, its motor's shaft, and the probability that all its limits suffice; None without a motor or limits."""

    load: UncertainLoad
    motor: UncertainLoad | None
    limits: tuple[UncertainLimit, ...]
    suffices: float | None


@dataclass(frozen=True)
class Uncertain:
    """How sure the figures of a motion are.

    Attributes:
        parameters: by name the standard deviation of each that varies [SI; of factors as shares].
        draws: of parameters, for figures that are not linear and for probabilities.
        bearings: by joint, components of its bearing's load and the resultants radial and tilting; {} without sizing.
        suffices: the probability that all joints keep to all their limits, None without any; lasting: likewise, of the
            limits that are kept with the parameters as they are given.
    """

    parameters: Mapping[str, float]
    draws: int
    joints: tuple[UncertainJoint, ...]
    base: tuple[UncertainLoad, ...]
    bearings: Mapping[str, tuple[UncertainLoad, ...]]
    suffices: float | None
    lasting: float | None

    @property
    def caveats(self) -> tuple[Caveat, ...]:
        if self.lasting is None or self.lasting >= SURE:
            return ()
        said = f"parameters are uncertain: limits are kept all with a probability of {100.0 * self.lasting:.3g} %"
        return (Caveat("with the parameters as they are given", said),)
