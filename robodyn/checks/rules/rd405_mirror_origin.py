"""Twin joints stand at each other's mirror image, where what carries them does.

A sign that was not turned, or turned twice, in the origin of one leg's joint moves the rest of
the leg to the wrong side of it, and nothing else tells: the leg is still a leg. Joints are twins if the names of the
links that they carry are each other's but for left and right; the mirror plane is the robot's own, as RD401 finds it.
Reported are joints that hang on one link in that plane or on two links that are twins. Passed over are fixed ones that
carry no mass, such as sensors; what is mounted alike on a part that is itself mounted on both sides, as fingers on a
gripper; and frames that lie askew where no sign in rpy explains it: they are chosen freely.
"""

from robodyn.checks.examples import two_elbows
from robodyn.checks.mirror.misplaced import Misplaced, misplaced
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule
from robodyn.robot.urdf.elements import Span
from robodyn.robot.urdf.numbers import value_span
from robodyn.robot.urdf.view import JointView
from robodyn.support.wording import place, shown

_REMEDY = "correct the one of the two that is wrong, or allow it where the sides differ"


@rule(Severity.WARNING, Stage.MODEL, good=two_elbows(), bad=two_elbows("0.1 0.05 0.3"))
def check(context: Context) -> Faults:
    for one in misplaced(context):
        yield _fault(one, context.view.joint[one.right.name])


def _fault(one: Misplaced, view: JointView) -> Fault:
    twin = f"{shown(one.left.name)} (line {one.left.line})"
    signs = " and ".join(one.signs)
    if one.expected is None:
        what = f"its axes are not the mirror image of those of its twin {twin}, but for the sign of {signs}"
        return Fault(_at(view, "rpy"), what, _REMEDY)
    what = (
        f"the origin is at {place(one.right.origin.xyz)} m; that of its mirror twin {twin} asks for "
        f"{place(one.expected.tolist())}, {one.off:.3g} m away"
    )
    cause = f"the sign of {signs} is not that of a mirror image" if signs else None
    return Fault(_at(view, "xyz"), what, _REMEDY, one.off, 0.0, cause=cause)


def _at(view: JointView, name: str) -> Span:
    origin = view.origin.element
    return view.element.span if origin is None else value_span(origin, name)
