"""A left link weighs what the right one does."""

from robodyn.checks.examples import IMAGE, two_arms
from robodyn.checks.mirror.loads import MASS, ONE_OF_TWO, twins
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule
from robodyn.support.wording import figure


@rule(
    Severity.WARNING,
    Stage.MODEL,
    explanation=f"""Links are twins if their names are each other's but for left and right, and at q = 0 each stands
where the mirror image of the other does; the plane is found from the robot. Masses may differ by {100 * MASS:g} %.
Where two parts that stand opposite each other do differ, as two tools do, a waiver says so.""",
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
            yield Fault(one.inertial.mass.span, what, ONE_OF_TWO, right, left)
