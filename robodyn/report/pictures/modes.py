"""A mode as a picture: the robot at rest, and where the mode takes it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from robodyn.dynamics.loops.closure import moved
from robodyn.programs.vectors import product
from robodyn.report.document import Figure
from robodyn.report.pictures.figures import INK, SERIES, SOFT, plot
from robodyn.report.pictures.solids import PAPER, triad
from robodyn.report.table import printable
from robodyn.robot.configuration import body_poses
from robodyn.robot.model import Model
from robodyn.support.floats import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

_SIZE = 340
_TURN, _SHIFT = 0.35, 0.15
"""rad, and parts of the robot's size: how far the joints go at most."""


def mode_figure(model: Model, q: Floats, shape: Sequence[complex], caption: str, name: str) -> Figure:
    """Return the robot at q as a skeleton, from joint to joint and on to mass centres, and where it is half a period
    of the mode apart, seen from (1, 1, 1).

    Args:
        shape: (n,) how the joints move; the phase shown is that of the first that moves as much as any.
        name: no other picture of the page has.
    """
    rest = _bars(model, q)
    size = float(np.ptp(np.concatenate(rest), axis=0).max()) or 1.0
    step = _step(model, np.array(shape), size)
    ends = [_bars(model, np.array(moved(model, q.tolist(), (sign * step).tolist()))) for sign in (1.0, -1.0)]

    def draw(canvas: Canvas) -> None:
        axes = canvas.add_axes((0.0, 0.0, 1.0, 1.0))
        axes.set_axis_off()
        axes.set_aspect("equal", adjustable="datalim")
        _draw(axes, rest, SOFT, 5.0, "-")
        _draw(axes, ends[1], SERIES[0], 2.0, (0, (4, 2)))
        _draw(axes, ends[0], SERIES[1], 3.0, "-")
        across, up, _ = product(np.stack([bar[0] for bar in rest]), PAPER.T).T
        axes.plot(across, up, linestyle="none", marker="o", markersize=5, color=INK)
        axes.margins(0.12)
        triad(canvas)

    alt = f"Skeleton at rest in grey, at one end of the motion as a line, at the other end dashed. {printable(caption)}"
    return Figure(printable(caption), alt, plot(_SIZE, _SIZE, draw, name))


def _step(model: Model, shape: Floats, size: float) -> Floats:
    """Return how far (n,) each joint goes."""
    lengths = np.ones(model.n)
    for joint in model.independent:
        if joint.kind == "prismatic":
            lengths[joint.rate] = size
        elif joint.kind == "floating":
            lengths[joint.rate + 3 : joint.rate + 6] = size
    far = np.abs(shape) / np.where(lengths == 1.0, _TURN, _SHIFT * lengths)
    first = shape[int(np.argmax(far >= far.max() * (1.0 - 1e-6)))]
    turned = (shape * np.conj(first)).real / (abs(first) or 1.0)
    return np.asarray(turned / (far.max() or 1.0))


def _bars(model: Model, q: Floats) -> list[Floats]:
    """Return (2, 3) each: from every body's origin to those that it carries, else to its mass centre, on the ground."""
    places = [(np.asarray(R, dtype=float), np.asarray(p, dtype=float)) for R, p in body_poses(model, q)]
    if model.floating:
        from robodyn.programs.vectors import rotation_from_quaternion

        R, p = np.asarray(rotation_from_quaternion(*q[3:7]), dtype=float), q[:3]
        places = [(product(R, each), p + product(R, at)) for each, at in places]
    bars = [np.stack((places[parent][1], places[k][1])) for k, parent in enumerate(model.parents) if parent >= 0]
    for k in set(range(len(places))) - {parent for parent in model.parents if parent >= 0}:
        R, p = places[k]
        bars.append(np.stack((p, p + product(R, model.bodies[k].inertia.centre_of_mass))))
    return bars


def _draw(axes: Axes, bars: list[Floats], colour: str, width: float, style: object) -> None:
    for bar in bars:
        across, up, _ = product(bar, PAPER.T).T
        axes.plot(across, up, color=colour, linewidth=width, linestyle=style, solid_capstyle="round")
