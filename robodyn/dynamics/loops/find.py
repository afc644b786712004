"""The loops of a scene found in a model: their ends, and which of their equations are independent."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from robodyn.dynamics.effects.effect import Sample
from robodyn.dynamics.loops.closed_chain import EXACT, ClosedChain
from robodyn.dynamics.loops.closure import GROUND_FRAME, Closure
from robodyn.dynamics.loops.equation import equations_of
from robodyn.dynamics.plan import Plan
from robodyn.dynamics.recursions.elimination import aligned
from robodyn.programs.vectors import product
from robodyn.robot.configuration import unit_rows
from robodyn.robot.model import Model
from robodyn.scene.parts import GROUND, Loop
from robodyn.support.floats import Floats

TRIALS = 6
"""Configurations at which equations are looked at."""
RANGE = 1.0
"""rad or m, by which these lie around q = 0."""
NOTHING = 1e-8
"""A smaller part of the largest is what rounding leaves of nothing, or a hinge that is meant to be parallel."""


@lru_cache(maxsize=16)
def closed_chain(plan: Plan) -> ClosedChain:
    """Return the closed chain of a model in a scene.

    Raises:
        InputError: nothing resists a joint.
    """
    chain = tied_chain(plan)
    largest = np.max([_sizes(chain, chain.sample(q)) for q in _trials(chain.model)], axis=0)
    return replace(chain, sizes=tuple(largest.tolist()))


@lru_cache(maxsize=16)
def tied_chain(plan: Plan) -> ClosedChain:
    """Return the closed chain of a model in a scene as it moves, whatever its masses; its `sizes` tell nothing.

    Equations that never change on their own, such as the one across the plane of a planar linkage, are found at
    configurations drawn at random: of the rows of J, side by side for all of them, the largest are kept one after
    another, each without what it has in common with those before it, until nothing is left.
    """
    model, scene = aligned(plan.model), plan.scene
    every = [closure_of(model, loop) for loop in scene.loops]
    sizes = [len(closure.equations) for closure in every]
    whole = ClosedChain(model, scene, tuple(every), (1.0,) * sum(sizes))
    rows = np.array([whole.jacobian(whole.sample(q)) for q in _trials(model)])
    kept: set[int] = set()
    for at, size in zip(np.cumsum([0, *sizes]).tolist(), sizes, strict=False):
        own = rows[:, at : at + size].transpose(1, 0, 2).reshape(size, -1)
        kept |= {at + k for k in independent(own)}
    return whole.keeping(kept)


def closure_of(model: Model, loop: Loop) -> Closure:
    """Return the loop with all its equations, its chains from the nearest body that carries both links."""
    ends = (
        model.links[loop.link],
        GROUND_FRAME if loop.to == GROUND and GROUND not in model.links else model.links[loop.to],
    )
    a, b = (_outward(model, end.body) for end in ends)
    common = sum(1 for i, j in zip(a, b, strict=False) if i == j)
    return Closure(loop, ends, (a[common:], b[common:]), equations_of(loop))


def _outward(model: Model, i: int) -> tuple[int, ...]:
    """Bodies from the base to body i; none for the ground."""
    path = []
    while i >= 0:
        path.append(i)
        i = model.parents[i]
    return tuple(reversed(path))


def independent(rows: Floats, nothing: float = NOTHING) -> list[int]:
    """The places of rows that span all but a part `nothing` of them, by elimination with the largest row first."""
    left, found = rows.copy(), []
    smallest = nothing * np.sqrt((rows * rows).sum(axis=1).max(initial=0.0))
    for _ in rows:
        sizes = np.sqrt((left * left).sum(axis=1))
        k = int(np.argmax(sizes * (1.0 - NOTHING * np.arange(len(rows)))))
        if sizes[k] <= smallest:
            break
        found.append(k)
        one = left[k] / sizes[k]
        left -= np.outer(product(left, one), one)
        left[k] = 0.0
    return sorted(found)


def _sizes(chain: ClosedChain, sample: Sample) -> Floats:
    """(equations,) lengths of the columns of C^-1 J^T, M being C C^T."""
    rows = chain.solver(sample, chain.inertial(sample), chain.equations(sample).J, EXACT).least.A
    squares = np.zeros(len(chain.sizes))
    for row in rows:
        for k, value in row.items():
            squares[k] += value * value
    return np.sqrt(squares)


def _trials(model: Model) -> list[tuple[float, ...]]:
    drawn = np.random.default_rng(0).uniform(-RANGE, RANGE, (TRIALS, model.nq))
    return [tuple(row.tolist()) for row in unit_rows(model, drawn)]
