"""A left link has the principal moments of the right one."""

from robodyn.checks.causes.causes import causes
from robodyn.checks.examples import IMAGE, two_arms
from robodyn.checks.mirror.loads import MOMENTS, ONE_OF_TWO, twins
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule
from robodyn.support.wording import figure


@rule(
    Severity.WARNING,
    Stage.MODEL,
    explanation=f"""A reflection leaves principal moments as they are. They may differ by {100 * MOMENTS:g} % of the
largest, as they stand or each divided by the mass of its link, so that a wrong mass is RD401's alone. Twins are found
as RD401 says. Where one cause explains the difference, RD306 to RD312 name it instead, and where no body can have one
of the tensors, RD204, RD206 or RD207 do.""",
    good=two_arms(),
    bad=(IMAGE, IMAGE.replace('"0.02"', '"0.024"')),
)
def check(context: Context) -> Faults:
    for one in context.once(twins):
        explained = {one.link.name, one.pair.left.name} & context.once(causes).keys()
        if one.moments_apart <= MOMENTS or not one.real or explained:
            continue
        left, right = ((mass * moments).tolist() for mass, moments in zip(one.masses, one.moments, strict=True))
        what = (
            f"the principal moments are {_listed(right)} kg m^2, those of its mirror twin {one.other} {_listed(left)}, "
            f"up to {figure(100 * one.moments_apart, 2)} % apart"
        )
        yield Fault(one.inertial.entries[0].span, what, ONE_OF_TWO, one.moments_apart, MOMENTS)


def _listed(moments: list[float]) -> str:
    return ", ".join(f"{moment:.4g}" for moment in moments)
