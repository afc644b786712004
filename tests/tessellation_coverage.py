"""How often bars of tessellation hold: `cd tests && python -m tessellation_coverage` writes the page in docs/."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import astuple
from pathlib import Path
from typing import NamedTuple

import numpy as np
from helpers.markdown_tables import table
from helpers.round_shapes import KINDS, PLACES, TRIED, TUNED, Round, drawn

from robodyn.solids.inertia.laws import inertia_matrix
from robodyn.solids.mesh.asymmetry import CentredBody
from robodyn.solids.mesh.integrals import Integrals, integrate
from robodyn.solids.mesh.read.load import from_array
from robodyn.solids.mesh.tessellation import Bars, Tessellation, tessellation

ENOUGH = 0.95
PUBLISHED = range(5000, 5040)
"""Seeds of the published table: on none of them was anything tuned."""
EPS = 1e-9
"""Relative errors that rounding may make."""


class Errors(NamedTuple):
    """(3,) true relative errors of volume, inertia and centre, of the mesh and of the corrected numbers; the bars."""

    mesh: np.ndarray
    corrected: np.ndarray
    found: Tessellation

    def over(self, bars: Bars) -> np.ndarray:
        """(3,) over the bars of the mesh or of the corrected numbers; infinite bars hold."""
        true = self.mesh if bars is self.found.mesh else self.corrected
        return true / (np.array([bars.volume, bars.inertia, bars.centre]) + EPS)


def estimated(corners: np.ndarray, fixed_mass: bool = False) -> tuple[Integrals, Tessellation]:
    triangles = from_array(corners)
    integrals = integrate(triangles)
    body = CentredBody.of(triangles, integrals)
    return integrals, tessellation(body.line_masses, integrals, body.centre, fixed_mass=fixed_mass)


def errors(solid: Round, fixed_mass: bool = False) -> Errors:
    whole, found = estimated(solid.corners, fixed_mass)
    return Errors(*(_true(one, solid, fixed_mass) for one in (whole, found.corrected)), found)


def _true(found: Integrals, solid: Round, fixed_mass: bool) -> np.ndarray:
    arm = found.first / found.volume
    S = found.S - np.outer(arm, found.first)
    if fixed_mass:
        S = S * (solid.volume / found.volume)
    size = _largest(solid.S)
    centre = np.linalg.norm(found.reference + arm - solid.com) / (size / solid.volume) ** 0.5
    return np.array([abs(found.volume / solid.volume - 1), _largest(S - solid.S) / size, centre])


def _largest(S: np.ndarray) -> float:
    return float(np.abs(np.linalg.eigvalsh(inertia_matrix(S))).max())


class Coverage(NamedTuple):
    """Shares (3,) of solids in which bars of volume, inertia and centre hold: those of the mesh, of the corrected
    numbers, and of these if the corners are on the surface; the median error over the bar of the mesh's volume; and
    shares (2,) for which some bar of the mesh, of the corrected numbers is none, which then holds."""

    mesh: np.ndarray
    rest: np.ndarray
    on_surface: np.ndarray
    typical: float
    without: np.ndarray


def coverage(kind: str, seeds: Iterable[int]) -> Coverage:
    by_place: dict[str, list[Errors]] = {place: [] for place in PLACES}
    for seed in seeds:
        for place, found in by_place.items():
            found.append(errors(drawn(kind, seed, place)))
    every = [one for found in by_place.values() for one in found]
    return Coverage(
        np.mean([one.over(one.found.mesh) <= 1 for one in every], axis=0),
        np.mean([one.over(one.found.rest) <= 1 for one in every], axis=0),
        np.mean([one.over(one.found.on_surface) <= 1 for one in by_place["on"]], axis=0),
        float(np.median([one.over(one.found.mesh)[0] for one in every])),
        np.mean(
            [[not np.isfinite(astuple(bars)).all() for bars in (one.found.mesh, one.found.rest)] for one in every],
            axis=0,
        ),
    )


def row_of(kind: str) -> tuple[tuple[str, ...], float]:
    """The row of a kind in the document, and the least share in it."""
    half = "tuned on" if kind in TUNED else "tried" if kind in TRIED else "held out"
    found = coverage(kind, PUBLISHED)
    shares = found.mesh, found.rest, found.on_surface
    cells = (" ".join(f"{100 * x:.0f}" for x in share) for share in (*shares, found.without))
    return (kind, half, *cells, f"{found.typical:.2f}"), min(float(share.min()) for share in shares)


def page() -> str:
    """The text of the document."""
    head = ("solids", "", "mesh", "corrected", "corrected, corners on the surface", "no bar", "error / bar")
    rows = [row_of(kind)[0] for kind in KINDS]
    return _TEXT.format(table=table(head, rows, left=(0, 1)), solids=len(PUBLISHED))


_TEXT = """# How far facets leave a mesh from the round body it stands for

`robodyn inertia` prints, beside the numbers of the mesh as it is, those of the smooth body that its facets may stand
for, and how far either may be off. Nothing in a mesh tells whether an eight-sided prism is one or a coarse cylinder, so
both readings are given. Bars of the mesh and of the corrected numbers hold wherever the corners are: on the surface, as
CAD programs put them, outside of it so that facets touch it, or between; the narrower bars of the corrected numbers
hold if the corners are on it. Edges of more than 65 degrees between faces that are flat otherwise, and edges beside
which nothing else bends, are meant as they are. Where a bar would be more than the whole, there is none.

Below: the share in percent of random solids in which the bars of volume, inertia and centre of mass hold, {solids} of
each kind in each of three places of the corners, of 6 to 72 facets to a turn in any pose; in how many some bar of the
mesh, and of the corrected numbers, is none, which counts as holding; and the median of the error over the bar of the
mesh's volume. The numbers of the estimate were tuned on the first kinds, its rules come of the next ones as well, and
nothing comes of the held out ones. `python -m tessellation_coverage` in `tests/` writes this page, and
`tests/solids/mesh/test_tessellation.py` fails where a share is below 95.

{table}"""

if __name__ == "__main__":
    document = Path(__file__).parents[1] / "docs" / "tessellation.md"
    document.write_text(page(), encoding="utf-8")
