"""Solids of triangles as a picture: seen from (1, 1, 1), drawn from the back to the front."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

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
_CELLS, _FEWEST, _MOST = 230, 60, 30_000
"""Corners in the same cell are drawn as one. A cell is the size of all over _CELLS, about two pixels, or more where
there would be too many triangles otherwise."""
_PLACES = np.array((1, 1 << 20, 1 << 40))
"""Numbers that make one of three."""
_SIDE = 420
_LIGHT = np.array([0.25, 0.55, 0.8])
_TINTS = ((0.62, 0.67, 0.74), (0.53, 0.59, 0.68))
_MARKED = (0.95, 0.60, 0.25)
Solid = tuple[int, Floats]
"""A number that gives the colour, and triangles (m, 3, 3)."""


def on_paper(solids: Sequence[Solid]) -> list[Solid]:
    """Return the solids in the axes of the paper, coarse enough for a picture; none where there is nothing to see."""
    placed = [(number, product(triangles, PAPER.T)) for number, triangles in solids if len(triangles)]
    if not placed:
        return []
    corners = np.concatenate([each.reshape(-1, 3) for _, each in placed])
    finite = corners[np.isfinite(corners).all(axis=1)]
    size = float(np.ptp(finite, axis=0).max()) if len(finite) else 0.0
    if not size > 0.0:
        return []
    cells, coarse = float(_CELLS), placed
    while cells == _CELLS or (sum(len(each) for _, each in coarse) > _MOST and cells > _FEWEST):
        coarse = [(number, _coarse(each, size / cells)) for number, each in placed]
        cells *= 0.8
    return coarse


def _coarse(triangles: Floats, cell: float) -> Floats:
    """Return triangles between the means of the corners in each cell, each once; the surface keeps closed."""
    finite = triangles[np.isfinite(triangles).all(axis=(1, 2))].reshape(-1, 3)
    places, cells = np.unique(product(np.rint(finite / cell).astype(np.int64), _PLACES), return_inverse=True)
    count = np.bincount(cells)
    means = np.stack([np.bincount(cells, weights=x) / count for x in finite.T], axis=1)
    corners = cells.reshape(-1, 3)
    a, b, c = np.sort(corners, axis=1).T
    real = (a != b) & (b != c)
    _, first = np.unique((a * len(places) + b)[real] * len(places) + c[real], return_index=True)
    found: Floats = means[corners[real][first]]
    return found


def paint(axes: Axes, solid: Sequence[Solid], marked: int | None = None) -> None:
    """Draw what `on_paper` returns by the painter's algorithm: what is behind is drawn first."""
    from matplotlib.collections import PolyCollection

    triangles = np.concatenate([each for _, each in solid])
    tints = [_MARKED if number == marked else _TINTS[number % 2] for number, _ in solid]
    colours = np.repeat(np.array(tints), [len(each) for _, each in solid], axis=0)
    order = np.argsort(triangles[:, :, 2].sum(axis=1), kind="stable")
    triangles, colours = triangles[order], colours[order]
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), np.finfo(float).tiny)
    light = np.abs(product(normal, _LIGHT / length(_LIGHT)))
    colours = np.clip(colours * (0.5 + 0.62 * light[:, None]), 0.0, 1.0)
    flat: Any = triangles[:, :, :2]
    faces = PolyCollection(flat, facecolors=colours, edgecolors=colours, linewidths=0.3, rasterized=True)
    axes.add_collection(faces)
    axes.autoscale_view()


def triad(canvas: Canvas) -> None:
    """The axes of the frame, in a corner."""
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
