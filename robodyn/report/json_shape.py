"""Symmetry and tessellation error of a mesh as JSON has them."""

from __future__ import annotations

from typing import Any

from robodyn.part import Part
from robodyn.report.json_body import finite


def symmetry_data(part: Part) -> dict[str, Any] | None:
    """Planes, axes and products [kg m^2]; the fold of an axis of revolution is null."""
    found = part.symmetry
    if found is None:
        return None
    return {
        "planes": [
            {
                "normal": plane.normal.tolist(),
                "offset": plane.offset,
                "asymmetry": plane.asymmetry,
                "verdict": plane.verdict,
            }
            for plane in found.planes
        ],
        "axes": [
            {
                "direction": axis.direction.tolist(),
                "point": axis.point.tolist(),
                "fold": finite(axis.fold),
                "asymmetry": axis.asymmetry,
                "verdict": axis.verdict,
            }
            for axis in found.axes
        ],
        "products": [
            {
                "axes": product.axes,
                "computed": -product.residual * (part.body.density or 0.0),
                "relative": product.relative,
                "zero_by_symmetry": product.zero,
            }
            for product in found.products
        ],
    }


def tessellation_data(part: Part) -> dict[str, Any] | None:
    """Numbers of the mesh beside those of the smooth body; bars are relative."""
    found, smooth = part.tessellation, part.corrected
    if found is None or smooth is None:
        return None
    return {
        "volume": {
            "mesh": part.body.volume,
            "corrected": smooth.volume,
            "bar": found.mesh.volume,
            "bar_corrected": found.rest.volume,
        },
        "inertia": {
            "corrected": smooth.inertia.tolist(),
            "bar": found.mesh.inertia,
            "bar_corrected": found.rest.inertia,
        },
        "com": {"corrected": smooth.com.tolist()},
    }
