"""Inertia matrix and principal moments of a body as text for a person."""

from __future__ import annotations

import numpy as np

from robodyn.programs.vectors import Array
from robodyn.report.table import Page, number
from robodyn.solids.inertia.properties import MassProperties
from robodyn.solids.inertia.view import View

AXES = ("x", "y", "z")


def point_text(point: Array, reach: float = 0.0) -> str:
    """Coordinates in brackets; 0 for what vanishes beside `reach`."""
    return f"({', '.join(number(x, reach) for x in point)})"


def inertia_table(body: MassProperties, view: View, page: Page) -> str:
    """The inertia matrix as the view asks for it."""
    _, matrix = view.inertia(body)
    scale = float(np.abs(matrix).max())
    rows = [(AXES[i], *(number(x, scale) for x in matrix[i])) for i in range(3)]
    return f"Inertia {view.words} [kg m^2]\n{page.table((('', *AXES), rows))}"


def principal_table(body: MassProperties, page: Page) -> str:
    """Principal moments and axes, and which axes are not unique."""
    principal = body.principal
    rows = [(str(k + 1), number(principal.moments[k]), *(f"{x:.6f}" for x in principal.axes[k])) for k in range(3)]
    head = ("", "moment [kg m^2]", *(f"axis {name}" for name in AXES))
    remark = f"{principal.remark}\n" if principal.remark else ""
    return f"Principal moments about the centre of mass\n{page.table((head, rows))}{remark}"
