"""Loading meshes, ns per triangle, against trimesh in one run.

    cd tests && python -m benchmarks.bench_mesh_loading [--rings N] [--turns N] [--write FILE]

A torus of 200 `rings` triangles in every format, in memory; both take turns and the fastest turn counts. robodyn goes
through all its blocks, trimesh gathers the corners of its mesh once. What trimesh reads for robodyn (DAE, GLB, 3MF) is
there for completeness. The peak memory is that of a new process that goes through a binary STL of 5 000 000 triangles;
Linux tells it.
"""

from __future__ import annotations

import io
import subprocess
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import trimesh
from helpers.machine import machine
from helpers.markdown_tables import main, table
from helpers.mesh_files import ascii_stl, dae, glb, indexed, obj, off, ply, three_mf
from helpers.mesh_samples import binary_stl, torus

from robodyn.solids.mesh.read.load import load_triangles

HEAD = ("format", "bytes per triangle", "robodyn", "trimesh", "ratio")
LARGE = 5_000_000
PEAK = """
import sys
from robodyn.solids.mesh.read.load import load_triangles
sum(len(block) for block in load_triangles(sys.argv[1]).blocks())
print(next(line.split()[1] for line in open("/proc/self/status") if line.startswith("VmHWM")))
"""


def files(rings: int) -> Mapping[str, tuple[str, bytes]]:
    """Type and bytes of the same mesh, by what is special about it."""
    ring = torus(rings=rings, sectors=100)
    vertices, faces = indexed(ring)
    plain = trimesh.Trimesh(vertices, faces, process=False)
    mixed = [*faces[:-1].tolist(), [*faces[-1].tolist(), 0]]
    return {
        "STL, binary": ("stl", binary_stl(ring)),
        "STL, ASCII, 7 digits": ("stl", ascii_stl(ring, number="%.6e")),
        "STL, ASCII, 17 digits": ("stl", ascii_stl(ring)),
        "OBJ, 6 decimals": ("obj", obj(ring, number="%.6f")),
        "OBJ, 6 decimals, `f v/t/n`": ("obj", obj(ring, "{0}/{0}/{0}", "%.6f")),
        "OBJ, 17 digits": ("obj", obj(ring)),
        "PLY, ASCII": ("ply", plain.export(file_type="ply", encoding="ascii")),
        "PLY, binary": ("ply", plain.export(file_type="ply")),
        "PLY, binary, polygons of two sizes": ("ply", ply(vertices, mixed, "<", "f4")),
        "OFF": ("off", off(ring, "%.9g")),
        "DAE": ("dae", dae(ring)),
        "GLB": ("glb", glb(ring)),
        "3MF": ("3mf", three_mf(ring)),
    }


def by_robodyn(data: bytes, kind: str) -> int:
    return sum(len(block) for block in load_triangles(data, file_type=kind).blocks())


def by_trimesh(data: bytes, kind: str) -> int:
    try:
        scene = trimesh.load(io.BytesIO(data), file_type=kind, force="scene", process=False)
    except ValueError:
        return 0
    return sum(len(mesh.triangles) for mesh in scene.geometry.values())


def fastest(acts: tuple[Callable[[bytes, str], int], ...], data: bytes, kind: str, turns: int) -> list[float]:
    """ns per triangle of each, in turns; infinity for one that fails."""
    best = [np.inf] * len(acts)
    for _ in range(turns):
        for k, act in enumerate(acts):
            start = time.perf_counter()
            count = act(data, kind)
            if count:
                best[k] = min(best[k], (time.perf_counter() - start) / count * 1e9)
    return best


def peak_megabytes() -> int:
    part = binary_stl(torus(rings=500, sectors=50))[84:]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "large.stl"
        with path.open("wb") as stream:
            stream.write(bytes(80) + LARGE.to_bytes(4, "little"))
            for _ in range(LARGE // (len(part) // 50)):
                stream.write(part)
        done = subprocess.run([sys.executable, "-c", PEAK, path], capture_output=True, text=True, check=True)
    return int(done.stdout) // 1024


def report(rings: int, turns: int) -> str:
    rows = []
    for name, (kind, data) in files(rings).items():
        ours, theirs = fastest((by_robodyn, by_trimesh), data, kind, turns)
        size = f"{len(data) / (200 * rings):.0f}"
        peer = (f"{theirs:.0f} ns", f"{theirs / ours:.1f}") if np.isfinite(theirs) else ("fails", "")
        rows.append((name, size, f"{ours:.0f} ns", *peer))
    memory = f"Peak memory at {LARGE} triangles of binary STL: {peak_megabytes()} MB.\n"
    return "\n".join((table(HEAD, rows), memory, machine("trimesh")))


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    main(report, __doc__, rings=1000, turns=5)
