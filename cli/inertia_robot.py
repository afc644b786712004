"""`robodyn inertia` of a URDF: a link, the whole robot, or declared inertias against shapes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING

import click

from robodyn.cli.files import described
from robodyn.cli.inertia_options import check_use, one_each, urdf_lines
from robodyn.cli.options import kept_value
from robodyn.cli.progress import counted
from robodyn.cli.reports import answer
from robodyn.cli.screen import complain
from robodyn.errors import InputError
from robodyn.report import inertia_pages as pages
from robodyn.report.inertia import comparison_sections, link_sections, link_shapes_sections, robot_sections
from robodyn.report.inertia_pages import comparison_json, link_json, link_shapes_json, robot_json
from robodyn.robot.masses.declared import link_inertia, robot_inertia
from robodyn.robot.masses.shapes import How, Reading, compare, link_from_shapes
from robodyn.robot.urdf.parts import Description, Kind
from robodyn.solids.inertia.conversions import View
from robodyn.support.wording import count

if TYPE_CHECKING:
    from robodyn.checks.check import Checked


def robot(files: Sequence[str], view: View, ctx: click.Context) -> int:
    """Show what the options ask of one description; the exit status, 2 where no link could be compared."""
    given = ctx.params
    shapes = given["geometry"] is not None
    use = "--compare" if given["compare"] else "a whole robot"
    if given["link"] is not None and not given["compare"]:
        use = "a link's shapes" if shapes else "a link as declared"
    check_use(use, ctx)
    if len(files) > 1:
        raise click.UsageError("a URDF stands alone: one robot at a time, and no meshes beside it", ctx)
    if given["compare"] and kept_value("form", "text") == "urdf":
        raise click.UsageError("--format urdf is not for --compare; --link NAME --geometry visual prints one", ctx)
    description = described(files[0])
    show = {"a whole robot": _whole, "a link's shapes": _from_shapes, "a link as declared": _declared}.get(use)
    if show is None:
        return _compared(description, ctx)
    show(description, view, ctx)
    return 0


def _reading(ctx: click.Context) -> Reading:
    given = ctx.params
    how = How(exact=given["exact"], repair=given["repair"], strict=given["strict"], cavities=given["cavities"])
    return Reading(how, watch=counted)


def _compared(description: Description, ctx: click.Context) -> int:
    kind: Kind = ctx.params["geometry"] or "visual"
    found = compare(description, kind, _reading(ctx))
    sections = comparison_sections(found)
    answer(sections, lambda _: pages.differences_page(found), json=lambda: comparison_json(found))
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


def _whole(description: Description, view: View, ctx: click.Context) -> None:
    found = robot_inertia(description, ctx.params["at"] or ())
    checked = _checked(description)
    document = partial(pages.robot_page, found, description, view, checked)
    json, urdf = partial(robot_json, found, view, checked), partial(urdf_lines, found.body)
    answer(robot_sections(found, view, checked), document, json=json, urdf=urdf)


def _declared(description: Description, view: View, ctx: click.Context) -> None:
    found = link_inertia(description, ctx.params["link"])
    checked = _checked(description).of_link(found.name)
    document = partial(pages.link_page, found, description, view, checked)
    json, urdf = partial(link_json, description.name, found, view, checked), partial(urdf_lines, found.body)
    answer(link_sections(description.file, found, view, checked), document, json=json, urdf=urdf)


def _from_shapes(description: Description, view: View, ctx: click.Context) -> None:
    given = ctx.params
    found = link_from_shapes(
        description,
        given["link"],
        given["geometry"],
        density=one_each(given["density"], [description.file], "--density")[0],
        mass=one_each(given["mass"], [description.file], "--mass")[0],
        reading=_reading(ctx),
    )
    document = partial(pages.link_shapes_page, found, description, view)
    json, urdf = partial(link_shapes_json, description.name, found, view), partial(urdf_lines, found.body)
    answer(link_shapes_sections(description.file, found, view), document, json=json, urdf=urdf)
