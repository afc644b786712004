"""Mass properties of parts as text for a person."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robodyn.inertia.view import View
from robodyn.part import Part
from robodyn.report.table import PLAIN, Page, number, printable

AXES = ("x", "y", "z")


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
            _inertia(part, view, page),
            _principal(part, page),
            _trust(part),
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
    centre = ", ".join(number(x, reach) for x in body.com)
    return "\n".join([*lines, f"centre of mass  ({centre}) m", ""])


def _inertia(part: Part, view: View, page: Page) -> str:
    _, matrix = view.inertia(part.body)
    scale = float(np.abs(matrix).max())
    rows = [(AXES[i], *(number(x, scale) for x in matrix[i])) for i in range(3)]
    return f"Inertia {view.words} [kg m^2]\n{page.table((('', *AXES), rows))}"


def _principal(part: Part, page: Page) -> str:
    principal = part.body.principal
    rows = [(str(k + 1), number(principal.moments[k]), *(f"{x:.6f}" for x in principal.axes[k])) for k in range(3)]
    head = ("", "moment [kg m^2]", *(f"axis {name}" for name in AXES))
    remark = f"{principal.remark}\n" if principal.remark else ""
    return f"Principal moments about the centre of mass\n{page.table((head, rows))}{remark}"


def _trust(part: Part) -> str:
    lines = [f"relative error of the volume: arithmetic {part.arithmetic:.0e} ({part.method}), "]
    lines[0] += f"rounding of the file at most {part.rounding:.0e}\n"
    lines += [
        f"repaired: {step.what}; volume {number(step.volume_before)} to {number(step.volume_after)} m^3\n"
        for step in part.repairs
    ]
    lines += [f"{printable(note)}\n" for note in part.notes]
    lines += [f"warning: {printable(line)}\n" for line in part.warnings]
    return "".join(lines)
