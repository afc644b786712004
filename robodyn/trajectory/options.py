"""How a table is to be read, as a person asks for it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from robodyn.errors import TrajectoryError
from robodyn.support.wording import alternatives, shown
from robodyn.trajectory.columns.signals import ANGLES, POSE, AngleUnit, Signals, TimeUnit

Derivatives = Literal["auto", "anew", "given", "spline", "savgol", "central", "none"]
MODES = ("auto", "anew", "given", "spline", "savgol", "central")
REST = "rest"
HoldGiven = str | float | Mapping[str, str | float]
"""`"rest"`, a position for all, positions by joint; or all of these as text: `"rest,elbow=0.3"`."""


@dataclass(frozen=True)
class Hold:
    """Where joints without columns are held, by the name of a joint or a coordinate; `every` other one if not None."""

    every: str | float | None = None
    named: Mapping[str, str | float] = field(default_factory=dict)

    def positions(self, signals: Signals, angle_unit: AngleUnit) -> dict[int, float]:
        """Index in q -> position [rad or m], of all that is to be held; raises if there is no such joint, or a floating
        one is given one number. A number for all leaves floating joints at rest: at their place and not turned."""

        def position(i: int, place: str | float) -> float:
            angle = signals.kinds[signals.positions[i]] == "angle"
            return signals.rest[i] if isinstance(place, str) else place / (ANGLES[angle_unit] if angle else 1.0)

        joints = {name: at for name, (at, _) in signals.spans.items()}
        found: dict[int, float] = {}
        if self.every is not None:
            for at in joints.values():
                found |= {i: position(i, self.every if len(at) == 1 else REST) for i in at}
        single = {stem: range(i, i + 1) for i, stem in enumerate(signals.positions) if signals.kinds[stem]}
        for name, place in self.named.items():
            if name not in joints and name not in single:
                follows = "it follows another" if name in signals.dependent else alternatives(name, [*joints], "joints")
                raise TrajectoryError(f"no joint {shown(name)} to hold", remedy=follows)
            at = joints.get(name) or single[name]
            if len(at) > 1 and not isinstance(place, str):
                remedy = f"give {', '.join(f'{name}_{part}=...' for part in POSE[:3])} or {name}={REST}"
                raise TrajectoryError(f"joint {shown(name)} moves freely, one number does not place it", remedy=remedy)
            found |= {i: position(i, place) for i in at}
        return found


def hold_of(given: HoldGiven | None) -> Hold:
    """What a person gives as data; raises if it is not understood."""
    if isinstance(given, Mapping):
        return Hold(None, {name: _place(place) for name, place in given.items()})
    parts = [part.rpartition("=") for part in str(given).split(",")] if given is not None else []
    every = [_place(place) for _, equals, place in parts if not equals]
    return Hold(every[-1] if every else None, {name.strip(): _place(place) for name, equals, place in parts if equals})


def _place(given: str | float) -> str | float:
    text = str(given).strip()
    try:
        place = math.nan if "_" in text else float(text)
    except ValueError:
        place = math.nan
    if text != REST and not math.isfinite(place):
        what = f"{shown(text)} is no place to hold a joint"
        raise TrajectoryError(what, remedy="rest, a number, or joints as in rest,elbow=0.3")
    return REST if text == REST else place


@dataclass(frozen=True)
class Reading:
    """How a table is to be read, as of `read_motion`; derivatives "none" leaves what is missing 0, for callers' own."""

    derivatives: Derivatives = "auto"
    ignore_extra: bool = False
    hold: Hold = field(default_factory=Hold)
    columns: Mapping[str, str] = field(default_factory=dict)
    time_unit: TimeUnit | None = None
    angle_unit: AngleUnit | None = None
    topic: str | None = None
    measured: bool = False
    encoder_error: float = 0.0

    def __post_init__(self) -> None:
        if not 0.0 <= self.encoder_error < math.inf:
            raise TrajectoryError(f"an encoder's error of {self.encoder_error:g} rad is none", remedy="0 or more")


DEFAULT = Reading()
