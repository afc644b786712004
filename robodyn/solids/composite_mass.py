"""Parts fixed to each other as one rigid body."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from robodyn.errors import InputError
from robodyn.programs.vectors import IDENTITY, ZERO
from robodyn.solids.inertia.properties import MassProperties, Pose, composite
from robodyn.solids.inertia.validity import Box, around, counted_twice
from robodyn.solids.mesh_mass import Part

HOME: Pose = (IDENTITY, ZERO)


@dataclass(frozen=True, eq=False)
class Combination:
    """Parts at their places, and the body that they make.

    Attributes:
        parts: as measured, each in its own axes; poses: of these in the common frame.
        body: in the common frame.
        box: around the parts, along the common axes.
        warnings: what is doubtful about the whole.
    """

    parts: tuple[Part, ...]
    poses: tuple[Pose, ...]
    body: MassProperties
    box: Box
    warnings: tuple[str, ...]

    @property
    def placed(self) -> tuple[MassProperties, ...]:
        """The parts' bodies in the common frame."""
        return tuple(part.body.placed(*pose) for part, pose in zip(self.parts, self.poses, strict=True))


def combined(parts: Sequence[Part], poses: Sequence[Pose] = (), mass: float | None = None) -> Combination:
    """Return the composite body of parts; see `composite`.

    Args:
        poses: of each part; all in the common frame as they are if empty.
        mass: of the whole [kg], in which the parts then share as they did.

    Raises:
        InputError: there are not as many poses as parts, or the mass is not positive.
    """
    if poses and len(poses) != len(parts):
        raise InputError(f"{len(poses)} places for {len(parts)} meshes", remedy="give one for each mesh, in order")
    where = tuple(poses) or (HOME,) * len(parts)
    body = composite(zip((part.body for part in parts), where, strict=True))
    if mass is not None:
        if not 0 < mass < float("inf"):
            raise InputError(f"a mass of {mass:g} kg is not positive and finite")
        shares = [mass * part.body.mass / body.mass for part in parts]
        parts = [_weighing(part, share) for part, share in zip(parts, shares, strict=True)]
        body = body.scaled_to_mass(mass)
    boxes = [Box(part.lo, part.hi).placed(*pose) for part, pose in zip(parts, where, strict=True)]
    return Combination(tuple(parts), where, body, around(boxes), counted_twice(boxes))


def _weighing(part: Part, mass: float) -> Part:
    smooth = part.corrected and part.corrected.scaled_to_mass(mass)
    return replace(part, body=part.body.scaled_to_mass(mass), corrected=smooth, assumed=False)
