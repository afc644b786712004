"""Pictures seen from (1, 1, 1): a robot in one pose, a solid with its principal axes, a mode of a robot."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from robodyn.dynamics.loops.closure import moved
from robodyn.errors import MeshError
from robodyn.programs.vectors import Array, length, product, rotation_from_quaternion, rotation_from_rpy
from robodyn.report.document import Figure
from robodyn.report.pictures.figures import INK, SERIES, SOFT, plot
from robodyn.report.table import number, printable
from robodyn.robot.kinematics import body_poses, link_poses
from robodyn.robot.model import Model
from robodyn.robot.urdf.parts import Description
from robodyn.solids.inertia.properties import MassProperties
from robodyn.solids.mesh.read.load import load_triangles
from robodyn.support.floats import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

PAPER = np.array(((-1, 1, 0), (-1, -1, 2), (1, 1, 1))) / np.sqrt(((2,), (6,), (3,)))
"""Ground axes to right, up, and towards the reader."""
_DOTS = 720
"""Of a picture of solids along its longer side."""
_LIGHT = np.array((0.25, 0.55, 0.8))
_TINTS = ((0.62, 0.67, 0.74), (0.53, 0.59, 0.68))
_TURN, _SHIFT = 0.35, 0.15
"""rad, and parts of the robot's size: how far the joints go at most."""
Solid = tuple[int, Floats]
"""A number that gives the colour, and triangles (m, 3, 3)."""


def shapes_of(description: Description) -> tuple[dict[str, Floats], str]:
    """Return (m, 3, 3) of each link's visual shapes in its frame [m], and what is said of meshes that cannot be
    read."""
    from trimesh import creation

    found: dict[str, list[Floats]] = {}
    missing: dict[str, None] = {}
    every = [(link.name, shape) for link in description.links for shape in link.geometries if shape.kind == "visual"]
    for name, shape in every:
        if shape.filename is not None:
            path = description.search.find(shape.filename)
            try:
                triangles = None if path is None else load_triangles(path).array() * np.array(shape.scale)
            except MeshError:
                triangles = None
            if triangles is None:
                missing[printable(shape.filename)] = None
                continue
        elif shape.shape == "box":
            triangles = np.asarray(creation.box(shape.size).triangles)
        elif shape.shape == "sphere":
            triangles = np.asarray(creation.uv_sphere(shape.size[0]).triangles)
        else:
            make = creation.cylinder if shape.shape == "cylinder" else creation.capsule
            triangles = np.asarray(make(radius=shape.size[0], height=shape.size[1]).triangles)
        R, p = rotation_from_rpy(*shape.origin.rpy), np.array(shape.origin.xyz)
        found.setdefault(name, []).append(product(triangles, R.T) + p)
    names = list(missing)
    some = ", ".join(names[:3]) + (" ..." if len(names) > 3 else "")
    words = (
        f"{len(names)} mesh files are not found or cannot be read, and not drawn: {some}. --package-path says where "
    )
    return {link: np.concatenate(parts) for link, parts in found.items()}, f"{words}packages are." if names else ""


def robot_figure(model: Model, q: Floats, joint: str, when: str, shapes: dict[str, Floats], name: str) -> Figure:
    """Return the robot at q in its base's frame: a skeleton, shapes of links, one joint and what it carries marked;
    `when` says in words which pose this is, and `name` is that of no other picture of the page."""
    poses = link_poses(model, q)
    solids = [
        (model.links[link].body, product(each, np.asarray(poses[link].R, float).T) + np.asarray(poses[link].p, float))
        for link, each in shapes.items()
        if link in poses
    ]
    marked = next((k for k, body in enumerate(model.bodies) if joint and body.joint.name == joint), None)

    def draw(axes: Axes) -> None:
        _draw_bars(axes, _bars(model, np.array((*[0.0] * 6, 1.0, *q[7:])) if model.floating else q), SOFT, 5.0, "-")
        draw_solids(axes, solids, marked)
        if marked is not None:
            place = product(PAPER, np.asarray(poses[model.bodies[marked].name].p, float))[:2]
            look: dict[str, Any] = {
                "color": INK,
                "fontsize": 12,
                "fontweight": "bold",
                "arrowprops": {"arrowstyle": "-", "color": INK},
            }
            axes.annotate(printable(joint), xy=place, xytext=(0.03, 0.95), textcoords="axes fraction", **look)
            axes.plot(*place, marker="o", markersize=6, color=INK)

    drawn = "" if solids else " as a skeleton, because it has no visual shapes that can be read here"
    state = ", ".join(f"{printable(name)} {value:.4g}" for name, value in zip(model.coordinates, q, strict=True))
    caption = f"{printable(model.name)} at {when}{drawn}"
    return Figure(caption, f"Picture of the robot{drawn}; {state}", _picture(draw, name))


