"""Composite bodies: combined meshes, a link, a robot at a configuration; declared inertias beside those of shapes."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from robodyn.report.bodies import AXES, amounts, inertia_tables
from robodyn.report.check_words import check_line
from robodyn.report.document import Paragraph, Section, Table, paragraphs, remarks
from robodyn.report.table import number, printable
from robodyn.robot.masses.compare import UNCERTAIN, Comparison, Difference, LinkComparison
from robodyn.robot.masses.declared import LinkInertia, RobotInertia
from robodyn.robot.masses.shapes import LinkShapes
from robodyn.solids.composite_mass import Combination
from robodyn.solids.inertia.conversions import View
from robodyn.solids.inertia.properties import MassProperties
from robodyn.solids.inertia.validity import Validity, validity
from robodyn.support.floats import ranked

if TYPE_CHECKING:
    from robodyn.checks.check import Checked

_HEAD = ("mass [kg]", "share [%]")
_PLACED = tuple(f"{axis} [m]" for axis in AXES)
_COMPARED = (
    *("link", "difference [%]", "mass [kg]", "density [kg/m^3]", "centres apart [m]"),
    *("I_1 ratio", "I_2 ratio", "I_3 ratio", "remarks"),
)


def combination_sections(found: Combination, view: View) -> Iterator[Section]:
    """Yield the parts by mass, and the body that they make."""
    reach = float(np.abs(found.box).max())
    rows = [
        (part.name, *_weights(body, found.body), number(part.body.volume or 0.0), *_point(body, reach))
        for part, body in zip(found.parts, found.placed, strict=True)
    ]
    heaviest = ranked(range(len(rows)), [body.mass for body in found.placed].__getitem__)
    head = ("part", *_HEAD, "volume [m^3]", *_PLACED)
    repairs = [f"{part.name}: {step.what}" for part in found.parts for step in part.repairs]
    warnings = [f"{part.name}: {text}" for part in found.parts for text in part.warnings]
    yield [Paragraph(f"{len(rows)} meshes as one rigid body")]
    yield [Table("Parts by mass, with their centres of mass", head, [rows[k] for k in heaviest])]
    yield [amounts(found.body, reach, ", at an assumed density" if any(part.assumed for part in found.parts) else "")]
    yield from inertia_tables(found.body, view)
    yield [*remarks("repaired", repairs), *remarks("warning", [*warnings, *found.warnings])]


def robot_sections(found: RobotInertia, view: View, checked: Checked) -> Iterator[Section]:
    """Yield links by mass, the robot at its configuration in the frame of the base, and what a check says of it."""
    placed = [link.placed for link in found.links]
    reach = max(float(np.abs(body.com).max()) for body in placed)
    rows = [
        (link.name, *_weights(body, found.body), *_point(body, reach), f"{link.validity.slack:.3f}")
        for link, body in zip(found.links, placed, strict=True)
    ]
    heaviest = ranked(range(len(rows)), [body.mass for body in placed].__getitem__)
    at = ", ".join(f"{name} {value:.6g}" for name, value in found.at.items()) or "no joint moves"
    what = f"{found.massive} of {found.count} links with mass, in the frame of the base"
    yield paragraphs([f"{printable(found.file)}: robot '{printable(found.name)}', {what}", f"at {at}"])
    yield [
        Table(
            "Links by mass, with their centres of mass",
            ("link", *_HEAD, *_PLACED, "slack"),
            [rows[k] for k in heaviest],
        )
    ]
    yield [amounts(found.body, reach)]
    yield from inertia_tables(found.body, view)
    verdicts = [_physical(validity(found.body), " as a whole"), _checked(checked)]
    yield [*paragraphs(verdicts), *remarks("warning", found.warnings)]


def link_sections(file: str, found: LinkInertia, view: View, checked: Checked) -> Iterator[Section]:
    """Yield what a link declares, whether a body can be so, and what a check says of the link."""
    yield [Paragraph(f"{printable(file)}:{found.line}: link '{printable(found.name)}' as declared, in its own frame")]
    yield [amounts(found.body)]
    yield from inertia_tables(found.body, view)
    yield paragraphs([_physical(found.validity), _checked(checked)])


def link_shapes_sections(file: str, found: LinkShapes, view: View) -> Iterator[Section]:
    """Yield what the shapes of a link make."""
    what = f"link '{printable(found.name)}' from its <{found.kind}> shapes, in its own frame"
    yield [Paragraph(f"{printable(file)}:{found.line}: {what}")]
    yield [amounts(found.body, float(np.abs(found.shapes.box).max()), f", {found.weight}")]
    yield from inertia_tables(found.body, view)
    yield [Paragraph(_physical(validity(found.body))), *remarks("remark", found.shapes.remarks)]


def comparison_sections(found: Comparison) -> Iterator[Section]:
    """Yield a table, the most different link first; remarks link by link; what could not be compared, and why."""
    pairs = [(link, link.difference) for link in found.links if link.difference is not None]
    rest = [f"{link.name} (line {link.line}): {link.reason}" for link in found.links if link.difference is None]
    lines = [f"{link.name} (line {link.line}): {text}" for link in found.links for text in link.remarks]
    what = f"declared inertias against the <{found.kind}> shapes at the declared masses"
    of = f"{len(pairs)} of {len(found.links)} links"
    yield [Paragraph(f"{printable(found.file)}: robot '{printable(found.name)}', {what}, {of}")]
    if pairs:
        legend = (
            "difference: |I_declared - I_shapes| / |I_shapes| about the centres of mass; "
            "ratios: declared over shapes' principal moments"
        )
        yield [Table("", _COMPARED, [_row(link, difference) for link, difference in pairs]), Paragraph(legend)]
    for title, part in (("Remarks", lines), ("Not compared", rest)):
        yield paragraphs([title, *part] if part else [])


def _weights(body: MassProperties, whole: MassProperties) -> tuple[str, str]:
    return number(body.mass), f"{100 * body.mass / whole.mass:.1f}"


def _point(body: MassProperties, reach: float) -> tuple[str, ...]:
    return tuple(number(x, reach) for x in body.com)


def _checked(checked: Checked) -> str:
    listed = f" (robodyn check {shlex.quote(checked.files[0])})" if checked.findings else ""
    return f"check: {check_line(checked)}{listed}"


def _physical(found: Validity, which: str = "") -> str:
    """Return the verdict with its margin: I_1 + I_2 - I_3 over the largest moment, twice the least second moment."""
    small, middle, large = (number(moment) for moment in found.moments)
    margin = f"I_1 + I_2 - I_3 = {small} + {middle} - {large} kg m^2, {found.slack:.4f} of the largest"
    if found.faults:
        return f"not physical{which}: {'; '.join(found.faults)} ({margin})"
    return f"physical{which}: no second moment is negative ({margin})"


def _row(link: LinkComparison, found: Difference) -> tuple[str, ...]:
    count = len(link.remarks)
    return (
        link.name,
        f"{100 * found.inertia:.3g}" if found.inertia > UNCERTAIN else "0",
        number(found.body.mass),
        number(found.density),
        number(found.distance, max(map(abs, (*found.shapes.box.lo, *found.shapes.box.hi)))),
        *(number(ratio) for ratio in found.ratios),
        f"{count} below" if count else "-",
    )
