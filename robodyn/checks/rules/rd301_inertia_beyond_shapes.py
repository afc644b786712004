"""The second moments are no larger than the link's shapes allow for its mass.

Whatever the density, mass within a distance r of its centre has second moments with a trace of at
most m r^2; and along an axis on which the shapes reach from lo to hi at most m (hi - c)(c - lo) (Bhatia and Davis).
The shapes are those of all links that fixed joints join, visual and collision, each in its box.
A trace above its bound is a warning, above four times its bound an error, unless it is the root's, whose inertia does
not matter where the base is fixed; above four times what the link's own shapes allow a warning. The second bound is a
remark, and a warning where it is exceeded four times wherever the centre is. Links of less than 1 % of the mass that
they are fixed to are passed over. The wrists of the UR5 exceed it 8 to 18 times.
"""

from dataclasses import replace

import numpy as np

from robodyn.checks.bodies.bodies import Body
from robodyn.checks.bodies.weighed import judged, suspected
from robodyn.checks.examples import SHAPED_INERTIA, a_shaped_link, inertia
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule
from robodyn.solids.inertia.validity import Box
from robodyn.support.floats import Floats, first_largest
from robodyn.support.wording import figure

FAR = 4.0
"""Times the bound that are an error."""
_SLIGHT = 1.1
_EDGE = 1e-3
"""Of the squared side of a box: a centre of mass this near a face may as well be in the middle."""
_ADVICE = "check the unit (kg m^2) and the point (the centre of mass) of the inertia, and the mass"


@rule(Severity.ERROR, Stage.TREE, good=a_shaped_link(), bad=(SHAPED_INERTIA, inertia("0.3 0 0 0.32 0 0.28")))
def check(context: Context) -> Faults:
    for body in judged(context):
        fault = _beyond_reach(body) or _beyond_box(body)
        if fault is not None:
            stands = context.tree.group[body.link.name].joint is None and fault.severity is Severity.ERROR
            severity = Severity.WARNING if stands else fault.severity
            yield replace(fault, cause=suspected(context, body), severity=severity)


def _beyond_reach(body: Body) -> Fault | None:
    """Check tr(S) > m r^2, r being the distance from the centre of mass to the farthest corner."""
    if body.S is None or body.box is None:
        return None
    spread = float(np.trace(body.S)) / body.mass
    own = _reach(body.box, body.c)
    group = own if body.group is None else _reach(body.group, body.in_group[0])
    if spread <= group and spread <= FAR * own:
        return None
    bound, which = (group, "its rigid group") if spread > group else (own, "the link")
    what = (
        f"its inertia is that of mass {spread**0.5:.3g} m from its centre (root mean square), but the shapes of {which}"
        f" reach {bound**0.5:.3g} m from there: {figure(spread / bound)} times the second moment that is possible"
    )
    return _fault(body, Severity.ERROR if spread > FAR * group else Severity.WARNING, what, spread, bound)


def _beyond_box(body: Body) -> Fault | None:
    """Check S_ii / m > (hi_i - c_i)(c_i - lo_i), with the box of the rigid group."""
    if body.S is None or body.group is None:
        return None
    c, S = body.in_group
    assert S is not None, "it is S turned"
    sides = body.group.hi - body.group.lo
    bound = (body.group.hi - c) * (c - body.group.lo)
    if not (bound > -_EDGE * sides**2).all():
        return None
    bound = np.where(bound > _EDGE * sides**2, bound, sides**2 / 4)
    spread = np.diagonal(S) / body.mass
    axis = first_largest(spread / bound)
    ratio = float(spread[axis] / bound[axis])
    if ratio <= _SLIGHT:
        return None
    wherever = spread[axis] > sides[axis] ** 2 / 4
    severity = Severity.WARNING if ratio > FAR and wherever else Severity.NOTE
    what = f"along {'xyz'[axis]} its inertia needs {figure(ratio)} times the second moment that any mass in the box"
    what += " around the shapes can have"
    return _fault(body, severity, what, float(spread[axis]), float(bound[axis]))


def _reach(box: Box, c: Floats) -> float:
    return float((np.maximum(box.hi - c, c - box.lo) ** 2).sum())


def _fault(body: Body, severity: Severity, what: str, spread: float, bound: float) -> Fault:
    measured, most = spread * body.mass, bound * body.mass
    return Fault(body.tensor_span, what, _ADVICE, measured, most, severity=severity, kind="beyond the shapes")