def body_figure(name: str, body: MassProperties, triangles: Floats, key: str) -> Figure:
    """Return a solid with its mass centre and its principal axes."""
    reach = float(np.ptp(triangles.reshape(-1, 3), axis=0).max())

    def draw(axes: Axes) -> None:
        draw_solids(axes, [(0, triangles)])
        centre = product(PAPER, body.com)
        for k, axis in enumerate(body.principal.axes):
            arm = 0.3 * reach * product(PAPER, axis)
            ends = np.stack((centre - arm, centre + arm)).T
            axes.plot(*ends[:2], color=SERIES[(1, 2, 5)[k]], linewidth=2, label=f"axis {k + 1}")
        axes.plot(centre[0], centre[1], marker="o", markersize=7, linestyle="none", color=INK, label="centre of mass")
        axes.legend(loc="upper left", ncols=4, columnspacing=1.0)

    moments = ", ".join(number(moment) for moment in body.principal.moments)
    alt = f"Picture of {name} with its centre of mass and its principal axes; principal moments {moments} kg m^2"
    return Figure(f"{name}: centre of mass and principal axes", alt, _picture(draw, key))


def mode_figure(model: Model, q: Floats, shape: Sequence[complex], caption: str, name: str) -> Figure:
    """Return the robot at q as a skeleton, from joint to joint and on to mass centres, and where it is half a period
    of the mode apart, at the phase of the first joint that moves as much as any; shape: (n,)."""
    rest, way = _bars(model, q), np.array(shape)
    most, size = np.full(model.n, _TURN), float(np.ptp(np.concatenate(rest), axis=0).max()) or 1.0
    for joint in model.independent:
        if joint.kind == "prismatic":
            most[joint.rate] = _SHIFT * size
        elif joint.kind == "floating":
            most[joint.rate + 3 : joint.rate + 6] = _SHIFT * size
    far = np.abs(way) / most
    first = way[int(np.argmax(far >= far.max() * (1.0 - 1e-6)))]
    step = (way * np.conj(first)).real / ((abs(first) or 1.0) * (far.max() or 1.0))
    one, other = (_bars(model, np.array(moved(model, q.tolist(), (sign * step).tolist()))) for sign in (1.0, -1.0))

    def draw(axes: Axes) -> None:
        _draw_bars(axes, rest, SOFT, 5.0, "-")
        _draw_bars(axes, other, SERIES[0], 2.0, "--")
        _draw_bars(axes, one, SERIES[1], 3.0, "-")

    alt = f"Skeleton at rest in grey, at one end of the motion as a line, at the other end dashed. {printable(caption)}"
    return Figure(printable(caption), alt, _picture(draw, name, 340))


def _picture(draw: Callable[[Axes], None], name: str, size: int = 460) -> str:
    def whole(canvas: Canvas) -> None:
        axes, corner = canvas.add_axes((0.0, 0.0, 1.0, 1.0)), canvas.add_axes((0.0, 0.0, 0.16, 0.16))
        axes.set_aspect("equal", adjustable="datalim")
        draw(axes)
        axes.margins(0.08)
        for k, letter in enumerate("xyz"):
            across, up, _ = PAPER[:, k]
            corner.plot((0, across), (0, up), color=SOFT, linewidth=1.5)
            corner.text(1.35 * across, 1.35 * up, letter, color=SOFT, ha="center", va="center", fontsize=11)
        corner.set(xlim=(-1.5, 1.5), ylim=(-1.5, 1.5))
        for each in (axes, corner):
            each.set_axis_off()

    return plot(size, size, whole, name)


