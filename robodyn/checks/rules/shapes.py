"""Visual and collision shapes: sizes, misfits, overlaps; their materials, colours and textures."""

from __future__ import annotations

from math import prod

import numpy as np

from robodyn.checks.bodies.bodies import real_shapes, solids
from robodyn.checks.bodies.collision_fit import misfits
from robodyn.checks.bodies.contacts import detached, overlaps
from robodyn.checks.examples import a_shaped_link, a_tower, arm
from robodyn.checks.meshes.files import MeshSearch, MeshUse, mesh_uses
from robodyn.checks.rule import ERROR, NOTE, TREE, WARNING, Context, Fault, Faults, namesakes, rule
from robodyn.checks.rules.text import own_elements
from robodyn.robot.urdf.document import Element, unexpanded
from robodyn.robot.urdf.parts import SHAPES
from robodyn.robot.urdf.view import Subject, numbers, value_span
from robodyn.support.wording import alternatives, count, figure, shown, shown_path


@rule("RD606", ERROR, good=a_shaped_link(), bad=('"0.1 0.1 0.25"', '"0.1 0 0.25"'), explains=("RD901",))
def shape_size(context: Context) -> Faults:
    """Sizes and scales of shapes are positive.

    A box, cylinder, sphere or capsule without size, or a mesh with a scale of zero, is refused by MuJoCo and Drake and
    dropped by others; one of size zero that is only seen is a remark. One or three negative scales make a mirror image,
    whose faces look inwards unless the program turns them: MuJoCo, Drake and trimesh do, and have its volume right;
    Pinocchio 4.1 has a negative volume and inertia of the shape. So this is a warning in a <collision>, and a remark
    where the mesh is only a <visual>, or stands unmirrored in the robot, too. Two are half a turn, a remark."""
    for geometry in (geometry for link in context.view.links for geometry in link.geometries):
        for size in geometry.sizes:
            if size.values is not None and min(size.values) <= 0:
                what = f"the {size.attribute} of the <{geometry.kind}> {geometry.tag} is {_shown(size.values)}"
                remedy = "write the size in metres, or remove the shape"
                severity = NOTE if geometry.kind == "visual" and min(size.values) == 0 else None
                yield Fault(size.span, f"{what}, not positive", remedy, min(size.values), 0.0, severity=severity)
    scaled: dict[tuple[str, tuple[float, ...]], list[MeshUse]] = {}
    for use in mesh_uses(context):
        scale = use.geometry.scale.or_default(1.0, 1.0, 1.0)
        if scale is not None:
            scaled.setdefault((use.geometry.uri, scale), []).append(use)
    for (uri, scale), uses in scaled.items():
        if min(scale) > 0:
            continue
        alike = [other for name, other in scaled if name == uri and [*map(abs, other)] == [*map(abs, scale)]]
        severity = NOTE
        if 0 in scale:
            severity, what, remedy = ERROR, "leaves no volume", 'write scale="1 1 1", or leave it out'
        elif sum(value < 0 for value in scale) % 2:
            if all(prod(other) <= 0 for other in alike) and any(use.geometry.kind != "visual" for use in uses):
                severity = WARNING
            what = "mirrors the mesh: to programs that do not turn its faces, its volume is negative"
            remedy = "export the mesh of this part, mirrored"
        else:
            what = "turns the mesh by half a turn, which every known program does"
            remedy = "export the mesh of this part, or turn it by rpy"
        what = f"the scale {_shown(scale)} {what}" + (f" (and {len(uses) - 1} more of this mesh)" if uses[1:] else "")
        yield Fault(uses[0].geometry.scale.span, what, remedy, min(scale), 0.0, severity=severity)


def _shown(values: tuple[float, ...]) -> str:
    return " ".join(f"{value:g}" for value in values)


