"""Physically consistent parameters: what bodies that can exist have, near a description where the log says nothing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from robodyn.dynamics.regressor import INERTIAL
from robodyn.errors import InputError, MeshError
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
from robodyn.support.floats import Floats, einsum
from robodyn.support.linear import eigen
from robodyn.support.wording import listed, shown

_FLAT, _THICKNESS = 1e-6, 1e-2
"""Of the largest second moment: one below is not told from an impossible body's, and what takes its place."""
_POINT, _GYRATION = 1e-4, 0.1
"""Of a body's size: the radius of gyration below which it is described as a point, and what takes its place."""
_SHARE = 1e-3  # mass of a body that is described without, in parts of the robot's


@dataclass(frozen=True, eq=False)
class PriorBody:
    """A body's `columns` among the parameters, and the matrix Q (4, 4) of its bounding ellipsoid, if it has one."""

    name: str
    columns: slice
    ellipsoid: Floats | None = None


@dataclass(frozen=True, eq=False)
class Prior:
    """Where parameters are drawn to: `described` (p,), and theta with bodies that cannot exist replaced by near ones
    that can, which `notes` tell; bodies: whose parameters are open, of the three of a planar joint the last."""

    names: tuple[str, ...]
    described: Floats
    theta: Floats
    bodies: tuple[PriorBody, ...]
    notes: tuple[str, ...]


def prior_of(model: Model, names: Sequence[str], theta: Floats, *, shapes: bool = True) -> Prior:
    """Return the prior of a description's parameters, which `robodyn.regressor` has.

    The base and mere frames (bodies without mass, inertia and shapes, if others have some) stay as they are. Another
    body without positive mass gets a thousandth of the robot's mass; second moments about the centre of mass that are
    not positive become a hundredth of the largest; a point gets a tenth of the body's size as radius of gyration.
    With `shapes` ellipsoids around their boxes bound the bodies, but those that are already described as larger.
    """
    boxes, notes = body_boxes(model) if shapes else ({}, ())
    sizes = _sizes(model, boxes)
    described, repaired = np.array(theta, dtype=float), np.array(theta, dtype=float)
    columns = {name[:-2]: slice(k, k + 10) for k, name in enumerate(names) if name.endswith(f".{INERTIAL[0]}")}
    share = _SHARE * (sum(max(described[own.start], 0.0) for own in columns.values()) or 1.0)
    assert model.description is not None, "models are made of descriptions"
    shaped = {link.name for link in model.description.links if link.geometries}
    real = {model.bodies[frame.body].name for link, frame in model.links.items() if link in shaped}
    real |= {body.name for body in model.bodies if body.inertia.m or body.inertia.I.any()}
    frames = {body.name for body in model.bodies if real and body.name not in real}
    for name in {model.bodies[0].name, *frames}:
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


def _possible(parameters: Floats, size: float, share: float) -> tuple[Floats, str]:
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
    """Return Q (4, 4) with tr(P Q) = integral of (1 - (x - x_s)^T A (x - x_s)) dm over a body of pseudo-inertia P.
    Positive for every body inside the ellipsoid, which is the smallest around the box: with semi-axes sqrt(3) times
    half its edges (Traversaro and others 2016; Wensing, Kim, Slotine 2018)."""
    centre, half = (box.lo + box.hi) / 2, (box.hi - box.lo) / 2
    A = 1.0 / (3.0 * np.maximum(half, _THICKNESS * half.max()) ** 2)
    Q = np.diag((*-A, 1.0 - float((A * centre * centre).sum())))
    Q[3, :3] = Q[:3, 3] = A * centre
    return Q


