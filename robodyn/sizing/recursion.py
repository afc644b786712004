"""The most that weight can ask of joints, bearings and the base in any pose: a bound from above, and poses near it.

1. From the tips to the base: `support`, the most that `w . h` can be for a direction w in a body's axes, h the first
   moment of all that the body carries. A joint is the maximum over its turns or its stroke, a branch the sum.
2. At each joint what weight asks of it, of a direction of gravity in the body's axes; from there to the base again a
   maximum for each joint on the way. There gravity is known.
3. From the base to the tips, `poses`: the turns at which these maxima were.

Each is a function of one direction, whatever the number of joints, and exact but for the lattice it is kept on
(`directions.py`, which bounds it from above). Joints that mimic count as free within their limits, which only adds.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from robodyn.programs.vectors import arctan2, frame, length, product
from robodyn.robot.model import Model
from robodyn.scene.scene import DEFAULT, ExternalWrench, Payload, Scene
from robodyn.sizing.directions import Lattice, Mix
from robodyn.support.floats import Floats, first_of_ties

TRIED = 32
"""Turns of a joint that a pose is chosen from."""
_CONVERGED = _NOTHING = 1e-14
"""Of all weight at its farthest reach, what is no gain, and what is nothing."""
ROUNDING = 1e-10
"""Of the weight at the farthest reach: more than the rounding of all sums of a bound."""


class Pull(NamedTuple):
    """What pulls one way throughout, as gravity does: a direction in the base's axes, on each body how strongly [N],
    and that times the place where, in the body's frame [N m]."""

    direction: Floats
    force: Floats
    moment: Floats


def weight_of(model: Model, scene: Scene = DEFAULT, payloads: Iterable[Payload] | None = None) -> Pull:
    """Return what pulls along gravity, or of it payloads alone: bodies, payloads, buoyancy, forces along it."""
    g = np.array(scene.gravity, dtype=float)
    size = length(g)
    direction = g / size if size else np.array([0.0, 0.0, -1.0])
    whole = payloads is None
    force = np.array([body.inertia.m * size * whole for body in model.bodies], dtype=float)
    moment = np.array([np.asarray(body.inertia.mc, float) * size * whole for body in model.bodies])
    points = [(each.link, each.com, each.mass * size) for each in (scene.payloads if payloads is None else payloads)]
    if whole:
        points += [(each.link, each.centre, -scene.fluid_density * each.volume * size) for each in scene.immersed]
        points += [
            (each.link, each.point, float(np.dot(each.force, direction)))
            for each in scene.wrenches
            if each.cause == "surroundings" and along_gravity(each, direction)
        ]
    for link, point, pull in points:
        body, R, p = model.links[link]
        force[body] += pull
        moment[body] += pull * (product(np.asarray(R, float), np.array(point, dtype=float)) + np.asarray(p, float))
    return Pull(direction, force, moment)


def along_gravity(wrench: ExternalWrench, direction: Floats) -> bool:
    """Whether a wrench is a force along gravity, whatever the pose."""
    force = np.array(wrench.force, dtype=float)
    aside = length(np.cross(force, direction))
    return wrench.frame != "link" and not any(wrench.moment) and aside <= 1e-15 * length(force)


class Key(NamedTuple):
    """What is asked for: "torque" (place: the entry of tau; side: 1 of tau, -1 of -tau, 0 of both), and of a joint's
    bearing "tilting" or "radial", of the base "tipping" (place: the body; side 0)."""

    what: str
    place: int
    side: int = 0


