"""Which velocities and accelerations are missing, and from which columns each is to be derived."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from robodyn.support.floats import Floats, median
from robodyn.trajectory.columns import Signals
from robodyn.trajectory.layout import ABSENT, Layout

if TYPE_CHECKING:
    from robodyn.trajectory.motion import Trajectory

Targets = tuple[tuple[int, int], ...]
_AXES = "xyz"
_MOVES, _EVEN, _EXACT = 1e-3, 1e-6, 1e-8
"""Of the largest acceleration: rows that accelerate; of steps or accelerations: what is equal; and of speeds."""


@dataclass(frozen=True)
class Group:
    """Columns that are differentiated together.

    Args:
        name: for the report.
        source, rows: the array that is differentiated, "q" or "qd", and its columns: one, or the four of a quaternion.
        velocity, acceleration: pairs (component of the derivative, column of qd or qdd that it fills).
    """

    name: str
    kind: Literal["scalar", "continuous", "quaternion"]
    source: Literal["q", "qd"]
    rows: tuple[int, ...]
    velocity: Targets
    acceleration: Targets


def samples_needed(groups: Sequence[Group]) -> int:
    """Samples without which the derivatives mean nothing: one more than the highest derivative."""
    orders = [2 if group.acceleration and group.source == "q" else 1 for group in groups]
    return 1 + max(orders, default=0)


def missing(signals: Signals, layout: Layout) -> tuple[tuple[Group, ...], tuple[str, ...]]:
    """What must be derived, and the assumptions made about floating joints."""
    groups: list[Group] = []
    notes: list[str] = []
    position = velocity = 0
    for joint in signals.joints:
        if joint.kind == "floating":
            for i, axis in enumerate(_AXES):
                groups += _scalar(f"{joint.name}_{axis}", "scalar", layout, position + i, velocity + 3 + i)
            groups += _rotation(f"{joint.name} orientation", layout, position + 3, velocity)
            if joint.name not in layout.followed:
                notes += _assumptions(joint.name, layout, position, velocity)
            position, velocity = position + 7, velocity + 6
        else:
            kind: Literal["scalar", "continuous"] = "continuous" if joint.kind == "continuous" else "scalar"
            groups += _scalar(joint.name, kind, layout, position, velocity)
            position, velocity = position + 1, velocity + 1
    return tuple(groups), tuple(notes)


def anew(signals: Signals, layout: Layout) -> Layout:
    """Return the layout without the velocities and accelerations that can be derived from positions in the table."""
    gone: set[int] = set()
    p = v = 0
    for joint in signals.joints:
        if joint.kind == "floating":
            gone |= {v + 3 + i for i in range(3) if layout.q[p + i] != ABSENT}
            gone |= {v, v + 1, v + 2} if layout.q[p + 3] != ABSENT else set()
            p, v = p + 7, v + 6
        else:
            gone |= {v} if layout.q[p] != ABSENT else set()
            p, v = p + 1, v + 1
    qd, qdd = (tuple(ABSENT if i in gone else c for i, c in enumerate(of)) for of in (layout.qd, layout.qdd))
    return replace(layout, qd=qd, qdd=qdd)


def given(signals: Signals, layout: Layout) -> tuple[Group, ...]:
    """Return how to derive from positions what the table gives of velocities and accelerations."""
    lacking = missing(signals, layout)[0]
    return tuple(group for group in missing(signals, anew(signals, layout))[0] if group not in lacking)


def _scalar(name: str, kind: Literal["scalar", "continuous"], layout: Layout, p: int, v: int) -> Iterator[Group]:
    q, qd, qdd = (column != ABSENT for column in (layout.q[p], layout.qd[v], layout.qdd[v]))
    target: Targets = ((0, v),)
    if qd and not qdd:
        yield Group(name, "scalar", "qd", (v,), (), target)
    elif q and not (qd and qdd):
        yield Group(name, kind, "q", (p,), () if qd else target, () if qdd else target)


def _rotation(name: str, layout: Layout, p: int, v: int) -> Iterator[Group]:
    for i, axis in enumerate(_AXES):
        if layout.qd[v + i] != ABSENT and layout.qdd[v + i] == ABSENT:
            yield Group(f"{name} w{axis}", "scalar", "qd", (v + i,), (), ((0, v + i),))
    absent = [i for i in range(3) if layout.qd[v + i] == ABSENT]
    if layout.q[p] != ABSENT and absent:
        w = tuple((i, v + i) for i in absent)
        wd = tuple((i, v + i) for i in absent if layout.qdd[v + i] == ABSENT)
        yield Group(name, "quaternion", "q", tuple(range(p, p + 4)), w, wd)


def _assumptions(name: str, layout: Layout, p: int, v: int) -> Iterator[str]:
    lost = [axis for i, axis in enumerate(_AXES) if _unsaid(layout, p + i)]
    if lost:
        yield f"{name}: position {' '.join(lost)} is not given and taken as 0"
    if _unsaid(layout, p + 3):
        yield f"{name}: orientation is not given and taken as the identity"
    still = [part for i, part in enumerate(("wx", "wy", "wz")) if _unknown(layout, p + 3, v + i)]
    still += [f"v{axis}" for i, axis in enumerate(_AXES) if _unknown(layout, p + i, v + 3 + i)]
    if still:
        yield f"{name}: velocity {' '.join(still)} is not given and taken as 0"


def _unsaid(layout: Layout, p: int) -> bool:
    return layout.q[p] == ABSENT and p not in layout.held


def _unknown(layout: Layout, p: int, v: int) -> bool:
    return _unsaid(layout, p) and layout.qd[v] == ABSENT


def consistent(groups: Sequence[Group], pieces: Sequence[Trajectory]) -> Floats | None:
    """Return (n,) what accelerations are off by from differences of velocities, None if anything may be wrong.

    That is told by exact data with equal steps h: q1 - q0 = h (qd0 + qd1) / 2 - h^2 (qdd1 - qdd0) / 12 but for terms of
    h^5, and Simpson's rule for velocities. In half of the rows that accelerate both must hold as for smooth motions.
    """
    found = np.zeros(pieces[0].qdd.shape[1])
    for group in groups:
        if group.kind == "quaternion" or not (group.velocity and group.acceleration):
            return None
        p, v = group.rows[0], group.velocity[0][1]
        for each in pieces:
            q, qd, qdd, steps = each.q[:, p], each.qd[:, v], each.qdd[:, v], np.diff(each.time)
            h, dq = float(steps.mean()), np.diff(q)
            if group.kind == "continuous":
                dq -= 2.0 * np.pi * np.rint(dq / (2.0 * np.pi))
            off = np.abs(dq - 0.5 * h * (qd[1:] + qd[:-1]) + h * h / 12.0 * (qdd[1:] - qdd[:-1]))
            rate = np.abs(qd[2:] - qd[:-2] - h / 3.0 * (qdd[2:] + 4.0 * qdd[1:-1] + qdd[:-2]))
            speed, level = np.abs(qd).max(), np.abs(qdd).max()
            moves = np.abs(qdd[1:-1]) > _MOVES * level
            if not moves.any():
                continue
            apart = median(rate[moves]) / (2.0 * h)
            if (
                np.abs(steps - h).max() > _EVEN * h
                or median(off[1:][moves]) > _EXACT * h * speed
                or apart > _EVEN * level
            ):
                return None
            found[v] = max(found[v], apart)
    return found
