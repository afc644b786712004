"""Robots in 3-D, which the page's viewer moves: bodies with meshes, motions, and arrows of what acts on them."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache
from math import pi
from typing import TYPE_CHECKING, Any

import numpy as np

from robodyn.errors import MeshError
from robodyn.programs.vectors import product, rotation_from_rpy
from robodyn.report.document import Stage
from robodyn.report.table import printable
from robodyn.robot.model import Body, Model
from robodyn.scene.scene import Contact, ExternalWrench, Scene
from robodyn.solids.mesh.read.load import load_triangles
from robodyn.support.floats import Floats
from robodyn.trajectory.columns.signals import COMPONENTS

if TYPE_CHECKING:
    from robodyn.robot.urdf.parts import Description
    from robodyn.solids.inertia.properties import MassProperties

TRIANGLES = 80_000
"""Of all meshes of a page at most: corners closer than a cell of a grid become one, cells as fine as that allows."""
_FINEST = 4000
"""Cells along the longest side of what is drawn, at most."""
KINDS = {
    "torque": {"what": "joint torques and forces", "colour": "c6", "on": True},
    "reaction": {"what": "joint wrenches", "colour": "c1", "on": False},
    "weight": {"what": "weights", "colour": "c3", "on": False},
    "external": {"what": "external wrenches", "colour": "c8", "on": True},
    "contact": {"what": "contact forces and their cones", "colour": "c2", "on": True},
    "loop": {"what": "forces of loops", "colour": "c5", "on": False},
    "base": {"what": "wrench of the base", "colour": "c4", "on": False},
}
_STILL: dict[str, Any] = {
    "name": "",
    "time": None,
    "rows": None,
    "q": [],
    "rest": [],
    "use": [],
    "sliders": [],
    "arrows": [],
}
Entry = Floats | list[float]
"""Values over the rows of a motion, or one that stays, in a list."""


def stage(
    caption: str,
    robots: Sequence[dict[str, Any]],
    marks: Sequence[dict[str, Any]] = (),
    alt: str = "",
    **shown: bool,
) -> Stage:
    """Return a view of robots, each of `robot` or `solid`; skeletons, too, where shapes are missing, which is said.

    Args:
        marks: each of `mark`; alt: what is to be seen, in words.
        shown: ellipsoids, through: shown from the start; loop: a motion is played again and again, in 5 s each.
    """
    shapes = [(robot["bodies"][k], part) for robot in robots for k, part in robot.pop("shapes").items()]
    missing = [why for why in dict.fromkeys(robot.pop("missing") for robot in robots) if why]
    meshes, error = _meshes(shapes)
    drawn = [f"Meshes are drawn to within {1000.0 * error:.2g} mm."] if meshes else []
    use = "Drag to turn, shift and drag to move, click and wheel or pinch to zoom; click a link for its numbers."
    names = ", ".join(printable(robot["name"]) for robot in robots)
    look = {"robots": [*robots], "meshes": meshes, "kinds": KINDS, "marks": [*marks], "bars": bool(missing)}
    return Stage(caption, f"In 3-D: {names}{alt and f'; {alt}'}", " ".join([*drawn, use, *missing]), look | shown)


def robot(
    model: Model,
    motions: Sequence[dict[str, Any]],
    *,
    name: str = "",
    colour: str | None = None,
    alpha: float = 1.0,
    lit: Mapping[str, str] | Iterable[str] = (),
    words: Mapping[str, str] | None = None,
) -> dict[str, Any]:
    """Return a robot of a stage with its `motion`s.

    Args:
        colour, alpha: of all bodies, in place of that of their use of limits; lit: bodies by name, each in a
            colour of its own, or in that of what is bad.
        words: what is said of bodies when they are picked.
    """
    bodies, colours = (
        [_body(body) for body in model.bodies],
        lit if isinstance(lit, Mapping) else dict.fromkeys(lit, "bad"),
    )
    for body in bodies:
        body |= {"lit": colours.get(body["name"], ""), "words": (words or {}).get(body["name"], "")}
    shapes, missing = shapes_of_bodies(model)
    found = {"name": name or model.name, "bodies": bodies, "motions": [*motions], "colour": colour, "alpha": alpha}
    return found | {"shapes": shapes, "missing": missing}


def _body(body: Body) -> dict[str, Any]:
    joint, inertia = body.joint, body.inertia
    found = {"name": body.name, "parent": body.parent, "joint": joint.name, "kind": joint.kind}
    found |= {"R": joint.R.ravel().tolist(), "p": joint.p.tolist(), "axis": joint.axis.tolist(), "q": joint.coordinate}
    found |= {"ratio": joint.multiplier, "offset": joint.offset, "meshes": []}
    return found | _spread(float(inertia.m), inertia.centre_of_mass, inertia.about_centre)


def _spread(mass: float, centre: Any, about_centre: Any) -> dict[str, Any]:
    """Return mass, centre and the even ellipsoid of that inertia, if any: axes (row by row, a rotation), half-axes."""
    found: dict[str, Any] = {"mass": mass, "centre": [float(x) for x in centre], "ellipsoid": None}
    if mass > 0.0:
        moments, axes = np.linalg.eigh(np.asarray(about_centre, dtype=float))
        squares = 2.5 * (moments.sum() - 2.0 * moments) / mass
        if np.isfinite(squares).all() and squares.max() > 0.0:
            found["ellipsoid"] = [axes.ravel().tolist(), np.sqrt(squares.clip(0.0)).tolist()]
    return found


def solid(name: str, body: MassProperties, triangles: Floats, place: Any, **look: Any) -> dict[str, Any]:
    """Return a body that stands at a place, a rotation and an origin, as a robot; `look` as that of `robot`."""
    R, p = place
    fixed = {"name": name, "parent": -1, "joint": "", "kind": "fixed", "lit": "", "words": look.pop("words", "")}
    fixed |= {"R": np.asarray(R, dtype=float).ravel().tolist(), "p": [float(x) for x in p], "meshes": []}
    bodies = [fixed | _spread(body.mass, body.com, body.inertia)]
    found = {"name": name, "bodies": bodies, "motions": [_STILL], "colour": None, "alpha": 1.0}
    return found | {"shapes": {0: triangles}, "missing": ""} | look


def mark(
    what: str, colour: str, pieces: Iterable[tuple[Any, Any, float]], alpha: float = 1.0, on: bool = True
) -> dict[str, Any]:
    """Return a thing that is drawn on demand: cylinders from a point along a vector, with a radius, in the axes of the
    ground [m]: thin ones are lines, flat ones discs."""
    listed = [([*map(float, at)], [*map(float, vector)], float(wide)) for at, vector, wide in pieces]
    return {"what": what, "colour": colour, "pieces": listed, "alpha": alpha, "on": on}


def motion(
    name: str,
    time: Floats,
    q: Sequence[Entry],
    *,
    rows: Floats | None = None,
    use: Sequence[tuple[Floats, float] | None] = (),
    arrows: Iterable[dict[str, Any]] = (),
) -> dict[str, Any]:
    """Return a motion: time (F,) [s], each coordinate over it; rows: their numbers in the table, from 1.

    Args:
        use: of each body what its joint's limit is compared with, and the limit.
    """
    uses = [None if each is None else {"values": each[0], "limit": each[1]} for each in use]
    return {"name": name, "time": time, "rows": rows, "q": [*q], "use": uses, "arrows": [*arrows]}


def pose(model: Model, q: Sequence[float], arrows: Iterable[dict[str, Any]] = ()) -> dict[str, Any]:
    """Return the motion of a robot that stands at q, and is moved by sliders."""
    sliders = []
    for joint in model.independent:
        if joint.kind in ("revolute", "prismatic"):
            turns, far = joint.kind == "revolute", pi if joint.kind == "revolute" else model.reach or 1.0
            low, high = (-far if joint.lower is None else joint.lower), (far if joint.upper is None else joint.upper)
            each = {"name": printable(joint.name), "q": joint.coordinate, "unit": "rad" if turns else "m"}
            value = float(q[joint.coordinate])  # which may be beyond a limit
            sliders.append(each | {"lower": min(low, value), "upper": max(high, value), "value": value})
    still = {"name": "", "time": None, "rows": None, "q": [], "rest": [float(x) for x in q], "use": []}
    return still | {"sliders": sliders, "arrows": [*arrows]}


def bodies_of(model: Model) -> dict[tuple[str, str], int]:
    """Return the number of the body that a ("link", name) is part of, or a ("joint", name) carries."""
    found = {("link", link): frame.body for link, frame in model.links.items()}
    found |= {("joint", body.joint.name): k for k, body in enumerate(model.bodies)}
    joints = () if model.description is None else model.description.joints
    return found | {("joint", one.name): model.links[one.child].body for one in joints if one.child in model.links}


def weights(model: Model, scene: Scene) -> list[dict[str, Any]]:
    """Return the weight of every body and payload, at its mass centre in the axes of the ground."""
    found = []
    for k, body in enumerate(model.bodies):
        if body.inertia.m > 0.0:
            weight: list[Entry] = [[float(body.inertia.m) * g] for g in scene.gravity]
            found.append(_arrow("weight", "weight", k, None, body.inertia.centre_of_mass, weight))
    for payload in scene.payloads:
        on, R, p = model.links[payload.link]
        point, weight = product(R, np.array(payload.com)) + p, [[payload.mass * g] for g in scene.gravity]
        found.append(_arrow("weight", "weight of the payload", on, None, point, weight))
    return found


def joint_torques(model: Model, columns: Mapping[str, Floats], kind: str = "tau") -> list[dict[str, Any]]:
    """Return the torque or force of every joint of which there is a column KIND_JOINT."""
    found = []
    for k, joint in ((k, body.joint) for k, body in enumerate(model.bodies)):
        tau, turns = columns.get(f"{kind}_{joint.name}"), joint.kind == "revolute"
        if tau is not None and joint.mimics is None and (turns or joint.kind == "prismatic"):
            values = [tau if a == 1.0 else [0.0] if a == 0.0 else a * tau for a in joint.axis.tolist()]
            what = "joint torque" if turns else "joint force"
            found.append(_arrow("torque", what, k, k, (0.0, 0.0, 0.0), values, turns))
    return found


def loads(model: Model, tree: Scene, columns: Mapping[str, Floats], contacts: Sequence[Contact] = ()) -> list[Any]:
    """Return arrows of what acts along a motion: joint torques and wrenches, of the base, and external wrenches.

    Args:
        tree: the scene in which constraints are wrenches; columns: those of `output_names` with reactions, and its own;
            what is not among them is left out.
        contacts: of the scene itself, for their cones.
    """
    found = [*weights(model, tree), *joint_torques(model, columns)]
    for k, body in enumerate(model.bodies):
        joint = printable(body.joint.name)
        names = [f"base_{part}" if k == 0 else f"{part}_{body.joint.name}" for part in COMPONENTS]
        for first, moment in ((0, False), (3, True)) if names[0] in columns else ():
            values = [columns[name] for name in names[first : first + 3]]
            kind, what = ("base", "by the ground") if k == 0 else ("reaction", f"by joint {joint}")
            found.append(_arrow(kind, what, k, k, (0.0, 0.0, 0.0), values, moment))
    cones = {contact.link: contact for contact in contacts}
    for wrench in tree.wrenches:
        if any(isinstance(each, str) and each not in columns for each in (*wrench.force, *wrench.moment)):
            continue
        found += _external(model, tree, wrench, columns, cones.get(wrench.link) if wrench.cause == "contact" else None)
    return [arrow for arrow in found if any(np.any(part) for part in arrow["values"])]


def _external(
    model: Model, tree: Scene, wrench: ExternalWrench, columns: Mapping[str, Floats], contact: Contact | None
) -> Iterable[dict[str, Any]]:
    from robodyn.dynamics.constraints.constraint_jacobian import normal_of

    place = model.links[wrench.link]
    point = product(place.R, np.array(wrench.point)) + place.p
    axes = model.links[wrench.axes or (wrench.link if wrench.frame == "link" else next(iter(model.links)))]
    ground = not wrench.axes and wrench.frame == "world"
    kind = {"loop": "loop", "contact": "contact"}.get(wrench.cause, "external")
    what = {"loop": "by a loop", "contact": "by a contact"}.get(wrench.cause, "external")
    for entries, moment in ((wrench.force, False), (wrench.moment, True)):
        own: list[Entry] = [columns[each] if isinstance(each, str) else [float(each)] for each in entries]
        if not ground and not np.array_equal(axes.R, np.eye(3)):
            parts = [np.asarray(each) for each in own]
            own = [sum(r * part for r, part in zip(row, parts, strict=True)) for row in axes.R]
            own = [each if len(each) > 1 else each.tolist() for each in own]  # type: ignore[union-attr]
        cone = None if contact is None or moment else [contact.friction, *normal_of(contact, tree).tolist()]
        yield _arrow(kind, what, place.body, None if ground else axes.body, point, own, moment, cone)


def _arrow(
    kind: str,
    what: str,
    body: int,
    axes: int | None,
    point: Any,
    values: Sequence[Entry],
    moment: bool = False,
    cone: list[float] | None = None,
) -> dict[str, Any]:
    found = {"kind": kind, "what": what, "body": body, "axes": axes, "point": [float(x) for x in point]}
    return found | {"values": [*values], "moment": moment, "cone": cone}


def shapes_of(description: Description, kind: str = "visual") -> tuple[dict[str, Floats], str]:
    """Return (m, 3, 3) of each link's shapes in its frame [m], and what is said of meshes that cannot be read."""
    found: dict[str, list[Floats]] = {}
    missing: dict[str, None] = {}
    every = [(link.name, shape) for link in description.links for shape in link.geometries if shape.kind == kind]
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
        else:
            triangles = _primitive(shape.shape, shape.size)
        R, p = rotation_from_rpy(*shape.origin.rpy), np.array(shape.origin.xyz)
        found.setdefault(name, []).append(product(triangles, R.T) + p)
    names = list(missing)
    some = ", ".join(names[:3]) + (" ..." if len(names) > 3 else "")
    words = (
        f"{len(names)} mesh files are not found or cannot be read, and not drawn: {some}. --package-path says where "
    )
    return {link: np.concatenate(parts) for link, parts in found.items()}, f"{words}packages are." if names else ""


