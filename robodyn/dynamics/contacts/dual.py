"""The least contact forces of whole blocks of samples, by Newton's method on the dual."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from robodyn.programs.program import trace
from robodyn.programs.run.runner import Runner
from robodyn.programs.scalar import Tape
from robodyn.programs.vectors import Array, Scalar, cross, sign, sqrt, total
from robodyn.support.floats import Floats, einsum

TINY = 1e-300


class Projected(NamedTuple):
    """The nearest point of the cone, and the derivative D = inside 1 + edge u u^T + turn v v^T of that by the point."""

    f: Array
    inside: Scalar
    edge: Scalar
    turn: Scalar
    u: Array
    v: Array


def projected(z: Array, normal: Array, cosine: Scalar, sine: Scalar) -> Projected:
    """The projection of z onto the cone |f_t| cos <= f_n sin of half angle atan(mu), mu = sine / cosine. Inside, 0, or
    onto the ray (z . u) u with u = sin e + cos n, e being the direction of the tangential part of z. A half space and a
    ray are cones too."""
    press = z @ normal
    tangential = z - normal * press
    t = sqrt(tangential @ tangential + TINY)
    inside = _positive(press * sine - t * cosine)
    along = press * cosine + t * sine
    edge = _positive(along) * (1.0 - inside)
    e = tangential / t
    u = e * sine + normal * cosine
    return Projected(z * inside + u * (edge * along), inside, edge, edge * along * sine / t, u, cross(normal, e))


def _positive(x: Scalar) -> Scalar:
    """1 where x > 0, else 0."""
    s = sign(x)
    return 0.5 * (s * (s + 1.0))


def _inputs(tape: Tape, name: str, *shape: int) -> Array:
    return np.array([tape.input(name, k) for k in range(int(np.prod(shape)))], dtype=object).reshape(shape)


def _projections(tape: Tape, rows: int, points: int) -> tuple[Array, Array, list[Projected]]:
    """Return G by points, nu, and the projections P(G^T nu)."""
    G, nu = _inputs(tape, "G", rows, points, 3), _inputs(tape, "nu", rows)
    normals = _inputs(tape, "normals", points, 3)
    cosine, sine = _inputs(tape, "cosine", points), _inputs(tape, "sine", points)
    return G, nu, [projected(G[:, k].T @ nu, normals[k], cosine[k], sine[k]) for k in range(points)]


def _forces(tape: Tape, rows: int, points: int) -> Iterable[Scalar]:
    """What is left of b, b - G f, and f = P(G^T nu)."""
    G, _, found = _projections(tape, rows, points)
    left = _inputs(tape, "b", rows) - total(G[:, k] @ each.f for k, each in enumerate(found))
    return [*left, *(x for each in found for x in each.f)]


def _step(tape: Tape, rows: int, points: int) -> Iterable[Scalar]:
    """psi = 1/2 sum |P(G^T nu)|^2 - b . nu + rho/2 |nu - c|^2, minus its gradient g, and (G D G^T + rho 1)^-1 of -g."""
    G, nu, found = _projections(tape, rows, points)
    b, rho = _inputs(tape, "b", rows), tape.input("rho", 0)
    away = nu - _inputs(tape, "centre", rows)
    value = 0.5 * total(x * x for each in found for x in each.f) - b @ nu
    value = value + 0.5 * rho * (away @ away)
    down = b - total(G[:, k] @ each.f for k, each in enumerate(found)) - away * rho
    H: Array = np.zeros((rows, rows))
    for k, point in enumerate(found):
        part, a, c = G[:, k], G[:, k] @ point.u, G[:, k] @ point.v
        H = H + (part @ part.T) * point.inside + np.outer(a * point.edge, a) + np.outer(c * point.turn, c)
    return [value, *down, *_solved(H, rho, down)]


def _start(tape: Tape, rows: int, points: int) -> Iterable[Scalar]:
    """The nu of the least forces without cones: (G G^T + rho 1)^-1 b, and once more what that leaves of b."""
    G, b, rho = _inputs(tape, "G", rows, 3 * points), _inputs(tape, "b", rows), tape.input("rho", 0)
    H = G @ G.T
    nu = np.array(_solved(H, rho, b))
    return list(nu + np.array(_solved(H, rho, b - H @ nu)))


def _solved(H: Array, rho: Scalar, b: Array) -> list[Scalar]:
    """(H + rho 1)^-1 b by the factorisation L D L^T, of the lower half of H."""
    n = len(b)
    L: list[list[Scalar]] = [[0.0] * n for _ in range(n)]
    D: list[Scalar] = []
    for i in range(n):
        for j in range(i):
            L[i][j] = (H[i, j] - total(L[i][k] * D[k] * L[j][k] for k in range(j))) / D[j]
        D.append(H[i, i] + rho - total(L[i][k] * L[i][k] * D[k] for k in range(i)))
    y: list[Scalar] = []
    for i in range(n):
        y.append(b[i] - total(L[i][k] * y[k] for k in range(i)))
    x = [y[i] / D[i] for i in range(n)]
    for i in reversed(range(n)):
        x[i] = x[i] - total(L[k][i] * x[k] for k in range(i + 1, n))
    return x


PROGRAMS = {"start": _start, "step": _step, "forces": _forces}


@lru_cache(maxsize=64)
def runner(kind: str, rows: int, points: int) -> Runner:
    """Return the program of a kind ("start", "step" or "forces"), ready to run on arrays of samples."""
    program = trace(lambda tape: PROGRAMS[kind](tape, rows, points))
    by_point = {"G": 3 * rows, "normals": 3, "cosine": 1, "sine": 1}
    widths = {name: width * points for name, width in by_point.items()}
    return Runner(program, {**widths, "nu": rows, "centre": rows, "b": rows, "rho": 1})


ENOUGH = 1e-4
"""The part of what a step promises that the function must fall by (Armijo)."""
FLATTER = 0.5
"""The slope where a search ends is at most this part of that where it began (Wolfe)."""
NARROW = 0.1
"""A search also ends where this part of the length is left, as at kinks of the slope."""
MARGIN = 0.1
"""The part of what is left that each look at least takes away."""
TOWARDS = 0.2
"""Where to look between the ends once the same one has moved twice."""


class Search(NamedTuple):
    """Of each sample: the slope where the step begins, the length to look at, the ends between which the slope is 0,
    the slopes there, and the end that moved last, 1 or -1; 0: none has."""

    slope: Floats
    length: Floats
    low: Floats
    high: Floats
    slope_low: Floats
    slope_high: Floats
    side: Any


def begun(slope: Floats) -> Search:
    """Return the search along steps of length 1."""
    zero, one = np.zeros_like(slope), np.ones_like(slope)
    return Search(slope, one, zero, one, slope, zero, zero)


def narrowed(search: Search, slope: Floats, lower: Any) -> Search:
    """Return the search after a look: where a line between the slopes is 0, or nearer to an end that stays. `lower` is
    whether the function fell by enough at a point of this slope."""
    right = (slope >= 0.0) | ~lower
    side = np.where(right, 1.0, -1.0)
    low, high = np.where(right, search.low, search.length), np.where(right, search.length, search.high)
    slope_low, slope_high = np.where(right, search.slope_low, slope), np.where(right, slope, search.slope_high)
    left = high - low
    with np.errstate(all="ignore"):
        zero = np.nan_to_num(low + left * slope_low / (slope_low - slope_high), nan=0.0)
    length = np.clip(zero, low + MARGIN * left, high - MARGIN * left)
    length = np.where(side == search.side, low + TOWARDS * left, length)
    return Search(search.slope, length, low, high, slope_low, slope_high, side)


FEASIBLE = 1e-9
"""Of |b|: a larger residual says that the equations have no solution inside the cones."""
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

    G: (R 3 K, N), row by row; b: (R, N); normals: (3 K, N); cosine, sine: (K, N), of the half angles atan(mu).
    """

    G: Floats
    b: Floats
    normals: Floats
    cosine: Floats
    sine: Floats

    def chosen(self, samples: Any) -> Cones:
        return Cones(*(np.ascontiguousarray(part[:, samples]) for part in self))


