"""A part that is seen has mass, as the other parts have.

Where nine of ten of the other links with shapes have an `<inertial>`, a moving link with shapes and
without one lost it: what is fixed to it has mass, so that the robot still loads, but too light by that link. It is at
least half as long as the longest link that is fixed to it, for a small one, such as a camera, may be weighed with what
carries it; and three other links with shapes must be there to tell. A group that has no mass at all is RD202's.
"""

from robodyn.checks.bodies.shapes import link_boxes, real_shapes, size_of
from robodyn.checks.examples import LIMIT, a_joint, a_link, a_shaped_link, inertia
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule

_SHAPE = '<visual><geometry><box size="0.1 0.1 0.1"/></geometry></visual>'
_BODY = f'<mass value="1"/>{inertia("0.0017 0 0 0.0018 0 0.0019")}'
_UP = f'<origin xyz="0 0 0.25"/><axis xyz="0 1 0"/>{LIMIT}'
_MORE = (
    a_link("fore", _BODY, _SHAPE)
    + a_joint("elbow", "upper", "fore", _UP)
    + a_link("hand", _BODY, _SHAPE)
    + a_joint("wrist", "fore", "hand", _UP)
    + a_link("camera", _BODY.replace("1", "0.2", 1), _SHAPE)
    + a_joint("mount", "hand", "camera", '<origin xyz="0 0 0.1"/>', "fixed")
)
_OTHERS, _MOST = 3, 0.9
"""Least number of other links with shapes, and the share of those with an <inertial>. Of 86 published robots one has
moving links with shapes and no <inertial> beside others that have one, and of its links with shapes half have one."""

_LONG = 0.5
"""How long it is at least, by the longest link of its rigid group."""


@rule(
    Severity.WARNING,
    Stage.TREE,
    good=a_shaped_link().replace("\n</robot>", f"{_MORE}\n</robot>"),
    bad=(a_link("hand", _BODY, _SHAPE), a_link("hand", "", _SHAPE)),
)
def check(context: Context) -> Faults:
    shaped = [link for link in context.view.links if real_shapes(link)]
    weighed = sum(link.inertial is not None for link in shaped)
    others = len(shaped) - 1
    if others < _OTHERS or weighed < _MOST * others:
        return
    boxes = {name: size_of(box) for name, box in context.once(link_boxes).items() if box is not None}
    for group in context.tree.groups:
        longest = max((boxes.get(link.name, 0.0) for link in group.links), default=0.0)
        for link in group.links if group.joint is not None and group.mass else ():
            if link.inertial is None and boxes.get(link.name, 0.0) >= _LONG * longest > 0:
                what = (
                    f"it has shapes and no <inertial>, and {weighed} of {others} other links with shapes have one: "
                    f"what moves with it weighs {group.mass:.4g} kg without it"
                )
                yield Fault(link.name_span, what, "write its <inertial>", measured=0.0)