def _primitive(kind: str, size: Sequence[float]) -> Floats:
    """Return (m, 3, 3) of a box, or of a sphere, cylinder or capsule about z: surfaces of revolution of 32 sides."""
    if kind == "box":
        outline, around = np.array(((0.0, -0.5), (0.5**0.5, -0.5), (0.5**0.5, 0.5), (0.0, 0.5))), 4
        scale, turn = np.array(size), pi / 4
    else:
        radius, half = size[0], (0.0 if kind == "sphere" else size[1] / 2)
        bend = np.linspace(-pi / 2, pi / 2, 18) if kind != "cylinder" else np.array((-pi / 2, 0.0, 0.0, pi / 2))
        r, z = radius * np.cos(bend), (0.0 if kind == "cylinder" else radius * np.sin(bend))
        outline = np.stack((r, z + half * np.where(np.arange(len(bend)) < len(bend) // 2, -1.0, 1.0)), axis=1)
        scale, around, turn = np.ones(3), 32, 0.0
    angles = turn + 2.0 * pi * np.arange(around + 1) / around
    rings = np.stack([np.stack((r * np.cos(angles), r * np.sin(angles), 0.0 * angles + z), axis=1) for r, z in outline])
    a, b, c, d = rings[:-1, :-1], rings[:-1, 1:], rings[1:, :-1], rings[1:, 1:]
    return np.asarray(scale * np.stack((np.stack((a, b, d), axis=2), np.stack((a, d, c), axis=2))).reshape(-1, 3, 3))


@lru_cache(maxsize=1)
def shapes_of_bodies(model: Model) -> tuple[dict[int, Floats], str]:
    """Return by body its visual shapes in its frame, else its collision shapes, and what is missing."""
    if model.description is None:
        return {}, ""
    shapes, why = shapes_of(model.description)
    if not shapes:
        shapes, others = shapes_of(model.description, "collision")
        why = why or others
    found: dict[int, list[Floats]] = {}
    for link, triangles in shapes.items():
        if link in model.links:
            body, R, p = model.links[link]
            found.setdefault(body, []).append(product(triangles, np.asarray(R, float).T) + p)
    if not found:
        why = f"{why} It is drawn as a skeleton.".strip()
    return {body: np.concatenate(parts) for body, parts in found.items()}, why


def _meshes(shapes: Sequence[tuple[dict[str, Any], Floats]]) -> tuple[list[dict[str, Any]], float]:
    """Return meshes with corners on a grid, whose numbers the bodies get, and how far a corner moves at most [m].

    Vertex clustering (Rossignac and Borrel 1993): corners of one cell become their mean, and triangles with two corners
    in one cell go.
    """
    alike: dict[int, tuple[list[dict[str, Any]], Floats]] = {}  # bodies of robots that stand beside each other
    for body, triangles in shapes:
        if len(triangles):
            alike.setdefault(id(triangles), ([], triangles.reshape(-1, 3)))[0].append(body)
    parts = [*alike.values()]
    many = sum(len(corners) for _, corners in parts) // 3
    cell = max((float(np.ptp(corners, axis=0).max()) for _, corners in parts), default=1.0)
    cell = cell / (_FINEST if many <= 2 * TRIANGLES else 400) or 1e-3
    found = [(np.arange(len(corners)), corners, np.arange(len(corners)).reshape(-1, 3)) for _, corners in parts]
    while True:
        found = [_clustered(*each, cell) for each in found]
        many = sum(len(faces) for *_, faces in found)
        if many <= TRIANGLES:
            break
        cell *= max(1.15, min((many / TRIANGLES) ** 0.5, 8.0))
    meshes: list[dict[str, Any]] = []
    error = 0.0
    for (bodies, corners), (numbers, means, faces) in zip(parts, found, strict=True):
        low = means.min(axis=0)
        step = float((means - low).max()) / 0xFFFF or 1e-9
        grid = np.rint((means - low) / step)
        error = max(error, float(np.linalg.norm(low + step * grid[numbers] - corners, axis=1).max()))
        for body in bodies:
            body["meshes"].append(len(meshes))
        kind = np.uint16 if len(grid) <= 0x10000 else np.uint32
        texts = (base64.b64encode(each.tobytes()).decode() for each in (grid.astype(np.uint16), faces.astype(kind)))
        meshes.append(dict(zip(("low", "step", "corners", "indices"), (low.tolist(), step, *texts), strict=True)))
    return meshes, error


def _clustered(numbers: Any, points: Floats, faces: Any, cell: float) -> tuple[Any, Floats, Any]:
    """Return of each corner, whose points had these numbers, that of its cell; the cells' means of points; and faces
    of three cells."""
    places = np.floor((points - points.min(axis=0)) / cell).astype(np.int64)
    keys, cells = np.unique((places[:, 0] << 32) | (places[:, 1] << 16) | places[:, 2], return_inverse=True)
    counts = np.bincount(cells, minlength=len(keys))
    means = np.stack([np.bincount(cells, part, len(keys)) / counts for part in points.T], axis=1)
    a, b, c = cells[faces].T
    return cells[numbers], means, cells[faces][(a != b) & (b != c) & (c != a)]
