"""What meshes, links and robots weigh, as reports for people."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import PurePath
from typing import TYPE_CHECKING

import numpy as np

from robodyn.errors import MeshError
from robodyn.programs.vectors import product
from robodyn.report.check_words import check_line, check_verdict
from robodyn.report.document import (
    Block,
    Document,
    Download,
    Facts,
    Figure,
    Gallery,
    Heading,
    Level,
    Verdict,
    downloads,
)
from robodyn.report.json_inertia import inertia_json
from robodyn.report.table import Page, number, printable
from robodyn.report.text_blocks import blocks_of
from robodyn.report.text_inertia import inertia_text
from robodyn.solids.inertia.properties import MassProperties
from robodyn.solids.inertia.validity import validity
from robodyn.solids.inertia.view import View
from robodyn.solids.mesh_mass import Part
from robodyn.support.floats import Floats

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

    from robodyn.checks.run import Checked

_SIZE = 420
_HOW = "robodyn inertia --format json prints it"


def parts_page(outcomes: Sequence[Part | MeshError], view: View, shapes: Sequence[Floats | None]) -> Document:
    """What each mesh encloses, and how far the numbers hold; and why meshes failed.

    Args:
        shapes: the triangles (m, 3, 3) of each part [m], None for those without a picture.
    """
    parts = [each for each in outcomes if isinstance(each, Part)]
    failures = [each for each in outcomes if isinstance(each, MeshError)]
    names = ", ".join(part.name for part in parts)
    blocks: list[Block] = [_failures(failures, len(outcomes))] if failures else []
    blocks.append(_verdict(parts))
    for k, (part, triangles) in enumerate(zip(parts, shapes, strict=True)):
        if len(outcomes) > 1:
            blocks.append(Heading(printable(part.name)))
        blocks.append(_weights(part.body))
        if triangles is not None:
            blocks.append(
                Gallery((body_figure(printable(PurePath(part.name).name), part.body, triangles, f"mesh {k}"),))
            )
        blocks += _numbers(partial(inertia_text, [part], view))
    blocks += _data("inertia.json", inertia_json(outcomes, view))
    title = PurePath(parts[0].name).name if len(outcomes) == 1 else "Meshes"
    return Document(title, f"Mass properties: {names}", tuple(blocks))


def body_page(
    title: str,
    what: str,
    body: MassProperties,
    doubts: Sequence[str],
    write: Callable[[Page], str],
    data: str,
    figures: Sequence[Figure] = (),
    checked: Checked | None = None,
) -> Document:
    """One rigid body: whether it can exist, what it weighs, and the figures of the text.

    Args:
        doubts: what is doubtful about it.
        write: the text report on a page; data: the JSON report.
        checked: what a check found in the description that it is declared in.
    """
    blocks: list[Block] = [_possible(body, doubts, checked), _weights(body)]
    if figures:
        blocks.append(Gallery(tuple(figures)))
    blocks += [Heading("In numbers"), *_numbers(write), *_data("inertia.json", data)]
    return Document(title, what, tuple(blocks))


def _possible(body: MassProperties, doubts: Sequence[str], checked: Checked | None) -> Verdict:
    """Whether a body can exist; no better than what the check says of its description."""
    faults = validity(body).faults if body.mass or body.S_c.any() else ()
    if checked is not None:
        if not checked.fit:
            found = check_verdict(checked)
            return replace(found, reasons=(*found.reasons, *faults, *doubts))
        if checked.findings:
            doubts = (*doubts, f"robodyn check: {check_line(checked)}.")
    if faults:
        return Verdict("bad", "No body can have this mass and inertia", (*faults, *doubts))
    sure = "Physically possible"
    return Verdict("doubtful", f"{sure}, with doubts", tuple(doubts)) if doubts else Verdict("good", sure)


def comparison_page(
    title: str, differences: Sequence[float], count: int, write: Callable[[Page], str], data: str
) -> Document:
    """Declared inertias against those of shapes.

    Args:
        differences: of the links that could be compared, relative; count: of all links.
    """
    far = sum(difference > _FAR for difference in differences)
    level: Level = "doubtful" if far else "good" if differences else "neutral"
    headline = f"{far} of {len(differences)} links differ from their shapes by more than {100 * _FAR:.0f} %"
    reasons = () if len(differences) == count else (f"{count - len(differences)} more links cannot be compared.",)
    blocks = [Verdict(level, headline, reasons), Heading("Links"), *blocks_of(write, "Declared against shapes")]
    return Document(title, "Declared inertias against shapes", (*blocks, *_data("comparison.json", data)))


_FAR = 0.1


def body_figure(name: str, body: MassProperties, triangles: Floats, key: str) -> Figure:
    """A solid with its mass centre and its principal axes."""
    from robodyn.report.figures import INK, SERIES, plot
    from robodyn.report.solids import PAPER, on_paper, paint, triad

    solids = on_paper([(0, triangles)])
    reach = float(np.ptp(triangles.reshape(-1, 3), axis=0).max())

    def draw(canvas: Canvas) -> None:
        axes = canvas.add_axes((0.0, 0.0, 1.0, 1.0))
        axes.set_axis_off()
        axes.set_aspect("equal", adjustable="datalim")
        if solids:
            paint(axes, solids)
        centre = product(PAPER, body.com)
        for k, axis in enumerate(body.principal.axes):
            across, up, _ = 0.3 * reach * product(PAPER, axis)
            ends = ((centre[0] - across, centre[0] + across), (centre[1] - up, centre[1] + up))
            axes.plot(*ends, color=SERIES[(1, 2, 5)[k]], linewidth=2, label=f"axis {k + 1}")
        axes.plot(centre[0], centre[1], marker="o", markersize=7, linestyle="none", color=INK, label="centre of mass")
        axes.margins(0.08)
        canvas.legend(loc="upper left", ncols=4, columnspacing=1.0)
        triad(canvas)

    moments = ", ".join(number(moment) for moment in body.principal.moments)
    alt = f"Picture of {name} with its centre of mass and its principal axes; principal moments {moments} kg m^2"
    return Figure(f"{name}: centre of mass and principal axes", alt, plot(_SIZE, _SIZE, draw, key))


def _failures(failures: Sequence[MeshError], count: int) -> Verdict:
    return Verdict("bad", f"{len(failures)} of {count} meshes failed", tuple(f"{each}." for each in failures))


def _verdict(parts: Sequence[Part]) -> Verdict:
    open_ones = [part for part in parts if not part.closed]
    doubts = [f"{printable(part.name)}: {text}." for part in parts for text in part.warnings]
    repairs = [f"{printable(part.name)}: repaired, {step.what}." for part in parts for step in part.repairs]
    error = max(max(part.arithmetic, part.rounding, part.union or 0.0) for part in parts)
    reasons = [f"The volume holds within {error:.0e} of itself, for the surface as the file has it.", *repairs, *doubts]
    if any(part.assumed for part in parts):
        reasons.append("The density is assumed: --density or --mass says what it is.")
    if open_ones:
        names = ", ".join(printable(part.name) for part in open_ones)
        return Verdict("bad", f"Not closed, so that the mass is not definite: {names}", tuple(reasons))
    if doubts or repairs:
        return Verdict("doubtful", "Mass and inertia, with repairs or doubts", tuple(reasons))
    return Verdict(
        "good", "Closed and without faults" if len(parts) == 1 else "All closed and without faults", tuple(reasons)
    )


def _weights(body: MassProperties) -> Facts:
    items = [("Mass", f"{number(body.mass)} kg", "")]
    for name, value, unit in (
        ("Volume", body.volume, "m^3"),
        ("Surface", body.area, "m^2"),
        ("Density", body.density, "kg/m^3"),
    ):
        if value is not None:
            items.append((name, f"{number(value)} {unit}", ""))
    size = float(np.sqrt(body.principal.moments.max() / body.mass)) if body.mass else 0.0
    centre = ", ".join(number(x, size) for x in body.com)
    return Facts((*items, ("Centre of mass", f"({centre}) m", "")))


def _numbers(write: Callable[[Page], str]) -> list[Block]:
    """What the text says beyond the facts at the top."""
    return [block for block in blocks_of(write, "Values") if not isinstance(block, Facts)]


def _data(name: str, text: str) -> list[Block]:
    return [Heading("Data"), downloads([Download(name, "application/json", text)], _HOW)]
