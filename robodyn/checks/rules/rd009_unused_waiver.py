"""A waiver allows a finding that is there.

A waiver that outlives its finding would hide the next one. It is reported if its rule has run and
has found nothing in the element that the waiver is about.
"""

from robodyn.checks.examples import one_link
from robodyn.checks.rule import Context, Edit, Fault, Faults, Fix, Severity, rule
from robodyn.checks.waivers import Waiver


@rule(Severity.WARNING, good=one_link(), bad=("<mass", "<!-- robodyn: allow RD208 no tensor is published --><mass"))
def check(context: Context) -> Faults:
    """Nothing: only when the other rules have run is it known which waivers they needed; the run then asks `unused`."""
    return ()


def unused(waiver: Waiver, code: str) -> Fault:
    what = f"the waiver of {code} has nothing to waive"
    remedy = "delete it, or put it above the element that the finding is in"
    fix = Fix("delete the waiver", (Edit(*waiver.erased, ""),), safe=True) if len(waiver.codes) == 1 else None
    return Fault(waiver.at, what, remedy, fix=fix, subject=None)
