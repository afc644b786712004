"""The inertia is not far below that of the link's shapes.

About each principal axis of the uniform solid that the link's shapes are (visual ones, or else collision shapes), the
moment of inertia is at least a twentieth of that of the solid with the link's mass. Less means that nearly all mass is
in one spot or, where it is one axis only, on a line: a femur of two tubes whose mass is on a thread.
Where a shape encloses no definite volume, the largest principal moment is at least a tenth of that of the largest shell
that fits into the box around the link's shapes, 2/3 m r^2; of a link without shapes at least that of a ball of
tungsten: TIAGo's camera of 0.22 kg has a quarter of it. That of a point is RD204's, and a mass beyond any solid
RD304's.
"""

from math import pi

import numpy as np

from robodyn.checks.bodies.bodies import Body
from robodyn.checks.bodies.masses import is_a_point, principal_moments
from robodyn.checks.bodies.uniform import shaped
from robodyn.checks.bodies.weighed import judged, suspected
from robodyn.checks.examples import SHAPED_INERTIA, a_shaped_link, inertia
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule
from robodyn.programs.linear import eigen
from robodyn.programs.vectors import product
from robodyn.robot.masses.likeness import Uniform
from robodyn.solids.inertia.laws import inertia_matrix
from robodyn.support.floats import first_largest

_LEAST, _LEAST_SHELL = 0.05, 0.1
_DENSEST = 19300.0
"""Of tungsten [kg/m^3]."""
_FAR = 0.01
"""Of the ball's moment: what is less is a mass or a size that no link has, of which RD209 and RD210 tell."""
_REMEDY = "check the unit (kg m^2) and the mass; write the inertia of the part"


@rule(Severity.WARNING, Stage.TREE, good=a_shaped_link(), bad=(SHAPED_INERTIA, inertia("4e-5 0 0 5e-5 0 3e-5")))
def check(context: Context) -> Faults:
    known = context.once(shaped)
    for body in judged(context):
        if body.S is None or is_a_point(body.link) or not _possible(context, body):
            continue
        shape = known.get(body.link.name)
        if shape is not None and body.mass > context.thresholds.most_density * shape.solid.volume:
            continue
        found = _below_shell(body) if shape is None or not shape.definite else _below_solid(body, shape.solid)
        if found is not None:
            measured, bound, what = found
            yield Fault(body.tensor_span, what, _REMEDY, measured, bound, cause=suspected(context, body))


def _possible(context: Context, body: Body) -> bool:
    """Return whether a body can have the tensor; RD206 and RD207 tell of one that none can have."""
    small, middle, large = principal_moments(body.link.tensor or (0.0,) * 6)
    limits = context.thresholds
    return small > limits.positive_definite * large and small + middle >= (1 - limits.triangle) * large


def _below_solid(body: Body, solid: Uniform) -> tuple[float, float, str] | None:
    """Return the moment about the solid's principal axis about which it is least, beside the solid's."""
    moments, axes = eigen(solid.inertia(body.mass))
    assert body.S is not None, "there is a tensor"
    own = np.diagonal(product(axes, inertia_matrix(body.S), axes.T))
    if not (moments > 0).all():
        return None
    k = first_largest(-own / moments)
    measured, right = float(own[k]), float(moments[k])
    if not 0 < measured < _LEAST * right:
        return None
    about = " ".join(f"{x + 0.0:.2g}" for x in np.round(axes[k], 3).tolist())
    what = (
        f"the moment {measured:.3g} kg m^2 about the axis ({about}) is {measured / right:.2g} of that of a solid of "
        f"its shapes and mass, {right:.3g}"
    )
    return measured, _LEAST * right, what


def _below_shell(body: Body) -> tuple[float, float, str] | None:
    tensor, box = body.link.tensor, body.own
    if tensor is None:
        return None
    largest = principal_moments(tensor)[2]
    if box is None:
        return _below_ball(body.mass, largest)
    radius = float((box.hi - box.lo).min()) / 2
    shell = 2 / 3 * body.mass * radius**2
    if not 0 < largest < _LEAST_SHELL * shell:
        return None
    what = (
        f"the largest principal moment {largest:.3g} kg m^2 is {largest / shell:.2g} of that of a shell "
        f"of its mass that fits into its shapes (radius {radius:.3g} m)"
    )
    return largest, _LEAST_SHELL * shell, what


def _below_ball(mass: float, largest: float) -> tuple[float, float, str] | None:
    """Return the largest principal moment, beside the least that a mass can have about any axis through its centre."""
    radius = (3 * mass / (4 * pi * _DENSEST)) ** (1 / 3)
    ball = 2 / 5 * mass * radius**2
    if not _FAR * ball < largest < ball:
        return None
    what = (
        f"the largest principal moment {largest:.3g} kg m^2 is {largest / ball:.2g} of that of a ball of its mass "
        f"of tungsten (radius {radius:.3g} m)"
    )
    return largest, ball, what
