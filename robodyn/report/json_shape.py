"""Symmetry and tessellation error of a mesh as JSON has them."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from robodyn.report.json_body import finite
from robodyn.solids.mesh_mass import Part

if TYPE_CHECKING:
    from robodyn.solids.mesh.tessellation import Bars, Tessellation


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
    """Numbers of the mesh beside those of the smooth body.

    Bars are relative, of the centre in metres; null where nothing can be said. `bar_corners_on_surface` is that of the
    corrected numbers if the corners lie on the smooth surface, `bar_corrected` wherever they lie.
    """
    found, smooth = part.tessellation, part.corrected
    if found is None or smooth is None:
        return None
    return {
        "volume": {
            "mesh": part.body.volume,
            "corrected": smooth.volume,
            **_bars(found, lambda bars: bars.volume),
        },
        "inertia": {"corrected": smooth.inertia.tolist(), **_bars(found, lambda bars: bars.inertia)},
        "com": {"corrected": smooth.com.tolist(), **_bars(found, lambda bars: bars.centre * part.body.gyration)},
    }


def _bars(found: Tessellation, of: Callable[[Bars], float]) -> dict[str, float | None]:
    return {
        "bar": finite(of(found.mesh)),
        "bar_corrected": finite(of(found.rest)),
        "bar_corners_on_surface": finite(of(found.on_surface)),
    }
