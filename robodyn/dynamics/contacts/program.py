"""The programs of the dual: its value, its gradient and a Newton step at a place, traced once per number of points."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache

import numpy as np

from robodyn.dynamics.contacts.cones import Projected, projected
from robodyn.programs.program import trace
from robodyn.programs.run.runner import Runner
from robodyn.programs.scalar import Tape
from robodyn.programs.vectors import Array, Scalar, total


def _inputs(tape: Tape, name: str, *shape: int) -> Array:
    return np.array([tape.input(name, k) for k in range(int(np.prod(shape)))], dtype=object).reshape(shape)


def _projections(tape: Tape, rows: int, points: int) -> tuple[Array, Array, list[Projected]]:
    """Return G by points, each times its scale, nu, and the projections P(G^T nu)."""
    G, nu = _inputs(tape, "G", rows, points, 3), _inputs(tape, "nu", rows)
    G = G * _inputs(tape, "scale", points)[:, None]
    normals = _inputs(tape, "normals", points, 3)
    cosine, sine = _inputs(tape, "cosine", points), _inputs(tape, "sine", points)
    return G, nu, [projected(G[:, k].T @ nu, normals[k], cosine[k], sine[k]) for k in range(points)]


def _forces(tape: Tape, rows: int, points: int) -> Iterable[Scalar]:
    """What is left of b, b - G f, and f = P(G^T nu)."""
    G, _, found = _projections(tape, rows, points)
    return [*_left(tape, G, found), *(x for each in found for x in each.f)]


def _left(tape: Tape, G: Array, found: list[Projected]) -> Array:
    rest: Array = _inputs(tape, "b", len(G)) - total(G[:, k] @ each.f for k, each in enumerate(found))
    return rest


def _step(tape: Tape, rows: int, points: int) -> Iterable[Scalar]:
    """psi = 1/2 sum |P(G^T nu)|^2 - b . nu + rho/2 |nu - c|^2, minus its gradient g, and (G D G^T + rho 1)^-1 of -g."""
    G, nu, found = _projections(tape, rows, points)
    rho = tape.input("rho", 0)
    away = nu - _inputs(tape, "centre", rows)
    value = 0.5 * total(x * x for each in found for x in each.f) - _inputs(tape, "b", rows) @ nu
    value = value + 0.5 * rho * (away @ away)
    down = _left(tape, G, found) - away * rho
    H = total(_curvature(G[:, k], each) for k, each in enumerate(found))
    return [value, *down, *_solved(H, rho, down)]


def _curvature(G: Array, point: Projected) -> Array:
    """G D G^T of one point, of which only the lower half is used."""
    a, c = G @ point.u, G @ point.v
    found: Array = (G @ G.T) * point.inside + np.outer(a * point.edge, a) + np.outer(c * point.turn, c)
    return found


def _start(tape: Tape, rows: int, points: int) -> Iterable[Scalar]:
    """The nu of the least forces without cones: (G G^T + rho 1)^-1 b, and once more what that leaves of b."""
    G, scale = _inputs(tape, "G", rows, points, 3), _inputs(tape, "scale", points)
    b, rho = _inputs(tape, "b", rows), tape.input("rho", 0)
    G = (G * scale[:, None]).reshape(rows, 3 * points)
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
    by_point = {"G": 3 * rows, "normals": 3, "cosine": 1, "sine": 1, "scale": 1}
    widths = {name: width * points for name, width in by_point.items()}
    return Runner(program, {**widths, "nu": rows, "centre": rows, "b": rows, "rho": 1})
