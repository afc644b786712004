"""`robodyn inertia` of meshes: one by one, or combined to one rigid body."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from os.path import isfile
from typing import Any

import click

from robodyn.cli.files import STANDARD_INPUT
from robodyn.cli.inertia_options import OF_ROBOTS, check_use, one_each, urdf_lines
from robodyn.cli.options import kept_value
from robodyn.cli.progress import metered
from robodyn.cli.reports import answer
from robodyn.cli.screen import complain
from robodyn.errors import InputError, MeshError
from robodyn.measure.accuracy.inertia_within import needs_rationals, with_promise
from robodyn.report.document import Document
from robodyn.report.inertia import inertia_sections
from robodyn.report.inertia_pages import inertia_json
from robodyn.solids.inertia.conversions import View
from robodyn.solids.inertia.properties import Pose
from robodyn.solids.mesh_mass import Part, mass_properties
from robodyn.support.floats import Floats


def meshes(
    files: Sequence[str],
    view: View,
    ctx: click.Context,
    combine: bool,
    place: Sequence[Pose],
    **options: Any,
) -> int:
    """Show what each mesh encloses, or what they make together; the exit status, 2 where a mesh failed.

    One that fails stops no other, but for meshes combined.
    """
    check_use("--combine" if combine else "meshes one by one", ctx)
    if combine or kept_value("form", "text") == "urdf":
        options |= {name: options[name] or False for name in ("symmetry", "tessellation")}
    outcomes, whole = _measured(
        files, combine, **{name: each for name, each in options.items() if name not in OF_ROBOTS}
    )
    parts = [each for each in outcomes if isinstance(each, Part)]
    failed = [each for each in outcomes if isinstance(each, MeshError)]
    for error in failed:
        complain(error)
    if failed and (combine or len(files) == 1):
        return 2
    shapes = partial(_shapes, files, outcomes, options)
    if combine:
        _combined(parts, place, whole, view, shapes)
        return 0

    def document(pictures: bool) -> Document:
        from robodyn.report.inertia_pages import parts_page

        return parts_page(outcomes, view, shapes(pictures))

    json, urdf = partial(inertia_json, outcomes, view), lambda: "".join(map(_element, outcomes))
    answer(inertia_sections(parts, view), document if parts else None, json=json, urdf=urdf)
    return 2 if failed else 0


def _element(outcome: Part | MeshError) -> str:
    """Return the <inertial> of a part; a comment stands for one that there is not."""
    if isinstance(outcome, Part):
        return urdf_lines(outcome.body)
    return f"<!-- {str(outcome).replace('--', '- -')} -->\n"


def _shapes(
    files: Sequence[str], outcomes: Sequence[Part | MeshError], options: dict[str, Any], pictures: bool
) -> list[Floats | None]:
    """Return the triangles of each part [m]; None where they are not wanted or cannot be read a second time."""
    from robodyn.solids.mesh.read.load import load_triangles

    units = one_each(options["unit"], files, "--unit")
    found: list[Floats | None] = []
    for name, unit, outcome in zip(files, units, outcomes, strict=True):
        if isinstance(outcome, MeshError):
            continue
        if not pictures or name == STANDARD_INPUT or not isfile(name):
            found.append(None)
            continue
        triangles = load_triangles(name, file_type=options["file_type"], unit=unit)
        found.append(triangles.array() * triangles.scale)
    return found


def _measured(
    files: Sequence[str],
    combine: bool,
    density: Sequence[float],
    mass: Sequence[float],
    unit: Sequence[str],
    accuracy: float | None,
    exact: bool,
    **options: Any,
) -> tuple[list[Part | MeshError], float | None]:
    """Return the part that each file is, or why it is none; and the mass of the whole if it is given."""
    whole = mass[0] if combine and len(mass) == 1 else None
    if whole is not None and density:
        raise InputError("both a density and a mass are given", remedy="give one of them")
    each = zip(
        files,
        one_each(density, files, "--density"),
        one_each(() if whole else mass, files, "--mass"),
        one_each(unit, files, "--unit"),
        strict=True,
    )
    options["exact"] = exact or (accuracy is not None and needs_rationals(accuracy))
    outcomes: list[Part | MeshError] = []
    with metered(files) as (on_progress, done):
        for name, rho, m, units in each:
            try:
                part = mass_properties(name, density=rho, mass=m, unit=units, on_progress=on_progress, **options)
                outcomes.append(part if accuracy is None else with_promise(part, accuracy))
            except MeshError as error:
                outcomes.append(error)
            done()
    return outcomes, whole


def _combined(
    parts: Sequence[Part],
    places: Sequence[Pose],
    mass: float | None,
    view: View,
    shapes: Callable[[bool], list[Floats | None]],
) -> None:
    from robodyn.report.inertia import combination_sections
    from robodyn.report.inertia_pages import combination_json
    from robodyn.solids.composite_mass import combined

    found = combined(parts, places, mass)

    def document(pictures: bool) -> Document:
        from robodyn.report.inertia_pages import combination_page

        return combination_page(found, view, shapes(pictures))

    json, urdf = partial(combination_json, found, view), partial(urdf_lines, found.body)
    answer(combination_sections(found, view), document, json=json, urdf=urdf)
