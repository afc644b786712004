"""A link hangs on the parent that its namesakes tell.

Of links whose names differ in one word, left_hand and right_hand, FL_calf and RR_calf, each hangs
on the namesake of the other's parent, and link_5 hangs on link_4. Where at least three others do so, and all but one in
ten, one that does not was hung on the wrong link: by a copied line that was not changed, or changed twice. The
words that go in pairs are those that the robot's own names show. Which one of two is wrong is told by those that differ
from several, by the side that a name and its parent's name say, and by shapes that do not touch those of the parent;
where nothing tells, both are named.
"""

from robodyn.checks.examples import a_joint, a_link, arm
from robodyn.checks.mirror.namesakes import Odd, odd_parents
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule
from robodyn.robot.urdf.elements import Span
from robodyn.robot.urdf.numbers import value_span
from robodyn.robot.urdf.view import JointView
from robodyn.support.wording import shown

_SEGMENTS = [f"segment_{k}" for k in range(1, 7)]
_CHAIN = zip(("upper", *_SEGMENTS), _SEGMENTS, strict=False)
_ARM = arm(more="".join(a_link(child) + a_joint(f"on_{parent}", parent, child) for parent, child in _CHAIN))


@rule(
    Severity.WARNING,
    Stage.TREE,
    good=_ARM,
    bad=('<parent link="segment_4"/>', '<parent link="segment_2"/>'),
    explains=("RD111",),
)
def check(context: Context) -> Faults:
    for odd in context.once(odd_parents):
        joint = context.tree.above[odd.link]
        what = f"it hangs {shown(odd.link)} on {shown(joint.parent)}, but {odd.why}"
        yield Fault(_at(joint), what, _remedy(odd))


def _remedy(odd: Odd) -> str:
    told = f"hang it on {shown(odd.expected)}"
    either = "" if odd.other is None else f", or the other pairs show that {shown(odd.other)} is the wrong one"
    return f"{told}{either}"


def _at(joint: JointView) -> Span:
    parent = next(child for child in joint.element.children if child.tag == "parent")
    return value_span(parent, "link")
