"""A robot is drawn in metres.

Where the links' masses over the boxes around their shapes are 1e9 times too small in the median, and
1000 times shorter lengths bring them to what published robots have, all lengths are in millimetres; or they were
divided by 1000 that were in metres. At least three links with mass and shapes show it. What follows from it, for
densities, inertias, centres of mass and torques, is not reported beside it. A mesh in millimetres alone is RD605's, an
origin RD111's.
"""

from robodyn.checks.bodies.shapes import other_unit
from robodyn.checks.examples import LIMIT, a_joint, a_link, a_shaped_link, inertia
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule
from robodyn.robot.urdf.numbers import value_span

_BOX = '<box size="0.1 0.1 0.25"/>'
_SHAPE = f'<visual><origin xyz="0 0 0.125"/><geometry>{_BOX}</geometry></visual>'
_BODY = f'<origin xyz="0 0 0.12"/><mass value="2"/>{inertia("0.0126 0 0 0.0124 0 0.0032")}'
_UP = f'<origin xyz="0 0 0.25"/><axis xyz="0 1 0"/>{LIMIT}'
_MORE = "".join(
    a_link(link, _BODY, _SHAPE) + a_joint(joint, above, link, _UP)
    for link, joint, above in (("fore", "elbow", "upper"), ("hand", "wrist", "fore"))
)


@rule(
    Severity.ERROR,
    Stage.TREE,
    good=a_shaped_link().replace("\n</robot>", f"{_MORE}\n</robot>"),
    bad=(_BOX, '<box size="100 100 250"/>'),
)
def check(context: Context) -> Faults:
    unit = context.once(other_unit)
    if unit is None:
        return
    large = unit.times > 1
    what = (
        f"its links weigh {unit.density:.3g} kg/m^3 of the boxes around their shapes (median): lengths are "
        f"{'in millimetres' if large else 'a thousandth of metres'}, which makes {unit.density * unit.times**3:.3g}"
    )
    remedy = f"{'divide' if large else 'multiply'} all lengths by 1000, those of meshes by their scale"
    yield Fault(value_span(context.view.root, "name"), what, remedy, unit.times, 1.0, subject=None)
