"""A mesh measured by a new process: `cd tests && python -m benchmarks.bench_cold_mesh`.

`robodyn inertia` as a user calls it, with what it adds unasked to few triangles (symmetry, tessellation) and without;
trimesh; and libigl, where it is installed. All read the same binary STL of a torus, the processes take turns, and the
medians count, without the first turn. Peak memory is what the system tells of a process; those that start others count
for them at first, so that the mesh is made by a process of its own.
"""

from __future__ import annotations

import sys
import tempfile
from importlib.util import find_spec
from multiprocessing import get_context
from pathlib import Path
from statistics import median

from benchmarks.timing import of_process
from helpers.machine import machine
from helpers.markdown_tables import main, table
from helpers.mesh_samples import binary_stl, torus

OURS = "robodyn inertia"
_CLI = "from robodyn.cli.start import start; start()"
_IGL = "import sys, igl; print(igl.moments(*igl.read_triangle_mesh(sys.argv[1])[:2]))"
_START = "import sys, numpy, click"
CALLS = {
    OURS: (_CLI, "inertia"),
    "robodyn inertia --no-symmetry --no-tessellation": (_CLI, "inertia", "--no-symmetry", "--no-tessellation"),
    "trimesh.load(...).moment_inertia": ("import sys, trimesh; print(trimesh.load(sys.argv[1]).moment_inertia)",),
    "libigl moments": (_IGL,),
    "import numpy, click": (_START,),
}
SIZES = {10_000: (100, 50), 100_000: (500, 100), 1_000_000: (1000, 500), 5_000_000: (2500, 1000)}
"""Rings and sectors of the torus of so many triangles."""


def write(path: Path, rings: int, sectors: int) -> None:
    """A torus as a binary STL."""
    path.write_bytes(binary_stl(torus(2.0, 0.5, rings, sectors)))


def medians(path: Path, turns: int) -> dict[str, tuple[float, float]]:
    """Median time [s] and memory [MB] of every process that can run here."""
    calls = {name: call for name, call in CALLS.items() if "igl" not in call[0] or find_spec("igl")}
    commands = {name: [sys.executable, "-c", *call, str(path)] for name, call in calls.items()}
    rounds = [{name: of_process(command) for name, command in commands.items()} for _ in range(turns + 1)][1:]
    return {name: tuple(median(each[name][k] for each in rounds) for k in (0, 1)) for name in calls}


def report(turns: int, largest: int) -> str:
    parts = []
    with tempfile.TemporaryDirectory() as folder:
        for count, (rings, sectors) in SIZES.items():
            if count > largest:
                continue
            path = Path(folder) / f"{count}.stl"
            writer = get_context("spawn").Process(target=write, args=(path, rings, sectors))
            writer.start()
            writer.join()
            found = medians(path, turns)
            rows = [
                (f"`{name}`", f"{1e3 * spent:.0f} ms", f"{spent / found[OURS][0]:.2f}", f"{memory:.0f} MB")
                for name, (spent, memory) in found.items()
            ]
            parts.append(table((f"{count} triangles", "time", "ratio", "peak memory"), rows))
    return "\n".join(parts) + "\n" + machine("trimesh")


if __name__ == "__main__":
    main(report, __doc__, turns=5, largest=max(SIZES))