@rule("RD608", WARNING, good=a_shaped_link(), bad=('<geometry><box size="0.1 0.1 0.25"/></geometry>', "<geometry/>"))
def no_shape(context: Context) -> Faults:
    """A <visual> and a <collision> have a shape, and one only.

    urdfdom drops a <visual> or <collision> without <geometry>, or whose <geometry> holds none of box, cylinder, sphere,
    capsule and mesh, and with it what follows in that link. Of two shapes in one <geometry> readers take one or the
    other."""
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
    WARNING,
    TREE,
    good=a_shaped_link().replace(
        "<inertial>", f'<collision><origin xyz="0 0 0.125"/>{_BOX}</collision>\n    <inertial>', 2
    ),
    bad=('<collision><origin xyz="0 0 0.125"/>', "<collision>"),
    explains=("RD406",),
)
def collision_misfit(context: Context) -> Faults:
    """What collides is where and what is seen.

    A collision mesh or primitive that is also a visual of the link stands where that stands; a collision mesh has the
    size of the visual one, and is not that of another link; and there is no gap as wide as half the link between the
    two. Shapes that are simpler on purpose are not judged by their size, unless a box, cylinder or sphere is 20 times
    as large as what is seen, or a cylinder fits that by exchanging its radius and length; meshes of one part differ by
    up to 10 % in the sides of their boxes. A shape less than 15 % of its size or 1 cm away is passed over. One mesh
    each for both, whose boxes share at most a fifth of their volume, are two parts, or one that is turned. Files called
    visual that collide while those called collision are seen, or ten times the faces in place of fewer, are exchanged
    with each other, where at least twice as many links have it the other way."""
    for geometry, what, remedy, measured, bound, cause in context.once(misfits):
        at = geometry.element if geometry.origin.element is None else geometry.origin.element
        at = at if cause is None or geometry.shape is None else geometry.shape
        yield Fault(at.span, what, remedy, measured, bound, cause=cause)


_SHOWN = 3


@rule(
    "RD610",
    NOTE,
    TREE,
    good=a_tower("collision"),
    bad=('child link="tool"/><origin xyz="0 0 0.1"/>', 'child link="tool"/><origin xyz="0 0 -0.08"/>'),
)
def self_overlap(context: Context) -> Faults:
    """Parts that no joint connects do not overlap at rest.

    A simulator that lets a robot collide with itself pushes such parts apart at the first step: the robot jumps. The
    convex hulls of collision shapes are compared, which MuJoCo and Drake collide, each joint at 0 or at its limit next
    to 0. Reported, once for a file, are pairs of links that overlap by more than 1 cm and a tenth of the smaller shape.
    Left out are neighbours, pairs that the SRDF disables, and shapes that RD609 reports. It is a remark, for many
    robots fold into themselves where all joints are at 0."""
    found = [] if context.once(detached) else overlaps(context)
    if not found:
        return
    (depth, first, _, shape), *others = found
    what = f"at rest it reaches {depth:.3g} m into link '{first.name}', which is no neighbour of it"
    if others:
        more = [f"'{two.name}' and '{one.name}' {deep:.3g} m" for deep, one, two, _ in others[:_SHOWN]]
        rest = f" and {len(others) - _SHOWN} more" if len(others) > _SHOWN else ""
        what += f"; so do {', '.join(more)}{rest}"
    remedy = "give it simpler collision shapes or several convex ones, or disable the pair in the SRDF"
    yield Fault(shape.element.span, what, remedy, depth, 0.0)


_THIN = 1e-5
_THINNER = 1e-3  # of the longest side
_COLLISION = '<collision><geometry><box size="0.1 0.1 0.25"/></geometry></collision>'


@rule(
    "RD611",
    WARNING,
    TREE,
    good=a_shaped_link().replace("<visual>", f"{_COLLISION}\n    <visual>"),
    bad=('<collision><geometry><box size="0.1 0.1 0.25"/>', '<collision><geometry><box size="0.1 1e-6 0.25"/>'),
    explains=("RD609",),
)
def flat_shape(context: Context) -> Faults:
    """Collision shapes have a thickness.

    A mesh in a plane, and a box 1 um thick, have no volume: MuJoCo refuses such a mesh, and contacts with it pass
    through in others. Reported are collision shapes thinner than 10 um and than a thousandth of their longest side.
    What is only seen may be a label, and be flat."""
    known = context.once(solids)
    for shape in (shape for link in context.view.links for shape in real_shapes(link)):
        if shape not in known or shape.shape is None or shape.kind == "visual":
            continue
        sides = known[shape].box.hi - known[shape].box.lo
        thin, most = float(sides.min()), min(_THIN, _THINNER * float(sides.max()))
        if thin < most:
            what = f"the collision {shape.tag} is flat: {thin:.3g} m thick along its {'xyz'[int(np.argmin(sides))]}"
            yield Fault(shape.shape.span, f"{what} axis", "give it a thickness", thin, most)


_SEEN = 0.1  # two colours that differ by more in a number are two
_SHAPE = """<link name="base">
    <visual><geometry><box size="0.1 0.1 0.1"/></geometry><material name="grey"/></visual>
  </link>"""
_GREY = '\n  <material name="grey"><color rgba="0.5 0.5 0.5 1"/></material>'


