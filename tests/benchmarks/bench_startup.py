"""New processes: `cd tests && python -m benchmarks.bench_startup`.

With `--meshes 5000000` they measure meshes of up to so many triangles; without, a cold start stands beside imports that
it cannot do without. Of meshes, `robodyn inertia` is called with what it adds unasked to few triangles (symmetry,
tessellation) and without; trimesh; and libigl, where it is installed. All read the same binary STL of a torus. The
processes take turns, so that all meet the same load, and the medians count, without the first turn, which writes
bytecode to a temporary folder, as that of an installed package is. Peak memory is what the system tells of a process;
those that start others count for them at first, so that the mesh is made by a process of its own.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Mapping
from functools import partial
from importlib.util import find_spec
from multiprocessing import get_context
from pathlib import Path

from benchmarks.timing import in_turns, medians_of, of_process
from helpers.machine import machine
from helpers.markdown_tables import main, table
from helpers.mesh_samples import binary_stl, torus

ROBOTS = Path(__file__).parent.parent.parent / "robots"
JOB = (
    "import sys; from robodyn.cli.start import start; "
    f"sys.argv = ['robodyn', 'torques', {str(ROBOTS / 'scara.urdf')!r}, "
    f"{str(ROBOTS / 'scara_pick_and_place.csv')!r}, '--out', sys.argv[1]]; start()"
)
REFERENCE = 'python -c "import numpy, click"'
CODES = {
    'python -c "pass"': "pass",
    REFERENCE: "import numpy, click",
    "robodyn torques scara.urdf scara_pick_and_place.csv --out tau.csv": JOB,
}
OURS = "robodyn inertia"
_CLI = "from robodyn.cli.start import start; start()"
_IGL = "import sys, igl; print(igl.moments(*igl.read_triangle_mesh(sys.argv[1])[:2]))"
CALLS = {
    OURS: (_CLI, "inertia"),
    "robodyn inertia --no-symmetry --no-tessellation": (_CLI, "inertia", "--no-symmetry", "--no-tessellation"),
    "trimesh.load(...).moment_inertia": ("import sys, trimesh; print(trimesh.load(sys.argv[1]).moment_inertia)",),
    "libigl moments": (_IGL,),
    "import numpy, click": ("import sys, numpy, click",),
}
SIZES = {10_000: (100, 50), 100_000: (500, 100), 1_000_000: (1000, 500), 5_000_000: (2500, 1000)}
"""Rings and sectors of the torus of so many triangles."""


def write(path: Path, rings: int, sectors: int) -> None:
    """A torus as a binary STL."""
    path.write_bytes(binary_stl(torus(2.0, 0.5, rings, sectors)))


def measured(calls: Mapping[str, tuple[str, ...]], argument: str, turns: int) -> dict[str, tuple[float, float]]:
    """Median time [s] and memory [MB] of every process."""
    with tempfile.TemporaryDirectory() as folder:
        commands = {name: [sys.executable, "-c", *call, argument] for name, call in calls.items()}
        started = {name: partial(of_process, command, PYTHONPYCACHEPREFIX=folder) for name, command in commands.items()}
        return {name: medians_of(found) for name, found in in_turns(started, turns).items()}


def of_meshes(turns: int, largest: int) -> str:
    parts, calls = [], {name: call for name, call in CALLS.items() if "igl" not in call[0] or find_spec("igl")}
    with tempfile.TemporaryDirectory() as folder:
        for count, (rings, sectors) in SIZES.items():
            if count > largest:
                continue
            path = Path(folder) / f"{count}.stl"
            writer = get_context("spawn").Process(target=write, args=(path, rings, sectors))
            writer.start()
            writer.join()
            found = measured(calls, str(path), turns)
            rows = [
                (f"`{name}`", f"{1e3 * spent:.0f} ms", f"{spent / found[OURS][0]:.2f}", f"{memory:.0f} MB")
                for name, (spent, memory) in found.items()
            ]
            parts.append(table((f"{count} triangles", "time", "ratio", "peak memory"), rows))
    return "\n".join(parts) + "\n" + machine("trimesh")


def report(turns: int, meshes: int) -> str:
    if meshes:
        return of_meshes(min(turns, 5), meshes)
    with tempfile.TemporaryDirectory() as folder:
        found = measured({name: (code,) for name, code in CODES.items()}, f"{folder}/tau.csv", turns)
    rows = [
        (f"`{name}`", f"{1e3 * time:.0f} ms", f"{time / found[REFERENCE][0]:.2f}") for name, (time, _) in found.items()
    ]
    return table(("process", "median", "ratio"), rows) + "\n" + machine("click")


if __name__ == "__main__":
    main(report, __doc__, turns=21, meshes=0)
