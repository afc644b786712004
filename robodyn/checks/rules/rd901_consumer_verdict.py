"""The programs that a description is meant for take it as it is."""

from robodyn.checks.consumers.found import named
from robodyn.checks.consumers.verdicts import FACTS, Opinion, Verdict, opinion
from robodyn.checks.context import TARGETS
from robodyn.checks.examples import a_joint, a_link, arm
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule

_MOST = 3
_UNASKED = ("mujoco", "drake")
"""Programs that the tests run."""
_SAYS = {Verdict.LOADS: "loads it as it is", Verdict.ALTERS: "loads it with changes", Verdict.REJECTS: "rejects it"}

_TOOL = a_link("tool") + a_joint("yaw", "cross", "tool")

_KNOWN = "\n".join(f"{fact.target} {fact.verdict.name.lower()}: it {fact.does} [{fact.source}]." for fact in FACTS)


@rule(
    Severity.NOTE,
    Stage.TREE,
    explanation=f"""For each program asked for ({", ".join(TARGETS)}) its verdict: loads, alters, or rejects and why. A
rejection by a program that is asked for is an error, all else a remark. Without being asked, only rejections by
{" and ".join(_UNASKED)} are reported, where no other rule tells of the same link or joint why. What is known, and from
where (KG is a mass):
{_KNOWN}""",
    good=arm(more=a_link("cross") + a_joint("pitch", "upper", "cross") + _TOOL),
    bad=arm(more=a_link("cross", "") + a_joint("pitch", "upper", "cross") + _TOOL),
)
def check(context: Context) -> Faults:
    """Yield the verdict of every program that is asked for; without being asked, each place that makes one reject the
    file, so that another rule may have told of it."""
    for target in context.asked.targets:
        yield _verdict(context, opinion(context, target))
    alone = {*map(named, context.view.links), *map(named, context.view.joints)}
    for target in () if context.asked.targets else _UNASKED:
        for fact, found in opinion(context, target, Verdict.REJECTS).found:
            does = f"{target} rejects it: it {fact.does}"
            for one in found:
                what = does if one.what in alone else f"{does} ({one.what})"
                yield Fault(one.at, what, f"known from {fact.source}", kind=does)


def _verdict(context: Context, one: Opinion) -> Fault:
    shown = [entry for entry in one.found if entry[0].verdict is one.verdict]
    reasons = [f"{fact.says(found)} ({_listed([each.what for each in found])})" for fact, found in shown]
    sources = dict.fromkeys(fact.source for fact, _ in shown)
    what = f"{one.target} {_SAYS[one.verdict]}" + (f": it {'; it '.join(reasons)}" if reasons else "")
    remedy = f"known from {'; '.join(sources)}" if sources else "nothing to do"
    at = shown[0][1][0].at if shown else context.view.root.span
    refused = one.verdict is Verdict.REJECTS
    return Fault(at, what, remedy, subject=None, severity=Severity.ERROR if refused else None)


def _listed(names: list[str]) -> str:
    more = f" and {len(names) - _MOST} more" if len(names) > _MOST else ""
    return ", ".join(names[:_MOST]) + more
