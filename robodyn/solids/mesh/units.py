"""Units of length of meshes."""

from __future__ import annotations

from robodyn.errors import MeshError

METRES = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "in": 0.0254}
"""Metres per unit, by the names that `unit` may have."""


def scale_of(unit: str | None, own: float | None, name: str) -> tuple[float, str]:
    """Metres per unit of the file, and the note about it.

    Args:
        unit: what the caller says, a key of METRES; it counts more than what the file says.
        own: metres per unit as the file says; None if it does not.

    Raises:
        MeshError: there is no such unit.
    """
    if unit is not None and unit not in METRES:
        raise MeshError(f"unknown unit {unit!r}", remedy=f"units: {', '.join(METRES)}", file=name)
    if unit is None:
        return (
            (1.0, "unit: metres, as the file says none") if own is None else (own, f"unit: {_named(own)} by the file")
        )
    given = METRES[unit]
    contrary = own is not None and abs(own - given) > 1e-9 * given
    return given, f"unit: {unit} as asked" + (f", though the file says {_named(own or 0.0)}" if contrary else "")


def _named(metres: float) -> str:
    return next((name for name, value in METRES.items() if value == metres), f"{metres:g} m")
