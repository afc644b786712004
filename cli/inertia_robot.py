"""`robodyn inertia` of a URDF: a link, the whole robot, or declared inertias against shapes."""

from __future__ import annotations

from collections import Counter
from functools import partial

from robodyn.checks.check import Checked, Options, check_description
from robodyn.cli.files import robot_source
from robodyn.cli.options import Call, refuse
from robodyn.cli.progress import counted
from robodyn.cli.screen import answer, complain
from robodyn.equations.composite import in_letters, in_numbers
from robodyn.errors import InputError
from robodyn.report import inertia_pages as pages
from robodyn.report.equations.latex import composite_latex
from robodyn.report.inertia import (
    comparison_sections,
    letters_sections,
    link_sections,
    link_shapes_sections,
    robot_sections,
)
from robodyn.robot.load import load_description
from robodyn.robot.masses.declared import LinkInertia, link_inertia, robot_inertia
from robodyn.robot.masses.shapes import How, LinkShapes, Reading, compare, link_from_shapes
from robodyn.robot.urdf.parts import Description, Kind
from robodyn.solids.inertia.properties import View, inertial_element
from robodyn.support.wording import count


def compared(call: Call, file: str, geometry: Kind, how: How) -> int:
    """Show declared inertias against the links' shapes; the exit status, 2 where no link could be compared."""
    if call.form == "urdf":
        refuse("--format urdf is not for --compare; --link NAME --geometry visual prints one")
    description = load_description(robot_source(file), **call.lookup)
    found = compare(description, geometry, Reading(how, watch=counted))
    sections = comparison_sections(found)
    document = partial(pages.differences_page, found, description)
    answer(call, sections, document, json=lambda: pages.comparison_json(found))
    if any(link.difference is not None for link in found.links):
        return 0
    what = f"none of {count(len(found.links), 'link')} could be compared"
    reasons = Counter(link.reason for link in found.links if link.reason)
    remedy = next((f"{often} of them: {most}" for most, often in reasons.most_common(1)), None)
    complain(InputError(what, remedy=remedy, file=found.file))
    return 2


def robot(
    call: Call,
    file: str,
    view: View,
    kinds: tuple[str, ...] | None,
    links: tuple[str, ...],
    frame: str,
    terms: bool,
    momentum: bool,
    moving_base: bool,
) -> int:
    """Show a robot, or some of its links, as one body: in letters of some kinds, or in numbers."""
    description = load_description(robot_source(file), **call.lookup)
    if kinds is not None:
        made = in_letters(description, view, kinds, links, frame, terms, momentum, moving_base)
        json, latex = partial(pages.letters_json, description, made), partial(composite_latex, made)
        answer(call, letters_sections(description, made, view), json=json, latex=latex)
        return 0
    found, checked = robot_inertia(description, call.at or (), links, frame), _checked(description)
    shares = in_numbers(found, description, view, (call.qd or ()) if momentum else None)
    document = partial(pages.robot_page, found, description, view, checked, shares)
    json = partial(pages.robot_json, found, view, checked, shares)
    sections = robot_sections(found, view, checked, shares, terms)
    answer(call, sections, document, json=json, urdf=lambda: inertial_element(found.body) + "\n")
    return 0


def one_link(
    call: Call,
    file: str,
    view: View,
    link: str,
    geometry: Kind | None,
    density: float | None,
    mass: float | None,
    how: How,
) -> int:
    """Show a link as declared, or what its shapes make of it."""
    description = load_description(robot_source(file), **call.lookup)
    found: LinkInertia | LinkShapes
    if geometry is not None:
        reading = Reading(how, watch=counted)
        found = link_from_shapes(description, link, geometry, density=density, mass=mass, reading=reading)
        sections = link_shapes_sections(description.file, found, view)
        document = partial(pages.link_shapes_page, found, description, view)
        json = partial(pages.link_shapes_json, description.name, found, view)
    else:
        found, checked = link_inertia(description, link), _checked(description).of_link(link)
        sections = link_sections(description.file, found, view, checked)
        document = partial(pages.link_page, found, description, view, checked)
        json = partial(pages.link_json, description.name, found, view, checked)
    answer(call, sections, document, json=json, urdf=lambda: inertial_element(found.body) + "\n")
    return 0


def _checked(description: Description) -> Checked:
    return check_description(description, Options(package_path=description.search.package_paths))
