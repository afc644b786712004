"""`robodyn inertia` of meshes: one by one, or combined to one rigid body."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import click

from robodyn.accuracy.inertia_within import needs_rationals, with_promise
from robodyn.cli.inertia_options import OF_ROBOTS, check_use, one_each
from robodyn.cli.meter import metered
from robodyn.cli.screen import page, show
from robodyn.errors import InputError
from robodyn.inertia.composite import Pose
from robodyn.inertia.urdf_text import inertial_element
from robodyn.inertia.view import View
from robodyn.part import Part, mass_properties
from robodyn.report.json_inertia import inertia_json
from robodyn.report.text_inertia import inertia_text


def meshes(
    files: Sequence[str],
    view: View,
    form: str,
    ctx: click.Context,
    combine: bool,
    place: Sequence[Pose],
    **how: Any,
) -> None:
    """Show what each mesh encloses, or what they make together."""
    check_use("--combine" if combine else "meshes one by one", ctx)
    if combine or form == "urdf":
        how |= {name: how[name] or False for name in ("symmetry", "tessellation")}
    parts, whole = _measured(files, combine, **{name: value for name, value in how.items() if name not in OF_ROBOTS})
    if combine:
        _combined(parts, place, whole, view, form)
    elif form == "urdf":
        show("\n".join(inertial_element(part.body, "") for part in parts) + "\n")
    else:
        show(inertia_json(parts, view) if form == "json" else inertia_text(parts, view, page()))


def _measured(
    files: Sequence[str],
    combine: bool,
    density: Sequence[float],
    mass: Sequence[float],
    unit: Sequence[str],
    accuracy: float | None,
    exact: bool,
    **how: Any,
) -> tuple[list[Part], float | None]:
    """The parts, and the mass of the whole if it is given."""
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
    how["exact"] = exact or (accuracy is not None and needs_rationals(accuracy))
    parts = []
    with metered(files) as (heard, done):
        for name, rho, m, units in each:
            parts.append(mass_properties(name, density=rho, mass=m, unit=units, heard=heard, **how))
            done()
    return parts if accuracy is None else [with_promise(part, accuracy) for part in parts], whole


def _combined(parts: Sequence[Part], places: Sequence[Pose], mass: float | None, view: View, form: str) -> None:
    from robodyn.combination import combined
    from robodyn.report.json_composite import combination_json
    from robodyn.report.text_composite import combination_text

    found = combined(parts, places, mass)
    if form == "urdf":
        show(inertial_element(found.body, "") + "\n")
    else:
        show(combination_json(found, view) if form == "json" else combination_text(found, view, page()))
