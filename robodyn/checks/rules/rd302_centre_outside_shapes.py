"""The centre of mass lies within the shapes of the link and what is fixed to it.

The centre of mass of a body is inside its convex hull. Instead of hulls, the box along the axes of
the rigid group's first link is taken around all its shapes, visual and collision, which contains the hull: what is
reported is outside the hull, too.
Up to a tenth of the box's diagonal outside is passed over, for parts that are not drawn (of published robots TALOS's
ankles are 6 % outside); beyond one diagonal it is an error, unless the group is the root's, whose mass does not matter
where the base is fixed. Where the mesh of a shape is not known the group is not judged. Where one coordinate with the
other sign is in the middle of the link's own shapes, as in Allegro's palm, that is said.
"""

import numpy as np

from robodyn.checks.bodies.bodies import Body
from robodyn.checks.bodies.shapes import outside, size_of
from robodyn.checks.bodies.uniform import shaped
from robodyn.checks.bodies.weighed import judged, suspected
from robodyn.checks.examples import a_shaped_link
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule
from robodyn.programs.vectors import length
from robodyn.support.wording import one_of

_OFF = 0.1
"""Of the size of the box: as little may be a part that is not drawn."""
_NEAR = 0.3
"""Of its distance from the middle of the shapes: as far from it a centre may be whose sign was wrong."""


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
        cause = suspected(context, body, centre=True) or _sign(context, body)
        yield Fault(at, what, remedy, away, size, severity=severity, cause=cause)


def _sign(context: Context, body: Body) -> str | None:
    """Return which coordinate may have the wrong sign: with the other one the centre is where the shapes have it."""
    shape = context.once(shaped).get(body.link.name)
    if shape is None or body.box is None:
        return None
    now, flipped = length(body.c - shape.solid.c), body.c * (1.0 - 2.0 * np.eye(3))
    near = [not outside(body.box, c) and length(c - shape.solid.c) <= _NEAR * now for c in flipped]
    return one_of(f"{axis} has the wrong sign" for axis, yes in zip("xyz", near, strict=True) if yes)
