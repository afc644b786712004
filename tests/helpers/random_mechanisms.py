"""Random closed chains and motions on their loops.

Trees of hinges and slides are drawn with their positions; loops hold together what meets there, so every mechanism is
closed to rounding. A draw whose equations are badly conditioned, or of which no choice of drives fits, is drawn again.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.linalg
from scipy.spatial.transform import Rotation

from helpers.dense_mechanics import Piece, ground, loop_rows, places, text_of, torques_of_masses
from helpers.small_robots import body_numbers
from robodyn.robot.load import load
from robodyn.scene.scene import GROUND, Loop, Scene


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
        """tau of the tree without loops."""
        found = places(self.pieces, self.q, qd, qdd)
        each = zip(found, self.pieces, strict=True)
        return torques_of_masses([(place, piece.mass, piece.com, piece.inertia) for place, piece in each])

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


SHAPES = (
    *("planar point", "planar hinge", "planar weld", "point", "hinge", "weld"),
    *("to the ground", "two loops", "bennett", "directions"),
)
DRIVES = ("driven", "redundant", "all", "undriven")
COUNT = 40
STATES = 3
GAP = 1e-2, 1e-11
"""Singular values that count are above the first part of the largest, and the others below the second."""


def clear_rank(A):
    """The rank, if the singular values leave no doubt of it; else None."""
    values = np.linalg.svd(A, compute_uv=False) if A.size else np.zeros(0)
    parts = values / max(values.max(initial=0.0), 1e-300)
    return None if ((parts < GAP[0]) & (parts > GAP[1])).any() else int((parts >= GAP[0]).sum())


def _spatial(rng, count, before=-1, start=0):
    """A chain of skew joints on a piece; the second may slide."""
    out = []
    for k in range(count):
        mass, com, inertia = body_numbers(rng)
        axis = rng.normal(size=3)
        kind = "prismatic" if k == 1 and rng.random() < 0.5 else ("revolute", "continuous")[rng.integers(2)]
        placed = tuple(rng.uniform(-0.6, 0.6, 3)), tuple(rng.uniform(-3, 3, 3))
        out.append(Piece(before, kind, tuple(axis / np.linalg.norm(axis)), *placed, mass, tuple(com), tuple(inertia)))
        before = start + k
    return out


def _planar(rng, count, turn, before=-1, start=0):
    """A chain whose joints move in the plane that `turn` turns to xy, at any height above it."""
    out = []
    for k in range(count):
        mass, com, inertia = body_numbers(rng)
        xyz, rpy = rng.uniform(-0.6, 0.6, 3), np.array([0.0, 0.0, rng.uniform(-3, 3)])
        if before < 0:
            xyz, rpy = turn.apply(xyz), (turn * Rotation.from_euler("xyz", rpy)).as_euler("xyz")
        slides = k == 1 and rng.random() < 0.4
        way = rng.uniform(-3, 3)
        axis = (np.cos(way), np.sin(way), 0.0) if slides else (0.0, 0.0, rng.choice([-1.0, 1.0]))
        kind = "prismatic" if slides else "revolute"
        out.append(Piece(before, kind, axis, tuple(xyz), tuple(rpy), mass, tuple(com), tuple(inertia)))
        before = start + k
    return out


def _tied(rng, pieces, q, link, to, kind, name, axis=None, directions=()):
    """A loop between what meets at q: a drawn point and axis of a link, and where they are in the other."""
    found = places(pieces, q)
    one, other = found[link], ground(len(q)) if to == GROUND else found[to]
    point = rng.uniform(-0.3, 0.3, 3)
    to_point = other.R.T @ (one.at(point)[0] - other.p)
    B = other.R.T @ one.R
    axes = {}
    if kind == "hinge":
        axis = rng.normal(size=3) if axis is None else one.R.T @ axis
        axes = {"axis": tuple(axis), "to_axis": tuple(B @ axis)}
    if kind == "weld":
        axes = {"rpy": tuple(Rotation.from_matrix(B).as_euler("xyz"))}
    to = to if to == GROUND else f"l{to}"
    return Loop(name, f"l{link}", tuple(point), to, tuple(to_point), kind, directions=directions, **axes)


def _drawn_shape(rng, shape):
    """Pieces, q and loops."""
    free = int(rng.integers(1, 4))
    if shape == "bennett":
        return _bennett(rng)
    if shape.startswith("planar"):
        kind, turn = shape.split()[1], Rotation.from_euler("xyz", rng.uniform(-3, 3, 3))
        count = {"point": 2, "hinge": 2, "weld": 3}[kind] + free
        first = int(rng.integers(1, count))
        pieces = _planar(rng, first, turn) + _planar(rng, count - first, turn, start=first)
        q = rng.uniform(-1, 1, count)
        ends = (first - 1, count - 1) if rng.random() < 0.6 else (count - 1, GROUND)
        if GROUND in ends:  # one chain, in a plane that is oblique to the ground's axes
            pieces = _planar(rng, count, turn)
        return pieces, q, [_tied(rng, pieces, q, *ends, kind, "tie", turn.apply([0, 0, 1]))]
    if shape == "two loops":
        pieces = _spatial(rng, 4) + _spatial(rng, 3, 0, 4) + _spatial(rng, 3, 4, 7)
        q = rng.uniform(-1, 1, 10)
        ends = (3, 6), (9, 3 if rng.random() < 0.5 else GROUND)
        return pieces, q, [_tied(rng, pieces, q, *pair, "point", f"tie{k}") for k, pair in enumerate(ends)]
    kind = shape if shape in ("point", "hinge", "weld") else "point"
    kind = ("point", "hinge", "weld")[rng.integers(3)] if shape == "to the ground" else kind
    count = {"point": 3, "hinge": 5, "weld": 6}[kind] + free
    first = count if shape == "to the ground" else int(rng.integers(1, count))
    pieces = _spatial(rng, first) + _spatial(rng, count - first, start=first)
    pieces += _spatial(rng, int(rng.integers(0, 3)), int(rng.integers(count)), count)
    q = rng.uniform(-1, 1, len(pieces))
    directions = tuple(map(tuple, np.linalg.qr(rng.normal(size=(3, 2)))[0].T)) if shape == "directions" else ()
    to = GROUND if shape == "to the ground" else count - 1
    return pieces, q, [_tied(rng, pieces, q, first - 1, to, kind, "tie", directions=directions)]


def _bennett(rng):
    """Opposite links are alike, a / sin(alpha) = b / sin(beta); of its hinges tan(q1/2) tan(q2/2) is constant."""
    alpha, beta, a = rng.uniform(0.4, 1.0), rng.uniform(1.1, 2.0), rng.uniform(0.3, 0.6)
    b = a * np.sin(beta) / np.sin(alpha)
    turn = Rotation.from_euler("xyz", rng.uniform(-3, 3, 3))
    first = rng.uniform(0.6, 2.2)
    ratio = np.sin((beta + alpha) / 2) / np.sin((beta - alpha) / 2)
    q = np.array([first, 2 * np.arctan(ratio / np.tan(first / 2)), -first])
    pieces, placed = [], (tuple(rng.uniform(-1, 1, 3)), tuple(turn.as_euler("xyz")))
    for k, (length, twist) in enumerate(((a, alpha), (b, beta), (a, alpha))):
        mass, com, inertia = body_numbers(rng)
        pieces.append(Piece(k - 1, "continuous", (0.0, 0.0, 1.0), *placed, mass, tuple(com), tuple(inertia)))
        placed = (length, 0.0, 0.0), (twist, 0.0, 0.0)
    last = places(pieces, q)[2]
    loop = _tied(rng, pieces, q, 2, GROUND, "hinge", "tie", last.R @ (0, -np.sin(alpha), np.cos(alpha)))
    point = (a, 0.0, 0.0)
    return pieces, q, [replace(loop, point=point, to_point=tuple(last.at(point)[0]))]


def _actuated(rng, J, drive):
    """Names of the joints that drive, so many that the passive ones are driven through the loops; None if not found."""
    n, rank = J.shape[1], clear_rank(J)
    if rank is None or rank == n:
        return None
    freedoms = n - rank
    if drive == "all":
        return tuple(f"j{k}" for k in range(n))
    count = {"driven": freedoms, "redundant": min(freedoms + int(rng.integers(1, 3)), n - 1), "undriven": freedoms - 1}
    for _ in range(20):
        chosen = np.sort(rng.permutation(n)[: count[drive]])
        passive = np.delete(np.arange(n), chosen)
        found = clear_rank(J[:, passive])
        if found == (rank if drive == "undriven" else len(passive)):
            return tuple(f"j{k}" for k in chosen)
    return None


def _motions(rng, one):
    """qd and qdd (STATES, n) on the loops, such that the drives can give them."""
    J = one.rows(np.zeros(one.n))[0]
    free = kernel(J)
    qd = (free @ rng.normal(size=(free.shape[1], STATES))).T
    qdd = np.zeros_like(qd)
    lost = kernel(J[:, one.passive]).T if one.passive.any() else np.zeros((0, 0))
    for k, rates in enumerate(qd):
        bias = one.rows(rates)[1]
        given = -scipy.linalg.lstsq(J, bias, cond=1e-9)[0] + free @ rng.normal(size=free.shape[1])
        if lost.size:  # no drive moves these ways: the motion falls freely along them
            bare = one.open_torques(rates, given)
            change = np.array([one.open_torques(rates, given + way) - bare for way in free.T]).T
            needed = lost @ bare[one.passive]
            given = given - free @ np.linalg.lstsq(lost @ change[one.passive], needed, rcond=1e-9)[0]
        qdd[k] = given
    return qd, qdd


def mechanism(seed):
    """Return the seed-th mechanism; shapes and drives go round."""
    shape, drive = SHAPES[seed % len(SHAPES)], DRIVES[seed // len(SHAPES) % len(DRIVES)]
    for attempt in range(1000):
        rng = np.random.default_rng([seed, attempt])
        pieces, q, loops = _drawn_shape(rng, shape)
        still = np.zeros((1, len(q)))
        one = Mechanism(shape, drive, tuple(pieces), Scene(loops=tuple(loops)), q, still, still)
        names = _actuated(rng, one.rows(still[0])[0], drive)
        if names is None:
            continue
        more = {"actuated": names, "joint_limits": "ignore"}
        if rng.random() < 0.5 and names:
            more |= {"share": "weighted", "weights": {name: float(rng.uniform(0.2, 5)) for name in names}}
        one = replace(one, scene=Scene(loops=tuple(loops), **more))
        qd, qdd = _motions(rng, one)
        return replace(one, qd=qd, qdd=qdd)
    raise AssertionError(f"no {shape} of {drive} drives was found for seed {seed}")
