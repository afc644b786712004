"""A robot in one pose as a picture: its visual shapes, or its joints as a skeleton."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from robodyn.history import Floats
from robodyn.model import Model
from robodyn.report.document import Figure
from robodyn.report.figures import INK, SERIES, SOFT, plot
from robodyn.report.svg_arrows import RIGHT, TOWARDS, UP
from robodyn.report.table import printable
from robodyn.robot_inertia.configuration import link_poses
from robodyn.spatial import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

    from robodyn.urdf.visuals import Visuals

_SIZE = 460
_CELLS, _FEWEST, _MOST = 230, 60, 30_000
"""Of triangles with corners in the same cells one is drawn. A cell is the robot's size over _CELLS, about two pixels,
or more where there would be too many triangles otherwise."""
_PLACES = np.array((1, 1 << 20, 1 << 40))
_CORNERS = np.array((1, 0x9E3779B97F4A7C15 - (1 << 64), 0x51ED270B7A3C9D4B))
"""Numbers that make one of three."""
_LIGHT = np.array([0.25, 0.55, 0.8])
_TINTS = ((0.62, 0.67, 0.74), (0.53, 0.59, 0.68))
_MARKED = (0.95, 0.60, 0.25)
_PAPER = np.stack((RIGHT, UP, TOWARDS))


def robot_figure(model: Model, q: Floats, joint: str, when: str, shapes: Visuals | None) -> Figure:
    """The robot at q, seen from (1, 1, 1) of its base's frame, with one joint and what it carries marked.

    Args:
        joint: the name of the one that is marked.
        when: which pose this is, in words.
        shapes: of its links; a skeleton is drawn where there are none.
    """
    poses = link_poses(model, q)
    origins = _joints(model, poses)
    triangles = _placed(model, poses, shapes) if shapes else []
    drawn = "" if triangles else " as a skeleton, because it has no visual shapes that can be read here"
    marked = next((k for k, body in enumerate(model.bodies) if body.joint.name == joint), None)

    def draw(canvas: Canvas) -> None:
        axes = canvas.add_axes((0.0, 0.0, 1.0, 1.0))
        axes.set_axis_off()
        axes.set_aspect("equal", adjustable="datalim")
        _solid(axes, triangles, marked) if triangles else _skeleton(axes, model, origins, marked)
        if marked is not None:
            _label(axes, origins[marked] @ _PAPER.T, printable(joint))
        axes.margins(0.06)
        _triad(canvas)

    caption = f"{printable(model.name)} at {when}{drawn}"
    alt = f"Picture of the robot{drawn}; {_state(model, q)}"
    return Figure(caption, alt, plot(_SIZE, _SIZE, draw, "picture"))


def shapes_of(model: Model) -> tuple[Visuals | None, str]:
    """The visual shapes of a robot's description, and what is said of those that are not there."""
    from robodyn.urdf.visuals import visuals

    if not os.path.isfile(model.file):
        return None, "The description did not come from a file, so the files of its meshes are not known."
    try:
        found = visuals(model.file)
    except Exception as error:
        first = str(error).partition("\n")[0][:200] or type(error).__name__
        return None, f"Its visual shapes cannot be read: {printable(first)}."
    if not found.missing:
        return found, ""
    some = ", ".join(map(printable, found.missing[:3])) + (" ..." if len(found.missing) > 3 else "")
    return found, (
        f"{len(found.missing)} mesh files are not found and not drawn: {some}. "
        "The variable ROS_PACKAGE_PATH says where packages are."
    )


def _joints(model: Model, poses: Mapping[str, tuple[Array, Array]]) -> list[Floats]:
    """The origin of each body in the base's frame."""
    return [np.asarray(poses[body.name][1], dtype=float) for body in model.bodies]


