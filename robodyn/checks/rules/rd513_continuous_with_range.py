"""A joint that turns freely has no range that leaves angles out.

Readers ignore lower and upper of a continuous joint. A range that is less than a whole turn says that
the part has stops: a revolute joint was meant, and simulation and planning drive it through them. Ranges of a turn and
more leave nothing out, and lower = upper is taken for none.
"""

from math import pi

from robodyn.checks.examples import LIMIT, arm
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule

_TURN = 2 * pi * (1 - 1e-2)
"""A little less, for limits such as 3.14."""


@rule(Severity.WARNING, good=arm(), bad=arm(f'<axis xyz="0 1 0"/>{LIMIT}', "continuous"))
def check(context: Context) -> Faults:
    for joint in context.view.joints:
        limit = joint.limit
        if joint.type != "continuous" or limit is None or limit.range is None:
            continue
        lower, upper = limit.range
        if 0 < upper - lower < _TURN:
            what = (
                f"it is continuous, and so turns freely, but has a range from {lower:g} to {upper:g} rad, "
                "which is less than a turn and ignored"
            )
            remedy = 'write type="revolute" if the part has stops; otherwise remove lower and upper'
            at = limit.lower if limit.lower.given else limit.upper
            yield Fault(at.span, what, remedy, upper - lower, 2 * pi)
