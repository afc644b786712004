"""`robodyn inertia` of a URDF: a link, the whole robot, or declared inertias against shapes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import click

from robodyn.cli.files import described
from robodyn.cli.inertia_options import check_use, one_each
from robodyn.cli.progress import counted
from robodyn.cli.reports import pictured, write_report
from robodyn.cli.screen import page, show
from robodyn.report.composite import comparison_sections, link_sections, link_shapes_sections, robot_sections
from robodyn.report.document import Section
from robodyn.report.json.bodies import comparison_json, link_json, link_shapes_json, robot_json
from robodyn.report.text import text
from robodyn.robot.masses.compare import compare
from robodyn.robot.masses.declared import link_inertia, robot_inertia
from robodyn.robot.masses.from_shapes import link_from_shapes
from robodyn.robot.masses.measured import How, Reading
from robodyn.robot.urdf.geometry import Kind
from robodyn.robot.urdf.parts import Description
from robodyn.solids.inertia.properties import MassProperties
from robodyn.solids.inertia.view import View, inertial_element

if TYPE_CHECKING:
    from robodyn.checks.run import Checked


def robot(files: Sequence[str], view: View, form: str, report: str | None, ctx: click.Context) -> None:
    """Show what the options ask of one description."""
    given = ctx.params
    shapes = given["geometry"] is not None
    use = "--compare" if given["compare"] else "a whole robot"
    if given["link"] is not None and not given["compare"]:
        use = "a link's shapes" if shapes else "a link as declared"
    check_use(use, ctx)
    if len(files) > 1:
        raise click.UsageError("a URDF stands alone: one robot at a time, and no meshes beside it", ctx)
    if given["compare"] and form == "urdf":
        raise click.UsageError("--format urdf is not for --compare; --link NAME --geometry visual prints one", ctx)
    description = described(files[0])
    {
        "--compare": _compared,
        "a whole robot": _whole,
        "a link's shapes": _from_shapes,
        "a link as declared": _declared,
    }[use](description, view, form, report, ctx)


def _reading(ctx: click.Context) -> Reading:
    given = ctx.params
    how = How(exact=given["exact"], repair=given["repair"], strict=given["strict"], cavities=given["cavities"])
    return Reading(how, watch=counted)


def _compared(description: Description, view: View, form: str, report: str | None, ctx: click.Context) -> None:
    kind: Kind = ctx.params["geometry"] or "visual"
    found = compare(description, kind, _reading(ctx))
    written = _written(report, "differences_page", found)
    show(comparison_json(found) if form == "json" else text(comparison_sections(found), page()) + written)


def _written(report: str | None, build: str, *given: Any) -> str:
    """Write the report that a function builds, if one is asked for; a line that says so."""
    if report is None:
        return ""
    from robodyn.report import inertia_pages

    pictures = () if build == "differences_page" else (pictured(report),)
    return write_report(report, getattr(inertia_pages, build)(*given, *pictures))


def _checked(description: Description) -> Checked:
    """Return what `robodyn check` finds in the description."""
    from robodyn.checks.project import check_description
    from robodyn.checks.run import Options

    return check_description(description, Options(package_path=description.search.package_paths))


def _whole(description: Description, view: View, form: str, report: str | None, ctx: click.Context) -> None:
    found = robot_inertia(description, ctx.params["at"] or ())
    checked = _checked(description)
    written = _written(report, "robot_page", found, description, view, checked)
    json = partial(robot_json, found, view, checked)
    _show(form, found.body, json, robot_sections(found, view, checked), written)


def _declared(description: Description, view: View, form: str, report: str | None, ctx: click.Context) -> None:
    found = link_inertia(description, ctx.params["link"])
    checked = _checked(description).of_link(found.name)
    written = _written(report, "link_page", found, description, view, checked)
    json = partial(link_json, description.name, found, view, checked)
    _show(form, found.body, json, link_sections(description.file, found, view, checked), written)


def _from_shapes(description: Description, view: View, form: str, report: str | None, ctx: click.Context) -> None:
    given = ctx.params
    found = link_from_shapes(
        description,
        given["link"],
        given["geometry"],
        density=one_each(given["density"], [description.file], "--density")[0],
        mass=one_each(given["mass"], [description.file], "--mass")[0],
        reading=_reading(ctx),
    )
    written = _written(report, "link_shapes_page", found, description, view)
    json = partial(link_shapes_json, description.name, found, view)
    _show(form, found.body, json, link_shapes_sections(description.file, found, view), written)


def _show(form: str, body: MassProperties, json: Callable[[], str], sections: Iterable[Section], written: str) -> None:
    """Show a body in the form that is asked for."""
    if form == "urdf":
        show(inertial_element(body, "") + "\n")
    else:
        show(json() if form == "json" else text(sections, page()) + written)