def least_forces(cones: Cones, executor: str = "auto", expected: int = 0) -> tuple[Floats, Floats]:
    """Return f (3 K, N) in the cones with G f = b and the least 1/2 |f|^2, and nu (R, N), by which f = P(G^T nu).

    Where there is none, 1/2 |f|^2 + 1/2 |b - G f|^2 / rho is least, rho = 1e-6. `executor`, `expected`: of
    `contact_forces`.

    Method: nu is where psi(nu) = 1/2 |P(G^T nu)|^2 - b . nu + 1/2 rho |nu - c|^2 is least, P being the projection onto
    the cones, by semismooth Newton steps with a search along each. First c = 0, and rho falls from 1e-2 to 1e-6; then c
    follows nu (the proximal point algorithm, Rockafellar 1976) and rho falls further, which takes the residual rho (nu
    - c) to rounding where forces exist.
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
    """Of each sample that is not done, its place among all, and `stage`, its place in SOFTNESS, or more. at, centre,
    step (R, N): nu, c and the step that is searched along; value, gradient, residual (N,): psi, |its gradient| and |b -
    G f| at nu; best: the residual where the stage began; soft (R, N): nu at the end of the last stage of SOFTNESS."""

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
        soft = SOFTNESS[np.minimum(self.stage, LAST)] * SHRINK ** np.maximum(self.stage - LAST, 0)
        return np.asarray(np.maximum(soft, HARDEST))


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
        lower = state.value - value >= ENOUGH * search.length * np.abs(search.slope)
        flat = np.abs(slope) <= FLATTER * np.abs(search.slope)
        narrow = search.high - search.low <= NARROW * search.length
        good = lower & (flat | narrow | (search.length == 1.0)) | (gradient <= 0.5 * state.gradient)
        again, new = narrowed(search, slope, lower), begun(-_dot(down, ahead))
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
    return np.asarray(einsum("in,in->n", x, y))


def _size(x: Floats) -> Floats:
    return np.sqrt(_dot(x, x))
