"""What meshes, links and robots weigh, as reports for people."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import PurePath
from typing import TYPE_CHECKING

import numpy as np

from robodyn.errors import MeshError
from robodyn.programs.vectors import Array, product
from robodyn.report.bodies import amounts, inertia_sections
from robodyn.report.check_words import check_line, check_verdict
from robodyn.report.composite import (
    combination_sections,
    comparison_sections,
    link_sections,
    link_shapes_sections,
    robot_sections,
)
from robodyn.report.document import (
    Block,
    Document,
    Facts,
    Gallery,
    Heading,
    Level,
    Section,
    Verdict,
    data_blocks,
    on_page,
)
from robodyn.report.json.bodies import (
    combination_json,
    comparison_json,
    inertia_json,
    link_json,
    link_shapes_json,
    robot_json,
)
from robodyn.report.table import printable
from robodyn.robot.configuration import configuration
from robodyn.robot.load import assemble
from robodyn.robot.masses.compare import Comparison
from robodyn.robot.masses.declared import LinkInertia, RobotInertia
from robodyn.robot.masses.shapes import LinkShapes
from robodyn.robot.urdf.parts import Description
from robodyn.solids.composite_mass import Combination
from robodyn.solids.inertia.conversions import View
from robodyn.solids.inertia.properties import MassProperties
from robodyn.solids.inertia.validity import validity
from robodyn.solids.mesh_mass import Part

if TYPE_CHECKING:
    from robodyn.checks.check import Checked

_FAR = 0.1
"""Relative difference of a link from its shapes that is counted."""


def parts_page(outcomes: Sequence[Part | MeshError], view: View, shapes: Sequence[Array | None]) -> Document:
    """Return what each mesh encloses, and how far the numbers hold; and why meshes failed.

    Args:
        shapes: the triangles (m, 3, 3) of each part [m], None for those without a picture.
    """
    parts = [each for each in outcomes if isinstance(each, Part)]
    failures = [each for each in outcomes if isinstance(each, MeshError)]
    names = ", ".join(part.name for part in parts)
    failed = f"{len(failures)} of {len(outcomes)} meshes failed"
    blocks: list[Block] = [Verdict("bad", failed, tuple(f"{each}." for each in failures))] if failures else []
    blocks.append(_verdict(parts))
    for k, (part, triangles) in enumerate(zip(parts, shapes, strict=True)):
        if len(outcomes) > 1:
            blocks.append(Heading(printable(part.name)))
        blocks.append(_weights(part.body))
        blocks += _solid(PurePath(part.name).name, part.body, triangles, f"mesh {k}")
        blocks += _numbers(inertia_sections([part], view))
    blocks += _data(inertia_json(outcomes, view))
    title = PurePath(parts[0].name).name if len(outcomes) == 1 else "Meshes"
    return Document(title, f"Mass properties: {names}", tuple(blocks))


def combination_page(found: Combination, view: View, shapes: Sequence[Array | None]) -> Document:
    """Return meshes as one rigid body.

    Args:
        shapes: the triangles (m, 3, 3) of each mesh in its own axes [m], None without a picture.
    """
    placed = [
        product(triangles, np.asarray(R, dtype=float).T) + np.asarray(p, dtype=float)
        for triangles, (R, p) in zip(shapes, found.poses, strict=True)
        if triangles is not None
    ]
    names = ", ".join(part.name for part in found.parts)
    doubts = [*(f"{part.name}: {text}" for part in found.parts for text in part.warnings), *found.warnings]
    figures = _solid("The whole", found.body, np.concatenate(placed) if placed else None, "whole")
    blocks = _body(found.body, _possible(found.body, doubts), combination_sections(found, view), figures)
    return Document("Meshes as one rigid body", names, (*blocks, *_data(combination_json(found, view))))


def robot_page(found: RobotInertia, description: Description, view: View, checked: Checked, pictures: bool) -> Document:
    """Return the whole robot, its joints locked."""
    figures: list[Block] = []
    if pictures:
        from robodyn.report.pictures.robot import robot_figure, shapes_of

        model = assemble(description)
        q = configuration(model, found.at)
        figures.append(Gallery((robot_figure(model, q, "", "this configuration", shapes_of(model)[0]),)))
    what = f"Mass properties of the whole robot, {found.massive} of {found.count} links with mass"
    verdict = _possible(found.body, found.warnings, checked)
    blocks = _body(found.body, verdict, robot_sections(found, view, checked), figures)
    return Document(found.name, what, (*blocks, *_data(robot_json(found, view, checked))))


def link_page(found: LinkInertia, description: Description, view: View, checked: Checked, pictures: bool) -> Document:
    """Return a link as declared."""
    sections, figures = link_sections(description.file, found, view, checked), _link(description, found, pictures)
    blocks = _body(found.body, _possible(found.body, (), checked), sections, figures)
    data = _data(link_json(description.name, found, view, checked))
    return Document(f"{description.name}: {found.name}", f"Link {found.name} as declared", (*blocks, *data))


def link_shapes_page(found: LinkShapes, description: Description, view: View, pictures: bool) -> Document:
    """Return a link made of its shapes."""
    sections, figures = link_shapes_sections(description.file, found, view), _link(description, found, pictures)
    blocks = _body(found.body, _possible(found.body, found.shapes.remarks), sections, figures)
    what = f"Link {found.name} from its {found.kind} shapes, {found.weight}"
    data = _data(link_shapes_json(description.name, found, view))
    return Document(f"{description.name}: {found.name}", what, (*blocks, *data))


def differences_page(found: Comparison) -> Document:
    """Return declared inertias against those of shapes."""
    differences = [link.difference.inertia for link in found.links if link.difference is not None]
    far, rest = sum(difference > _FAR for difference in differences), len(found.links) - len(differences)
    level: Level = "doubtful" if far else "good" if differences else "neutral"
    headline = f"{far} of {len(differences)} links differ from their shapes by more than {100 * _FAR:.0f} %"
    verdict = Verdict(level, headline, (f"{rest} more links cannot be compared.",) if rest else ())
    blocks = [verdict, Heading("Links"), *on_page(comparison_sections(found), "Declared against shapes")]
    data = _data(comparison_json(found), "comparison.json")
    return Document(found.name, "Declared inertias against shapes", (*blocks, *data))


def _body(body: MassProperties, verdict: Verdict, sections: Iterable[Section], figures: Sequence[Block]) -> list[Block]:
    """Return the blocks on one rigid body: whether it can exist, what it weighs, and the figures of the text."""
    return [verdict, _weights(body), *figures, Heading("In numbers"), *_numbers(sections)]


def _solid(name: str, body: MassProperties, triangles: Array | None, key: str) -> list[Block]:
    """Return the picture of a body with its centre of mass and principal axes; nothing without triangles."""
    if triangles is None:
        return []
    from robodyn.report.pictures.solids import body_figure

    return [Gallery((body_figure(printable(name), body, triangles, key),))]


def _link(description: Description, found: LinkInertia | LinkShapes, pictures: bool) -> list[Block]:
    """Return the picture of the visual shapes of a link, where there are some."""
    if not pictures or not found.body.mass:
        return []
    from robodyn.report.pictures.robot import shapes_of

    shapes, _ = shapes_of(assemble(description))
    return _solid(found.name, found.body, shapes.triangles.get(found.name) if shapes else None, "link")


def _possible(body: MassProperties, doubts: Sequence[str], checked: Checked | None = None) -> Verdict:
    """Return whether a body can exist; no better than what the check says of its description.

    Args:
        doubts: what is doubtful about it.
        checked: what a check found in the description that it is declared in.
    """
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


def _verdict(parts: Sequence[Part]) -> Verdict:
    open_ones = ", ".join(printable(part.name) for part in parts if not part.closed)
    doubts = [f"{printable(part.name)}: {text}." for part in parts for text in part.warnings]
    repairs = [f"{printable(part.name)}: repaired, {step.what}." for part in parts for step in part.repairs]
    error = max(max(part.arithmetic, part.rounding, part.union or 0.0) for part in parts)
    reasons = [f"The volume holds within {error:.0e} of itself, for the surface as the file has it.", *repairs, *doubts]
    if any(part.assumed for part in parts):
        reasons.append("The density is assumed: --density or --mass says what it is.")
    if open_ones:
        return Verdict("bad", f"Not closed, so that the mass is not definite: {open_ones}", tuple(reasons))
    if doubts or repairs:
        return Verdict("doubtful", "Mass and inertia, with repairs or doubts", tuple(reasons))
    return Verdict("good", f"{'Closed' if len(parts) == 1 else 'All closed'} and without faults", tuple(reasons))


def _weights(body: MassProperties) -> Facts:
    size = float(np.sqrt(body.principal.moments.max() / body.mass)) if body.mass else 0.0
    items = amounts(body, size, area=body.area).items
    names = {"area": "Surface"}
    return Facts(tuple((names.get(name, name.capitalize()), value, more) for name, value, more in items))


def _numbers(sections: Iterable[Section]) -> list[Block]:
    """Return what the text says beyond the facts at the top."""
    return [block for block in on_page(sections, "Values") if not isinstance(block, Facts)]


def _data(text: str, name: str = "inertia.json") -> list[Block]:
    return data_blocks([(name, text)], "robodyn inertia --format json prints it")
