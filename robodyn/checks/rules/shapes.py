"""Visual and collision shapes: sizes, misfits, overlaps."""

from __future__ import annotations

from math import prod

import numpy as np

from robodyn.checks.bodies.collision_fit import misfits
from robodyn.checks.bodies.contacts import detached, overlaps
from robodyn.checks.bodies.shapes import real_shapes, solids
from robodyn.checks.examples import a_shaped_link, a_tower
from robodyn.checks.meshes.files import MeshUse, mesh_uses
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule
from robodyn.robot.urdf.parts import SHAPES


@rule("RD606", Severity.ERROR, good=a_shaped_link(), bad=('"0.1 0.1 0.25"', '"0.1 0 0.25"'), explains=("RD901",))
def shape_size(context: Context) -> Faults:
    """Sizes and scales of shapes are positive.

    A box, cylinder, sphere or capsule without size, or a mesh with a scale of zero, is refused by MuJoCo and Drake and
    dropped by others. One or three negative scales make a mirror image, whose faces look inwards unless the program
    turns them: MuJoCo, Drake and trimesh do, and have its volume right; Pinocchio 4.1 has a negative volume and inertia
    of the shape. So this is a warning in a <collision>, and a remark where the mesh is only a <visual>, or stands
    unmirrored in the robot, too. Two negative scales are half a turn, right in all four, and a remark.
    """
    for geometry in (geometry for link in context.view.links for geometry in link.geometries):
        for size in geometry.sizes:
            if size.values is not None and min(size.values) <= 0:
                what = f"the {size.attribute} of the <{geometry.kind}> {geometry.tag} is {_shown(size.values)}"
                remedy = "write the size in metres, or remove the shape"
                yield Fault(size.span, f"{what}, not positive", remedy, min(size.values), 0.0)
    scaled: dict[tuple[str, tuple[float, ...]], list[MeshUse]] = {}
    for use in mesh_uses(context):
        scale = use.geometry.scale.or_default(1.0, 1.0, 1.0)
        if scale is not None:
            scaled.setdefault((use.geometry.uri, scale), []).append(use)
    for (uri, scale), uses in scaled.items():
        if min(scale) <= 0:
            alike = [other for name, other in scaled if name == uri and [*map(abs, other)] == [*map(abs, scale)]]
            yield _scale(uses, scale, any(prod(other) > 0 for other in alike))


def _scale(uses: list[MeshUse], scale: tuple[float, ...], both: bool) -> Fault:
    """One finding for all uses of a mesh with one scale; `both` if it stands unmirrored somewhere, too."""
    severity = Severity.NOTE
    if 0 in scale:
        severity, what, remedy = Severity.ERROR, "leaves no volume", 'write scale="1 1 1", or leave it out'
    elif sum(value < 0 for value in scale) % 2:
        if not both and any(use.geometry.kind != "visual" for use in uses):
            severity = Severity.WARNING
        what = "mirrors the mesh: to programs that do not turn its faces, its volume is negative"
        remedy = "export the mesh of this part, mirrored"
    else:
        what = "turns the mesh by half a turn, which every known program does"
        remedy = "export the mesh of this part, or turn it by rpy"
    more = f" (and {len(uses) - 1} more of this mesh)" if len(uses) > 1 else ""
    what = f"the scale {_shown(scale)} {what}{more}"
    return Fault(uses[0].geometry.scale.span, what, remedy, min(scale), 0.0, severity=severity)


def _shown(values: tuple[float, ...]) -> str:
    return " ".join(f"{value:g}" for value in values)


@rule(
    "RD608",
    Severity.WARNING,
    good=a_shaped_link(),
    bad=('<geometry><box size="0.1 0.1 0.25"/></geometry>', "<geometry/>"),
)
def no_shape(context: Context) -> Faults:
    """A <visual> and a <collision> have a shape, and one only.

    urdfdom drops a <visual> or <collision> without <geometry>, or whose <geometry> holds none of box, cylinder, sphere,
    capsule and mesh, and with it what follows in that link. Of two shapes in one <geometry> every reader takes one, and
    not the same one.
    """
    for link in context.view.links:
        for geometry in link.geometries:
            inside = geometry.element.find("geometry")
            shapes = [child for child in inside.children if child.tag in SHAPES] if inside is not None else []
            if shapes[1:]:
                what = f"the <geometry> has {len(shapes)} shapes: readers take one of them"
                yield Fault(shapes[1].span, what, f"write a <{geometry.kind}> for each")
            if geometry.shape is not None:
                continue
            what = f"the <{geometry.kind}> has no " + ("<geometry>" if inside is None else "shape in its <geometry>")
            remedy = f"write one of <{'>, <'.join(SHAPES)}>, or delete the <{geometry.kind}>"
            yield Fault((geometry.element if inside is None else inside).span, f"{what}: urdfdom drops it", remedy)


