"""The parts on both sides of a joint are next to each other.

Where the shapes of nearly all joints' children touch those of their parents, a child far from its
parent hangs on the wrong link, or its origin is wrong: it has millimetres in an entry, or a sign or digit too many.
The gap is that between the boxes around the shapes, each joint at 0 or at its limit next to 0; it is reported where it
is more than a tenth of the larger part and 1 cm, of parts that are fixed half the larger part and 5 cm, and nine of ten
of the other joints have none.
"""

from robodyn.checks.bodies.contacts import detached, too_large
from robodyn.checks.examples import LIMIT, a_joint, a_link, a_shaped_link, inertia
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule

_SHAPE = '<visual><geometry><box size="0.1 0.1 0.1"/></geometry></visual>'
_BODY = f'<mass value="1"/>{inertia("0.0017 0 0 0.0018 0 0.0019")}'
_UP = f'<origin xyz="0 0 0.25"/><axis xyz="0 1 0"/>{LIMIT}'
_LINKS = "".join(a_link(name, _BODY, _SHAPE) for name in ("fore", "hand"))
_MORE = _LINKS + a_joint("elbow", "upper", "fore", _UP) + a_joint("wrist", "fore", "hand", _UP.replace("25", "1"))
_ARM = a_shaped_link().replace('<link name="base"/>', f'<link name="base">{_SHAPE}</link>')


@rule(
    Severity.WARNING,
    Stage.TREE,
    good=_ARM.replace("\n</robot>", f"{_MORE}\n</robot>"),
    bad=('"0 0 0.25"', '"0 0 2.5"'),
)
def check(context: Context) -> Faults:
    for name, (contact, bound) in context.once(detached).items():
        joint = context.view.joint[name]
        below = f"of link '{joint.child}' and what is fixed to it"
        what = f"its parts do not meet: the shapes {below} are {contact.gap:.3g} m from those of '{contact.above}'"
        remedy = "check the parent link, and the unit and signs of the origin"
        at = joint.name_span if joint.origin.element is None else joint.origin.xyz.span
        yield Fault(at, what, remedy, contact.gap, bound, cause=too_large(context, joint))
