"""Parts that no joint connects do not overlap at rest.

A simulator that lets a robot collide with itself pushes such parts apart at the first step: the robot
jumps. The convex hulls of collision shapes are compared, which MuJoCo and Drake collide, each joint at 0 or at its
limit next to 0. Reported, once for a file, are pairs of links that overlap by more than 1 cm and a tenth of the smaller
shape; depths are those of MuJoCo 4.0 within 2.5 mm on four published robots. Left out are neighbours, pairs that the
SRDF disables, and shapes that RD609 reports. It is a remark, for many robots fold into themselves where all joints are
at 0.
"""

from robodyn.checks.bodies.contacts import detached
from robodyn.checks.bodies.overlaps import overlaps
from robodyn.checks.examples import LIMIT, a_joint, a_link, arm, inertia
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule

_SHAPE = '<collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision>'
_BODY = f'<mass value="1"/>{inertia("0.0017 0 0 0.0018 0 0.0019")}'
_UP = f'<origin xyz="0 0 0.1"/><axis xyz="0 1 0"/>{LIMIT}'
_SHOWN = 3


@rule(
    Severity.NOTE,
    Stage.TREE,
    good=arm(
        more=a_link("fore", _BODY, _SHAPE)
        + a_joint("elbow", "upper", "fore", _UP)
        + a_link("hand", _BODY, _SHAPE)
        + a_joint("wrist", "fore", "hand", _UP)
        + a_link("tool", _BODY, _SHAPE)
        + a_joint("mount", "hand", "tool", _UP)
    ),
    bad=('child link="tool"/><origin xyz="0 0 0.1"/>', 'child link="tool"/><origin xyz="0 0 -0.08"/>'),
)
def check(context: Context) -> Faults:
    found = [] if context.once(detached) else overlaps(context)
    if not found:
        return
    worst, *others = found
    what = f"at rest it reaches {worst.depth:.3g} m into link '{worst.first.name}', which is no neighbour of it"
    if others:
        more = [f"'{one.second.name}' and '{one.first.name}' {one.depth:.3g} m" for one in others[:_SHOWN]]
        rest = f" and {len(others) - _SHOWN} more" if len(others) > _SHOWN else ""
        what += f"; so do {', '.join(more)}{rest}"
    remedy = "give it simpler collision shapes or several convex ones, or disable the pair in the SRDF"
    yield Fault(worst.shape.element.span, what, remedy, worst.depth, 0.0)
