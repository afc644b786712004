"""What a closed mesh says about the body that it stands for: how symmetric it is, and what its facets leave out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from robodyn.solids.mesh.integrate.integrals import Integrals
from robodyn.solids.mesh.triangles import Triangles
from robodyn.support.input_limits import VARIABLE, limits

if TYPE_CHECKING:
    from robodyn.solids.mesh.symmetry.kinds import Symmetry
    from robodyn.solids.mesh.tessellation.bars import Tessellation

SYMMETRY_TRIANGLES = 30_000
"""Up to which symmetry is sought unasked: a tenth of a second on most parts of that size."""

TESSELLATION_TRIANGLES = 100_000
"""Up to which facets are asked unasked: a tenth of a second."""

_LARGEST = 1 << 24
"""Bytes of an array that may be needed again and again."""

_UNDEFINED = "symmetry and tessellation: not of sheets, and not of surfaces that are open or overlap themselves"


@dataclass(frozen=True, eq=False)
class Shape:
    """What was asked of a mesh.

    Attributes:
        symmetry: in metres; None where it was not sought. tessellation: None where facets were not asked.
        notes: why one of them is missing.
    """

    symmetry: Symmetry | None = None
    tessellation: Tessellation | None = None
    notes: tuple[str, ...] = ()


def shape(
    triangles: Triangles,
    integrals: Integrals,
    *,
    even: bool | None = None,
    smooth: bool | None = None,
    defined: bool = True,
    fixed_mass: bool = False,
) -> Shape:
    """Symmetry and tessellation error of a mesh that has a volume.

    Args:
        even: whether to seek symmetry, smooth: whether to ask facets; None: if there are few enough triangles.
        defined: whether the integrals are those of what the mesh encloses: it is closed and does not overlap itself.
        fixed_mass: see `tessellation`.
    """
    if not defined:
        return Shape(notes=() if (even, smooth) == (False, False) else (_UNDEFINED,))
    count = integrals.count
    seek, notes_even = _wanted("symmetry", even, count, SYMMETRY_TRIANGLES)
    ask, notes_smooth = _wanted("tessellation", smooth, count, TESSELLATION_TRIANGLES)
    if not seek and not ask:
        return Shape(notes=notes_even + notes_smooth)
    from robodyn.solids.mesh.symmetry.asymmetry import CentredBody
    from robodyn.solids.mesh.symmetry.symmetry import symmetry
    from robodyn.solids.mesh.tessellation.bars import tessellation

    _keep_what_is_freed()
    body = CentredBody.of(triangles, integrals)
    return Shape(
        symmetry(body).scaled(triangles.scale) if seek else None,
        tessellation(body.line_masses, integrals, body.centre, fixed_mass=fixed_mass) if ask else None,
        notes_even + notes_smooth,
    )


def _keep_what_is_freed() -> None:
    """Let glibc keep the memory of arrays up to this size for the next ones, as it does once one of them is freed.

    Without, every array of a few hundred kilobytes is new memory, and touching that is a sixth of the time.
    """
    np.empty(_LARGEST, np.uint8)


def _wanted(name: str, asked: bool | None, count: int, most: int) -> tuple[bool, tuple[str, ...]]:
    if asked and count > limits().mesh_shape:
        what = f"{name}: not sought above {limits().mesh_shape} triangles, for want of memory"
        return False, (f"{what} (simplify the mesh, or {VARIABLE}=mesh_shape=NUMBER allows more)",)
    if asked is not None or count <= most:
        return asked is not False, ()
    return False, (f"{name}: not sought unasked above {most} triangles (--{name} does)",)
