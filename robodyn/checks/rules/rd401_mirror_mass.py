"""A left link weighs what the right one does."""

from math import isclose

from robodyn.checks.examples import IMAGE, two_arms
from robodyn.checks.mirror.loads import MASS, ONE_OF_TWO, twins
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule
from robodyn.support.wording import figure

_FACTORS = (
    (1000.0, "in grams, 1000 times the other"),
    (1 / 0.45359237, "in pounds, 2.2046 times the other"),
    (10.0, "10 times the other, as with the decimal point one place off"),
    (100.0, "100 times the other, as with the decimal point two places off"),
)
_EXACT = 1e-3
"""How far the ratio may be from a factor: masses of twins are equal or differ by chance."""


@rule(
    Severity.WARNING,
    Stage.MODEL,
    explanation=f"""Links are twins if their names are each other's but for left and right, and at q = 0 each stands
where the mirror image of the other does; the plane is found from the robot. Masses may differ by {100 * MASS:g} %.
Where two parts that stand opposite each other do differ, as two tools do, a waiver says so. A ratio of 1000, 2.2046, 10
or 100 is named as the slip that makes it.""",
    good=two_arms(),
    bad=(f'"2"/>{IMAGE}', f'"2.1"/>{IMAGE}'),
)
def check(context: Context) -> Faults:
    for one in context.once(twins):
        left, right = one.masses
        if one.mass_differs:
            what = (
                f"the mass is {right:g} kg, that of its mirror twin {one.other} {left:g} kg, "
                f"{figure(100 * abs(left - right) / max(left, right), 2)} % apart"
            )
            yield Fault(one.inertial.mass.span, what, ONE_OF_TWO, right, left, cause=_unit(left, right))


def _unit(left: float, right: float) -> str | None:
    """Return what makes one mass a round number of times the other, if it is one."""
    ratio = max(left, right) / min(left, right)
    which = "it" if right > left else "that of the twin"
    return next((f"{which} is {how}" for factor, how in _FACTORS if isclose(ratio, factor, rel_tol=_EXACT)), None)
