"""Composite bodies as reports for people: combined meshes, a link, a robot at a configuration, a comparison."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from robodyn.programs.vectors import product
from robodyn.report.document import Document, Figure
from robodyn.report.json_comparison import comparison_json
from robodyn.report.json_composite import combination_json, link_json, link_shapes_json, robot_json
from robodyn.report.page_inertia import body_figure, body_page, comparison_page
from robodyn.report.table import printable
from robodyn.report.text_comparison import comparison_text
from robodyn.report.text_composite import combination_text, link_shapes_text, link_text, robot_text
from robodyn.robot.assemble import assemble
from robodyn.robot.configuration import configuration
from robodyn.robot.masses.compare import Comparison
from robodyn.robot.masses.declared import LinkInertia, RobotInertia
from robodyn.robot.masses.from_shapes import LinkShapes
from robodyn.robot.urdf.description import Description
from robodyn.solids.composite_mass import Combination
from robodyn.solids.inertia.view import View
from robodyn.support.floats import Floats

if TYPE_CHECKING:
    from robodyn.checks.run import Checked


def combination_page(found: Combination, view: View, shapes: Sequence[Floats | None]) -> Document:
    """Meshes as one rigid body.

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
    figures = [body_figure("The whole", found.body, np.concatenate(placed), "whole")] if placed else []
    write, data = partial(combination_text, found, view), combination_json(found, view)
    return body_page("Meshes as one rigid body", names, found.body, doubts, write, data, figures)


def robot_page(found: RobotInertia, description: Description, view: View, checked: Checked, pictures: bool) -> Document:
    """The whole robot, its joints locked."""
    figures: list[Figure] = []
    if pictures:
        from robodyn.report.robot_picture import robot_figure, shapes_of

        model = assemble(description)
        q = configuration(model, found.at)
        figures.append(robot_figure(model, q, "", "this configuration", shapes_of(model)[0]))
    write, data = partial(robot_text, found, view, checked), robot_json(found, view, checked)
    what = f"Mass properties of the whole robot, {found.massive} of {found.count} links with mass"
    return body_page(found.name, what, found.body, found.warnings, write, data, figures, checked)


def link_page(found: LinkInertia, description: Description, view: View, checked: Checked, pictures: bool) -> Document:
    """A link as declared."""
    write = partial(link_text, description.file, found, view, checked)
    data = link_json(description.name, found, view, checked)
    figures = _figures(description, found, pictures)
    what = f"Link {found.name} as declared"
    return body_page(f"{description.name}: {found.name}", what, found.body, (), write, data, figures, checked)


def link_shapes_page(found: LinkShapes, description: Description, view: View, pictures: bool) -> Document:
    """A link made of its shapes."""
    write = partial(link_shapes_text, description.file, found, view)
    data = link_shapes_json(description.name, found, view)
    what = f"Link {found.name} from its {found.kind} shapes, {found.weight}"
    figures = _figures(description, found, pictures)
    remarks = found.shapes.remarks
    return body_page(f"{description.name}: {found.name}", what, found.body, remarks, write, data, figures)


def differences_page(found: Comparison) -> Document:
    """Declared inertias against those of shapes."""
    differences = [link.difference.inertia for link in found.links if link.difference is not None]
    write, data = partial(comparison_text, found), comparison_json(found)
    return comparison_page(found.name, differences, len(found.links), write, data)


def _figures(description: Description, found: LinkInertia | LinkShapes, pictures: bool) -> list[Figure]:
    """The visual shapes of a link, where there are some, with its centre of mass and principal axes."""
    if not pictures or not found.body.mass:
        return []
    from robodyn.report.robot_picture import shapes_of

    shapes, _ = shapes_of(assemble(description))
    triangles = None if shapes is None else shapes.triangles.get(found.name)
    return [] if triangles is None else [body_figure(printable(found.name), found.body, triangles, "link")]
