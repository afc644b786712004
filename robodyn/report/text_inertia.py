"""Mass properties of parts as text for a person."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robodyn.report.table import PLAIN, Page, number, printable
from robodyn.report.text_body import inertia_table, point_text, principal_table
from robodyn.report.text_shape import symmetry_text, tessellation_text
from robodyn.solids.inertia.view import View
from robodyn.solids.mesh_mass import Part


def inertia_text(parts: Sequence[Part], view: View, page: Page = PLAIN) -> str:
    """The report of each part: mass, centre, inertia as the view asks for it, principal moments, errors, warnings."""
    return "\n".join(_part(part, view, page) for part in parts)


def _part(part: Part, view: View, page: Page) -> str:
    size = " x ".join(number(x) for x in part.hi - part.lo)
    state = "closed" if part.closed else "not closed"
    count = f"{part.triangles} triangle{'' if part.triangles == 1 else 's'}"
    return "\n".join(
        (
            f"{printable(part.name)}: {count}, {state}, {size} m\n",
            _amounts(part),
            inertia_table(part.body, view, page),
            principal_table(part.body, page),
            symmetry_text(part, page) + _trust(part),
        )
    )


def _amounts(part: Part) -> str:
    body = part.body
    lines = [f"mass            {number(body.mass)} kg" + (", at an assumed density" if part.assumed else "")]
    if body.volume is not None:
        lines.append(f"volume          {number(body.volume)} m^3")
    if body.area is not None:
        lines.append(f"area            {number(body.area)} m^2")
    if body.density is not None:
        lines.append(f"density         {number(body.density)} kg/m^3")
    reach = float(np.abs((part.lo, part.hi)).max())
    return "\n".join([*lines, f"centre of mass  {point_text(body.com, reach)} m", ""])


def _trust(part: Part) -> str:
    lines = [f"relative error of the volume: arithmetic {part.arithmetic:.0e} ({part.method}), "]
    lines[0] += f"rounding of the file at most {part.rounding:.0e}\n"
    lines += [
        f"repaired: {step.what}; volume {number(step.volume_before)} to {number(step.volume_after)} m^3\n"
        for step in part.repairs
    ]
    if part.union is not None:
        lines.append(f"holes and overlaps: relative error at most {part.union:.0e}\n")
    lines += [tessellation_text(part)] + [f"{printable(note)}\n" for note in part.notes]
    lines += [f"warning: {printable(line)}\n" for line in part.warnings]
    return "".join(lines)
