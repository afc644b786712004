"""A root with a collision shape has an <inertial>.

MuJoCo takes the mass of a body without an inertial from its shapes, at the density of water, and
other programs take none: the same floating robot weighs differently in each. A base that stands still is not
affected.
"""

from robodyn.checks.examples import arm
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule

_SHAPE = '<collision><geometry><sphere radius="0.1"/></geometry></collision>'
_MASS = '<inertial><mass value="4"/><inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial>'


@rule(
    Severity.WARNING,
    Stage.TREE,
    good=arm().replace('<link name="base"/>', f'<link name="base">{_MASS}{_SHAPE}</link>'),
    bad=arm().replace('<link name="base"/>', f'<link name="base">{_SHAPE}</link>'),
)
def check(context: Context) -> Faults:
    root = context.tree.root
    shapes = [shape for shape in root.geometries if shape.kind == "collision"]
    if root.inertial is None and shapes:
        what = "the root has a collision shape and no <inertial>: MuJoCo gives it the mass of water in that shape"
        yield Fault(root.name_span, what, "write its <inertial>, or nothing if the base always stands still")
