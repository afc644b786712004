"""Mass properties of a body as JSON has them."""

from __future__ import annotations

from typing import Any

from robodyn.solids.inertia.properties import MassProperties
from robodyn.solids.inertia.view import View

COM = View()


def body_data(body: MassProperties, view: View = COM) -> dict[str, Any]:
    """Keys and values; units are SI, matrices lists of rows, principal axes rows."""
    point, matrix = view.inertia(body)
    return {
        "mass": body.mass,
        "volume": body.volume,
        "area": body.area,
        "density": body.density,
        "com": body.com.tolist(),
        "inertia": body.inertia.tolist(),
        "inertia_about": {"point": point.tolist(), "matrix": matrix.tolist()},
        "principal": {"moments": body.principal.moments.tolist(), "axes": body.principal.axes.tolist()},
    }


def finite(value: float) -> float | None:
    """The value, or None where JSON has no number for it."""
    return value if abs(value) < float("inf") else None