def _placed(model: Model, poses: Mapping[str, tuple[Array, Array]], shapes: Visuals) -> list[tuple[int, Floats]]:
    """(body, triangles in the axes of the paper), coarse enough for a picture."""
    solid = []
    for link, corners in shapes.triangles.items():
        if link in poses:
            R, p = (np.asarray(each, dtype=float) for each in poses[link])
            solid.append((model.links[link].body, (corners @ R.T + p) @ _PAPER.T))
    if not solid:
        return []
    everything = np.concatenate([each.reshape(-1, 3) for _, each in solid])
    size = float(np.ptp(everything[np.isfinite(everything).all(axis=1)], axis=0).max())
    if not size > 0.0:
        return []
    cells, coarse = float(_CELLS), solid
    while cells == _CELLS or (sum(len(each) for _, each in coarse) > _MOST and cells > _FEWEST):
        coarse = [(body, _coarse(each, size / cells)) for body, each in solid]
        cells *= 0.8
    return coarse


def _coarse(triangles: Floats, cell: float) -> Floats:
    """One of the triangles whose corners lie in the same three cells, none with two corners in one."""
    finite = triangles[np.isfinite(triangles).all(axis=(1, 2))]
    places = np.rint(finite / cell).astype(np.int64) @ _PLACES
    a, b, c = np.sort(places, axis=1).T
    real = (a != b) & (b != c)
    _, first = np.unique((np.stack((a, b, c), axis=1) @ _CORNERS)[real], return_index=True)
    found: Floats = finite[real][first]
    return found


def _solid(axes: Axes, solid: list[tuple[int, Floats]], marked: int | None) -> None:
    """Painter's algorithm: what is behind is drawn first."""
    from matplotlib.collections import PolyCollection

    triangles = np.concatenate([each for _, each in solid])
    tints = [_MARKED if body == marked else _TINTS[body % 2] for body, _ in solid]
    colours = np.repeat(np.array(tints), [len(each) for _, each in solid], axis=0)
    order = np.argsort(triangles[:, :, 2].sum(axis=1))
    triangles, colours = triangles[order], colours[order]
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), np.finfo(float).tiny)
    light = np.abs(normal @ (_LIGHT / np.linalg.norm(_LIGHT)))
    colours = np.clip(colours * (0.5 + 0.62 * light[:, None]), 0.0, 1.0)
    flat: Any = triangles[:, :, :2]
    faces = PolyCollection(flat, facecolors=colours, edgecolors=colours, linewidths=0.3, rasterized=True)
    axes.add_collection(faces)
    axes.autoscale_view()


def _skeleton(axes: Axes, model: Model, origins: list[Floats], marked: int | None) -> None:
    """Bars from joint to joint."""
    for k, parent in enumerate(model.parents):
        if parent >= 0:
            across, up, _ = (np.stack((origins[parent], origins[k])) @ _PAPER.T).T
            axes.plot(across, up, color=SOFT, linewidth=5, solid_capstyle="round")
    across, up, _ = (np.stack(origins) @ _PAPER.T).T
    axes.plot(across, up, linestyle="none", marker="o", markersize=7, color=INK)
    if marked is not None:
        axes.plot(across[marked], up[marked], marker="o", markersize=11, color=SERIES[1])


def _label(axes: Axes, at: Floats, name: str) -> None:
    """The name of a joint above the picture, with a line to it."""
    axes.annotate(
        name,
        xy=(at[0], at[1]),
        xytext=(0.03, 0.95),
        textcoords="axes fraction",
        color=INK,
        fontsize=12,
        fontweight="bold",
        arrowprops={"arrowstyle": "-", "color": INK, "linewidth": 1.0, "shrinkA": 2, "shrinkB": 0},
    )
    axes.plot(at[0], at[1], marker="o", markersize=6, color=INK)


def _triad(canvas: Canvas) -> None:
    """The axes of the base's frame, in a corner."""
    axes = canvas.add_axes((0.0, 0.0, 0.16, 0.16))
    axes.set_axis_off()
    axes.set_xlim(-1.5, 1.5)
    axes.set_ylim(-1.5, 1.5)
    for k, letter in enumerate("xyz"):
        across, up, _ = _PAPER[:, k]
        axes.plot((0, across), (0, up), color=SOFT, linewidth=1.5)
        axes.text(1.35 * across, 1.35 * up, letter, color=SOFT, ha="center", va="center", fontsize=11)


def _state(model: Model, q: Floats) -> str:
    """The coordinates in words."""
    return ", ".join(f"{printable(name)} {value:.4g}" for name, value in zip(model.coordinates, q, strict=True))
