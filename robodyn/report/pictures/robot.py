"""A robot in one pose as a picture, and where a mode takes it: its visual shapes, or its joints as a skeleton."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from io import BytesIO
from typing import TYPE_CHECKING, Any

import numpy as np

from robodyn.dynamics.loops.closure import moved
from robodyn.programs.vectors import Array, product, rotation_from_rpy
from robodyn.report.document import Figure
from robodyn.report.pictures.figures import INK, SERIES, SOFT, plot
from robodyn.report.pictures.solids import PAPER, Solid, on_paper, paint, triad
from robodyn.report.table import printable
from robodyn.robot.configuration import body_poses, link_poses
from robodyn.robot.model import Model
from robodyn.robot.urdf.parts import Description, Geometry
from robodyn.support.floats import Floats
from robodyn.support.libraries import library_messages

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas


_AROUND, _ALONG = 32, 12
"""Corners of a circle, and of a quarter and a half circle along the axis."""


@dataclass(frozen=True, eq=False)
class Visuals:
    """What a robot looks like.

    Attributes:
        triangles: (m, 3, 3) of each link that has some, in its frame [m].
        missing: names of meshes without a file, or that cannot be read.
    """

    triangles: dict[str, Floats]
    missing: tuple[str, ...]


def visuals(description: Description) -> Visuals:
    """Return the visual shapes of a robot; nothing is fetched from a network.

    yourdfpy and trimesh, which take half a second to be imported, are not needed where no mesh is named.

    Raises:
        Exception: whatever yourdfpy and trimesh raise on what they cannot read.
    """
    named = [(link.name, each) for link in description.links for each in link.geometries]
    shapes = [(link, each) for link, each in named if each.kind == "visual"]
    if all(each.filename is None for _, each in shapes):
        found: dict[str, list[Floats]] = {}
        for link, each in shapes:
            found.setdefault(link, []).append(primitive(each))
        return Visuals({link: np.concatenate(parts) for link, parts in found.items()}, ())
    return _of_meshes(description)


def _of_meshes(description: Description) -> Visuals:
    import yourdfpy

    missing = list[str]()

    def path_of(fname: str) -> str:
        path = description.search.find(fname)
        if path is None:
            missing.append(fname)
        return "" if path is None else str(path)

    with library_messages("yourdfpy", "trimesh"):
        scene: Any = yourdfpy.URDF.load(BytesIO(description.data), filename_handler=path_of).scene
        placed: dict[str, list[Floats]] = {}
        for node in scene.graph.nodes_geometry:
            matrix, name = scene.graph.get(node)
            geometry = scene.geometry[name]
            if getattr(geometry, "faces", None) is not None and len(geometry.faces):
                link = scene.graph.transforms.parents[node]
                local = product(np.linalg.inv(scene.graph.get(link)[0]), matrix)
                corners = product(np.asarray(geometry.vertices, dtype=np.float64), local[:3, :3].T) + local[:3, 3]
                placed.setdefault(link, []).append(corners[np.asarray(geometry.faces)])
    return Visuals({link: np.concatenate(parts) for link, parts in placed.items()}, tuple(dict.fromkeys(missing)))


def primitive(geometry: Geometry) -> Floats:
    """Return the surface of a shape that is no mesh, (m, 3, 3) in its link's frame [m]."""
    R, p = rotation_from_rpy(*geometry.origin.rpy), np.array(geometry.origin.xyz)
    own = _box(geometry.size) if geometry.shape == "box" else _turned(_profile(geometry.shape, geometry.size))
    found: Floats = product(own, R.T) + p
    return found


def _box(size: tuple[float, ...]) -> Floats:
    faces = []
    for k in range(3):
        for side in (-1.0, 1.0):
            u, v = side * np.eye(3)[(k + 1) % 3], np.eye(3)[(k + 2) % 3]
            a, b, c, d = (side * np.eye(3)[k] + s * u + t * v for s, t in ((-1, -1), (1, -1), (1, 1), (-1, 1)))
            faces += [(a, b, c), (a, c, d)]
    found: Floats = np.array(faces) * np.array(size) / 2
    return found


def _profile(shape: str, size: tuple[float, ...]) -> Floats:
    """Return (k, 2) radius and height of a surface of revolution about z, from its bottom to its top."""
    radius = size[0]
    if shape == "cylinder":
        half = size[1] / 2
        return np.array(((0.0, -half), (radius, -half), (radius, half), (0.0, half)))
    turn = np.linspace(0.0, np.pi / 2, _ALONG)
    cap = radius * np.column_stack((np.cos(turn), np.sin(turn)))
    up = np.array((0.0, size[1] / 2 if shape == "capsule" else 0.0))
    return np.concatenate((cap[::-1] * (1, -1) - up, cap + up))


def _turned(profile: Floats) -> Floats:
    """Return the surface that a profile sweeps."""
    turn = np.linspace(0.0, 2 * np.pi, _AROUND + 1)
    rings = np.stack([np.column_stack((r * np.cos(turn), r * np.sin(turn), np.full_like(turn, z))) for r, z in profile])
    a, b, c, d = rings[:-1, :-1], rings[:-1, 1:], rings[1:, 1:], rings[1:, :-1]
    quads = (np.stack((a, b, c), axis=2), np.stack((a, c, d), axis=2))
    return np.concatenate([each.reshape(-1, 3, 3) for each in quads])


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
    origins = [np.asarray(poses[body.name][1], dtype=float) for body in model.bodies]
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


_MODE_SIZE = 340
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
        _draw_bars(axes, rest, SOFT, 5.0, "-")
        _draw_bars(axes, ends[1], SERIES[0], 2.0, (0, (4, 2)))
        _draw_bars(axes, ends[0], SERIES[1], 3.0, "-")
        across, up, _ = product(np.stack([bar[0] for bar in rest]), PAPER.T).T
        axes.plot(across, up, linestyle="none", marker="o", markersize=5, color=INK)
        axes.margins(0.12)
        triad(canvas)

    alt = f"Skeleton at rest in grey, at one end of the motion as a line, at the other end dashed. {printable(caption)}"
    return Figure(printable(caption), alt, plot(_MODE_SIZE, _MODE_SIZE, draw, name))


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


def _draw_bars(axes: Axes, bars: list[Floats], colour: str, width: float, style: object) -> None:
    for bar in bars:
        across, up, _ = product(bar, PAPER.T).T
        axes.plot(across, up, color=colour, linewidth=width, linestyle=style, solid_capstyle="round")
