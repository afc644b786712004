"""Moments of a mesh from the bytes of an STL: `cd tests && python -m benchmarks.bench_mesh_integral`.

All take turns on the same torus, and the shortest runs count. robodyn reads its bytes block by block; trimesh is given
the same bytes, and once more the corners as an array, as libigl is where it is installed. Long doubles and exact
integers are asked for on a mesh that does not need them. All have one thread: NumPy's calls on a block are so short
that a second one takes longer, because they wait for each other.
"""

from __future__ import annotations

import io
import time
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from helpers.machine import machine
from helpers.markdown_tables import main, table
from helpers.mesh_samples import binary_stl, torus

from robodyn.solids.mesh.closed import fingerprint, is_one_shell
from robodyn.solids.mesh.integrals import integrate, measure, swept
from robodyn.solids.mesh.kernel import volume_kernel
from robodyn.solids.mesh.read.load import load_triangles

OURS = "integral"
SLOW = 1000.0
"""Nanoseconds per triangle above which a way has one turn only."""


def ways(corners: np.ndarray, data: bytes, path: Path) -> dict[str, Callable[[], object]]:
    """Everything that is measured, by its name."""
    import trimesh

    path.write_bytes(data)
    triangles, streamed = load_triangles(data, file_type="stl"), load_triangles(path)
    return {
        OURS: lambda: integrate(triangles),
        "integral, from a file": lambda: integrate(streamed),
        "integral and proof of closedness": lambda: measure(triangles),
        "proof alone": lambda: fingerprint(triangles),
        "proof that it is one shell": lambda: is_one_shell(triangles),
        "reading alone": lambda: sum(len(block) for block in triangles.blocks()),
        "integral in long double": lambda: swept(triangles, volume_kernel, dtype=np.longdouble),
        "integral in exact integers": lambda: integrate(triangles, exact=True),
        "trimesh, from the bytes": lambda: trimesh.load(io.BytesIO(data), file_type="stl").moment_inertia,
        "trimesh, from an array": lambda: trimesh.triangles.mass_properties(corners),
        **_libigl(corners),
    }


def _libigl(corners: np.ndarray) -> dict[str, Callable[[], object]]:
    try:
        import igl
    except ImportError:
        return {}
    vertices = np.ascontiguousarray(corners.reshape(-1, 3))
    faces = np.arange(len(vertices)).reshape(-1, 3)
    return {"libigl, from an array": lambda: igl.moments(vertices, faces)}


def shortest(found: dict[str, Callable[[], object]], count: int, turns: int) -> dict[str, float]:
    """Nanoseconds per triangle of the shortest run of each."""
    best: dict[str, float] = {}
    for _ in range(turns):
        for name, run in found.items():
            if best.get(name, 0.0) > SLOW:
                continue
            if name in best:
                run()  # what the one before it has left in memory is not its fault
            start = time.perf_counter()
            run()
            spent = (time.perf_counter() - start) / count * 1e9
            best[name] = min(spent, best.get(name, spent))
    return best


def report(turns: int, rings: int) -> str:
    parts = []
    for factor in (100, 10, 1):
        corners = torus(2.0, 0.5, rings, max(rings // 2 // factor, 3)).astype(np.float32)
        with TemporaryDirectory() as folder:
            found = ways(corners.astype(np.float64), binary_stl(corners), Path(folder) / "torus.stl")
            best = shortest(found, len(corners), turns)
        rows = [(name, f"{spent:.1f}", f"{spent / best[OURS]:.2f}") for name, spent in best.items()]
        parts.append(table((f"{len(corners)} triangles", "ns per triangle", "ratio"), rows))
    return "\n".join(parts) + "\n" + machine("trimesh")


if __name__ == "__main__":
    main(report, __doc__, turns=7, rings=1000)
