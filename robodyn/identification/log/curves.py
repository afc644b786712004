"""What plots show of logs: of every joint its speed, torques that were measured and computed, and friction."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robodyn.support.courses import Courses
from robodyn.support.floats import Floats

KINDS = ("speed", "measured", "computed", "explained", "friction")
"""Columns of each joint: `computed` is by the description, `explained` by what was found, and `friction` is in that."""


def curves_of(joints: Sequence[str], others: Sequence[str] = ()) -> Courses:
    """Return empty courses with the columns time, `others`, and `KIND_JOINT`, for `add`; besides these torques
    `off_JOINT` and `left_JOINT`, what is measured beyond computed and explained ones, have their extremes kept."""
    columns = ("time", *others, *(f"{kind}_{name}" for kind in KINDS for name in joints))
    return Courses(columns, [f"{kind}_{name}" for kind in (*KINDS[1:4], "off", "left") for name in joints])


def add(curves: Courses, time: Floats, joints: Sequence[Floats], others: Sequence[Floats] = ()) -> None:
    """Take in rows: time (N,), (N, joints) of each of `KINDS`, and others (N,) each."""
    _, measured, computed, explained, _ = joints
    extremes = (measured, computed, explained, measured - computed, measured - explained)
    curves.update((time, *others, *np.concatenate(joints, axis=1).T), [*np.concatenate(extremes, axis=1).T])