class Recursion:
    """The recursion of one robot, pull and lattice.

    Attributes:
        most: of each key, and side -1 or 1, a bound of the most that weight, and springs, ask for [N m, N].
    """

    def __init__(
        self,
        model: Model,
        pull: Pull,
        low: Floats,
        high: Floats,
        lattice: Lattice,
        *,
        springs: Mapping[str, tuple[float, float]] | None = None,
        bearings: bool = True,
        wanted: frozenset[Key] | None = None,
    ) -> None:
        """Args:
        low, high: (nq,) of each coordinate [rad or m]; an angle turns once at most, unless a spring or others follow.
        springs: stiffness and rest of joints, by name.
        wanted: keys of side 0; None: all.
        """
        self.model, self.pull, self.lattice, self.low, self.high = model, pull, lattice, low, high
        self.springs, self.bearings, self.wanted = springs or {}, bearings, wanted
        bodies, parents = model.bodies, model.parents
        self.carried = pull.force.copy()
        for i in reversed(range(1, len(bodies))):
            self.carried[parents[i]] += self.carried[i]
        self.axes = [frame(np.asarray(body.joint.axis, float)) if i else np.eye(3) for i, body in enumerate(bodies)]
        # of each body, from the axes of its parent to those of its lattice
        self.inwards = [product(turn, body.joint.R.T) for turn, body in zip(self.axes, bodies, strict=True)]
        self.ends = [
            sorted(self.position(i, end) for end in (low, high)) if i else [0.0, 0.0] for i in range(len(bodies))
        ]
        self._mixes: dict[int, Mix] = {}
        self.support: list[Floats] = [np.empty(0)] * len(bodies)
        self.turned: list[Floats] = list(self.support)
        self.keys: list[list[Key]] = [[] for _ in bodies]
        self.values: list[Floats] = list(self.support)
        self.added: dict[Key, float] = {}
        self.most: dict[tuple[Key, int], float] = {}
        self._inward()
        self._outward()

    def position(self, i: int, q: Floats) -> float:
        joint = self.model.bodies[i].joint
        return float(joint.multiplier * q[joint.coordinate] + joint.offset)

    @property
    def size(self) -> int:
        """How many values are on all lattices."""
        return sum(len(keys) for keys in self.keys) * (self.lattice.rows + 1) * self.lattice.columns

    def _mix(self, i: int) -> Mix:
        """Return the directions of the lattice of a body's parent on its own."""
        if i not in self._mixes:
            parent = self.model.parents[i]
            ways = product(self.inwards[i], product(self.axes[parent].T, self.lattice.directions))
            self._mixes[i] = self.lattice.mix(ways)
        return self._mixes[i]

    def _carries(self, i: int, w: Floats, mix: Mix) -> Floats:
        """Return what body i, with all that it carries, adds to the support of its parent in directions w (3, N)."""
        joint, weight = self.model.bodies[i].joint, self.carried[i]
        found = weight * product(joint.p, w) + self.lattice.at(self.turned[i], mix)
        if joint.kind == "prismatic":
            along = weight * product(product(joint.R, joint.axis), w)
            found += np.maximum(self.ends[i][0] * along, self.ends[i][1] * along)
        return np.asarray(found)

    def _inward(self) -> None:
        lattice, parents = self.lattice, self.model.parents
        shape = (lattice.rows + 1, lattice.columns)
        for i in reversed(range(1, len(parents))):
            ways = product(self.axes[i].T, lattice.directions)
            support = product(self.pull.moment[i], ways)
            for k in range(i + 1, len(parents)):
                if parents[k] == i:
                    support += self._carries(k, ways, self._mix(k))
            self.support[i] = self.turned[i] = support.reshape(shape)
            if self.model.bodies[i].joint.kind == "revolute":
                self.turned[i] = lattice.turned(self.support[i], *self.ends[i])

    def _outward(self) -> None:
        """Note what weight asks of joints, and carry it to the base."""
        lattice, parents, down = self.lattice, self.model.parents, self.pull.direction
        below: list[dict[Key, Floats]] = [{} for _ in parents]
        ends: dict[tuple[Key, int], float] = {}
        for i in reversed(range(1, len(parents))):
            own = self._own(i)
            for key, value in own.items():
                below[i][key] = below[i][key] + value if key in below[i] else value
            if not below[i]:
                continue
            self.keys[i], self.values[i] = [*below[i]], np.stack([*below[i].values()])
            passed = self._passed(i, own)
            if parents[i]:
                resampled = lattice.at(passed, self._mix(i)).reshape(passed.shape)
                for key, value in zip(self.keys[i], resampled, strict=True):
                    there = below[parents[i]]
                    there[key] = there[key] + value if key in there else value
            else:
                both = lattice.at(passed, lattice.mix(product(self.inwards[i], np.stack([-down, down], axis=1))))
                for key, pair in zip(self.keys[i], both.tolist(), strict=True):
                    for side, value in zip((1, -1), pair, strict=True):
                        if key.side in (0, side):
                            ends[key, side] = ends.get((key, side), 0.0) + value
        if self.bearings:
            ends[self.base, 1] = float(self._tipped().max()) / np.cos(np.pi / self.tipping.shape[1])
        margin = ROUNDING * self.scale
        self.most = {(key, side): value - self.added.get(key, 0.0) + margin for (key, side), value in ends.items()}

    @cached_property
    def scale(self) -> float:
        """More than all weight at its farthest reach asks for [N m, N]."""
        slides = (end for end, body in zip(self.ends, self.model.bodies, strict=True) if body.joint.kind == "prismatic")
        reach = 1.0 + self.model.reach + sum(max(map(abs, end)) for end in slides)
        return float(np.abs(self.pull.force).sum() * reach + np.abs(self.pull.moment).sum()) or 1.0

    @cached_property
    def tipping(self) -> Floats:
        """(3, N) gravity across each direction in the base's x and y."""
        angle = 2.0 * np.pi * np.arange(256) / 256
        round_about = np.array([np.cos(angle), np.sin(angle), 0.0 * angle])
        return np.asarray(np.cross(self.pull.direction, round_about, axisb=0).T)

    def _own(self, i: int) -> dict[Key, Floats]:
        """Return what is asked for at joint i, of the direction of gravity in the body's axes."""
        joint, lattice, support = self.model.bodies[i].joint, self.lattice, self.support[i]
        found: dict[Key, Floats] = {}
        if self._asked("torque", joint.rate):
            level = np.cos(lattice.polar * np.arange(lattice.rows + 1))[:, None] + np.zeros(lattice.columns)
            one = self.carried[i] * level if joint.kind == "prismatic" else lattice.across(support)
            size, other = abs(joint.multiplier), lattice.opposite(one) if joint.multiplier < 0.0 else one
            for side in self.sides(joint.rate):
                found[Key("torque", joint.rate, side)] = size * other
        if self.bearings and self._asked("tilting", i):
            found[Key("tilting", i)] = lattice.tilting(support)
        if self.bearings and self._asked("radial", i):
            found[Key("radial", i)] = abs(self.carried[i]) * lattice.sine + np.zeros(lattice.columns)
        return found

    def _asked(self, what: str, place: int) -> bool:
        return self.wanted is None or Key(what, place) in self.wanted

    def sides(self, rate: int) -> tuple[int, ...]:
        """Return the sides of a torque that are functions of their own: those of gravity mirror each other."""
        joints = [body.joint for body in self.model.bodies[1:] if body.joint.rate == rate]
        plain = len(joints) == 1 and joints[0].name not in self.springs
        return (0,) if plain else (1, -1)

    def spring(self, i: int, side: int) -> tuple[float, float]:
        """Return slope and value at 0 of what the spring of joint i adds to a torque on this side, by its position."""
        joint = self.model.bodies[i].joint
        stiffness, rest = self.springs.get(joint.name, (0.0, 0.0))
        return side * joint.multiplier * stiffness, -side * joint.multiplier * stiffness * rest

    def _passed(self, i: int, own: Mapping[Key, Floats]) -> Floats:
        """Return the values of body i as functions of gravity in the axes of the joint's placement: over all turns."""
        joint, (low, high), values = self.model.bodies[i].joint, self.ends[i], self.values[i]
        passed = self.lattice.turned(values, low, high) if joint.kind == "revolute" else values.copy()
        for k, key in enumerate(self.keys[i]):
            slope, start = self.spring(i, key.side) if key in own and key.what == "torque" else (0.0, 0.0)
            if slope or start:
                least = min(slope * low, slope * high) + start
                self.added[key] = self.added.get(key, 0.0) + max(-least, 0.0)
                start += max(-least, 0.0)
                if joint.kind == "revolute":
                    passed[k] = self.lattice.turned(values[k], low, high, slope, start)
                else:
                    passed[k] += max(slope * low, slope * high) + start
        return passed

    def poses(self, rows: Sequence[tuple[Key, int]], rest: Floats, sweeps: int = 40) -> tuple[Floats, Floats]:
        """Return (rows, nq) poses of the largest value of each key and side that is found, and these values: those of
        the maxima on the lattice, then of each joint in turn its best position, where `a + b cos q + c sin q` has it,
        until that gains nothing, `sweeps` times at most. Coordinates that do not matter are at `rest`, those that
        several joints share where it is best for one, or at an end or in the middle."""
        state = _Rows(self, rows, np.tile(rest, (len(rows), 1)))
        chosen = np.zeros(state.q.shape, dtype=bool)
        places = [self.kept(*row) for row in rows]
        if self.base.what in [key.what for key, _ in rows]:
            best = self.tipping[:, first_of_ties(self._tipped()[None])[0]]
            state.w[:, [key == self.base for key, _ in rows]] = best[:, None]

        def by_lattice(i: int, g: Floats, w: Floats) -> None:
            joint, (low, high) = self.model.bodies[i].joint, self.ends[i]
            kinds = {key: k for k, key in enumerate(self.keys[i])}
            kind = np.array([kinds.get(key, len(kinds)) for key in places])
            above = kind < len(kinds)
            free = np.flatnonzero((above | w.any(axis=0)) & ~chosen[:, joint.coordinate])
            if not len(free) or not joint.multiplier:
                return
            here = min(max(joint.multiplier * float(rest[joint.coordinate]) + joint.offset, low), high)
            tried = np.concatenate(([here], np.linspace(low, high, TRIED + 1)))
            if joint.kind == "revolute":
                values = np.concatenate([*([self.values[i]] if kinds else []), self.support[i][None]])
                found = self._tried(values, kind[free], np.where(above, g, w)[:, free], tried)
            else:
                found = self.carried[i] * w[2, free, None] * tried
            for row, k in enumerate(free.tolist()):
                if rows[k][0].what == "torque" and rows[k][0].place == joint.rate:
                    slope, start = self.spring(i, rows[k][1])
                    found[row] += slope * tried + start
            state.q[free, joint.coordinate] = (tried[first_of_ties(found)] - joint.offset) / joint.multiplier
            chosen[free, joint.coordinate] = True

        state.outward(by_lattice, tilts=True)
        owners = [body.joint.coordinate for body in self.model.bodies[1:] if body.joint.kind != "floating"]
        if shared := sorted({k for k in owners if owners.count(k) > 1}):
            tried = [state.q.copy() for _ in range(4)]
            for q, part in zip(tried[1:], (0.0, 0.5, 1.0), strict=True):
                q[:, shared] = (self.low + part * (self.high - self.low))[shared]
            which = first_of_ties(np.array([state.asked(q) for q in tried]).T)
            state.q = np.array(tried)[which, np.arange(len(rows))]
        for _ in range(sweeps):
            state.inward()
            if state.outward(state.best) <= _CONVERGED:
                break
        return state.q, state.asked(state.q)

    @property
    def base(self) -> Key:
        return Key("tipping", 0)

    def _tipped(self) -> Floats:
        """(N,) what weight asks of the base about each direction of `tipping`."""
        value = product(self.pull.moment[0], self.tipping)
        for i, parent in enumerate(self.model.parents):
            if parent == 0:
                value += self._carries(i, self.tipping, self.lattice.mix(product(self.inwards[i], self.tipping)))
        return np.asarray(value)

    def kept(self, key: Key, side: int) -> Key:
        """Return the key under which the values of a key and side are."""
        return Key("torque", key.place, 0 if 0 in self.sides(key.place) else side) if key.what == "torque" else key

    def _tried(self, values: Floats, which: Floats, way: Floats, tried: Floats) -> Floats:
        """(rows, N) values of kind `which` (rows,), at directions (3, rows) turned back by each angle."""
        ways = _turned(np.repeat(way, len(tried), axis=1), np.tile(tried, way.shape[1]))
        mix = self.lattice.mix(ways)
        flat, first = values.reshape(-1), np.repeat(which, len(tried)) * values[0].size
        found = sum(flat[first + place] * share for place, share in zip(mix.places, mix.shares, strict=True))
        return np.asarray(found).reshape(-1, len(tried))