@rule(
    "RD621",
    WARNING,
    good=arm(more=_GREY).replace('<link name="base"/>', _SHAPE),
    bad=arm().replace('<link name="base"/>', _SHAPE),
    explains=("RD901",),
)
def undefined_material(context: Context) -> Faults:
    """A material that is named is defined, once, in one colour.

    Where a <material> has a name and neither color nor texture, and no other of that name has them, viewers draw the
    link in a colour of their own. Two <material> of one name in <robot> make urdfdom refuse the file; a <material>
    without a name makes it drop the shape, and what follows in that link. Of two colours of one name urdfdom takes the
    first for all shapes, others each shape's own, and Drake refuses them."""
    root = context.view.root
    shared = root.findall("material")
    local = [
        material
        for link in context.view.links
        for geometry in link.geometries
        for material in geometry.element.findall("material")
    ]
    for again, first in namesakes(shared):
        twice = again.get("name") or ""
        what = f"a second <material> {shown(twice)} in <robot> after line {first.line}: urdfdom refuses the file"
        at, subject = value_span(again, "name"), Subject("material", twice)
        yield Fault(at, what, "keep one of them", subject=subject, severity=ERROR)
    seen, told = dict[str, tuple[Element, tuple[float, ...]]](), set()
    for material, is_used in (*((each, False) for each in shared), *((each, True) for each in local)):
        name, rgba = material.get("name"), numbers(material.find("color"), "rgba", 4).values
        if not name or rgba is None:
            continue
        other, colour = seen.setdefault(name, (material, rgba))
        if is_used and name not in told and any(abs(a - b) > _SEEN for a, b in zip(rgba, colour, strict=True)):
            told.add(name)
            here, there = (" ".join(map(figure, each)) for each in (rgba, colour))
            what = f"the <material> {shown(name)} is {here} here and {there} in line {other.line}"
            yield Fault(value_span(material, "name"), what, "give one of the two another name")
    defined = dict.fromkeys(material.get("name") for material in (*shared, *local) if _looks(material))
    undefined: dict[str, list[Element]] = {}
    for material in local:
        name = material.get("name")
        if name is None and material.children:
            what = "the <material> has no name: urdfdom drops the shape"
            yield Fault(material.span, what, 'write name="..."', severity=ERROR)
        if name and name not in defined and not _looks(material):
            undefined.setdefault(name, []).append(material)
    for missing, uses in undefined.items():
        more = f" (used by {count(len(uses), 'shape')})" if uses[1:] else ""
        what = f"no <material> {shown(missing)} has a color or a texture{more}"
        remedy = alternatives(missing, [each for each in defined if each], "materials")
        yield Fault(value_span(uses[0], "name"), what, remedy)


def _looks(material: Element) -> bool:
    return any(child.tag in ("color", "texture") for child in material.children)


_RED = '\n  <material name="red"><color rgba="0.8 0.1 0.1 1"/></material>'


@rule("RD622", WARNING, good=arm(more=_RED), bad=("0.8 0.1 0.1", "204 26 26"), explains=("RD901",))
def colour_range(context: Context) -> Faults:
    """Colours are four numbers from 0 to 1: red, green, blue and opacity.

    urdfdom drops a colour with a number outside; others show it white, or black. Numbers to 255 are the most frequent
    cause. An opacity of 0 is a shape that nobody sees, which some do on purpose."""
    for element, _, subject in context.once(own_elements):
        rgba = numbers(element, "rgba", 4) if element.tag == "color" else None
        if rgba is None or rgba.values is None or all(0 <= value <= 1 for value in rgba.values):
            continue
        worst = max(rgba.values, key=lambda value: abs(value - 0.5))
        bytewise = worst > 1 and all(0 <= value <= 255 for value in rgba.values)
        first = " ".join(f"{figure(value / 255)}" for value in rgba.values[:3])
        remedy = f'divide by 255: "{first} 1"' if bytewise and worst > 2 else "write four numbers from 0 to 1"
        what = f"the color has {figure(worst)}, which is not from 0 to 1: urdfdom drops it"
        yield Fault(rgba.span, what, remedy, worst, 1.0 if worst > 1 else 0.0, subject=subject)


_WOOD = '\n  <material name="wood"><texture filename="package://part/wood.png"/></material>'


@rule("RD623", WARNING, good=arm(more=_WOOD), bad=("package://part/wood.png", "package:///wood.png"))
def texture_missing(context: Context) -> Faults:
    """Every texture is there.

    Viewers draw the shape white, or say so at each frame, where it is missing. Names are looked up as those of
    meshes."""
    meshes = MeshSearch(context)
    seen = set()
    for element, _, subject in context.once(own_elements):
        uri = element.get("filename") if element.tag == "texture" else None
        if not uri or unexpanded(uri) or uri in seen:
            continue
        seen.add(uri)
        state = meshes.find(uri, ()).state
        if state in ("not there", "there in another case"):
            what, remedy = f"the texture {shown_path(uri)} is {state}", "correct its name, or delete <texture>"
            yield Fault(value_span(element, "filename"), what, remedy, subject=subject)
