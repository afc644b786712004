"""What a description says of the parameters before a log is read, made into bodies that can exist."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from robodyn.dynamics.regressor import INERTIAL
from robodyn.errors import MeshError
from robodyn.programs.linear import eigen
from robodyn.programs.vectors import length, product
from robodyn.robot.load import placement
from robodyn.robot.masses.shapes import mesh_file
from robodyn.robot.model import Model
from robodyn.robot.urdf.description import Shape, link_shapes, missing_mesh
from robodyn.robot.urdf.parts import Description
from robodyn.solids.inertia.laws import Inertia, inertia_matrix, parallel_axis, second_moments, symmetric
from robodyn.solids.inertia.validity import Box, around, half_size
from robodyn.solids.mesh.read.load import load_triangles
from robodyn.solids.mesh.triangles import scaled
from robodyn.support.floats import Floats
from robodyn.support.wording import listed, shown

_FLAT, _THICKNESS = 1e-6, 1e-2
"""Of the largest second moment: one below is not told from an impossible body's, and what takes its place."""
_POINT, _GYRATION = 1e-4, 0.1
"""Of a body's size: the radius of gyration below which it is described as a point, and what takes its place."""
_SHARE = 1e-3
"""Mass of a body that is described without, in parts of the robot's."""


@dataclass(frozen=True, eq=False)
class PriorBody:
    """A body's `columns` among the parameters, and the matrix Q (4, 4) of its bounding ellipsoid, if it has one."""

    name: str
    columns: slice
    ellipsoid: Floats | None = None


@dataclass(frozen=True, eq=False)
class Prior:
    """Where parameters are drawn to.

    Attributes:
        described: (p,) values of the description; theta: with bodies that cannot exist replaced by near ones that can.
        bodies: whose parameters are open. Of the three that a planar joint is made of it is the last.
        notes: what was replaced, a line each.
    """

    names: tuple[str, ...]
    described: Floats
    theta: Floats
    bodies: tuple[PriorBody, ...]
    notes: tuple[str, ...]


def prior_of(model: Model, names: Sequence[str], theta: Floats, *, shapes: bool = True) -> Prior:
    """Return the prior of a description's parameters.

    The base and mere frames (bodies without mass, inertia and shapes, if others have some) stay as they are. Another
    body without positive mass gets a thousandth of the robot's mass; second moments about the centre of mass that are
    not positive become a hundredth of the largest; a point gets a tenth of the body's size as radius of gyration.

    Args:
        names, theta: of `robodyn.regressor`.
        shapes: whether ellipsoids around the boxes of shapes bound the bodies. They do not bound a body that is already
            described as larger; which is noted.
    """
    boxes, notes = body_boxes(model) if shapes else ({}, ())
    sizes = _sizes(model, boxes)
    described, repaired = np.array(theta, dtype=float), np.array(theta, dtype=float)
    columns = {name[:-2]: slice(k, k + 10) for k, name in enumerate(names) if name.endswith(f".{INERTIAL[0]}")}
    share = _SHARE * (sum(max(described[own.start], 0.0) for own in columns.values()) or 1.0)
    for name in {model.bodies[0].name, *_frames(model)}:
        del columns[name]
    bodies, unbounded, said = [], list[str](), list(notes)
    for name, own in columns.items():
        repaired[own], why = _possible(described[own], sizes[name], share)
        if why:
            said.append(f"body {shown(name)} {why}: what the log does not show of it is assumed")
        Q = ellipsoid(boxes[name]) if name in boxes else None
        if Q is not None and np.sum(Q * pseudo_inertia(repaired[own])) <= 0.0:
            unbounded.append(name)
            Q = None
        bodies.append(PriorBody(name, own, Q))
    if unbounded:
        said.append(f"shapes do not bound what is described as larger than they are: {listed(unbounded)}")
    return Prior(tuple(names), described, repaired, tuple(bodies), tuple(said))


def _frames(model: Model) -> list[str]:
    """Return the bodies that are nothing but frames between joints."""
    assert model.description is not None, "models are made of descriptions"
    shaped = {link.name for link in model.description.links if link.geometries}
    real = {frame.body for link, frame in model.links.items() if link in shaped}
    real |= {k for k, body in enumerate(model.bodies) if body.inertia.m or body.inertia.I.any()}
    names = {model.bodies[k].name for k in real}
    return [name for name in dict.fromkeys(body.name for body in model.bodies) if names and name not in names]


def _possible(parameters: Floats, size: float, share: float) -> tuple[Floats, str]:
    """Return the parameters of a body that can exist, and what is wrong with those that are given."""
    m, mc, I = parameters[0], parameters[1:4], symmetric(parameters[4:])
    why = ""
    if not m > 0.0:
        m, mc, I, why = share, np.zeros(3), np.zeros((3, 3)), f"has a mass of {m:.4g} kg"
    c = mc / m
    moments, axes = eigen(second_moments(Inertia(m, mc, I).about_centre))
    if moments[0] <= m * (_POINT * size) ** 2:
        moments, why = np.full(3, m * (_GYRATION * size) ** 2), why or "has no inertia"
    elif moments[2] < _FLAT * moments[0]:
        moments, why = np.maximum(moments, _THICKNESS * moments[0]), why or "has an inertia that no body has"
    if not why:
        return parameters, why
    about_origin = parallel_axis(inertia_matrix(product(axes.T, np.diag(moments), axes)), m, c)
    return np.array((m, *(m * c), *about_origin[np.triu_indices(3)])), why


