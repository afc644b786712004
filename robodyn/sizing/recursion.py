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

from collections.abc import Callable, Collection, Mapping, Sequence
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from robodyn.programs.vectors import arctan2, frame, length, product
from robodyn.robot.model import Model
from robodyn.scene.scene import DEFAULT, ExternalWrench, Scene
from robodyn.sizing.directions import Lattice
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


def weight_of(model: Model, scene: Scene = DEFAULT) -> Pull:
    """Return what pulls along gravity: bodies, payloads, buoyancy, forces along it."""
    size, direction = length(np.array(scene.gravity, dtype=float)), down(scene)
    force = np.array([body.inertia.m * size for body in model.bodies], dtype=float)
    moment = np.array([np.asarray(body.inertia.mc, float) * size for body in model.bodies])
    points = [(each.link, each.com, each.mass * size) for each in scene.payloads]
    points += [(each.link, each.centre, -scene.fluid_density * each.volume * size) for each in scene.immersed]
    points += [(each.link, each.point, float(np.dot(each.force, direction))) for each in scene.wrenches]
    for link, point, pull in points:
        body, R, p = model.links[link]
        force[body] += pull
        moment[body] += pull * (product(np.asarray(R, float), np.array(point, dtype=float)) + np.asarray(p, float))
    return Pull(direction, force, moment)


def down(scene: Scene) -> Floats:
    """The direction of gravity in the base's axes; -z where there is none."""
    g = np.array(scene.gravity, dtype=float)
    return g / length(g) if g.any() else np.array([0.0, 0.0, -1.0])


def along_gravity(wrench: ExternalWrench, scene: Scene) -> bool:
    """Whether a wrench is a force along gravity, whatever the pose."""
    force = np.array(wrench.force, dtype=float)
    aside = length(np.cross(force, down(scene)))
    return wrench.frame != "link" and not any(wrench.moment) and aside <= 1e-15 * length(force)


class Key(NamedTuple):
    """What is asked for: "torque" (place: the entry of tau), or of a joint's bearing, or the base as body 0, what is
    across its axis: "tilting" moment or "radial" force (place: the body)."""

    what: str
    place: int


Row = tuple[Key, int]
"""A key and a side: 1 of tau, -1 of -tau."""