def draw_solids(axes: Axes, solids: Sequence[Solid], marked: int | None = None) -> None:
    """Draw solids, those with the marked number in a colour of their own: triangles as points, dense enough to cover
    every dot, of which the one nearest to the reader is seen."""
    triangles = product(np.concatenate([np.zeros((0, 3, 3)), *(each for _, each in solids)]), PAPER.T)
    if not len(triangles) or not np.ptp(triangles, axis=(0, 1)).any():
        return
    tints = np.array([(0.95, 0.60, 0.25) if number == marked else _TINTS[number % 2] for number, _ in solids])
    a, b, c = triangles.transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    sizes = np.linalg.norm(normal, axis=1).clip(np.finfo(float).tiny)
    light = np.abs(product(normal, _LIGHT)) / (sizes * length(_LIGHT))
    colours = np.repeat(tints, [len(each) for _, each in solids], axis=0) * (0.5 + 0.62 * light[:, None])
    low, high = triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))
    dot = float((high - low)[:2].max()) / _DOTS
    seen = nearest((triangles - low) / dot, *(int(n) + 1 for n in (high - low)[:2] / dot))
    picture = np.concatenate((colours.clip(0.0, 1.0)[seen], (seen >= 0)[:, :, None]), axis=2)
    ends = low + dot * np.array((*seen.shape[::-1], 0.0))
    axes.imshow(picture, origin="lower", extent=(low[0], ends[0], low[1], ends[1]), interpolation="none")
    axes.use_sticky_edges = False


def nearest(triangles: Floats, across: int, up: int) -> Array:
    """Return (up, across) which triangle is seen at each dot, -1 where there is none: points of each by the additive
    recurrence of the plastic number, which spreads them evenly, and a buffer of depths (Catmull 1974).

    Args:
        triangles: (m, 3, 3) to the right, up and towards the reader; a unit is a dot.
    """
    a, b, c = triangles.transpose(1, 0, 2)
    area = np.abs(np.cross(b - a, c - a)[:, 2]) / 2
    around = sum(np.abs(end - start).sum(axis=1) for start, end in ((a, b), (b, c), (c, a)))
    per_dot = 6.0
    many = np.ceil(per_dot * (area + around / 2)).astype(np.int64) + 1
    depth, seen = np.full(up * across, -np.inf), np.full(up * across, -1)
    for part in np.split(np.arange(len(a)), np.flatnonzero(np.diff(np.cumsum(many) // 2_000_000)) + 1):
        of = np.repeat(part, many[part])
        k = np.arange(len(of))[:, None] * np.array((0.7548776662466927, 0.5698402909980532)) % 1.0
        u, v = np.where(k.sum(axis=1, keepdims=True) > 1.0, 1.0 - k, k).T[:, :, None]
        x, y, z = (a[of] + u * (b - a)[of] + v * (c - a)[of]).T
        at = x.astype(np.int64).clip(0, across - 1) + across * y.astype(np.int64).clip(0, up - 1)
        np.maximum.at(depth, at, z)
        front = z >= depth[at]
        seen[at[front]] = of[front]
    return seen.reshape(up, across)


def _bars(model: Model, q: Floats) -> list[Floats]:
    """Return (2, 3) each: from every body's origin to those that it carries, else to its mass centre, on the ground."""
    places = [(np.asarray(R, float), np.asarray(p, float)) for R, p in body_poses(model, q)]
    if model.floating:
        R, p = np.asarray(rotation_from_quaternion(*q[3:7]), float), q[:3]
        places = [(product(R, each), p + product(R, at)) for each, at in places]
    bars = [np.stack((places[parent][1], places[k][1])) for k, parent in enumerate(model.parents) if parent >= 0]
    for k in set(range(len(places))) - {parent for parent in model.parents if parent >= 0}:
        R, p = places[k]
        bars.append(np.stack((p, p + product(R, model.bodies[k].inertia.centre_of_mass))))
    return bars


def _draw_bars(axes: Axes, bars: list[Floats], colour: str, width: float, style: str) -> None:
    for bar in bars:
        across, up, _ = product(bar, PAPER.T).T
        axes.plot(across, up, style, color=colour, linewidth=width, solid_capstyle="round", marker="o", zorder=-1)
