"""Solids of triangles as a picture: seen from (1, 1, 1), what is nearer hides what is behind."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from robodyn.programs.vectors import length, product
from robodyn.report.document import Figure
from robodyn.report.pictures.arrows import RIGHT, TOWARDS, UP
from robodyn.report.pictures.figures import INK, SERIES, SOFT, plot
from robodyn.report.table import number
from robodyn.solids.inertia.properties import MassProperties
from robodyn.support.floats import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

PAPER = np.stack((RIGHT, UP, TOWARDS))
"""Ground axes to right, up, and towards the reader."""
_DOTS, _FINE = 800, 2
"""Dots of a picture along its longer side, and samples along a dot, so that edges are smooth."""
_WORK = 60_000_000
"""Samples of all triangles together, those that are hidden too; where there would be more, they are larger."""
_AT_ONCE = 1_000_000
_EDGE_ON = 1e-9
"""The part of a normal towards the reader below which a triangle has no width."""
_SIDE = 420
_LIGHT = np.array([0.25, 0.55, 0.8])
_TINTS = ((0.62, 0.67, 0.74), (0.53, 0.59, 0.68))
_MARKED = (0.95, 0.60, 0.25)
Solid = tuple[int, Floats]
"""A number that gives the colour, and triangles (m, 3, 3)."""


def on_paper(solids: Sequence[Solid]) -> list[Solid]:
    """Return the solids in the axes of the paper; none where there is nothing to see."""
    placed = [(number, product(triangles, PAPER.T)) for number, triangles in solids]
    found = [(number, each[np.isfinite(each).all(axis=(1, 2))]) for number, each in placed]
    corners = [ends for _, each in found if len(each) for ends in (each.min(axis=(0, 1)), each.max(axis=(0, 1)))]
    return found if corners and np.ptp(corners, axis=0).any() else []


def paint(axes: Axes, solids: Sequence[Solid], marked: int | None = None) -> None:
    """Draw what `on_paper` returns: of all triangles that cover a dot, the one nearest to the reader is seen."""
    triangles = np.concatenate([each for _, each in solids])
    tints = [_MARKED if number == marked else _TINTS[number % 2] for number, _ in solids]
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), np.finfo(float).tiny)
    light = np.abs(product(normal, _LIGHT / length(_LIGHT)))
    colours = np.repeat(np.array(tints), [len(each) for _, each in solids], axis=0) * (0.5 + 0.62 * light[:, None])
    low, high = triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))
    sample = _sample(triangles, float((high - low).max()))
    across, up = (int(n) + 1 for n in (high - low)[:2] / (_FINE * sample))
    nearest = _nearest((triangles - low) / sample, _FINE * across, _FINE * up).reshape(up, _FINE, across, _FINE)
    covered = (nearest >= 0).sum(axis=(1, 3))[:, :, None]
    colours = np.concatenate((colours.clip(0.0, 1.0), np.zeros((1, 3))))[nearest].sum(axis=(1, 3)) / covered.clip(1)
    ends = low[:2] + sample * _FINE * np.array((across, up))
    picture = np.concatenate((colours, covered / _FINE**2), axis=2)
    axes.imshow(picture, origin="lower", extent=(low[0], ends[0], low[1], ends[1]), interpolation="none")
    axes.use_sticky_edges = False


def _sample(triangles: Floats, size: float) -> float:
    """Return the width of a sample, for triangles that are so large together."""
    (x, y), (u, v) = ((triangles[:, k, :2] - triangles[:, 0, :2]).T for k in (1, 2))
    return max(size / (_FINE * _DOTS), float(np.sqrt(np.abs(x * v - y * u).sum() / (2 * _WORK))))


def _nearest(triangles: Floats, across: int, up: int) -> NDArray[np.int64]:
    """Return (up * across,) the triangle that is seen at the middle of each sample, -1 where there is none.

    Method: the rows of each triangle, the samples of each row, and a buffer of depths (Catmull 1974).

    Args:
        triangles: (m, 3, 3), a unit is a sample.
    """
    depth, found = np.full(up * across, -np.inf), np.full(up * across, -1)
    a, b, c = (triangles[:, k] for k in range(3))
    normal = np.cross(b - a, c - a)
    flat = np.abs(normal[:, 2:]) > _EDGE_ON * np.linalg.norm(normal, axis=1, keepdims=True)
    tilt = np.divide(-normal[:, :2], normal[:, 2:], out=np.zeros((len(a), 2)), where=flat)
    first, last = (_middles(end(triangles[:, :, 1], axis=1), up) for end in (np.min, np.max))
    work = np.cumsum((last - first) * (np.ptp(triangles[:, :, 0], axis=1) + 1.0) + 1.0)
    for part in np.split(np.arange(len(triangles)), np.flatnonzero(np.diff(work // _AT_ONCE)) + 1):
        row_of, y = _counted(first[part], last[part])
        corners = triangles[part][row_of]
        begins, ends = corners, np.roll(corners, 1, axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            slope = (ends[:, :, 0] - begins[:, :, 0]) / (ends[:, :, 1] - begins[:, :, 1])
            crossed = begins[:, :, 0] + slope * (y[:, None] + 0.5 - begins[:, :, 1])
        crossed[(begins[:, :, 1] <= y[:, None] + 0.5) == (ends[:, :, 1] <= y[:, None] + 0.5)] = np.nan
        left, right = (_middles(end.reduce(crossed, axis=1), across) for end in (np.fmin, np.fmax))
        row, x = _counted(left, right)
        triangle = part[row_of]
        here = np.stack((np.full(len(y), 0.5), y + 0.5), axis=1) - corners[:, 0, :2]
        start = corners[:, 0, 2] + (tilt[triangle] * here).sum(axis=1)
        z, at = start[row] + tilt[triangle[row], 0] * x, across * y[row] + x
        np.maximum.at(depth, at, z)
        seen = z >= depth[at]
        found[at[seen]] = triangle[row[seen]]
    return found


def _middles(places: Floats, most: int) -> NDArray[np.int64]:
    """Return the first sample whose middle is not below each place; 0 for one that is missing."""
    return np.ceil(np.nan_to_num(places) - 0.5).clip(0, most).astype(np.int64)


def _counted(first: NDArray[np.int64], last: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the numbers of several ranges one after another: of which range each is, and the number."""
    many = last - first
    of = np.repeat(np.arange(len(many)), many)
    return of, np.arange(len(of)) - np.repeat(np.cumsum(many) - many, many) + first[of]


