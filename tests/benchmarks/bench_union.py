"""Overlapping shells united in three ways: `cd tests && python -m benchmarks.bench_union`.

Two tori askew to each other. Errors are those of the volume against the union by `manifold3d`, which is exact.
Winding numbers are taken of the same shells without 2 % of their triangles. The shortest of some runs counts.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TypeVar

import numpy as np
from helpers.machine import machine
from helpers.markdown_tables import main, table
from helpers.mesh_samples import moved, torus

from robodyn.solids.mesh.columns import by_columns, by_winding_numbers
from robodyn.solids.mesh.holes import filled
from robodyn.solids.mesh.indexed import Indexed, merged
from robodyn.solids.mesh.integrals import integrate
from robodyn.solids.mesh.nesting import nested
from robodyn.solids.mesh.shells import wound
from robodyn.solids.mesh.triangles import MemoryTriangles
from robodyn.solids.mesh.union import united

T = TypeVar("T")
TURN = np.linalg.qr(np.array([(1.0, 2.0, 3.0), (-2.0, 1.0, 0.5), (0.3, 0.7, -1.0)]))[0]
MISSING = 0.02


def shells(rings: int) -> np.ndarray:
    """Two tori that overlap by a tenth of their volume: 2 rings^2 triangles."""
    one = torus(2.0, 0.7, rings, rings // 2)
    return np.concatenate([moved(one, R=TURN), moved(one, (1.2, 0.3, 0.4))])


def volume(mesh: Indexed) -> float:
    return integrate(MemoryTriangles("union", mesh.corners)).volume


def perforated(corners: np.ndarray) -> tuple[Indexed, np.ndarray]:
    """Without some triangles, and the caps of what is then missing."""
    keep = np.random.default_rng(0).random(len(corners)) > MISSING
    open_shells, _ = wound(merged(corners[keep]))
    whole = filled(open_shells).shells.mesh
    return open_shells.mesh, whole.faces[len(open_shells.mesh.faces) :]


def timed(run: Callable[[], T], turns: int) -> tuple[float, T]:
    """Shortest time in ms, and what was found."""
    best, found = np.inf, run()
    for _ in range(turns):
        start = time.perf_counter()
        found = run()
        best = min(best, time.perf_counter() - start)
    return best * 1e3, found


def rows(corners: np.ndarray, turns: int) -> list[tuple[str, str, str, str]]:
    """Way, time, error of the volume relative to that of the manifold union, and the error bar that is given."""
    mesh = merged(corners)
    nesting = nested(wound(mesh)[0])
    holey, caps = perforated(corners)
    spent, union = timed(lambda: united(nesting).mesh, turns)
    exact = volume(union)
    signed, doubled = timed(lambda: volume(mesh), turns)
    found = [
        ("signed sum, which counts twice", f"{signed:.0f}", f"{abs(doubled / exact - 1):.0e}", ""),
        ("union by manifold3d", f"{spent:.0f}", "", ""),
    ]
    for name, run in (
        ("columns", lambda: by_columns(mesh)),
        ("winding numbers, 2 % missing", lambda: by_winding_numbers(holey, caps)),
    ):
        spent, region = timed(run, turns)
        assert region is not None
        found.append((name, f"{spent:.0f}", f"{abs(region.volume / exact - 1):.0e}", f"{region.bar:.0e}"))
    return found


def report(turns: int) -> str:
    parts = []
    for rings in (84, 168):
        corners = shells(rings)
        parts.append(table((f"{len(corners)} triangles", "ms", "error", "bar"), rows(corners, turns)))
    return "\n".join(parts) + "\n" + machine("manifold3d")


if __name__ == "__main__":
    main(report, __doc__, turns=5)
