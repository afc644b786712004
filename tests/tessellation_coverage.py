"""How often bars of tessellation hold: `cd tests && python -m tessellation_coverage` writes the page in docs/."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import astuple, dataclass
from pathlib import Path

import numpy as np
from helpers.markdown_tables import table
from helpers.round_shapes import KINDS, PLACES, TRIED, TUNED, drawn
from helpers.tessellation_errors import Errors, errors

ENOUGH = 0.95
PUBLISHED = range(5000, 5040)
"""Seeds of the published table: on none of them was anything tuned."""


@dataclass(frozen=True)
class Coverage:
    """Shares (3,) of solids in which bars of volume, inertia and centre hold.

    Attributes:
        mesh: of the mesh's own numbers. rest: of the corrected ones. on_surface: of these, if the corners are there.
        typical: median over the solids of the error over the bar of the mesh's volume.
        without: (2,) shares of solids for which some bar of the mesh, of the corrected numbers is none; it then holds.
    """

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
