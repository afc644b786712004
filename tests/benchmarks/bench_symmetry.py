"""Symmetry of the links of example-robot-data, and false verdicts: `cd tests && python -m benchmarks.bench_symmetry`.

Times are of the processor, from triangles in memory to planes and axes, the shorter of two turns. Meshes that are not
closed are left out, as the command refuses or repairs them. False verdicts are counted on bodies of known symmetry.
"""

from __future__ import annotations

import importlib.metadata
import time
import warnings
from collections import Counter
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
from helpers.machine import machine
from helpers.markdown_tables import main, table
from helpers.symmetry_cases import bodies

from robodyn.errors import MeshError
from robodyn.solids.mesh.asymmetry import CentredBody
from robodyn.solids.mesh.integrals import measure
from robodyn.solids.mesh.read.load import load_triangles
from robodyn.solids.mesh.symmetry import symmetry
from robodyn.solids.mesh.triangles import MemoryTriangles, Triangles

SUFFIXES = (".stl", ".obj", ".dae")
SIZES = (0, 1000, 3000, 10_000, 30_000, 100_000)
LARGEST = SIZES[-1]


def links() -> Iterator[Triangles]:
    """Closed meshes of example-robot-data, in memory."""
    files = importlib.metadata.files("example-robot-data") or []
    for path in sorted(Path(str(file.locate())) for file in files if file.suffix.lower() in SUFFIXES):
        try:
            triangles = load_triangles(path)
            integrals, edges = measure(triangles)
        except MeshError:
            continue
        if edges.closed and integrals.volume > 0 and triangles.count <= LARGEST:
            yield MemoryTriangles(corners=triangles.array(), **{**triangles.labels, "name": path.name})


def spent(triangles: Triangles) -> tuple[float, Counter[str]]:
    """Milliseconds, and how many planes have each verdict."""
    best = np.inf
    integrals, _ = measure(triangles)
    for _ in range(2):
        start = time.process_time()
        found = symmetry(CentredBody.of(triangles, integrals))
        best = min(best, time.process_time() - start)
    return best * 1e3, Counter(plane.verdict for plane in found.planes)


def distribution() -> str:
    counts, times, verdicts = [], [], Counter()
    for triangles in links():
        took, seen = spent(triangles)
        counts.append(triangles.count)
        times.append(took)
        verdicts += seen
    size, ms = np.array(counts), np.array(times)
    shown = []
    for low, high in [*pairwise(SIZES), (0, LARGEST)]:
        among = ms[(size >= low) & (size <= high)]
        if len(among):
            shown.append(
                (f"{low} to {high}", str(len(among)), *(f"{x:.1f}" for x in np.percentile(among, (50, 90, 100))))
            )
    told = ", ".join(f"{count} {verdict}" for verdict, count in verdicts.most_common())
    return f"{table(('triangles', 'links', 'median ms', '90 % below', 'largest'), shown)}\nPlanes: {told}.\n"


def report(bodies_told: int) -> str:
    warnings.simplefilter("ignore")
    shown = distribution()
    wrong, told = (sum(part) for part in zip(*(body.false_verdicts() for body in bodies(bodies_told)), strict=True))
    return f"{shown}\nFalse verdicts: {wrong} of {told} ({wrong / told:.2%}).\n\n{machine()}"


if __name__ == "__main__":
    main(report, __doc__, bodies_told=1000)
