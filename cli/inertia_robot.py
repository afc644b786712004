"""`robodyn inertia` of a URDF: a link, the whole robot, or declared inertias against shapes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

from robodyn.cli.call import Call, one_each, refuse
from robodyn.cli.files import described
from robodyn.cli.progress import counted
from robodyn.cli.reports import answer
from robodyn.cli.screen import complain
from robodyn.errors import InputError
from robodyn.report import inertia_pages as pages
from robodyn.report.inertia import comparison_sections, link_sections, link_shapes_sections, robot_sections
from robodyn.report.inertia_pages import comparison_json, link_json, link_shapes_json, robot_json
from robodyn.robot.masses.declared import link_inertia, robot_inertia
from robodyn.robot.masses.shapes import How, Reading, link_from_shapes
from robodyn.robot.masses.shapes import compare as compare_shapes
from robodyn.robot.urdf.parts import Description, Kind
from robodyn.solids.inertia.properties import MassProperties, View, inertial_element
from robodyn.support.wording import count

if TYPE_CHECKING:
    from robodyn.checks.check import Checked


@dataclass(frozen=True)
class Link:
    """The link that is asked for, None for all, and by which of its shapes and with what density or mass."""

    name: str | None
    geometry: Kind | None
    density: Sequence[float]
    mass: Sequence[float]


def robot(call: Call, file: str, view: View, link: Link, how: How, *, at: Any, compare: bool) -> int:
    """Show what the options ask of one description; the exit status, 2 where no link could be compared."""
    if compare and call.form == "urdf":
        refuse("--format urdf is not for --compare; --link NAME --geometry visual prints one")
    description = described(call, file)
    reading = Reading(how, watch=counted)
    if compare:
        return _compared(call, description, link.geometry or "visual", reading)
    if link.name is None:
        _whole(call, description, view, at)
    elif link.geometry is None:
        _declared(call, description, view, link.name)
    else:
        _from_shapes(call, description, view, link.name, link.geometry, link, reading)
    return 0


def _compared(call: Call, description: Description, geometry: Kind, reading: Reading) -> int:
    found = compare_shapes(description, geometry, reading)
    sections = comparison_sections(found)
    answer(call, sections, lambda _: pages.differences_page(found), json=lambda: comparison_json(found))
    if any(link.difference is not None for link in found.links):
        return 0
    what = f"none of {count(len(found.links), 'link')} could be compared"
    reasons = [link.reason for link in found.links if link.reason]
    most, often = Counter(reasons).most_common(1)[0] if reasons else ("", 0)
    remedy = f"{often} of them: {most}" if reasons else None
    complain(InputError(what, remedy=remedy, file=found.file))
    return 2


def _checked(description: Description) -> Checked:
    """Return what `robodyn check` finds in the description."""
    from robodyn.checks.check import Options, check_description

    return check_description(description, Options(package_path=description.search.package_paths))


def _whole(call: Call, description: Description, view: View, at: Any) -> None:
    found = robot_inertia(description, at)
    checked = _checked(description)
    document = partial(pages.robot_page, found, description, view, checked)
    json, urdf = partial(robot_json, found, view, checked), partial(_urdf, found.body)
    answer(call, robot_sections(found, view, checked), document, json=json, urdf=urdf)


def _declared(call: Call, description: Description, view: View, name: str) -> None:
    found = link_inertia(description, name)
    checked = _checked(description).of_link(found.name)
    document = partial(pages.link_page, found, description, view, checked)
    json, urdf = partial(link_json, description.name, found, view, checked), partial(_urdf, found.body)
    answer(call, link_sections(description.file, found, view, checked), document, json=json, urdf=urdf)


def _from_shapes(
    call: Call, description: Description, view: View, name: str, kind: Kind, link: Link, reading: Reading
) -> None:
    found = link_from_shapes(
        description,
        name,
        kind,
        density=one_each(link.density, [description.file], "--density")[0],
        mass=one_each(link.mass, [description.file], "--mass")[0],
        reading=reading,
    )
    document = partial(pages.link_shapes_page, found, description, view)
    json, urdf = partial(link_shapes_json, description.name, found, view), partial(_urdf, found.body)
    answer(call, link_shapes_sections(description.file, found, view), document, json=json, urdf=urdf)


def _urdf(body: MassProperties) -> str:
    """Return a body as the <inertial> of a link."""
    return inertial_element(body, "") + "\n"