class Recursion:
    """The recursion of one robot, pull and lattice.

    Attributes:
        most: of each key and side a bound of the most that weight, and springs, ask for [N m, N].
    """

    def __init__(
        self,
        model: Model,
        pull: Pull,
        low: Floats,
        high: Floats,
        lattice: Lattice,
        wanted: Collection[Key],
        springs: Mapping[str, tuple[float, float]] | None = None,
    ) -> None:
        """Args:
        low, high: (nq,) of each coordinate [rad or m]; an angle turns once at most, unless a spring or others follow.
        springs: stiffness and rest of joints, by name.
        """
        self.model, self.pull, self.low, self.high = model, pull, low, high
        self.lattice, self.wanted, self.springs = lattice, wanted, springs or {}
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
        # of the directions of the lattice of a body's parent on its own
        turns = [product(self.inwards[i], self.axes[parent].T) for i, parent in enumerate(parents)]
        self.mixes = [lattice.mix(product(turn, lattice.directions)) for turn in turns]
        self.support: list[Floats] = [np.empty(0)] * len(bodies)
        self.keys: list[list[Key]] = [[] for _ in bodies]
        self.values: list[Floats] = list(self.support)
        self._inward()
        self.most = self._outward()

    def position(self, i: int, q: Floats) -> float:
        joint = self.model.bodies[i].joint
        return float(joint.multiplier * q[joint.coordinate] + joint.offset)

    def _inward(self) -> None:
        lattice, bodies = self.lattice, self.model.bodies
        for i in reversed(range(len(bodies))):
            ways = product(self.axes[i].T, lattice.directions)
            support = product(self.pull.moment[i], ways)
            for k in range(i + 1, len(bodies)):
                if bodies[k].parent != i:
                    continue
                joint, weight, turned = bodies[k].joint, self.carried[k], self.support[k]
                if joint.kind == "revolute":
                    turned = lattice.turned(turned, *self.ends[k])
                support += weight * product(joint.p, ways) + lattice.at(turned, self.mixes[k])
                if joint.kind == "prismatic":
                    along = weight * product(product(joint.R, joint.axis), ways)
                    support += np.maximum(self.ends[k][0] * along, self.ends[k][1] * along)
            self.support[i] = support.reshape(lattice.rows + 1, lattice.columns)

    def _outward(self) -> dict[Row, float]:
        """Return what weight asks of joints, carried to the base, of gravity's direction and its opposite there."""
        lattice, parents = self.lattice, self.model.parents
        ways = np.stack([-self.pull.direction, self.pull.direction], axis=1)
        below: list[dict[Key, Floats]] = [{} for _ in parents]
        for i in reversed(range(1, len(parents))):
            for key, value in self._own(i).items():
                below[i][key] = below[i].get(key, 0.0) + value
            if not below[i]:
                continue
            self.keys[i], self.values[i] = [*below[i]], np.stack([*below[i].values()])
            passed, mix = self.values[i], self.mixes[i]
            if self.model.bodies[i].joint.kind == "revolute":
                passed = lattice.turned(passed, *self.ends[i])
            if not parents[i]:
                mix = lattice.mix(product(self.inwards[i], ways))
            for key, value in zip(self.keys[i], lattice.at(passed, mix), strict=True):
                there = value.reshape(self.support[0].shape) if parents[i] else value
                below[parents[i]][key] = below[parents[i]].get(key, 0.0) + there
        base = Key("tilting", 0)
        if base in self.wanted:
            below[0][base] = lattice.at(lattice.tilting(self.support[0]), lattice.mix(ways))
        most: dict[Row, float] = {}
        for key, values in below[0].items():
            for side, value in zip((1, -1), values.tolist(), strict=True):
                sprung = sum(
                    max(self.spring(i, end, side) for end in self.ends[i])
                    for i, body in enumerate(self.model.bodies)
                    if key == ("torque", body.joint.rate)
                )
                most[key, side] = value + sprung + ROUNDING * (self.scale + abs(sprung))
        return most

    @cached_property
    def scale(self) -> float:
        """More than all weight at its farthest reach asks for [N m, N]."""
        slides = (end for end, body in zip(self.ends, self.model.bodies, strict=True) if body.joint.kind == "prismatic")
        reach = 1.0 + self.model.reach + sum(max(map(abs, end)) for end in slides)
        return float(np.abs(self.pull.force).sum() * reach + np.abs(self.pull.moment).sum()) or 1.0

    @cached_property
    def shared(self) -> list[int]:
        """The coordinates that several joints follow."""
        owners = [body.joint.coordinate for body in self.model.bodies[1:] if body.joint.multiplier]
        return sorted({k for k in owners if owners.count(k) > 1})

    @cached_property
    def special(self) -> list[int]:
        """The coordinates in which a torque has no closed form: shared ones, or with a spring."""
        sprung = {body.joint.coordinate for body in self.model.bodies[1:] if body.joint.name in self.springs}
        return sorted({*self.shared, *sprung})

    def _own(self, i: int) -> dict[Key, Floats]:
        """Return what weight asks for at joint i, of the direction of gravity in the body's axes."""
        joint, lattice, support = self.model.bodies[i].joint, self.lattice, self.support[i]
        found: dict[Key, Floats] = {}
        if (key := Key("torque", joint.rate)) in self.wanted:
            level = np.cos(lattice.polar * np.arange(lattice.rows + 1))[:, None] + np.zeros(lattice.columns)
            one = self.carried[i] * level if joint.kind == "prismatic" else lattice.across(support)
            found[key] = abs(joint.multiplier) * (lattice.opposite(one) if joint.multiplier < 0.0 else one)
        if (key := Key("tilting", i)) in self.wanted:
            found[key] = lattice.tilting(support)
        if (key := Key("radial", i)) in self.wanted:
            found[key] = abs(self.carried[i]) * lattice.sine + np.zeros(lattice.columns)
        return found

    def spring(self, i: int, position: Any, side: Any) -> Any:
        """Return what the spring of joint i adds to `side` times the torque of its coordinate."""
        joint = self.model.bodies[i].joint
        stiffness, rest = self.springs.get(joint.name, (0.0, 0.0))
        return side * joint.multiplier * stiffness * (position - rest)

    def poses(self, rows: Sequence[Row], rest: Floats, sweeps: int = 40, levels: int = 4) -> tuple[Floats, Floats]:
        """Return (rows, nq) poses of the largest value of each key and side that is found, and these values: those of
        the maxima on the lattice; then, `sweeps` times at most, of each joint in turn its best position, where `a + b
        cos q + c sin q` has it; of coordinates without such a form the best of some, `levels` times finer each.
        Coordinates that do not matter are at `rest`."""
        state = _Rows(self, rows, np.tile(rest, (len(rows), 1)))
        chosen = np.zeros(state.q.shape, dtype=bool)

        def by_lattice(i: int, g: Floats, w: Floats) -> None:
            joint, (low, high) = self.model.bodies[i].joint, self.ends[i]
            kinds = {key: k for k, key in enumerate(self.keys[i])}
            kind = np.array([kinds.get(key, len(kinds)) for key, _ in rows])
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
                if rows[k][0] == ("torque", joint.rate):
                    found[row] += self.spring(i, tried, rows[k][1])
            state.q[free, joint.coordinate] = (tried[first_of_ties(found)] - joint.offset) / joint.multiplier
            chosen[free, joint.coordinate] = True

        state.outward(by_lattice, tilts=True)
        for _ in range(2 if self.special and levels > 1 else 1):
            for k in self.special:
                state.search(k, levels)
            for _ in range(sweeps):
                state.inward()
                if state.outward(state.best) <= _CONVERGED:
                    break
        return state.q, state.asked()

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

    def __init__(self, of: Recursion, rows: Sequence[Row], q: Floats) -> None:
        self.of, self.rows, self.q = of, rows, q
        self.sides = np.array([side for _, side in rows], dtype=float)
        self.g = -self.sides * of.pull.direction[:, None]
        self.e = np.zeros((3, len(rows)))
        self.values = np.zeros(len(rows))
        """(rows,) what is asked for, of the last of `outward`, of torques before it."""
        places: dict[Key, list[int]] = {}
        for k, (key, _) in enumerate(rows):
            places.setdefault(key, []).append(k)
        self.about = [
            [(key.what, np.array(places[key])) for key in self._keys(i) if key in places]
            for i in range(len(of.model.bodies))
        ]
        self.inward()

    def _keys(self, i: int) -> list[Key]:
        torques = [Key("torque", self.of.model.bodies[i].joint.rate)] if i else []
        return [*torques, Key("tilting", i), Key("radial", i)]

    def inward(self) -> None:
        """Find h and v of all bodies in all rows."""
        of, bodies, count = self.of, self.of.model.bodies, len(self.rows)
        moments = [product(turn, moment)[:, None] for turn, moment in zip(of.axes, of.pull.moment, strict=True)]
        self.h = [np.repeat(moment, count, axis=1) for moment in moments]
        self.v = [np.zeros((3, count)) for _ in bodies]
        for i in reversed(range(1, len(bodies))):
            joint, parent, h, v = bodies[i].joint, bodies[i].parent, self.h[i], self.v[i]
            for what, k in self.about[i]:
                e = np.outer((0.0, 0.0, joint.multiplier), np.ones(len(k))) if what == "torque" else self.e[:, k]
                straight = what == "radial" or (what == "torque" and joint.kind == "prismatic")
                v[:, k] += of.carried[i] * e if straight else np.cross(e, h[:, k], axis=0)
            back = product(of.axes[parent], of.inwards[i].T)
            if joint.kind == "revolute":
                h, v = _turned(h, -self.position(i)), _turned(v, -self.position(i))
            else:
                h = h + of.carried[i] * np.array([[0.0], [0.0], [1.0]]) * self.position(i)
            self.h[parent] += product(back, h) + of.carried[i] * product(of.axes[parent], joint.p)[:, None]
            self.v[parent] += product(back, v)

    def asked(self) -> Floats:
        """(rows,) what is asked for in the poses q."""
        self.inward()
        self.outward(lambda *_: None)
        return self.values

    def position(self, i: int) -> Floats:
        joint = self.of.model.bodies[i].joint
        return np.asarray(joint.multiplier * self.q[:, joint.coordinate] + joint.offset)

    def outward(self, choose: Callable[[int, Floats, Floats], float | None], tilts: bool = False) -> float:
        """Let each joint in turn `choose` its position, given g and w in its axes before its turn; return the largest
        gain, as a share of the scale. Rows about bearings and the base choose e: at first, `tilts`, by the lattice."""
        of, model, gain = self.of, self.of.model, 0.0
        self.values = np.zeros(len(self.rows))
        g, w = [self.g], [np.zeros_like(self.g)]
        self._across(0, g[0], w[0], tilts)
        for i in range(1, len(model.bodies)):
            joint, parent = model.bodies[i].joint, model.parents[i]
            here_g, here_w = (product(of.inwards[i], each[parent]) for each in (g, w))
            gain = max(gain, choose(i, here_g, here_w) or 0.0)
            if joint.kind == "revolute":
                here_g, here_w = (_turned(each, self.position(i)) for each in (here_g, here_w))
            for k in (k for what, k in self.about[i] if what == "torque"):
                if joint.kind == "prismatic":
                    self.values[k] += joint.multiplier * of.carried[i] * here_g[2, k]
                else:
                    own = np.cross(here_g[:, k], (0.0, 0.0, joint.multiplier), axisa=0).T
                    here_w[:, k] += own
                    self.values[k] += (own * self.h[i][:, k]).sum(axis=0)
                self.values[k] += of.spring(i, self.position(i)[k], self.sides[k])
            self._across(i, here_g, here_w, tilts)
            g.append(product(of.axes[i].T, here_g))
            w.append(product(of.axes[i].T, here_w))
        return gain

    def _across(self, i: int, g: Floats, w: Floats, tilts: bool) -> None:
        """Choose, for rows about a bearing or the base, the direction e in which they count, and their w."""
        lattice = self.of.lattice
        for what, k in self.about[i]:
            if what == "torque":
                continue
            x, h = g[:, k], self.h[i][:, k]
            along = x if what == "radial" else np.cross(h, x, axis=0)
            if what == "tilting" and tilts:
                level = lattice.directions.reshape(3, -1, lattice.columns)[:, lattice.rows // 2]
                ways = np.cross(x[:, :, None], level[:, None], axis=0)
                most = lattice.at(self.of.support[i], lattice.mix(ways.reshape(3, -1)))
                along = level[:, first_of_ties(most.reshape(len(k), -1))]
            along = along * [[1.0], [1.0], [0.0]]
            size = np.sqrt((along * along).sum(axis=0))
            e = np.where(size > 0.0, along / np.where(size > 0.0, size, 1.0), [[1.0], [0.0], [0.0]])
            self.e[:, k] = e
            if what == "radial":
                self.values[k] = abs(self.of.carried[i]) * size
            else:
                w[:, k] = np.cross(x, e, axis=0)
                self.values[k] = (w[:, k] * h).sum(axis=0)

    def search(self, k: int, levels: int) -> None:
        """Give one coordinate its best value among some, then among some near that, in all rows."""
        low, high = self.of.low[k], self.of.high[k]
        for level in range(1, levels + 1):
            steps = (high - low) * 8.0**-level * np.array(sorted(range(-8, 9), key=abs))
            tried = np.clip(self.q[:, k] + steps[:, None], low, high)
            many = np.tile(self.q, (len(steps), 1))
            many[:, k] = tried.ravel()
            values = _Rows(self.of, [*self.rows] * len(steps), many).asked().reshape(tried.shape)
            self.q[:, k] = tried[first_of_ties(values.T), np.arange(len(self.q))]

    def best(self, i: int, g: Floats, w: Floats) -> float:
        """Give a joint that moves alone its best position in every row; return the largest gain."""
        of, joint, (low, high) = self.of, self.of.model.bodies[i].joint, self.of.ends[i]
        if joint.coordinate in of.special or not joint.multiplier:
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
