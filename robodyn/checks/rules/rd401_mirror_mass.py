"""A left link weighs what the right one does."""

from robodyn.checks.examples import IMAGE, ORIGIN_IMAGE, two_arms
from robodyn.checks.mirror.loads import MASS, twins
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule
from robodyn.support.wording import figure, shown


@rule(
    Severity.WARNING,
    Stage.MODEL,
    explanation=f"""Links are twins if their names are each other's but for left and right, and at q = 0 each stands
where the mirror image of the other does; the plane is found from the robot. Masses may differ by {100 * MASS:g} %.
Where two parts that stand opposite each other do differ, as two tools do, a waiver says so.""",
    bad=two_arms(right=f'{ORIGIN_IMAGE}<mass value="2.1"/>{IMAGE}'),
    good=two_arms(),
)
def check(context: Context) -> Faults:
    for one in context.once(twins):
        left, right = one.masses
        if one.mass_differs:
            yield Fault(
                at=one.inertial.mass.span,
                subject=one.link.subject,
                what=f"the mass is {right:g} kg; that of its mirror twin {shown(one.other)} is {left:g} kg, "
                f"{figure(100 * abs(left - right) / max(left, right), 2)} % apart",
                remedy="one of the two is wrong, or allow it where the parts differ",
                measured=right,
                bound=left,
            )
