"""Sizes and scales of shapes are positive.

A box, cylinder, sphere or capsule without size, or a mesh with a scale of zero, is refused by some
programs (MuJoCo 4.0 and Drake 1.51, run) and dropped by others. One or three negative scales make a mirror image, whose
faces look inwards unless the program turns them: MuJoCo, Drake and trimesh 4 do, and have its volume right; Pinocchio
4.1 does not, and has a negative volume and a negative inertia of the shape (all run on one tetrahedron). Shapes are
where they should be in all four. So this is a warning in a <collision>, and a remark where the mesh is only a <visual>,
or stands unmirrored in the robot, too: both sides of a robot are often made of one mesh.
Two negative scales are half a turn, right in all four, and a remark.
"""

from math import prod

from robodyn.checks.examples import a_shaped_link
from robodyn.checks.meshes.files import MeshUse, mesh_uses
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule


@rule(Severity.ERROR, good=a_shaped_link(), bad=('"0.1 0.1 0.25"', '"0.1 0 0.25"'), explains=("RD901",))
def check(context: Context) -> Faults:
    for geometry in (geometry for link in context.view.links for geometry in link.geometries):
        for size in geometry.sizes:
            if geometry.shape is not None and size.values is not None and min(size.values) <= 0:
                what = f"the {size.attribute} of the <{geometry.kind}> {geometry.shape.tag} is {_shown(size.values)}"
                remedy = "write the size in metres, or remove the shape"
                yield Fault(size.span, f"{what}, not positive", remedy, min(size.values), 0.0)
    scaled: dict[tuple[str, tuple[float, ...]], list[MeshUse]] = {}
    for use in mesh_uses(context):
        scale = use.geometry.scale.or_default(1.0, 1.0, 1.0)
        if scale is not None:
            scaled.setdefault((use.uri, scale), []).append(use)
    for (uri, scale), uses in scaled.items():
        if min(scale) <= 0:
            yield _scale(uses, scale, any(_unmirrored(other, scale) for name, other in scaled if name == uri))


def _unmirrored(other: tuple[float, ...], scale: tuple[float, ...]) -> bool:
    """Return whether a scale is another up to its signs, and mirrors nothing."""
    return prod(other) > 0 and [*map(abs, other)] == [*map(abs, scale)]


def _scale(uses: list[MeshUse], scale: tuple[float, ...], both: bool) -> Fault:
    """Return one finding for all uses of a mesh with one scale; `both` if it stands unmirrored somewhere, too."""
    if 0 in scale:
        severity, remedy = Severity.ERROR, 'write scale="1 1 1", or leave it out'
        what = "leaves no volume"
    elif sum(value < 0 for value in scale) % 2:
        harmless = both or all(use.geometry.kind == "visual" for use in uses)
        severity = Severity.NOTE if harmless else Severity.WARNING
        remedy = "export the mesh of this part, mirrored"
        what = "mirrors the mesh: to programs that do not turn its faces, its volume is negative"
    else:
        severity, remedy = Severity.NOTE, "export the mesh of this part, or turn it by rpy"
        what = "turns the mesh by half a turn, which every known program does"
    more = f" (and {len(uses) - 1} more of this mesh)" if len(uses) > 1 else ""
    what = f"the scale {_shown(scale)} {what}{more}"
    return Fault(uses[0].geometry.scale.span, what, remedy, min(scale), 0.0, severity=severity)


def _shown(values: tuple[float, ...]) -> str:
    return " ".join(f"{value:g}" for value in values)
