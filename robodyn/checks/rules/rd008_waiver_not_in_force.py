"""A waiver names rules that exist, and says why.

A comment `<!-- robodyn: allow RD208 no tensor is published, see issue 52 -->` above an element, or
behind it on its line, allows the finding there. Without a reason nobody can tell later whether it still holds, so a
waiver without one is not in force; nor is one with a code that no rule has, or a comment that begins with `robodyn:`
and goes on in another way.
"""

from robodyn.checks.examples import inertia, one_link
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.checks.waivers import waivers

_IDENTITY = '<mass value="2"/>' + inertia("1 0 0 1 0 1")


@rule(
    Severity.WARNING,
    good=one_link(f"{_IDENTITY} <!-- robodyn: allow RD208 a test weight, its tensor does not matter -->"),
    bad=one_link(f"<!-- robodyn: allow RD208 -->{_IDENTITY}"),
)
def check(context: Context) -> Faults:
    for waiver in context.once(waivers):
        if not waiver.in_force(context.codes):
            what, remedy = waiver.problem(context.codes)
            yield Fault(waiver.at, what, remedy, subject=None)