def _sizes(model: Model, boxes: Mapping[str, Box]) -> dict[str, float]:
    """Return how large each body is [m]: the farthest of its joints, its centre of mass and its shapes from its frame.
    A body without any of them is as large as the joint before it is far, or else 1 m."""
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

    Accuracy: each entry (..., 4, 4) within 2 eps of the largest of its kind; `parameters_of` undoes it likewise.
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
    """Return a box around all shapes of each body that has some, visual and collision, of all its links, along the axes
    of its frame; where one cannot be read the body has none, since the others do not bound it, which is noted."""
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
    """Return the box around a shape; raise MeshError if the mesh is not found, cannot be read, or is not the whole."""
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


MARGIN = 1e-6  # P - MARGIN P0 is positive definite, so that rounding in print makes no body impossible
_FLOOR = 1e-12
"""The least strength, in parts of ||z||^2, and the weight of the barriers of bounds where the path ends."""
_SIGNS = {"viscous": 1.0, "coulomb": 1.0, "forward": 1.0, "backward": -1.0, "stribeck": 1.0, "load": 1.0, "rotor": 1.0}
_NEXT, _CENTRED, _SETTLED = 0.05, 1.0, 1e-8
"""By which the barrier weakens; squares of Newton's decrement, in units of the barrier, up to which it does, and up to
which the last point is the minimum."""
_STEPS, _LAST = 400, 12
"""Newton's steps at most, and those at the end of the path after which what is left is rounding."""
BASIS = np.zeros((10, 4, 4))  # an orthonormal basis (10, 4, 4) of the symmetric matrices
for _k, (_i, _j) in enumerate(zip(*np.triu_indices(4), strict=True)):
    BASIS[_k, _i, _j] = BASIS[_k, _j, _i] = 1.0 if _i == _j else 0.5**0.5
_ONE = einsum("kii->k", BASIS)  # the coordinates of the identity


def coordinates(V: Floats) -> Floats:
    """Return the coordinates (..., 10) of symmetric matrices (..., 4, 4) in `BASIS`."""
    v: Floats = einsum("kij,...ij->...k", BASIS, V)
    return v


class ConsistentFit(NamedTuple):
    """Physically consistent parameters theta (p,), with `error` = ||R theta - z||^2 / 2; gap: by how much the objective
    exceeds its minimum at most; infinite if that could not be found."""

    theta: Floats
    error: float
    gap: float


def consistent_parameters(R: Floats, z: Floats, prior: Prior, strength: float = 0.0) -> ConsistentFit:
    """Return the parameters of possible bodies that minimise the squares and the distance from the prior, together.

    The minimum of

        ||R theta - z||^2 / 2 + strength (sum over bodies of D(P || P0) + sum over the others of ((x - x0) / s)^2 / 2)

    over P positive definite with tr(P Q) >= 0 where a body has a bounding ellipsoid, viscous, coulomb, forward,
    stribeck and rotor >= 0, backward <= 0. D is the log-determinant divergence of what exceeds `MARGIN` P0 from what P0
    has of that (Lee, Wensing, Park 2020), which does not depend on units, axes or masses; s is |x0| or what alone would
    make ||z||, whichever is larger. Without strength the least that is computed with is 1e-12 ||z||^2: of all fits as
    good as any this is the one nearest to the prior. Parameters that the rows do not show keep the description's
    values.

    Method: Newton's along the path of a weakening barrier (see `_Path`), in variables V with P = L V L^T, P0 = L L^T,
    and x / s. The objective is its own barrier of the bodies: it is self-concordant, and Newton's decrement bounds how
    far its minimum is (Boyd and Vandenberghe 2004, 9.6).

    Args:
        R, z: (rows, p), (rows,), as triangular factors of a weighted regressor and torques.
        strength: of the prior, in the unit of ||z||^2.

    Raises:
        InputError: a number is not finite.

    Accuracy: the objective is within 2e-12 (k + 1) ||z||^2 of its minimum, with k bounds; `gap` says it.
    """
    if not (np.isfinite(R).all() and np.isfinite(z).all()):
        raise InputError("the rows have numbers that are not finite", remedy="look for gaps in the log")
    path = _Path(R, z, prior, strength)
    if not path.seen.any():
        return ConsistentFit(prior.described.copy(), float(z @ z) / 2.0, 0.0)
    gap, theta = path.follow(), path.theta()
    residual = R @ theta - z
    return ConsistentFit(theta, float(residual @ residual) / 2.0, gap * path.size**2)


