"""The centre of mass lies within the shapes of the link and what is fixed to it.

The centre of mass of a body is inside its convex hull. Instead of hulls, the box along the axes of
the rigid group's first link is taken around all its shapes, visual and collision, which contains the hull: what is
reported is outside the hull, too. Up to 5 % of the box's diagonal outside are passed over, for parts that are not
drawn; beyond one diagonal it is an error, unless the group is the root's, whose mass does not matter where the base is
fixed. Where the mesh of a shape is not known the group is not judged.
"""

from robodyn.checks.bodies.shapes import outside, size_of
from robodyn.checks.bodies.weighed import judged, suspected
from robodyn.checks.examples import a_shaped_link
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule

_OFF = 0.05
"""Of the size of the box: as little may be a part that is not drawn."""


@rule(Severity.WARNING, Stage.TREE, good=a_shaped_link(), bad=('"0 0 0.12"', '"0 0 0.5"'))
def check(context: Context) -> Faults:
    for body in judged(context, tensors=False):
        if body.group is None:
            continue
        away, size = outside(body.group, body.in_group[0]), size_of(body.group)
        if away <= _OFF * size:
            continue
        moves = context.tree.group[body.link.name].joint is not None
        origin = body.inertial.origin
        what = f"the centre of mass is {away:.3g} m outside the box around the shapes, which is {size:.3g} m across"
        remedy = "check the unit (m), the signs, and that it is in the link's frame, not the mesh's or the world's"
        at = body.inertial.element.span if origin.element is None else origin.xyz.span
        severity = Severity.ERROR if away > size and moves else Severity.WARNING
        cause = suspected(context, body, centre=True)
        yield Fault(at, what, remedy, away, size, severity=severity, cause=cause)
