"""A robot in one pose as a picture: its visual shapes, or its joints as a skeleton."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from robodyn.programs.vectors import Array, product
from robodyn.report.document import Figure
from robodyn.report.pictures.figures import INK, SERIES, SOFT, plot
from robodyn.report.pictures.solids import PAPER, Solid, on_paper, paint, triad
from robodyn.report.table import printable
from robodyn.robot.configuration import link_poses
from robodyn.robot.model import Model
from robodyn.support.floats import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

    from robodyn.report.pictures.visuals import Visuals

_SIZE = 460


def robot_figure(
    model: Model, q: Floats, joint: str, when: str, shapes: Visuals | None, name: str = "picture"
) -> Figure:
    """Return the robot at q, seen from (1, 1, 1) of its base's frame, with one joint and what it carries marked.

    Args:
        joint: the name of the one that is marked; empty for none.
        when: which pose this is, in words.
        shapes: of its links; a skeleton is drawn where there are none.
        name: no other picture of the page has.
    """
    poses = link_poses(model, q)
    origins = _joints(model, poses)
    solids = on_paper(_placed(model, poses, shapes)) if shapes else []
    bare = shapes is not None and bool(shapes.missing)
    drawn = " with its skeleton, because some meshes are not found" if bare else ""
    if not solids:
        drawn = " as a skeleton, because it has no visual shapes that can be read here"
    marked = next((k for k, body in enumerate(model.bodies) if joint and body.joint.name == joint), None)

    def draw(canvas: Canvas) -> None:
        axes = canvas.add_axes((0.0, 0.0, 1.0, 1.0))
        axes.set_axis_off()
        axes.set_aspect("equal", adjustable="datalim")
        if solids:
            paint(axes, solids, marked)
        if bare or not solids:
            _skeleton(axes, model, origins, marked)
        if marked is not None:
            _label(axes, product(origins[marked], PAPER.T), printable(joint))
        axes.margins(0.06)
        triad(canvas)

    caption = f"{printable(model.name)} at {when}{drawn}"
    alt = f"Picture of the robot{drawn}; {_state(model, q)}"
    return Figure(caption, alt, plot(_SIZE, _SIZE, draw, name))


def shapes_of(model: Model) -> tuple[Visuals | None, str]:
    """Return the visual shapes of a robot's description, and what is said of those that are not there."""
    from robodyn.report.pictures.visuals import visuals

    assert model.description is not None, "it is not a model of bodies alone"
    try:
        found = visuals(model.description)
    except Exception as error:
        first = str(error).partition("\n")[0][:200] or type(error).__name__
        return None, f"Its visual shapes cannot be read: {printable(first)}."
    if not found.missing:
        return found, ""
    some = ", ".join(map(printable, found.missing[:3])) + (" ..." if len(found.missing) > 3 else "")
    return found, (
        f"{len(found.missing)} mesh files are not found and not drawn: {some}. --package-path says where packages are."
    )


def _joints(model: Model, poses: Mapping[str, tuple[Array, Array]]) -> list[Floats]:
    """Return the origin of each body in the base's frame."""
    return [np.asarray(poses[body.name][1], dtype=float) for body in model.bodies]


def _placed(model: Model, poses: Mapping[str, tuple[Array, Array]], shapes: Visuals) -> list[Solid]:
    """Return each link's triangles in the base's frame, by body."""
    found = []
    for link, corners in shapes.triangles.items():
        if link in poses:
            R, p = (np.asarray(each, dtype=float) for each in poses[link])
            found.append((model.links[link].body, product(corners, R.T) + p))
    return found


def _skeleton(axes: Axes, model: Model, origins: list[Floats], marked: int | None) -> None:
    """Draw bars from joint to joint."""
    for k, parent in enumerate(model.parents):
        if parent >= 0:
            across, up, _ = product(np.stack((origins[parent], origins[k])), PAPER.T).T
            axes.plot(across, up, color=SOFT, linewidth=5, solid_capstyle="round")
    across, up, _ = product(np.stack(origins), PAPER.T).T
    axes.plot(across, up, linestyle="none", marker="o", markersize=7, color=INK)
    if marked is not None:
        axes.plot(across[marked], up[marked], marker="o", markersize=11, color=SERIES[1])


def _label(axes: Axes, at: Floats, name: str) -> None:
    """Draw the name of a joint above the picture, with a line to it."""
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


def _state(model: Model, q: Floats) -> str:
    """Return the coordinates in words."""
    return ", ".join(f"{printable(name)} {value:.4g}" for name, value in zip(model.coordinates, q, strict=True))
