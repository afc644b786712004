"""A root with a collision shape has an <inertial>, unless it stands still.

MuJoCo takes the mass of a body without an inertial from its shapes, at the density of water, and
other programs take none: the same floating robot weighs differently in each. A base that stands still, as an arm's, is
not affected, since MuJoCo makes it a part of the ground: asked are robots that stand on two or more legs or wheels, or
fly, by their links.
"""

from robodyn.checks.examples import INERTIA, LIMIT, a_joint, a_link
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule
from robodyn.robot.base_guess import untouched

_SHAPE = '<collision><geometry><sphere radius="0.1"/></geometry></collision>'
_WHEELS = "".join(
    a_link(f"{side}_wheel", f'<mass value="1"/>{INERTIA}')
    + a_joint(f"{side}_axle", "cart", f"{side}_wheel", f'<axis xyz="0 1 0"/>{LIMIT}', "continuous")
    for side in ("left", "right")
)
_CART = f"""<robot name="cart">
  <link name="cart">
    <inertial><mass value="4"/>{INERTIA}</inertial>
    {_SHAPE}
  </link>
  {_WHEELS}
</robot>
"""


@rule(
    Severity.WARNING,
    Stage.MODEL,
    good=_CART,
    bad=(f'    <inertial><mass value="4"/>{INERTIA}</inertial>\n', ""),
)
def check(context: Context) -> Faults:
    root = context.tree.root
    shapes = [shape for shape in root.geometries if shape.kind == "collision"]
    if root.inertial is None and shapes and context.model.n and untouched(context.model):
        what = "the root has a collision shape and no <inertial>: MuJoCo gives it the mass of water in that shape"
        yield Fault(root.name_span, what, "write its <inertial>")
