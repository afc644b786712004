"""Mimic joints follow one that is free, at last.

In a cycle no joint has a position of its own. Some readers follow it for ever.
"""

from robodyn.checks.examples import LIMIT, longer_arm
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.robot.urdf.numbers import value_span
from robodyn.robot.urdf.structure import cycles
from robodyn.support.wording import listed

_FOLLOWER = f'<axis xyz="0 1 0"/>{LIMIT}<mimic joint="shoulder"/>'


@rule(Severity.ERROR, good=longer_arm(inside=_FOLLOWER), bad=('joint="shoulder"', 'joint="elbow"'), explains=("RD901",))
def check(context: Context) -> Faults:
    joints = context.view.joint
    masters = {name: joint.mimic.joint for name, joint in joints.items() if joint.mimic is not None}
    for cycle in cycles(masters):
        first = min((joints[name] for name in cycle), key=lambda joint: joint.element.start)
        assert first.mimic is not None, "it follows a joint"
        what = "it mimics itself" if len(cycle) == 1 else f"joints mimic each other in a cycle: {listed(cycle)}"
        yield Fault(value_span(first.mimic.element, "joint"), what, "let one of them be free")
