"""The mass fits the size of the shapes.

The mass of a rigid group over the volume of the box around its visual shapes (its collision shapes
if it has no visual ones, for these are often stand-ins) is between 10 and 9000 kg/m^3: most of a box is air, and solid
steel that fills it has 7850. Links of published robots have 390 to 1200. The band is set by the thresholds
`least-density` and `most-density`. Where mass and shapes do not fit each other, it is no second defect that the inertia
or the centre of mass does not fit the shapes (RD301, RD302).
"""

from robodyn.checks.bodies.masses import link_poses
from robodyn.checks.bodies.shapes import around_known, box_of, real_shapes, solids
from robodyn.checks.bodies.weighed import weighed
from robodyn.checks.examples import a_shaped_link, inertia
from robodyn.checks.reading.tree import Group
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule
from robodyn.solids.inertia.validity import Box
from robodyn.support.wording import figure


@rule(
    Severity.WARNING,
    Stage.TREE,
    good=a_shaped_link(),
    bad=a_shaped_link("90", inertia("0.3 0 0 0.32 0 0.1")),
    explains=("RD301", "RD302"),
)
def check(context: Context) -> Faults:
    limits, explained = context.thresholds, {name for name, one in context.once(weighed).items() if one.units}
    for group in context.tree.groups:
        if not group.mass or group.mass < limits.least_mass or any(link.name in explained for link in group.links):
            continue
        box = _box(context, group)
        volume = 0.0 if box is None else float((box.hi - box.lo).prod())
        if not volume > 0:
            continue
        density = group.mass / volume
        if limits.least_density <= density <= limits.most_density:
            continue
        dense = density > limits.most_density
        _, inertial = group.heaviest
        what = (
            f"what moves with it weighs {group.mass:.4g} kg, which is {figure(density)} kg/m^3 of the box around "
            f"its shapes, {'denser than solid steel' if dense else 'lighter than foam'}"
        )
        remedy = "check the unit of the mass (kg) and the size of the shapes"
        yield Fault(inertial.mass.span, what, remedy, density, limits.most_density if dense else limits.least_density)


def _box(context: Context, group: Group) -> Box | None:
    """Return the box around the visual shapes of the group, or its collision shapes if it has no visual ones."""
    known, poses = context.once(solids), context.once(link_poses)
    seen = any(shape.kind == "visual" for link in group.links for shape in real_shapes(link))
    boxes = []
    for link in group.links:
        shapes = [shape for shape in real_shapes(link) if shape.kind == "visual" or not seen]
        if shapes:
            boxes.append(box_of(shapes, known, poses[link.name]) if link.name in poses else None)
    return around_known(boxes)