class _Path:
    """theta = offset + T y of the parameters that the rows show, so that prior and rows are of the order of 1.

    P = MARGIN P0 + (1 - MARGIN) L V L^T of each body, V by its coordinates, then the other parameters in units of
    their own. At mu y minimises

        ||A y - b||^2 / 2 + lam ||x - x0||^2 / 2 + lam tr V - (lam + mu - floor) log det V - mu sum log(G y + h)

    where mu falls to the floor.
    """

    def __init__(self, R: Floats, z: Floats, prior: Prior, strength: float) -> None:
        self.prior, self.offset = prior, prior.described.copy()
        self.seen = (R != 0.0).any(axis=0)
        self.bodies = [body for body in prior.bodies if self.seen[body.columns].any()]
        columns = np.linalg.norm(R, axis=0)
        self.size = float(np.linalg.norm(z, axis=0)) or float(columns.max(initial=0.0)) or 1.0
        self.lam = max(strength / self.size**2, _FLOOR)
        kinds = [name.rpartition(".")[2] for name in prior.names]
        others = np.array([k for k, kind in enumerate(kinds) if self.seen[k] and kind not in INERTIAL], dtype=int)
        signs = np.array([_SIGNS.get(kinds[k], 0.0) for k in others])
        units = np.maximum(np.abs(prior.theta[others]), self.size / columns[others])
        units[signs < 0.0] *= -1.0
        self.offset[others] = 0.0
        self.inner = 10 * len(self.bodies)
        self.signed = np.flatnonzero(signs) + self.inner
        self.T = np.zeros((len(R.T), self.inner + len(others)))
        self.T[others, np.arange(self.inner, len(self.T.T))] = units
        G, h = [np.eye(len(self.T.T))[self.signed]], [0.0] * len(self.signed)
        for k, body in enumerate(self.bodies):
            L = np.linalg.cholesky(pseudo_inertia(prior.theta[body.columns]))
            own = slice(10 * k, 10 * k + 10)
            self.T[body.columns, own] = (1.0 - MARGIN) * parameters_of(L @ BASIS @ L.T).T
            self.offset[body.columns] = MARGIN * prior.theta[body.columns]
            if body.ellipsoid is not None:
                row, Q = np.zeros((1, len(self.T.T))), L.T @ body.ellipsoid @ L
                row[0, own] = (1.0 - MARGIN) * coordinates(Q)
                G.append(row)
                h.append(MARGIN * float(np.trace(Q)))
        self.A, self.b = R @ self.T / self.size, (z - R @ self.offset) / self.size
        self.G, self.ones = np.concatenate(G), np.tile(_ONE, len(self.bodies))
        self.y = np.concatenate((self.ones, prior.theta[others] / units))
        self.y[self.signed] = np.maximum(self.y[self.signed], 0.0)
        self.centre = self.y[self.inner :].copy()
        self.y[self.signed] = np.maximum(self.y[self.signed], 1e-3)
        self.slack = self.G @ self.y + h

    def theta(self) -> Floats:
        """Return the parameters; those at their bound are 0."""
        y, slack = self.y.copy(), self.slack[: len(self.signed)]
        y[self.signed] = np.where(slack * slack < _FLOOR, 0.0, slack)
        theta: Floats = self.offset + self.T @ y
        return theta

    def follow(self) -> float:
        """Go to the end of the path; return by how much the objective exceeds its minimum at most."""
        error = self.A @ self.y - self.b
        mu, at_end = max(1e-2, float(error @ error)), 0
        for _ in range(_STEPS):
            squared = self._step(mu)
            if mu > _FLOOR:
                mu = max(_FLOOR, _NEXT * mu) if squared < _CENTRED * mu else mu
                continue
            at_end += 1
            if squared < min(_SETTLED * self.lam, _FLOOR) or at_end > _LAST:
                return squared + len(self.slack) * _FLOOR
        return inf

    def _step(self, mu: float) -> float:
        """Go by Newton's direction to where the objective is least along it; return the square of the decrement. In
        variables u with V + dV = F (1 + dU) F^T, V = F F^T, and signed ones in parts of themselves, the second
        derivatives of barriers are multiples of the identity, and those of everything are rows^T rows."""
        from scipy.linalg import solve_triangular

        n, curve = self.inner, self.lam + mu - _FLOOR
        F = np.linalg.cholesky(einsum("lk,kij->lij", self.y[:n].reshape(-1, 10), BASIS))
        S = np.swapaxes(coordinates(F[:, None] @ BASIS @ np.swapaxes(F, -1, -2)[:, None]), -1, -2)
        unit = np.ones(len(self.y) - n)
        unit[self.signed - n] = self.slack[: len(self.signed)]

        def scaled(rows: Floats) -> Floats:
            blocks = rows[:, :n].reshape(len(rows), len(self.bodies), 1, 10) @ S
            return np.concatenate((blocks.reshape(len(rows), n), rows[:, n:] * unit), axis=1)

        nearing, root = scaled(self.G) / self.slack[:, None], np.sqrt(self.lam)
        own = np.concatenate((np.full(n, np.sqrt(curve)), root * unit))
        rows = np.concatenate((scaled(self.A), np.diag(own), np.sqrt(mu) * nearing))
        trace = (self.ones.reshape(-1, 1, 10) @ S).ravel()
        off = np.concatenate(
            (
                self.A @ self.y - self.b,
                (self.lam * trace - curve * self.ones) / np.sqrt(curve),
                root * (self.y[n:] - self.centre),
                np.full(len(self.slack), -np.sqrt(mu)),
            )
        )
        triangle = np.asarray(np.linalg.qr(np.column_stack((rows, off)), mode="r"))
        along = triangle[: len(self.y), -1]
        u = -solve_triangular(triangle[: len(self.y), :-1], along)
        bends = np.linalg.eigvalsh(einsum("lk,kij->lij", u[:n].reshape(-1, 10), BASIS)).ravel()
        approach = nearing @ u
        smooth = np.concatenate((rows[: len(self.A)] @ u, root * unit * u[n:]))
        slope = (
            smooth @ np.concatenate((off[: len(self.A)], root * (self.y[n:] - self.centre))) + self.lam * trace @ u[:n]
        )
        barriers = np.concatenate((np.full(len(bends), curve), np.full(len(approach), mu)))
        part = _least(float(slope), float(smooth @ smooth), barriers, np.concatenate((bends, approach)))
        self.y = self.y + part * np.concatenate(((S @ u[:n].reshape(-1, 10, 1)).ravel(), unit * u[n:]))
        self.slack = self.slack * (1.0 + part * approach)
        return float(along @ along)


def _least(slope: float, bend: float, weights: Floats, rates: Floats) -> float:
    """Minimiser t > 0 of slope t + bend t^2 / 2 - sum weights log(1 + t rates), by Newton steps in a bracket."""
    low, high = 0.0, -1.0 / float(rates.min()) if rates.min(initial=0.0) < 0.0 else 1e3
    t = min(1.0, 0.9 * high)
    for _ in range(30):
        parts = rates / (1.0 + t * rates)
        first = slope + bend * t - float(weights @ parts)
        low, high = (low, t) if first > 0.0 else (t, high)
        new = t - first / (bend + float(weights @ (parts * parts)))
        new = new if low < new < high else 0.5 * (low + high)
        if abs(new - t) < 1e-3 * t:
            return new
        t = new
    return t
