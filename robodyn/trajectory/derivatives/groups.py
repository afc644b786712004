"""Which velocities and accelerations are missing, and from which columns each is to be derived."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from robodyn.support.floats import Floats
from robodyn.trajectory.columns.layout import ABSENT, Layout
from robodyn.trajectory.columns.signals import TWIST, Signals
from robodyn.trajectory.motion import Trajectory

Targets = tuple[tuple[int, int], ...]
_AXES = "xyz"


@dataclass(frozen=True)
class Group:
    """Columns `rows` of the array `source` that are differentiated together: one, or the four of a quaternion; velocity
    and acceleration are pairs (component of the derivative, column of qd or qdd that it fills)."""

    name: str
    kind: Literal["scalar", "continuous", "quaternion"]
    source: Literal["q", "qd"]
    rows: tuple[int, ...]
    velocity: Targets
    acceleration: Targets

    @property
    def order(self) -> int:  # of the highest derivative that is wanted
        return 2 if self.acceleration and self.source == "q" else 1


def source(group: Group, samples: Trajectory) -> Floats:
    """The columns to differentiate (N, c), quaternions with continuous sign."""
    values: Floats = getattr(samples, group.source)[:, group.rows]
    if group.kind == "quaternion":
        flips = (values[1:] * values[:-1]).sum(axis=1) < 0.0
        sign = np.where(np.concatenate(([0], np.cumsum(flips))) % 2, -1.0, 1.0)
        return values * sign[:, None]
    return values


def straight(group: Group, samples: Trajectory) -> Floats:
    """The columns to differentiate with turns of 2 pi undone."""
    values = source(group, samples)
    return values - 2.0 * math.pi * turns_ahead(values) if group.kind == "continuous" else values


def turns_ahead(angles: Floats) -> Floats:
    """Whole turns that angles (N, c) are ahead of the shorter way from each to the next."""
    jumps = np.rint(np.diff(angles, axis=0) / (2.0 * math.pi))
    return np.concatenate((np.zeros((1, angles.shape[1])), np.cumsum(jumps, axis=0)))


def missing(signals: Signals, layout: Layout) -> tuple[tuple[Group, ...], tuple[str, ...]]:
    """What must be derived, and the assumptions made about floating joints."""
    groups: list[Group] = []
    notes: list[str] = []
    for joint in signals.joints:
        q, qd = signals.spans[joint.name]
        if joint.kind != "floating":
            groups += _scalar(joint.name, joint.kind == "continuous", layout, q[0], qd[0])
            continue
        for i, axis in enumerate(_AXES):
            groups += _scalar(f"{joint.name}_{axis}", False, layout, q[i], qd[3 + i])
        name, p, v = f"{joint.name} orientation", q[3], qd[0]
        for i, axis in enumerate(_AXES):
            if layout.qd[v + i] != ABSENT and layout.qdd[v + i] == ABSENT:
                groups.append(Group(f"{name} w{axis}", "scalar", "qd", (v + i,), (), ((0, v + i),)))
        absent = [i for i in range(3) if layout.qd[v + i] == ABSENT]
        if layout.q[p] != ABSENT and absent:
            w = tuple((i, v + i) for i in absent)
            wd = tuple((i, v + i) for i in absent if layout.qdd[v + i] == ABSENT)
            groups.append(Group(name, "quaternion", "q", tuple(range(p, p + 4)), w, wd))
        if joint.name in layout.followed:
            continue
        unsaid = [layout.q[p] == ABSENT and p not in layout.held for p in q[:4]]
        if lost := [axis for axis, absent in zip(_AXES, unsaid, strict=False) if absent]:
            notes.append(f"{joint.name}: position {' '.join(lost)} is not given and taken as 0")
        if unsaid[3]:
            notes.append(f"{joint.name}: orientation is not given and taken as the identity")
        rates = zip(TWIST, qd, (*[unsaid[3]] * 3, *unsaid[:3]), strict=True)
        if still := [part for part, v, absent in rates if absent and layout.qd[v] == ABSENT]:
            notes.append(f"{joint.name}: velocity {' '.join(still)} is not given and taken as 0")
    return tuple(groups), tuple(notes)


def anew(signals: Signals, layout: Layout) -> Layout:
    """The layout without the velocities and accelerations that can be derived from positions in the table."""
    gone: set[int] = set()
    for q, qd in signals.spans.values():
        of_rates = [q[3]] * 3 + [*q[:3]] if len(q) > 1 else [*q]
        gone |= {v for v, p in zip(qd, of_rates, strict=True) if layout.q[p] != ABSENT}
    rates = [tuple(ABSENT if i in gone else c for i, c in enumerate(of)) for of in (layout.qd, layout.qdd)]
    return replace(layout, qd=rates[0], qdd=rates[1])


def given(signals: Signals, layout: Layout) -> tuple[Group, ...]:
    """How to derive from positions what the table gives of velocities and accelerations."""
    lacking = missing(signals, layout)[0]
    return tuple(group for group in missing(signals, anew(signals, layout))[0] if group not in lacking)


def _scalar(name: str, endless: bool, layout: Layout, p: int, v: int) -> Iterator[Group]:
    q, qd, qdd = (column != ABSENT for column in (layout.q[p], layout.qd[v], layout.qdd[v]))
    target: Targets = ((0, v),)
    if qd and not qdd:
        yield Group(name, "scalar", "qd", (v,), (), target)
    elif q and not (qd and qdd):
        kind: Literal["scalar", "continuous"] = "continuous" if endless else "scalar"
        yield Group(name, kind, "q", (p,), () if qd else target, () if qdd else target)
