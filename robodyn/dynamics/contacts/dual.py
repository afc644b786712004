"""The least contact forces of whole blocks of samples, by Newton's method on the dual."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

import numpy as np

from robodyn.dynamics.contacts.problem import FEASIBLE
from robodyn.dynamics.contacts.program import runner
from robodyn.dynamics.contacts.search import Search, begun, ended, narrowed
from robodyn.support.floats import Floats
from robodyn.support.sums import einsum

HARDEST = 1e-12
"""The least rho; that of the first look, where cones do not matter."""
SOFTNESS = np.array((1e-2, 1e-4, 1e-6))
"""rho of the stages; the last one's is what weighs forces against a residual that nothing can balance."""
LAST = len(SOFTNESS) - 1
SHRINK = 0.01
"""rho of each later stage over that of the one before."""
HALT = 0.9
"""These go on while the residual falls to this part of what it was, or less."""
NEAR = np.array((0.1, 0.1, 1e-9, 0.1))
"""A stage ends where psi's gradient is this part of the residual; the last number is for those that follow."""
ROUNDING = 1e-14
"""Of |b|: a residual that is rounding."""
INSIDE = 1e-13
"""Of |b|: a residual of forces that no cone cuts off."""
NOISE = 4e-15
"""Of |nu|: likewise."""
SHORTEST = 1e-10
"""A part of a step that is lost in rounding."""
STEPS = 200
"""So many looks of a sample are enough; of random ones all but one in a hundred take fewer than 40."""
KEPT = 0.7
"""Samples that are done go on with the others until no more than this part is left."""
LOOKS = 20
"""Looks of a typical sample, by which the executor is chosen."""


class Cones(NamedTuple):
    """G f = b of N samples with |b| = 1, f in the cones of K points; samples are the last axis.

    Attributes:
        G: (R 3 K, N), row by row, of which the columns of each point count times its scale.
        b: (R, N).
        normals: (3 K, N). cosine, sine: (K, N), of the half angles atan(mu). scale: (K, N).
    """

    G: Floats
    b: Floats
    normals: Floats
    cosine: Floats
    sine: Floats
    scale: Floats

    def chosen(self, samples: Any) -> Cones:
        """Return those of some samples."""
        return Cones(*(np.ascontiguousarray(part[:, samples]) for part in self))


def least_forces(cones: Cones, executor: str = "auto", expected: int = 0) -> tuple[Floats, Floats]:
    """Return f (3 K, N) in the cones with G f = b and the least 1/2 |f|^2, and nu (R, N), by which f = P(G^T nu).

    Where there is none, 1/2 |f|^2 + 1/2 |b - G f|^2 / rho is least, rho = 1e-6.

    Method: P is the projection onto the cones, and nu is where this convex function is least:
    psi(nu) = 1/2 |P(G^T nu)|^2 - b . nu + 1/2 rho |nu - c|^2, whose gradient is piecewise smooth: semismooth Newton
    steps with a search along each. First c = 0, and rho falls from 1e-2 to 1e-6; then c follows nu (the proximal
    point algorithm, Rockafellar 1976) and rho falls further, which takes the residual rho (nu - c) to rounding where
    forces exist.

    Args:
        executor, expected: as for `contact_forces`.
    """
    R, N = cones.b.shape

    def run(kind: str, part: Cones, **given: Floats) -> Floats:
        sources = {name: np.atleast_2d(values).T for name, values in (part._asdict() | given).items()}
        count = LOOKS * (expected or N)
        return runner(kind, R, len(part.cosine))(sources, part.b.shape[1], executor=executor, expected=count).T

    nu = run("start", cones, rho=np.full(N, HARDEST))
    out = run("forces", cones, nu=nu)
    outside = np.flatnonzero(_size(out[:R]) > INSIDE)
    if len(outside):
        part = cones.chosen(outside)
        nu[:, outside] = _least(part, nu[:, outside], run)
        out[:, outside] = run("forces", part, nu=nu[:, outside])
    return out[R:], nu


