"""What the recursions pass around; the entries are any scalar."""

from __future__ import annotations

from typing import NamedTuple

from robodyn.programs.vectors import Array


class Motion(NamedTuple):
    """How a body moves relative to its parent; see `kinematics.joint_motion`.

    Attributes:
        R: rotation that takes components in the body's axes to the parent's.
        p: the body's origin from the parent's, in the parent's axes [m].
        w, v: relative angular and linear velocity, in the body's axes [rad/s, m/s].
        wd, a: their rates as seen from the parent, in the body's axes [rad/s^2, m/s^2].
    """

    R: Array
    p: Array
    w: Array
    v: Array
    wd: Array
    a: Array


class Wrench(NamedTuple):
    """A force [N] and a moment [N m] about the body's origin, both in the body's axes."""

    f: Array
    n: Array
