"""`robodyn inertia` of a URDF: a link, the whole robot, or declared inertias against shapes."""

from __future__ import annotations

from collections import Counter
from functools import partial
from typing import Any

from robodyn.checks.check import Options, check_description
from robodyn.cli.files import robot_source
from robodyn.cli.options import Call, refuse
from robodyn.cli.progress import counted
from robodyn.cli.screen import answer, complain
from robodyn.equations.composite import in_letters, in_numbers
from robodyn.equations.letters import KINDS
from robodyn.errors import InputError
from robodyn.report import inertia_pages as pages
from robodyn.report.inertia import (
    comparison_sections,
    letters_sections,
    link_sections,
    link_shapes_sections,
    robot_sections,
)
from robodyn.report.renderers.latex import composite_latex
from robodyn.report.renderers.letters import text_of
from robodyn.robot.load import load_description
from robodyn.robot.masses.declared import BASE, LinkInertia, RobotInertia, link_inertia, robot_inertia
from robodyn.robot.masses.shapes import How, LinkShapes, Reading, compare, link_from_shapes
from robodyn.robot.urdf.parts import Kind
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
    at: Any,
    link: str | None,
    geometry: Kind | None,
    density: float | None,
    mass: float | None,
    how: How,
    links: tuple[str, ...] = (),
    frame: str = BASE,
    terms: bool = False,
    momentum: bool = False,
) -> int:
    """Show a robot or some of its links, a link as declared, or what a link's shapes make of it."""
    description = load_description(robot_source(file), **call.lookup)
    options = Options(package_path=description.search.package_paths)
    found: RobotInertia | LinkInertia | LinkShapes
    if link is not None and geometry is not None:
        reading = Reading(how, watch=counted)
        found = link_from_shapes(description, link, geometry, density=density, mass=mass, reading=reading)
        sections = link_shapes_sections(description.file, found, view)
        document = partial(pages.link_shapes_page, found, description, view)
        json = partial(pages.link_shapes_json, description.name, found, view)
    elif link is not None:
        found = link_inertia(description, link)
        checked = check_description(description, options).of_link(link)
        sections = link_sections(description.file, found, view, checked)
        document = partial(pages.link_page, found, description, view, checked)
        json = partial(pages.link_json, description.name, found, view, checked)
    else:
        found, checked = (
            robot_inertia(description, at, links, BASE if frame == "ground" else frame),
            check_description(description, options),
        )
        shares = in_numbers(found, description, view, call.qd or ())
        sections = robot_sections(found, view, checked, shares, terms, momentum)
        document = partial(pages.robot_page, found, description, view, checked, shares, momentum)
        json = partial(pages.robot_json, found, view, checked, shares, momentum)
    answer(call, sections, document, json=json, urdf=lambda: inertial_element(found.body) + "\n")
    return 0


def letters(
    call: Call, file: str, view: View, kinds: tuple[str, ...], links: tuple[str, ...], frame: str, momentum: bool
) -> int:
    """Show the bodies of a robot in letters."""
    description = load_description(robot_source(file), **call.lookup)
    frame = BASE if frame == "ground" else frame
    kinds = KINDS if kinds == ("all",) else kinds
    found = in_letters(description, view, kinds, links, frame, momentum)
    answer(
        call,
        letters_sections(description, found, view, frame, momentum, text_of),
        json=lambda: pages.letters_json(description, found, view, frame, momentum, text_of),
        latex=lambda: composite_latex(found, momentum),
    )
    return 0