_BOX = '<geometry><box size="0.1 0.1 0.25"/></geometry>'


@rule(
    "RD609",
    Severity.WARNING,
    Stage.TREE,
    good=a_shaped_link().replace(
        "<inertial>", f'<collision><origin xyz="0 0 0.125"/>{_BOX}</collision>\n    <inertial>', 2
    ),
    bad=('<collision><origin xyz="0 0 0.125"/>', "<collision>"),
)
def collision_misfit(context: Context) -> Faults:
    """What collides is where and what is seen.

    A collision mesh or primitive that is also a visual of the link stands where that stands; a collision mesh has the
    size of the visual one, and is not that of another link; and there is no gap as wide as half the link between the
    two. Shapes that are simpler on purpose are not judged by their size, unless a box, cylinder or sphere is 20 times
    as large as what is seen, or a cylinder fits that by exchanging its radius and length; meshes of one part differ by
    up to 10 % in the sides of their boxes. A shape less than 15 % of its size or 1 cm away is passed over. One mesh
    each for both, whose boxes share at most a fifth of their volume, are two parts, or one that is turned.
    """
    for geometry, what, remedy, measured, bound, cause in context.once(misfits):
        at = geometry.element if geometry.origin.element is None else geometry.origin.element
        at = at if cause is None or geometry.shape is None else geometry.shape
        yield Fault(at.span, what, remedy, measured, bound, cause=cause)


_SHOWN = 3


@rule(
    "RD610",
    Severity.NOTE,
    Stage.TREE,
    good=a_tower("collision"),
    bad=('child link="tool"/><origin xyz="0 0 0.1"/>', 'child link="tool"/><origin xyz="0 0 -0.08"/>'),
)
def self_overlap(context: Context) -> Faults:
    """Parts that no joint connects do not overlap at rest.

    A simulator that lets a robot collide with itself pushes such parts apart at the first step: the robot jumps. The
    convex hulls of collision shapes are compared, which MuJoCo and Drake collide, each joint at 0 or at its limit next
    to 0. Reported, once for a file, are pairs of links that overlap by more than 1 cm and a tenth of the smaller shape.
    Left out are neighbours, pairs that the SRDF disables, and shapes that RD609 reports. It is a remark, for many
    robots fold into themselves where all joints are at 0.
    """
    found = [] if context.once(detached) else overlaps(context)
    if not found:
        return
    worst, *others = found
    what = f"at rest it reaches {worst.depth:.3g} m into link '{worst.first.name}', which is no neighbour of it"
    if others:
        more = [f"'{one.second.name}' and '{one.first.name}' {one.depth:.3g} m" for one in others[:_SHOWN]]
        rest = f" and {len(others) - _SHOWN} more" if len(others) > _SHOWN else ""
        what += f"; so do {', '.join(more)}{rest}"
    remedy = "give it simpler collision shapes or several convex ones, or disable the pair in the SRDF"
    yield Fault(worst.shape.element.span, what, remedy, worst.depth, 0.0)


_THIN = 1e-5
_THINNER = 1e-3
"""Of the longest side."""
_COLLISION = '<collision><geometry><box size="0.1 0.1 0.25"/></geometry></collision>'


@rule(
    "RD611",
    Severity.WARNING,
    Stage.TREE,
    good=a_shaped_link().replace("<visual>", f"{_COLLISION}\n    <visual>"),
    bad=('<collision><geometry><box size="0.1 0.1 0.25"/>', '<collision><geometry><box size="0.1 1e-6 0.25"/>'),
    explains=("RD609",),
)
def flat_shape(context: Context) -> Faults:
    """Collision shapes have a thickness.

    A mesh in a plane, and a box 1 um thick, have no volume: MuJoCo refuses such a mesh, and contacts with it pass
    through in others. Reported are collision shapes thinner than 10 um and than a thousandth of their longest side.
    What is only seen may be a label, and be flat.
    """
    known = context.once(solids)
    for shape in (shape for link in context.view.links for shape in real_shapes(link)):
        if shape not in known or shape.shape is None or shape.kind == "visual":
            continue
        sides = known[shape].box.hi - known[shape].box.lo
        thin, most = float(sides.min()), min(_THIN, _THINNER * float(sides.max()))
        if thin < most:
            what = f"the collision {shape.tag} is flat: {thin:.3g} m thick along its {'xyz'[int(np.argmin(sides))]}"
            yield Fault(shape.shape.span, f"{what} axis", "give it a thickness", thin, most)
