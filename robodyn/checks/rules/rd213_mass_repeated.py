"""The mass of a body is not written twice, on links that are fixed to each other.

A frame that is fixed to a part, for a tool or a camera, and has the part's inertial again doubles the
mass; so does a link whose inertial is that of the link it is fixed to, in other axes. Reported are links fixed to each
other with the same mass, of 1 % of what moves with them or more, and either one centre of mass, within 1 mm, or the
same numbers throughout, where the child has no shape of its own or the inertia has three products and the shapes
differ. Stand-ins, which have the same moment three times, do not count.
"""

from robodyn.checks.bodies.bodies import bodies
from robodyn.checks.bodies.repeated import repeated
from robodyn.checks.examples import ORIGIN, TENSOR, a_joint, a_link, arm
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule

_BODY = f'{ORIGIN}<mass value="1.25"/>{TENSOR}'


@rule(
    Severity.WARNING,
    Stage.TREE,
    good=arm(more=a_link("fore", _BODY) + a_joint("elbow", "upper", "fore")).replace("\n</robot>\n", "")
    + a_link("tool", "")
    + a_joint("mount", "fore", "tool", "", "fixed")
    + "\n</robot>\n",
    bad=('<link name="tool">', f'<link name="tool"><inertial>{_BODY}</inertial>'),
)
def check(context: Context) -> Faults:
    known = context.once(bodies)
    for name, joint in context.once(repeated).items():
        again = known[name]
        what = f"its mass of {again.mass:g} kg is that of link '{joint.parent}', to which it is fixed, again"
        remedy = "leave the <inertial> of one of them out, if it is one part"
        yield Fault(again.inertial.mass.span, what, remedy, again.mass, 0.0)
