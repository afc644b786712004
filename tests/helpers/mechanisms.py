"""Closed chains of pieces, and what their motions take by dense equations of their own."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.linalg

from helpers.dense_mechanics import Piece, ground, loop_rows, places, text_of, torques_of_masses
from robodyn.robot.load import load
from robodyn.scene.scene import GROUND, Scene


@dataclass(frozen=True, eq=False)
class Mechanism:
    """A tree of pieces with loops, closed at q, and motions on its loops: qd and qdd (states, n)."""

    shape: str
    drive: str
    pieces: tuple[Piece, ...]
    scene: Scene
    q: np.ndarray
    qd: np.ndarray
    qdd: np.ndarray

    @cached_property
    def text(self):
        return text_of(self.pieces)

    @cached_property
    def model(self):
        return load(self.text)

    @property
    def n(self):
        return len(self.pieces)

    @cached_property
    def passive(self):
        return np.array([self.scene.actuated is not None and f"j{k}" not in self.scene.actuated for k in range(self.n)])

    def place(self, name, found):
        return ground(self.n) if name == GROUND else found[int(name[1:])]

    def rows(self, qd):
        """J, its bias, and by loop the wrenches of its equations; all of them, implied ones too."""
        found = places(self.pieces, self.q, qd)
        parts = [loop_rows(each, *(self.place(x, found) for x in (each.link, each.to))) for each in self.scene.loops]
        return (
            np.vstack([part[0] for part in parts]),
            np.concatenate([part[1] for part in parts]),
            [part[2] for part in parts],
        )

    def open_torques(self, qd, qdd):
        """tau of the tree without loops: masses, payloads, friction, rotors, springs, wrenches."""
        found, scene = places(self.pieces, self.q, qd, qdd), self.scene
        bodies = [
            (place, piece.mass, piece.com, piece.inertia) for place, piece in zip(found, self.pieces, strict=True)
        ]
        bodies += [(self.place(load.link, found), load.mass, load.com, load.inertia) for load in scene.payloads]
        tau = torques_of_masses(bodies)
        for name, friction in scene.friction.items():
            rate = qd[int(name[1:])]
            dry = friction.forward if rate > 0 else friction.backward if rate < 0 else 0.0
            tau[int(name[1:])] += friction.viscous * rate + dry
        for name, rotor in scene.rotor.items():
            tau[int(name[1:])] += rotor.gear**2 * rotor.inertia * qdd[int(name[1:])]
        for name, spring in scene.spring.items():
            tau[int(name[1:])] += spring.stiffness * (self.q[int(name[1:])] - spring.rest)
        for wrench in scene.wrenches:
            place = self.place(wrench.link, found)
            T = place.R if wrench.frame == "link" else np.eye(3)
            tau -= place.at(wrench.point)[3].T @ T @ wrench.force + place.turns.T @ T @ wrench.moment
        return tau

    @cached_property
    def weights(self):
        return np.array([self.scene.weights.get(f"j{k}", 1.0) for k in np.flatnonzero(~self.passive)], dtype=float)

    def solution(self, qd, qdd):
        """tau (n,), and by loop the wrench on its link (L, 6), by least weighted torques, dense."""
        J, _, wrenches = self.rows(qd)
        tau = self.open_torques(qd, qdd)
        torques, multipliers = least_torques(J, self.passive, tau, self.weights)
        found = np.zeros(self.n)
        found[~self.passive] = torques
        split = np.split(multipliers, np.cumsum([len(each) for each in wrenches])[:-1])
        return found, np.array([own @ each for own, each in zip(split, wrenches, strict=True)])

    def determined_wrenches(self):
        """(L, 6) which entries of the loops' wrenches are the same for all forces that balance the motion."""
        J, _, wrenches = self.rows(self.qd[0])
        open_forces = kernel(J[:, self.passive].T)
        split = np.split(open_forces, np.cumsum([len(each) for each in wrenches])[:-1])
        sizes = [np.abs(each.T @ own).max(axis=1, initial=0.0) for own, each in zip(split, wrenches, strict=True)]
        return np.array(sizes) <= 1e-9


def least_torques(J, passive, tau, weights):
    """Actuated torques with the least weighted squares, and the shortest multipliers with which they balance tau.

    Least squares three times: what passive joints need, what is open for the actuated ones, what is open for both.
    """
    A, D, roots = J[:, passive].T, J[:, ~passive].T, np.sqrt(weights)
    x = scipy.linalg.lstsq(A, tau[passive], cond=1e-9)[0] if A.size else np.zeros(len(J))
    N = kernel(A)
    B = D @ N
    if np.abs(B).max(initial=0.0) > 1e-10 * np.abs(J).max():
        x = x + N @ scipy.linalg.lstsq(roots[:, None] * B, roots * (tau[~passive] - D @ x), cond=1e-9)[0]
    torques, rest = tau[~passive] - D @ x, tau.copy()
    rest[~passive] -= torques
    return torques, scipy.linalg.lstsq(J.T, rest, cond=1e-9)[0]


def kernel(A):
    """An orthonormal basis of what A maps to nothing, as columns."""
    return scipy.linalg.null_space(A, rcond=1e-9) if A.size else np.eye(A.shape[1])
