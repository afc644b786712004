"""Mass properties as accurate as asked: the arithmetic by its proven bound, and what the mesh itself leaves open."""

from __future__ import annotations

from dataclasses import replace

from robodyn.errors import InputError, MeshError
from robodyn.solids.mesh.integrate.integrals import LIMIT
from robodyn.solids.mesh_mass import Part

ROUNDING = 2.0**-53
"""Of a result to a float."""


def needs_rationals(target: float) -> bool:
    """Whether floats, which are escalated until their bounds are below 1e-12, are not enough for a relative error.

    Raises:
        InputError: no result in doubles can be that accurate.
    """
    if target < ROUNDING:
        what = f"an accuracy of {target:g} cannot be promised: results are doubles, which are rounded to {ROUNDING:.1e}"
        raise InputError(what, remedy=f"ask for {ROUNDING:.1e} or more")
    return target < LIMIT


def with_promise(part: Part, target: float) -> Part:
    """Return the part with a note that says by which arithmetic the target is met.

    Raises:
        MeshError: what the surface encloses is not known that well.

    Accuracy: bounds are proven for the triangles as given, whose own rounding is reported beside.
    """
    if part.union is not None and part.union > target:
        raise MeshError(
            f"an accuracy of {target:g} cannot be promised: what the surface encloses is known to {part.union:.0e}",
            remedy="mend overlaps and gaps, or ask for less",
            file=part.name,
        )
    rational = part.method == "rational"
    bound = f"{ROUNDING:.1e}" if rational else f"{LIMIT:.0e} (volume: {part.arithmetic:.0e})"
    name = "exact rationals" if rational else part.method
    data = f"; the rounding of the file can make {part.rounding:.0e} of it" if part.rounding > target else ""
    said = f"accuracy: {target:g} asked, proven within {bound} by {name}{data}"
    return replace(part, notes=(*part.notes, said))
