"""A <visual> and a <collision> have a shape, and one only.

urdfdom drops a <visual> or <collision> without <geometry>, or whose <geometry> holds none of box,
cylinder, sphere, capsule and mesh, and with it what follows in that link: also shapes that are in order are not there.
Of two shapes in one <geometry> every reader takes one, and not the same one.
"""

from robodyn.checks.examples import a_shaped_link
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.robot.urdf.parts import SHAPES


@rule(Severity.WARNING, good=a_shaped_link(), bad=('<geometry><box size="0.1 0.1 0.25"/></geometry>', "<geometry/>"))
def check(context: Context) -> Faults:
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