def ellipsoid(box: Box) -> Floats:
    """Return Q with tr(P Q) = integral of (1 - (x - x_s)^T A (x - x_s)) dm over a body of pseudo-inertia P.

    Positive for every body inside the ellipsoid, which is the smallest around the box: with semi-axes sqrt(3) times
    half its edges (Traversaro and others 2016; Wensing, Kim, Slotine 2018).

    Returns:
        (4, 4) [[-A, A x_s], [x_s^T A, 1 - x_s^T A x_s]].
    """
    centre, half = (box.lo + box.hi) / 2, (box.hi - box.lo) / 2
    A = 1.0 / (3.0 * np.maximum(half, _THICKNESS * half.max()) ** 2)
    Q = np.diag((*-A, 1.0 - float((A * centre * centre).sum())))
    Q[3, :3] = Q[:3, 3] = A * centre
    return Q


def _sizes(model: Model, boxes: Mapping[str, Box]) -> dict[str, float]:
    """Return how large each body is [m]: the farthest of its joints, its centre of mass and its shapes from its frame.

    A body without any of them is as large as the joint before it is far, or else 1 m.
    """
    sizes = [length(body.inertia.centre_of_mass) for body in model.bodies]
    for body in model.bodies[1:]:
        sizes[body.parent] = max(sizes[body.parent], length(body.joint.p))
    for name, box in boxes.items():
        k = model.links[name].body
        sizes[k] = max(sizes[k], float(np.abs(box).max()))
    return {body.name: size or length(body.joint.p) or 1.0 for body, size in zip(model.bodies, sizes, strict=True)}


def pseudo_inertia(parameters: ArrayLike) -> Floats:
    """P = [[S, m c], [m c^T, m]] with S = tr(I) / 2 1 - I, the integral of (x, 1) (x, 1)^T dm about the frame's origin.

    P is positive definite if and only if some body of positive density has these parameters: mass positive, principal
    moments about the centre of mass positive and within the triangle inequality (Wensing, Kim, Slotine 2018).

    Args:
        parameters: (..., 10) m, m c, and Ixx Ixy Ixz Iyy Iyz Izz about the origin [kg, kg m, kg m^2].

    Returns:
        (..., 4, 4).

    Accuracy: each entry within 2 eps of the largest of its kind; `parameters_of` undoes it likewise.
    """
    m, mx, my, mz, xx, xy, xz, yy, yz, zz = np.moveaxis(np.asarray(parameters, dtype=float), -1, 0)
    half = 0.5 * (xx + yy + zz)
    rows = (half - xx, -xy, -xz, mx), (-xy, half - yy, -yz, my), (-xz, -yz, half - zz, mz), (mx, my, mz, m)
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def parameters_of(P: ArrayLike) -> Floats:
    """Return the ten parameters (..., 10) of pseudo-inertias (..., 4, 4), I = tr(S) 1 - S; undoes `pseudo_inertia`."""
    P = np.asarray(P, dtype=float)
    xx, yy, zz = P[..., 0, 0], P[..., 1, 1], P[..., 2, 2]
    first = (P[..., 3, 3], P[..., 0, 3], P[..., 1, 3], P[..., 2, 3])
    moments = (yy + zz, -P[..., 0, 1], -P[..., 0, 2], xx + zz, -P[..., 1, 2], xx + yy)
    return np.stack((*first, *moments), axis=-1)


def body_boxes(model: Model) -> tuple[dict[str, Box], tuple[str, ...]]:
    """Return a box around all shapes of each body that has some, along the axes of its frame, and notes.

    The shapes, visual and collision, of all links of a body count. Where one cannot be read the body has no box, since
    the others do not bound it; which is noted.
    """
    description = model.description
    assert description is not None, "models are made of descriptions"
    found: dict[int, list[Box]] = {}
    unread: dict[int, str] = {}
    for link, frame in model.links.items():
        shapes = link_shapes(description, link)
        try:
            boxes = [_box(description, shape).placed(frame.R, frame.p) for shape in shapes]
        except MeshError as error:
            unread[frame.body] = error.sentence
            continue
        found.setdefault(frame.body, []).extend(boxes)
    named = {model.bodies[body].name: around(boxes) for body, boxes in found.items() if boxes and body not in unread}
    notes = (f"shapes do not bound body {shown(model.bodies[body].name)}: {why}" for body, why in unread.items())
    return {name: box for name, box in named.items() if (box.hi > box.lo).any()}, tuple(notes)


def _box(description: Description, shape: Shape) -> Box:
    """Return the box around a shape, along the axes of its link; raise MeshError if the mesh is not found, cannot be
    read, or may not be the whole."""
    geometry, file = shape.geometry, mesh_file(shape)
    if shape.missing:
        raise MeshError(missing_mesh(description, geometry).what)
    if file is None:
        half = half_size(geometry.shape, geometry.size)
        return Box(-half, half).placed(*placement(geometry.origin))
    triangles = scaled(load_triangles(file[0]), file[1])
    if triangles.warnings:
        raise MeshError(triangles.warnings[0])
    ends = [end for block in triangles.blocks() for end in (block.min(axis=(0, 1)), block.max(axis=(0, 1)))]
    corners = np.array(ends, dtype=float) * triangles.scale
    return Box(corners.min(axis=0), corners.max(axis=0)).placed(*placement(geometry.origin))
