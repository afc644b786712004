"""KDL ignores the inertia of the root.

kdl_parser warns of it and drops it. It matters for a robot whose base moves; nothing is wrong for
others.
"""

from robodyn.checks.examples import a_link, arm
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule


@rule(Severity.NOTE, Stage.TREE, good=arm(), bad=arm().replace('<link name="base"/>', a_link("base").strip()))
def check(context: Context) -> Faults:
    root = context.tree.root
    if root.inertial is not None and root.mass and context.view.joints:
        what = f"the root has a mass of {root.mass:g} kg, which KDL ignores"
        remedy = "where KDL or robot_state_publisher matters, put an empty root link above it with a fixed joint"
        yield Fault(root.inertial.element.span, what, remedy, measured=root.mass)