class _State(NamedTuple):
    """Of each sample that is not done: its place among all, and how far it is.

    Attributes:
        sample: (N,). stage: (N,), place in SOFTNESS, or more.
        at, centre, step: (R, N), nu, c and the step that is searched along.
        value, gradient, residual: (N,), psi, |its gradient| and |b - G f| at nu.
        best: (N,), the residual where the stage began. soft: (R, N), nu at the end of the last stage of SOFTNESS.
    """

    sample: Any
    stage: Any
    at: Floats
    centre: Floats
    step: Floats
    value: Floats
    gradient: Floats
    residual: Floats
    best: Floats
    soft: Floats

    @property
    def rho(self) -> Floats:
        later = np.maximum(self.stage - LAST, 0)
        found: Floats = np.maximum(SOFTNESS[np.minimum(self.stage, LAST)] * SHRINK**later, HARDEST)
        return found


def _least(cones: Cones, nu: Floats, run: Callable[..., Floats]) -> Floats:
    """Return nu (R, N) of samples that need friction or would pull, from a guess."""
    R, N = cones.b.shape
    zero, none, infinite = np.zeros((R, N)), np.zeros(N), np.full(N, np.inf)
    found, part = np.zeros((R, N)), cones
    state = _State(np.arange(N), np.zeros(N, dtype=int), nu, zero, zero, infinite, infinite, infinite, infinite, zero)
    search, going = begun(none), np.ones(N, dtype=bool)
    for _ in range(STEPS):
        trial = state.at + search.length * state.step
        out = run("step", part, nu=trial, centre=state.centre, rho=state.rho)
        state, search = _looked(state, search, trial, out)
        state, search, done = _next_stage(state, search)
        done &= going
        if done.any():
            found[:, state.sample[done]] = _final(state)[:, done]
            going &= ~done
        if np.count_nonzero(going) <= KEPT * len(going):
            if not going.any():
                return found
            part, search = part.chosen(going), Search(*(each[going] for each in search))
            state = _State(*(each[..., going] for each in state))
            going = going[going]
    found[:, state.sample[going]] = _final(state)[:, going]
    return found


def _final(state: _State) -> Floats:
    lost = (state.stage > LAST) & (state.residual > FEASIBLE)
    return np.where(lost, state.soft, state.at)


def _looked(state: _State, search: Search, trial: Floats, out: Floats) -> tuple[_State, Search]:
    """Return the state at the trials that end their searches, with new steps; the others look elsewhere."""
    R = len(trial)
    value, down, ahead = out[0], out[1 : 1 + R], out[1 + R :]
    gradient, slope = _size(down), -_dot(down, state.step)
    with np.errstate(invalid="ignore"):
        good = ended(search, slope, state.value - value) | (gradient <= 0.5 * state.gradient)
        again, new = narrowed(search, slope, state.value - value), begun(-_dot(down, ahead))
    search = Search(*_where(good, new, again))
    rest = down + state.rho * (trial - state.centre)
    reached = state._replace(at=trial, step=ahead, value=value, gradient=gradient, residual=_size(rest))
    return _State(*_where(good, reached, state)), search


def _next_stage(state: _State, search: Search) -> tuple[_State, Search, Any]:
    """Return the samples whose stage has ended in the next one, and which are done."""
    noise = np.maximum(ROUNDING, NOISE * _size(state.at))
    near = np.maximum(noise, NEAR[np.minimum(state.stage, LAST + 1)] * state.residual)
    over = ((search.length == 1.0) & (state.gradient <= near)) | (search.high - search.low < SHORTEST)
    done = over & (state.stage > LAST) & ((state.residual <= noise) | (state.residual > HALT * state.best))
    follows = over & (state.stage >= LAST)
    if not over.any():
        return state, search, done
    state = state._replace(
        stage=state.stage + over,
        centre=np.where(follows, state.at, state.centre),
        soft=np.where(over & (state.stage == LAST), state.at, state.soft),
        best=np.where(follows, state.residual, state.best),
        value=np.where(over, np.inf, state.value),
        gradient=np.where(over, np.inf, state.gradient),
        step=np.where(over, 0.0, state.step),
    )
    return state, Search(*_where(over, begun(np.zeros(len(over))), search)), done


def _where(good: Any, ones: Iterable[Any], others: Iterable[Any]) -> list[Any]:
    return [x if x is y else np.where(good, x, y) for x, y in zip(ones, others, strict=True)]


def _dot(x: Floats, y: Floats) -> Floats:
    found: Floats = einsum("in,in->n", x, y)
    return found


def _size(x: Floats) -> Floats:
    return np.sqrt(_dot(x, x))
