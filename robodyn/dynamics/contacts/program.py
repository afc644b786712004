"""The programs of the dual: its value, its gradient and a Newton step at a place, traced once per number of points."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache

import numpy as np

from robodyn.dynamics.contacts.cones import Projected, projected
from robodyn.programs.program import Program, trace
from robodyn.programs.run.runner import Runner
from robodyn.programs.scalar import Tape
from robodyn.programs.vectors import Array, Scalar, total


def _inputs(tape: Tape, name: str, *shape: int) -> Array:
    return np.array([tape.input(name, k) for k in range(int(np.prod(shape)))], dtype=object).reshape(shape)


def _forces(tape: Tape, rows: int, points: int) -> tuple[Array, Array, list[Projected]]:
    """G by points, nu, and the forces P(G^T nu)."""
    G, nu = _inputs(tape, "G", rows, points, 3), _inputs(tape, "nu", rows)
    cosine, sine = _inputs(tape, "cosine", points), _inputs(tape, "sine", points)
    return G, nu, [projected(G[:, k].T @ nu, cosine[k], sine[k]) for k in range(points)]


def _step(tape: Tape, rows: int, points: int) -> Iterable[Scalar]:
    """psi = 1/2 sum |P(G^T nu)|^2 - b . nu + rho/2 |nu - c|^2, minus its gradient g, and (G D G^T + rho 1)^-1 of -g."""
    G, nu, found = _forces(tape, rows, points)
    b, rho = _inputs(tape, "b", rows), tape.input("rho", 0)
    away = nu - _inputs(tape, "centre", rows)
    value = 0.5 * total(x * x for each in found for x in each.f) - b @ nu + 0.5 * rho * (away @ away)
    down = b - total(G[:, k] @ each.f for k, each in enumerate(found)) - away * rho
    H = total(_curvature(G[:, k], each) for k, each in enumerate(found))
    return [value, *down, *_solved(H, rho, down)]


def _curvature(G: Array, point: Projected) -> Array:
    """G D G^T of one point, of which only the lower half is used."""
    a, c = G @ point.u, G @ point.v
    found: Array = (G @ G.T) * point.inside + np.outer(a * point.edge, a) + np.outer(c * point.turn, c)
    return found


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


def _widths(rows: int, points: int) -> dict[str, int]:
    return {"G": 3 * rows * points, "nu": rows, "centre": rows, "b": rows, "cosine": points, "sine": points, "rho": 1}


PROGRAMS = {"step": _step, "start": _start}


@lru_cache(maxsize=64)
def runner(kind: str, rows: int, points: int) -> Runner:
    """Return the program of a kind ("start", "step" or "forces"), ready to run on arrays of samples."""

    def outputs(tape: Tape) -> Iterable[Scalar]:
        if kind == "forces":
            return [x for each in _forces(tape, rows, points)[2] for x in each.f]
        return PROGRAMS[kind](tape, rows, points)

    program: Program = trace(outputs)
    return Runner(program, _widths(rows, points))
