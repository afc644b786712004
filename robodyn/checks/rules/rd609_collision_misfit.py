"""What collides is where and what is seen.

A collision mesh or primitive that is also a visual of the link stands where that stands; a collision
mesh has the size of the visual one, and is not that of another link; and there is no gap as wide as half the link
between the two. A simulator stops the robot at walls that nobody sees. Shapes that are simpler on purpose are not
judged by their size, unless a box, cylinder or sphere is 20 times as large as what is seen, or a cylinder fits that by
exchanging its radius and length; meshes of one part differ by up to 10 % in the sides of their boxes. A shape less
than 15 % of its size or 1 cm away is passed over. One mesh each for both, whose boxes share at most a fifth of their
volume, are two parts, or one that is turned.
"""

from robodyn.checks.bodies.collision_fit import misfits
from robodyn.checks.examples import a_shaped_link
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule

_BOX = '<geometry><box size="0.1 0.1 0.25"/></geometry>'


@rule(
    Severity.WARNING,
    Stage.TREE,
    good=a_shaped_link().replace(
        "<inertial>", f'<collision><origin xyz="0 0 0.125"/>{_BOX}</collision>\n    <inertial>', 2
    ),
    bad=('<collision><origin xyz="0 0 0.125"/>', "<collision>"),
)
def check(context: Context) -> Faults:
    for geometry, what, remedy, measured, bound, cause in context.once(misfits):
        at = geometry.element if geometry.origin.element is None else geometry.origin.element
        at = at if cause is None or geometry.shape is None else geometry.shape
        yield Fault(at.span, what, remedy, measured, bound, cause=cause)
