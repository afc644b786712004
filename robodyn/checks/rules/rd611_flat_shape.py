"""Collision shapes have a thickness.

A mesh all of whose points lie in a plane, and a box 1 um thick, have no volume: MuJoCo refuses such a
mesh, because it has no convex hull, and contacts with it pass through in others. Reported are collision shapes
thinner than 10 um and than a thousandth of their longest side. What is only seen may be a label, and be flat.
"""

import numpy as np

from robodyn.checks.bodies.shapes import real_shapes, solids
from robodyn.checks.examples import a_shaped_link
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule

_THIN = 1e-5
_THINNER = 1e-3
"""Of the longest side."""
_COLLISION = '<collision><geometry><box size="0.1 0.1 0.25"/></geometry></collision>'


@rule(
    Severity.WARNING,
    Stage.TREE,
    good=a_shaped_link().replace("<visual>", f"{_COLLISION}\n    <visual>"),
    bad=('<collision><geometry><box size="0.1 0.1 0.25"/>', '<collision><geometry><box size="0.1 1e-6 0.25"/>'),
    explains=("RD609",),
)
def check(context: Context) -> Faults:
    known = context.once(solids)
    for shape in (shape for link in context.view.links for shape in real_shapes(link)):
        if shape not in known or shape.shape is None or shape.kind == "visual":
            continue
        sides = known[shape].box.hi - known[shape].box.lo
        thin, most = float(sides.min()), min(_THIN, _THINNER * float(sides.max()))
        if thin < most:
            what = (
                f"the collision {shape.shape.tag} is flat: {thin:.3g} m thick along its {'xyz'[int(np.argmin(sides))]}"
            )
            yield Fault(shape.shape.span, f"{what} axis", "give it a thickness", thin, most)
