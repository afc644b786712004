"""Mass, inertia and centre of mass are in kg, kg m^2 and m.

One unit, or one system of units, explains what does not fit the shapes: g, mg, lb or t for kg, mm, cm or in for m,
and all their products for kg m^2, in one of the three quantities or in several. The link is weighed by the uniform
solid that its own shapes are (visual ones, or else collision shapes): by density, centre, size and form. A unit is
named where it is nine times as probable as everything else together, among which is any factor that belongs to no unit;
otherwise the candidates are listed in a warning. Tensors near a multiple of the identity and round numbers are made up,
not in other units. RD301 to RD304 are silent about such a link.
"""

from robodyn.checks.bodies.bodies import Body, bodies
from robodyn.checks.bodies.uniform import shaped
from robodyn.checks.bodies.weighed import weighed
from robodyn.checks.context import Context
from robodyn.checks.examples import SHAPED_INERTIA, a_shaped_link, inertia
from robodyn.checks.rule import Fault, Faults, Severity, Stage, rule
from robodyn.robot.masses.units import QUANTITIES
from robodyn.robot.masses.weighing import Cause, Weighed
from robodyn.robot.urdf.elements import Span
from robodyn.support.wording import figure, one_of


@rule(Severity.ERROR, Stage.TREE, good=a_shaped_link(), bad=(SHAPED_INERTIA, inertia("12600 0 0 12400 0 3200")))
def check(context: Context) -> Faults:
    for name, verdict in context.once(weighed).items():
        if verdict.units:
            yield _fault(context, context.once(bodies)[name], verdict)


def _fault(context: Context, body: Body, verdict: Weighed) -> Fault:
    first = (verdict.named or verdict.either)[0]
    assert first.units is not None, "it is one of units"
    which = first.units.wrong[0]
    factor = first.units.factors[which]
    at = _place(body, QUANTITIES[which])
    if not verdict.named:
        what = one_of([one.what for one in verdict.either]) or ""
        remedy = "see which it is, and correct it"
        return Fault(at, what, remedy, factor, 1.0, severity=Severity.WARNING, subject=body.link.subject)
    what = f"{first.what} {_shown(context, body, first)}"
    remedy = " and ".join(_undone(QUANTITIES[k], first.units.factors[k]) for k in first.units.wrong)
    return Fault(at, what, f"{remedy} if that is so", factor, 1.0, subject=body.link.subject)


def _shown(context: Context, body: Body, cause: Cause) -> str:
    """Return how well what was meant fits."""
    solid = context.once(shaped)[body.link.name].solid
    apart = 100.0 * cause.apart
    return f"(then {figure(cause.mass / solid.volume)} kg/m^3, and an inertia {figure(apart, 2)} % from the shapes')"


def _undone(what: str, factor: float) -> str:
    by = f"divide the {what} by {factor:g}" if factor > 1 else f"multiply the {what} by {1 / factor:g}"
    return by


def _place(body: Body, what: str) -> Span:
    if what == "mass":
        return body.inertial.mass.span
    return body.tensor_span if what == "inertia" else body.inertial.origin.xyz.span
