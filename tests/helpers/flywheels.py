"""A flywheel on a hinge or a slide, in space, whose figures have closed forms: motions and scenes."""

from __future__ import annotations

import numpy as np

from helpers.oracles import reference
from helpers.small_robots import built, joint, link
from robodyn.scene.scene import Scene
from robodyn.trajectory.read import motion

SIZING = reference("sizing")
LIMITS = '<limit lower="-9" upper="9" effort="1000" velocity="100"/>'


def wheel(kind="revolute", limits=LIMITS, J=2.0):
    hinge = joint("j", "base", "wheel", kind).replace(LIMITS, limits)
    return built(link("base"), link("wheel", J, inertia=(J, 0, 0, J, 0, J)), hinge)


def swing(model, n=4001):
    """q = 0.5 sin(2 pi t) over one cycle, sampled so that all extremes are met."""
    t = np.linspace(0, 1, n)[:, None]
    w = 2 * np.pi
    return motion(model, t[:, 0], 0.5 * np.sin(w * t), 0.5 * w * np.cos(w * t), -0.5 * w * w * np.sin(w * t))


def in_space(motor=None, rotor=None, **more):
    """A scene without weight, with a motor or a rotor at the joint."""
    return Scene(
        gravity=(0.0, 0.0, 0.0),
        motor={"j": motor} if motor else {},
        rotor={"j": rotor} if rotor is not None else {},
        **more,
    )


EXAMPLE = SIZING["harmonic_drive"]["worked_example"]
"""Of the gear's maker: 150, 82, 130, 0 N m for 0.2, 3, 0.3, 0.2 s at 10, 20, 10, 0 rpm."""


def worked_example():
    """The same as a motion of the flywheel."""
    rows = [(T, n * np.pi / 30, t) for T, n, t in zip(*(EXAMPLE[key] for key in ("T", "n", "t")), strict=True)]
    ends = np.cumsum([0, *(t for *_, t in rows)])
    time = np.column_stack((ends[:-1] + 1e-9, ends[1:])).ravel()
    speed, push = (np.repeat([row[k] for row in rows], 2)[:, None] for k in (1, 0))
    return motion(wheel(), time, 0 * speed, speed, push / 2.0)
