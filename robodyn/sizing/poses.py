"""Poses in which a robot that holds still has most to hold: the best of random ones, improved joint by joint.

In the angle of a joint that moves alone each part of a wrench is `a + b cos q + c sin q`, so that three positions give
its best one; so they nearly do, in a short range, where a spring acts or others follow.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import cos, sin

import numpy as np
from numpy.typing import NDArray

from robodyn.dynamics.plan import Plan, plan, ready
from robodyn.programs.program import Program
from robodyn.programs.vectors import arctan2, frame
from robodyn.robot.model import Model
from robodyn.scene.scene import DEFAULT, Payload, Scene
from robodyn.sizing.recursion import Key
from robodyn.support.floats import Floats, first_of_ties

Numbers = NDArray[np.intp]
_RANDOM = 2048
_NOISE = 1e-14
"""Of the largest value: what is less is no gain."""


class Poses:
    """What a robot at rest asks for, by key, in any pose."""

    def __init__(self, model: Model, keys: Sequence[Key], scene: Scene = DEFAULT, extra: Payload | None = None) -> None:
        """Args: extra: a payload that counts as often as `times` says."""
        self.model, self.keys, still = (
            model,
            keys,
            frozenset((what, k) for what in ("qd", "qdd") for k in range(model.n)),
        )
        scenes = [scene, *([replace(scene, payloads=(*scene.payloads, extra))] if extra else [])]
        program = Plan.torques if all(key.what == "torque" for key in keys) else _wrenches
        self._runners = [ready(program, plan(model, each, still)) for each in scenes]
        columns, across = [], []
        for what, place in keys:
            first = place if what == "torque" else model.n + 6 * place + (0 if what == "radial" else 3)
            columns.append([first] * 3 if what == "torque" else [first, first + 1, first + 2])
            axis = model.bodies[place].joint.axis if what != "torque" and place else (0.0, 0.0, 1.0)
            across.append([[1, 0, 0], [0, 0, 0]] if what == "torque" else frame(np.array(axis, float))[:2])
        self._columns, self._across = np.array(columns, dtype=np.intp), np.array(across, dtype=float)

    def parts(self, which: Numbers, q: Floats, times: float = 0.0) -> Floats:
        """Return (K, N, 2) what keys of these numbers (K,) ask for in poses (K, N, nq), or in the same for all (1, N,
        nq): a torque and 0, or x and y of a moment or force."""
        flat, zero = q.reshape(-1, q.shape[-1]), np.zeros((q[..., 0].size, self.model.n))
        sources = {"q": flat, "qd": zero, "qdd": zero, "columns": np.empty((len(flat), 0))}
        outputs = [each(sources, len(flat)) for each in self._runners]
        found = outputs[0] if len(outputs) == 1 else outputs[0] + times * (outputs[1] - outputs[0])
        picked = np.take_along_axis(found.reshape(*q.shape[:-1], -1), self._columns[which][:, None], axis=2)
        return np.asarray((picked[:, :, None] * self._across[which][:, None]).sum(axis=-1))

    def worst(
        self,
        which: Numbers,
        low: Floats,
        high: Floats,
        rest: Floats,
        times: float = 0.0,
        sweeps: int = 40,
        starts: int = 4,
    ) -> tuple[Floats, Floats]:
        """Return (K, nq) poses, between low and high, of the most that is found of these keys, and (K,) how much, a
        torque with its sign. Coordinates that do not matter are at rest (nq,).

        Args:
            sweeps: in which each joint is given its best position, at most.
            starts: from the random poses of the most to so many sides; 2 are enough for torques.
        """
        random = low + np.random.default_rng(0).random((_RANDOM, self.model.nq)) * (high - low)
        parts, moving = self.parts(which, random[None], times), np.flatnonzero(high > low).tolist()
        ways = [(cos(angle), sin(angle)) for angle in np.linspace(0.0, 2.0 * np.pi, starts, endpoint=False)]
        best = np.stack([first_of_ties((parts * way).sum(axis=2)) for way in ways], axis=1)
        noise = _NOISE * float(_length(parts).max())
        moved = np.repeat(random[:1], len(moving) + 1, axis=0)
        moved[np.arange(len(moving)), moving] = random[1, moving]
        changed = self.parts(which, moved[None], times)
        matters = np.zeros((len(which), self.model.nq), dtype=bool)
        matters[:, moving] = np.abs(changed[:, :-1] - changed[:, -1:]).max(axis=2) > noise
        rows, matters = np.repeat(which, starts), np.repeat(matters, starts, axis=0)
        q = np.where(matters, random[best].reshape(len(rows), -1), rest)
        values = _length(self.parts(rows, q[:, None], times))[:, 0]
        active = np.ones(len(rows), dtype=bool)
        for sweep in range(sweeps):
            before = values.copy()
            for k in moving:
                free = np.flatnonzero(active & matters[:, k])
                if not len(free):
                    continue
                tried = self._tried(rows[free], q[free], k, low[k], high[k], rest[k], times)
                found = _length(self.parts(rows[free], tried, times))
                chosen = first_of_ties(found)
                there = found[np.arange(len(free)), chosen]
                take = there > values[free] + np.where(np.ptp(found, axis=1) <= noise, -noise, noise)
                q[free[take], k], values[free[take]] = tried[take, chosen[take], k], there[take]
            active = values > before + 100.0 * noise
            if sweep >= 2:
                active &= values >= np.repeat(values.reshape(-1, starts).max(axis=1), starts) - noise
            if not active.any():
                break
        one = np.arange(len(which)) * starts + first_of_ties(values.reshape(-1, starts))
        found = self.parts(rows[one], q[one][:, None], times)[:, 0]
        torques = [self.keys[k].what == "torque" for k in which]
        return q[one], np.where(torques, found[:, 0], values[one])

    def _tried(self, which: Numbers, q: Floats, k: int, low: float, high: float, rest: float, times: float) -> Floats:
        """(K, 4, nq) poses with coordinate k at rest, at the ends of its range and where it is best, if alone."""
        step = max(min(2.0, 0.5 * (high - low)), 1e-3)
        tried = np.repeat(q[:, None], 4, axis=1)
        tried[:, 1, k] += step
        tried[:, 2, k] -= step
        parts = self.parts(which, tried, times)  # as many as will be tried: a workspace fits calls of one size
        here, after, before, _ = (parts * parts[:, :1]).sum(axis=2).T
        turn = arctan2((after - before) / (2.0 * sin(step)), (2.0 * here - after - before) / (2.0 - 2.0 * cos(step)))
        there = q[:, k] + turn
        there += 2.0 * np.pi * ((there < low) * 1.0 - (there > high))
        tried[:, :, k] = np.stack(
            [np.full(len(q), rest), np.clip(there, low, high), np.full(len(q), low), np.full(len(q), high)], axis=1
        )
        return tried


def _length(parts: Floats) -> Floats:
    return np.asarray(np.sqrt((parts * parts).sum(axis=-1)))


def _wrenches(a_plan: Plan) -> Program:
    return a_plan.wrenches(joints=True)