class _Rows:
    """Poses in rows, each of which raises the value of a key, `h . (g x e)` of the body that it is about: h the first
    moment of what that carries, g against gravity or along it, by the side, e its axis or across it. In the turn of a
    joint above, this is g . v with v = e x h; below, w . h with w = g x e. All are in the axes of lattices."""

    values: Floats
    """(rows,) of torques, before the last of `outward`."""

    def __init__(self, of: Recursion, rows: Sequence[tuple[Key, int]], q: Floats) -> None:
        self.of, self.rows, self.q = of, rows, q
        self.g = np.array([[-side] for _, side in rows]).T * of.pull.direction[:, None]
        self.w = np.zeros((3, len(rows)))  # of the base
        self.e = np.zeros((3, len(rows)))
        self.about: list[list[int]] = [[] for _ in of.model.bodies]
        for i, body in enumerate(of.model.bodies):
            for k, (key, _) in enumerate(rows):
                if key.place == (body.joint.rate if key.what == "torque" else i) and (i or key == of.base):
                    self.about[i].append(k)
        self.h: list[Floats] = []
        self.v: list[Floats] = []
        self.inward()

    def inward(self) -> None:
        """Find h and v of all bodies in all rows."""
        of, bodies, count = self.of, self.of.model.bodies, len(self.rows)
        self.h = [
            np.repeat(product(turn, moment)[:, None], count, axis=1)
            for turn, moment in zip(of.axes, of.pull.moment, strict=True)
        ]
        self.v = [np.zeros((3, count)) for _ in bodies]
        for i in reversed(range(len(bodies))):
            joint, h, v = bodies[i].joint, self.h[i], self.v[i]
            for k in self.about[i]:
                what = self.rows[k][0].what
                e = np.array([0.0, 0.0, joint.multiplier]) if what == "torque" else self.e[:, k]
                straight = what == "radial" or (what == "torque" and joint.kind == "prismatic")
                v[:, k] += of.carried[i] * e if straight else np.cross(e, h[:, k])
            if i == 0:
                continue
            parent, position = bodies[i].parent, self.position(i)
            back = product(of.axes[parent], of.inwards[i].T)
            moment = of.carried[i] * product(of.axes[parent], joint.p)[:, None]
            if joint.kind == "revolute":
                h, v = _turned(h, -position), _turned(v, -position)
            else:
                h = h + of.carried[i] * np.array([0.0, 0.0, 1.0])[:, None] * position
            self.h[parent] += product(back, h) + moment
            self.v[parent] += product(back, v)

    def asked(self, q: Floats) -> Floats:
        """Return (rows,) the torques in poses q, which are taken."""
        self.q = q
        self.inward()
        self.outward(lambda *_: None)
        return self.values

    def position(self, i: int) -> Floats:
        joint = self.of.model.bodies[i].joint
        return np.asarray(joint.multiplier * self.q[:, joint.coordinate] + joint.offset)

    def outward(self, choose: Callable[[int, Floats, Floats], float | None], tilts: bool = False) -> float:
        """Let each joint in turn `choose` its position, given g and w in its axes before its turn; return the largest
        gain, as a share of its row's amplitude."""
        of, model, gain, self.values = self.of, self.of.model, 0.0, np.zeros(len(self.rows))
        g, w = [self.g], [self.w]
        self._across(0, self.g, self.w)
        for i in range(1, len(model.bodies)):
            joint, parent = model.bodies[i].joint, model.parents[i]
            here_g, here_w = (product(of.inwards[i], each[parent]) for each in (g, w))
            gain = max(gain, choose(i, here_g, here_w) or 0.0)
            if joint.kind == "revolute":
                here_g, here_w = (_turned(each, self.position(i)) for each in (here_g, here_w))
            for k in self.about[i]:
                if self.rows[k][0].what == "torque":
                    own = np.cross(here_g[:, k], (0.0, 0.0, joint.multiplier))
                    slides = joint.kind == "prismatic"
                    here_w[:, k] += 0.0 if slides else own
                    asked = joint.multiplier * of.carried[i] * here_g[2, k] if slides else own @ self.h[i][:, k]
                    self.values[k] += asked
            self._across(i, here_g, here_w, tilts)
            g.append(product(of.axes[i].T, here_g))
            w.append(product(of.axes[i].T, here_w))
        return gain

    def _across(self, i: int, g: Floats, w: Floats, tilts: bool = False) -> None:
        """Choose, for rows about a bearing or the base, the direction e in which they count, and their w."""
        for k in self.about[i]:
            what, x = self.rows[k][0].what, g[:, k]
            if what == "torque":
                continue
            if what == "radial":
                along = x.copy()
            elif tilts:
                lattice = self.of.lattice
                ways = np.cross(x, lattice.directions.reshape(3, -1, lattice.columns)[:, lattice.rows // 2].T).T
                best = first_of_ties(lattice.at(self.of.support[i], lattice.mix(ways))[None])[0]
                along = lattice.directions.reshape(3, -1, lattice.columns)[:, lattice.rows // 2, best]
            elif i == 0 and not self.e[:, k].any() and w[:, k].any():
                along = np.cross(w[:, k], x)
            else:
                along = np.cross(self.h[i][:, k], x)
            along = along * (1.0, 1.0, 0.0)
            size = float(np.sqrt((along * along).sum()))
            self.e[:, k] = along / size if size > 0.0 else (1.0, 0.0, 0.0)
            if what != "radial":
                w[:, k] = np.cross(x, self.e[:, k])

    def best(self, i: int, g: Floats, w: Floats) -> float:
        """Give a joint that moves alone its best position in every row; return the largest gain."""
        of, joint, (low, high) = self.of, self.of.model.bodies[i].joint, self.of.ends[i]
        if of.sides(joint.rate) != (0,):
            return 0.0
        q, here, scale = self.q[:, joint.coordinate], self.position(i), of.scale
        if joint.kind == "prismatic":
            slope = of.carried[i] * w[2]
            best = np.where(slope > _NOTHING * scale, high, np.where(slope < -_NOTHING * scale, low, here))
            gain = slope * (best - here)
        else:
            (a, b), (c, d) = (g, self.v[i]), (w, self.h[i])
            cosine = a[0] * b[0] + a[1] * b[1] + c[0] * d[0] + c[1] * d[1]
            sine = a[1] * b[0] - a[0] * b[1] + c[1] * d[0] - c[0] * d[1]
            best = low + (arctan2(sine, cosine) - low) % (2.0 * np.pi)
            at_low, at_high = (cosine * np.cos(end) + sine * np.sin(end) for end in (low, high))
            best = np.where(best <= high, best, np.where(at_low > at_high, low, high))
            gain = cosine * (np.cos(best) - np.cos(here)) + sine * (np.sin(best) - np.sin(here))
        better = gain > _NOTHING * scale
        q[better] = (best[better] - joint.offset) / joint.multiplier
        return float(np.max(gain, initial=0.0)) / scale


def _turned(w: Floats, angle: Floats) -> Floats:
    """Rot(z, angle)^T w of vectors (3, N)."""
    x, y, z = w
    return np.array([np.cos(angle) * x + np.sin(angle) * y, np.cos(angle) * y - np.sin(angle) * x, z])
