"""What a description declares of its links against what their shapes make of the same mass."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from robodyn.errors import InputError, MeshError, RobodynError
from robodyn.programs.vectors import length, product
from robodyn.robot.load import placement
from robodyn.robot.masses.declared import LinkInertia, declared
from robodyn.robot.masses.likeness import Uniform
from robodyn.robot.masses.measured import MeshFile, Outcome, Reading
from robodyn.robot.masses.shapes import ShapesInertia, mesh_file, shapes_inertia
from robodyn.robot.masses.slips import Given
from robodyn.robot.masses.weighing import weigh
from robodyn.robot.urdf.geometry import Shape, link_shapes
from robodyn.robot.urdf.parts import Description, Inertial, Kind, Link
from robodyn.solids.inertia.properties import MassProperties
from robodyn.solids.inertia.validity import PRINTED, box_bound
from robodyn.support.floats import Floats, ranked
from robodyn.support.wording import one_of

UNCERTAIN = 1e-12
"""Relative differences below this are none: rounding makes them."""
_OTHER = 0.02
"""Corrections that are nearer to each other are one."""


@dataclass(frozen=True, eq=False)
class Difference:
    """How far declared properties are from those of the shapes at the same mass.

    Attributes:
        body: of the shapes, at the declared mass, in the link's frame.
        density: that the declared mass gives the shapes [kg/m^3].
        distance: of the centres of mass [m]; offset: (3,) from that of the shapes to the declared one.
        ratios: (3,) of declared to shapes' principal moments, both ascending.
        inertia: |I_declared - I_shapes| / |I_shapes| about the centres of mass, in Frobenius' norm.
        room: the most by which the declared spread exceeds what any mass inside the box around the shapes can have;
            above 1 no distribution of mass inside them is possible; see `box_bound`.
        slip: what explains the difference, if anything does; see `slip`.
        shapes: with remarks on them.
    """

    body: MassProperties
    density: float
    offset: Floats
    ratios: Floats
    inertia: float
    room: float
    slip: tuple[str, ...]
    shapes: ShapesInertia

    @property
    def distance(self) -> float:
        return length(self.offset)


@dataclass(frozen=True, eq=False)
class LinkComparison:
    """One link: what it declares, and the difference to its shapes or the reason why there is none."""

    name: str
    line: int
    shapes: tuple[Shape, ...]
    declared: LinkInertia | None
    difference: Difference | None
    reason: str | None

    @property
    def remarks(self) -> tuple[str, ...]:
        """What is impossible, and what is doubtful about the meshes."""
        found = () if self.declared is None else self.declared.faults
        if self.difference is None:
            return found
        difference = self.difference
        return found + _impossible(difference.room) + difference.slip + difference.shapes.remarks


def _impossible(room: float) -> tuple[str, ...]:
    if room <= 1 + PRINTED:
        return ()
    if room == np.inf:
        return ("the centre of mass lies outside the box around the shapes",)
    return (f"spread over {room:.3g} times what any mass inside the box around the shapes can be",)


@dataclass(frozen=True, eq=False)
class Comparison:
    """The links of a robot that have mass or shapes, the most different first, those that were not compared last.

    Links that differ equally, or by no more than rounding, stand in the order of the description.
    """

    name: str
    file: str
    kind: Kind
    links: tuple[LinkComparison, ...]


def compare(description: Description, kind: Kind = "visual", reading: Reading | None = None) -> Comparison:
    """Return declared against shape-derived mass properties; shapes have one density per link, by the mass.

    Args:
        kind: which shapes, "visual" or "collision".
        reading: how the meshes are read.
    """
    shapes = {link.name: link_shapes(description, link.name, kind) for link in description.links}
    wanted = [link for link in description.links if link.inertial or shapes[link.name]]
    files = [file for link in wanted if link.inertial for shape in shapes[link.name] if (file := mesh_file(shape))]
    meshes = (reading or Reading({})).parts(files)
    links = [_compared(description, link, kind, shapes[link.name], meshes) for link in wanted]
    return Comparison(description.name, description.file, kind, tuple(ranked(links, _rank, UNCERTAIN)))


def _rank(link: LinkComparison) -> float:
    return -1.0 if link.difference is None else link.difference.inertia


def _compared(
    description: Description, link: Link, kind: Kind, shapes: tuple[Shape, ...], meshes: Mapping[MeshFile, Outcome]
) -> LinkComparison:
    given = declared(link)
    difference, reason = None, None
    if given is None or link.inertial is None:
        reason = "no <inertial>"
    elif not shapes:
        reason = f"no <{kind}> shape"
    elif not given.body.mass > 0:
        reason = f"a mass of {given.body.mass:g} kg"
    else:
        try:
            difference = _difference(given.body, link.inertial, shapes_inertia(description, shapes, meshes))
        except RobodynError as error:
            reason = _reason(error)
    return LinkComparison(link.name, link.line, shapes, given, difference, reason)


def _reason(error: RobodynError) -> str:
    """Return what is wrong without the remedy, which is for a mesh on the command line."""
    if isinstance(error, MeshError) and error.file is not None:
        return f"{Path(error.file).name}: {error.what}"
    return error.what


def _difference(given: MassProperties, inertial: Inertial, shapes: ShapesInertia) -> Difference:
    body = shapes.body.scaled_to_mass(given.mass)
    if not (body.principal.moments > 0).all():
        raise InputError("the shapes are too small for floats")
    with np.errstate(over="ignore", invalid="ignore"):
        offset, ratios = given.com - body.com, given.principal.moments / body.principal.moments
        apart, density = relative(given.inertia, body.inertia), given.mass / float(shapes.body.volume or np.inf)
        figures = (*ratios, apart, density, length(offset))
    if not np.isfinite(figures).all():
        raise InputError("the declared numbers are too large for a comparison")
    return Difference(
        body=body,
        density=density,
        offset=offset,
        ratios=ratios,
        inertia=apart,
        room=box_bound(given, *shapes.box).worst,
        slip=slip(inertial, shapes.body),
        shapes=shapes,
    )


def relative(I: Floats, right: Floats) -> float:
    """Return |I - right| / |right| in Frobenius' norm."""
    return float(length(I - right) / length(right))


def slip(inertial: Inertial, shapes: MassProperties) -> tuple[str, ...]:
    """Return the slip that explains a declared inertial, in words, or those of which one does; at most one remark.

    See `robodyn.robot.masses.weighing`.

    Args:
        inertial: of positive mass.
        shapes: of one density, in the link's frame.
    """
    R, p = placement(inertial.origin)
    if not any(inertial.inertia) or not shapes.volume:
        return ()
    given = Given(inertial.mass, product(R.T, p), R, inertial.inertia)
    found = weigh(given, Uniform(shapes.volume, shapes.com, shapes.S_c / shapes.mass).along(R))
    if not found.named:
        either = one_of([one.what for one in found.either])
        return () if either is None else (either,)
    first = found.named[0]
    others = [one.what for one in found.named[1:] if relative(one.I, first.I) > _OTHER]
    agrees = f"corrected, the inertia agrees within {max(100 * first.apart, 0.1):.1f} %"
    return (f"{' or '.join(dict.fromkeys((first.what, *others)))}: {agrees}",)
