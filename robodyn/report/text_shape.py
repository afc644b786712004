"""Symmetry and tessellation error of a mesh as text for a person."""

from __future__ import annotations

from math import inf, isfinite
from typing import TYPE_CHECKING

import numpy as np

from robodyn.report.table import Page, is_noise, number
from robodyn.report.text_body import point_text
from robodyn.solids.mesh_mass import Part

if TYPE_CHECKING:
    from robodyn.solids.mesh.symmetry_kinds import Axis, Plane
    from robodyn.solids.mesh.tessellation import Bars

_UNKNOWN = "an unknown amount (facets too coarse)"
_MOST = 9
"""Planes and axes that are listed; of the others there is a count."""


def symmetry_text(part: Part, page: Page) -> str:
    """Planes and axes that hold or nearly do, and the products that are 0 by them; nothing where none were sought."""
    found = part.symmetry
    if found is None:
        return ""
    reach = float(np.abs((part.lo, part.hi)).max())
    things: list[Plane | Axis] = [*found.planes, *found.axes]
    rows = [_row(thing, reach) for thing in things if thing.verdict != "none"]
    if not rows:
        least = [f"; the nearest plane leaves {_percent(plane.asymmetry)} outside" for plane in found.planes[:1]]
        return f"Symmetry\nnone{''.join(least)}\n\n"
    more = f"and {len(rows) - _MOST} more\n" if len(rows) > _MOST else ""
    table = page.table((("", "normal or axis", "at", "asymmetry", "verdict"), rows[:_MOST]))
    return f"Symmetry\n{table}{more}{_zeros(part)}\n"


def tessellation_text(part: Part) -> str:
    """How far facets leave the numbers from those of a smooth body; nothing where they were not asked."""
    found, smooth = part.tessellation, part.corrected
    if found is None or smooth is None:
        return ""
    if not found.mesh.volume:
        return "tessellation: no facets that may stand for a curved face\n"
    moments = ", ".join(number(x) for x in smooth.principal.moments)
    reach = float(np.abs((part.lo, part.hi)).max())
    meant, tight, wide = (_bars(bars, part.body.gyration) for bars in (found.mesh, found.on_surface, found.rest))
    volume, inertia, centre = (f"within {on}, else {off}" for on, off in zip(tight, wide, strict=True))
    return (
        "tessellation: if facets are meant flat, nothing is missing; if they stand for smooth faces, the volume is off "
        f"by up to {meant[0]}, the inertia by {meant[1]}, the centre of mass by {meant[2]}\n"
        f"with smooth faces through the corners: volume {number(smooth.volume or 0.0)} m^3, "
        f"principal moments {moments} kg m^2, centre of mass {point_text(smooth.com, reach)} m\n"
        f"if the corners are on them: volume {volume}; inertia {inertia}; centre of mass {centre}\n"
    )


def _bars(bars: Bars, gyration: float) -> tuple[str, str, str]:
    """Of volume, inertia and centre of mass."""
    centre = bars.centre * gyration
    length = f"{centre:.1g} m" if isfinite(centre) else _UNKNOWN
    return _percent(bars.volume), _percent(bars.inertia), length


def _row(thing: Plane | Axis, reach: float) -> tuple[str, ...]:
    from robodyn.solids.mesh.symmetry_kinds import Plane

    if isinstance(thing, Plane):
        name, direction, place = "plane", thing.normal, number(thing.offset, reach)
    else:
        name = "axis of revolution" if thing.fold == inf else f"axis, {thing.fold:.0f}-fold"
        direction, place = thing.direction, point_text(thing.point, reach)
    along = ", ".join(f"{x + 0.0:.4g}" for x in direction.round(9))
    return name, f"({along})", f"{place} m", _short(thing.asymmetry, 1.0), thing.verdict


def _zeros(part: Part) -> str:
    """The products that are 0 by symmetry, with what was computed."""
    products = [product for product in part.symmetry.products if product.zero] if part.symmetry else []
    if not products or part.body.density is None:
        return ""
    density, scale = part.body.density, float(np.trace(part.body.inertia))
    computed = ", ".join(_short(-product.residual * density, scale) for product in products)
    return f"0 by symmetry: I{', I'.join(product.axes for product in products)} (computed {computed} kg m^2)\n"


def _short(value: float, scale: float) -> str:
    """One digit; 0 for what vanishes beside `scale`."""
    return "0" if is_noise(abs(value), scale) else f"{value:.0e}"


def _percent(share: float) -> str:
    return f"{100 * share:.2g} %" if isfinite(share) else _UNKNOWN
