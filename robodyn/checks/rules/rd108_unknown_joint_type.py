"""The type of a joint is revolute, continuous, prismatic, fixed, floating or planar.

Readers refuse other types; some take them for fixed. Types are written in small letters.
"""

from robodyn.checks.examples import arm
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.robot.urdf.numbers import value_span
from robodyn.robot.urdf.parts import JOINT_TYPES
from robodyn.robot.urdf.xml_reader import unexpanded
from robodyn.support.wording import alternatives, shown


@rule(Severity.ERROR, good=arm(), bad=arm(kind="hinge"))
def check(context: Context) -> Faults:
    for joint in context.view.joints:
        if joint.type in JOINT_TYPES or unexpanded(joint.type):
            continue
        what = f"URDF has no joint type {shown(joint.type)}" if joint.type else "it has no type"
        remedy = alternatives(joint.type.lower(), JOINT_TYPES, "types")
        yield Fault(value_span(joint.element, "type"), what, remedy)
