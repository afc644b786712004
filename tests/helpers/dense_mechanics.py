"""Mechanics of small trees by dense matrices, on their own: places and rates in the ground's axes, virtual power.

Nothing of robodyn's recursions, effects or closures enters; numbers are read from `Piece`s, of which URDF is written.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from helpers.small_robots import joint, link, urdf

GRAVITY = np.array([0.0, 0.0, -9.81])


class Piece(NamedTuple):
    """A link and the joint that carries it, on the piece number `before`; -1 is the ground.

    Attributes:
        mass, com, inertia: kg, m, and ixx ixy ixz iyy iyz izz about the centre of mass in the link's axes [kg m^2].
    """

    before: int
    kind: str
    axis: tuple = (0.0, 0.0, 1.0)
    xyz: tuple = (0.0, 0.0, 0.0)
    rpy: tuple = (0.0, 0.0, 0.0)
    mass: float = 1.0
    com: tuple = (0.0, 0.0, 0.0)
    inertia: tuple = (0.01, 0.0, 0.0, 0.01, 0.0, 0.01)


def text_of(pieces):
    """URDF of the pieces: links l0, l1, .. on a frame, joints j0, j1, .."""
    parts = [link("frame")]
    for k, piece in enumerate(pieces):
        before = "frame" if piece.before < 0 else f"l{piece.before}"
        parts.append(link(f"l{k}", piece.mass, piece.com, piece.inertia))
        parts.append(joint(f"j{k}", before, f"l{k}", piece.kind, piece.axis, piece.xyz, piece.rpy))
    return urdf(*parts)


class Place(NamedTuple):
    """A link: axes R and origin p, their velocities w and v, accelerations, and what unit rates do (3, n)."""

    R: np.ndarray
    p: np.ndarray
    w: np.ndarray
    v: np.ndarray
    wd: np.ndarray
    a: np.ndarray
    turns: np.ndarray
    moves: np.ndarray

    def at(self, point):
        """Of a point of the link: its place, velocity, acceleration and Jacobian."""
        r = self.R @ np.asarray(point, dtype=float)
        a = self.a + np.cross(self.wd, r) + np.cross(self.w, np.cross(self.w, r))
        return self.p + r, self.v + np.cross(self.w, r), a, self.moves - np.cross(r, self.turns, axisb=0, axisc=0)


def ground(n):
    zero = np.zeros(3)
    return Place(np.eye(3), zero, zero, zero, zero, zero, np.zeros((3, n)), np.zeros((3, n)))


def places(pieces, q, qd=None, qdd=None):
    """The Place of each piece."""
    n = len(pieces)
    qd, qdd = (np.zeros(n) if rates is None else rates for rates in (qd, qdd))
    found = []
    for k, piece in enumerate(pieces):
        before = found[piece.before] if piece.before >= 0 else ground(n)
        p, v, a, moves = before.at(piece.xyz)
        R = before.R @ Rotation.from_euler("xyz", piece.rpy).as_matrix()
        axis = R @ np.asarray(piece.axis, dtype=float)
        w, wd, turns = before.w, before.wd, before.turns.copy()
        if piece.kind == "prismatic":
            arm, rate = axis * q[k], axis * qd[k]
            p, moves = p + arm, moves - np.cross(arm, turns, axisb=0, axisc=0)
            v = v + np.cross(w, arm) + rate
            a = a + np.cross(wd, arm) + np.cross(w, np.cross(w, arm)) + 2.0 * np.cross(w, rate) + axis * qdd[k]
            moves[:, k] += axis
        else:
            R = R @ Rotation.from_rotvec(np.asarray(piece.axis) * q[k]).as_matrix()
            w, wd = w + axis * qd[k], wd + np.cross(w, axis * qd[k]) + axis * qdd[k]
            turns[:, k] += axis
        found.append(Place(R, p, w, v, wd, a, turns, moves))
    return found


def inertia_of(numbers):
    xx, xy, xz, yy, yz, zz = numbers
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def torques_of_masses(bodies):
    """tau by virtual power: the sum of each body's momentum rates along what unit rates do to it.

    Args:
        bodies: (Place, mass, centre of mass, inertia about it) each.
    """
    tau = 0.0
    for place, mass, com, inertia in bodies:
        _, _, a, moves = place.at(com)
        I = place.R @ inertia_of(inertia) @ place.R.T
        spin = I @ place.wd + np.cross(place.w, I @ place.w)
        tau = tau + moves.T @ (mass * (a - GRAVITY)) + place.turns.T @ spin
    return tau


def across(axis):
    """Two unit vectors across an axis and each other."""
    return np.linalg.svd(np.asarray(axis, dtype=float)[None])[2][1:]


def loop_rows(loop, one, other):
    """J (m, n), what it adds to J qdd, and by equation the wrench (force, moment) on the link for a unit of it.

    For loops that are closed and whose rates are zero, all in the axes of the other link.

    Args:
        one, other: the Place of the loop's link and of the other.
    """
    _, v, a, moves = one.at(loop.point)
    _, v_other, a_other, moves_other = other.at(loop.to_point)
    T, w = other.R.T, other.w
    slide, turn = v - v_other, T @ (one.w - w)
    point = T @ (moves - moves_other)
    point_bias = T @ (a - a_other - 2.0 * np.cross(w, slide))
    D = np.array(loop.directions, dtype=float).reshape(-1, 3)
    D = D / np.linalg.norm(D, axis=1, keepdims=True) if len(D) else np.eye(3)
    turns, bias = T @ (one.turns - other.turns), T @ (one.wd - other.wd - np.cross(w, one.w))
    E = np.zeros((0, 3))
    if loop.kind == "hinge":
        E = across(loop.to_axis)
        s = T @ one.R @ (np.asarray(loop.axis) / np.linalg.norm(loop.axis))
        assert np.abs(np.cross(s, turn)).max() <= 1e-9 * (1.0 + np.abs(turn).max())
    elif loop.kind == "weld":
        E = np.eye(3)
    wrenches = np.vstack((np.hstack((D, np.zeros((len(D), 3)))), np.hstack((np.zeros((len(E), 3)), E))))
    return np.vstack((D @ point, E @ turns)), np.concatenate((D @ point_bias, E @ bias)), wrenches
