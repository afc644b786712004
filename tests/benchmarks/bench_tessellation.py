"""What facets leave out of smooth solids, and its correction: `cd tests && python -m benchmarks.bench_tessellation`.

Errors are those of the inertia, relative to the largest exact principal moment: of the mesh, and of the corrected
numbers; each is the median over the poses, with the largest bar over error. Last, the time that it takes.
"""

from __future__ import annotations

import time

import numpy as np
from helpers.machine import machine
from helpers.markdown_tables import main, table
from helpers.smooth_solids import solids
from helpers.tessellation_errors import Case, case

from robodyn.solids.mesh.tessellation import line_masses

RESOLUTIONS = (12, 16, 24, 32, 64, 128)
HEAD = ("solid", "facets", "triangles", "error", "corrected", "ratio", "bar", "bar of corrected", "bars hold")


def measured(poses: int) -> list[list[Case]]:
    """For each solid and resolution the cases in all poses."""
    return [[case(solid, facets, seed) for seed in range(poses)] for solid in solids() for facets in RESOLUTIONS]


def row(found: list[Case]) -> tuple[str, ...]:
    first = found[0]
    errors = [np.median([one.inertia for one in found]), np.median([one.inertia_corrected for one in found])]
    bars = first.found.mesh.inertia, first.found.on_surface.inertia
    hold = sum(all(one.covered) for one in found)
    numbers = [f"{x:.1e}" for x in errors], [f"{x:.1e}" for x in bars]
    ratio = f"{errors[0] / errors[1]:.3g}"
    return first.solid, str(first.facets), str(first.triangles), *numbers[0], ratio, *numbers[1], f"{hold}/{len(found)}"


def summary(groups: list[list[Case]]) -> str:
    every = [one for group in groups for one in group]
    mesh, rest = np.mean([one.covered for one in every], axis=0)
    ratios = np.array([one.ratio for one in every])
    return (
        f"Median of error over corrected error: {np.median(ratios):.0f}; below 20 in {np.mean(ratios < 20):.0%}, "
        f"below 1 in {np.mean(ratios < 1):.0%} of {len(every)}. Bars of the mesh's numbers hold in {mesh:.1%}, "
        f"those of the corrected ones in {rest:.1%}.\n"
    )


def speed() -> str:
    """Nanoseconds per triangle, the shortest of five runs on the same solid at several sizes."""
    (solid,) = [one for one in solids() if one.name == "rounded disc"]
    shown = []
    for facets in (64, 256, 1024):
        corners = solid.mesh(facets)
        spent = []
        for _ in range(5):
            start = time.process_time()
            line_masses(corners)
            spent.append(time.process_time() - start)
        shown.append((str(len(corners)), f"{min(spent) / len(corners) * 1e9:.0f}"))
    return table(("triangles", "ns per triangle"), shown)


def report(poses: int) -> str:
    groups = measured(poses)
    shown = table(HEAD, [row(group) for group in groups])
    return f"{shown}\n{summary(groups)}\n{speed()}\n{machine()}"


if __name__ == "__main__":
    main(report, __doc__, poses=5)
