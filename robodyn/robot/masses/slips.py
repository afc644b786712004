"""Slips of export by which a declared inertia matrix differs from the right one."""

from __future__ import annotations

import numpy as np

from robodyn.programs.vectors import ZERO, length
from robodyn.solids.inertia.properties import MassProperties
from robodyn.support.floats import Floats, first_largest

_MUCH = 0.1
_AGREES = 0.05


def relative(I: Floats, right: Floats) -> float:
    """|I - right| / |right| in Frobenius' norm."""
    return float(length(I - right) / length(right))


def slip(given: Floats, right: MassProperties) -> tuple[str, ...]:
    """The slip that explains a declared inertia matrix [kg m^2], in words, if one does: at most one.

    A slip explains it if it leaves a difference of at most 5 %, and a tenth of that without it. Known are products of
    inertia with the opposite sign, a matrix about the origin of the link's frame in place of the centre of mass, and a
    factor of a power of ten, as a wrong unit leaves.
    """
    own, size = right.inertia, length(given)
    apart = relative(given, own)
    if apart <= _AGREES:
        return ()
    mirrored = 2 * np.diag(np.diagonal(own)) - own
    power = 10.0 ** round(np.log10(size / length(own))) if size else 1.0
    slips = (
        ("the products of inertia had the opposite sign", mirrored),
        ("it were meant about the origin of the link's frame", right.about(ZERO)),
        (f"it were divided by {power:g}", power * own),
    )
    found = [(relative(given, wrong), what) for what, wrong in slips]
    rest, what = found[first_largest([-rest for rest, _ in found])]
    if rest > min(_AGREES, _MUCH * apart):
        return ()
    return (f"the declared inertia would agree within {max(100 * rest, 0.1):.1f} % if {what}",)