def triad(canvas: Canvas) -> None:
    """Draw the axes of the frame, in a corner."""
    axes = canvas.add_axes((0.0, 0.0, 0.16, 0.16))
    axes.set_axis_off()
    axes.set_xlim(-1.5, 1.5)
    axes.set_ylim(-1.5, 1.5)
    for k, letter in enumerate("xyz"):
        across, up, _ = PAPER[:, k]
        axes.plot((0, across), (0, up), color=SOFT, linewidth=1.5)
        axes.text(1.35 * across, 1.35 * up, letter, color=SOFT, ha="center", va="center", fontsize=11)


def body_figure(name: str, body: MassProperties, triangles: Floats, key: str) -> Figure:
    """Return a solid with its mass centre and its principal axes."""
    solids = on_paper([(0, triangles)])
    reach = float(np.ptp(triangles.reshape(-1, 3), axis=0).max())

    def draw(canvas: Canvas) -> None:
        axes = canvas.add_axes((0.0, 0.0, 1.0, 1.0))
        axes.set_axis_off()
        axes.set_aspect("equal", adjustable="datalim")
        if solids:
            paint(axes, solids)
        centre = product(PAPER, body.com)
        for k, axis in enumerate(body.principal.axes):
            across, up, _ = 0.3 * reach * product(PAPER, axis)
            ends = ((centre[0] - across, centre[0] + across), (centre[1] - up, centre[1] + up))
            axes.plot(*ends, color=SERIES[(1, 2, 5)[k]], linewidth=2, label=f"axis {k + 1}")
        axes.plot(centre[0], centre[1], marker="o", markersize=7, linestyle="none", color=INK, label="centre of mass")
        axes.margins(0.08)
        canvas.legend(loc="upper left", ncols=4, columnspacing=1.0)
        triad(canvas)

    moments = ", ".join(number(moment) for moment in body.principal.moments)
    alt = f"Picture of {name} with its centre of mass and its principal axes; principal moments {moments} kg m^2"
    return Figure(f"{name}: centre of mass and principal axes", alt, plot(_SIDE, _SIDE, draw, key))
