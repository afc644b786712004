"""Mass, inertia and centre of mass are in kg, kg m^2 and m.

One factor between units explains what does not fit the shapes: a mass that is 1000 or 1e6 times that
of a usual density, beyond any solid, with an inertia that fits one of the two; an inertia that is 1e3, 1e6 or 1e9 times
larger or smaller than that of the solid box around the shapes, in all three axes, where the density is usual (near
multiples of the identity are made up, not in other units); a centre of mass beyond one size of the shapes that lies in
them when it is divided by 1000 or 25.4. RD301 to RD304 are silent about such a link.
"""

from robodyn.checks.bodies.bodies import Body, bodies
from robodyn.checks.bodies.unit_slips import slips
from robodyn.checks.examples import SHAPED_INERTIA, a_shaped_link, inertia
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule
from robodyn.robot.urdf.elements import Span


@rule(Severity.ERROR, Stage.TREE, good=a_shaped_link(), bad=(SHAPED_INERTIA, inertia("12600 0 0 12400 0 3200")))
def check(context: Context) -> Faults:
    known = context.once(bodies)
    for name, slip in context.once(slips).items():
        by = f"divide it by {slip.factor:g}" if slip.factor > 1 else f"multiply it by {1 / slip.factor:g}"
        what = slip.sentence
        remedy = f"{by} if that is so"
        yield Fault(_place(known[name], slip.what), what, remedy, slip.factor, 1.0, subject=known[name].link.subject)


def _place(body: Body, what: str) -> Span:
    if what == "mass":
        return body.inertial.mass.span
    return body.tensor_span if what == "inertia" else body.inertial.origin.xyz.span
