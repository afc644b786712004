"""What is asked for: limits along a motion, verdicts of programs, the earlier version."""

from __future__ import annotations

from math import isfinite

from robodyn.checks.context import TARGETS
from robodyn.checks.examples import a_joint, a_link, arm
from robodyn.checks.importers import FACTS, INSTALLABLE, Opinion, Verdict, named, opinion, refusals
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule
from robodyn.robot.urdf.view import JointView, LinkView, Subject


@rule(
    "RD802",
    Severity.WARNING,
    Stage.MODEL,
    good=arm('<axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="30" velocity="9"/>'),
    bad=('lower="-2" upper="2"', 'lower="-0.5" upper="0.5"'),
)
def limits_along_motion(context: Context) -> Faults:
    """The limits hold along the given motion.

    With --trajectory FILE: the torques of inverse dynamics, speeds and positions along the motion, against effort,
    velocity, lower and upper. It is what robodyn torques --fail-on-limits says, among the other findings. The
    examples are held against a motion that swings the arm by 1 rad.
    """
    if context.asked.trajectory is None:
        return
    from robodyn.loads.torques import torques
    from robodyn.trajectory.read import read_motion

    with read_motion(context.asked.trajectory, context.model, **context.asked.reading) as motion:
        result = torques(context.model, motion)
    for caveat in motion.caveats:
        what = f"limits along {context.asked.trajectory} hold only {caveat.kind}: {caveat.text}"
        yield Fault(context.view.root.span, what, "say which unit it is", subject=None)
    for excess in result.exceeded:
        joint = context.view.joint[excess.joint]
        assert joint.limit is not None, "a limit is exceeded"
        name: str = excess.quantity
        if name == "position":
            name = "lower" if excess.value < excess.limit else "upper"
        what = (
            f"the motion of {context.asked.trajectory} reaches {excess.quantity} {excess.value:.4g} "
            f"{excess.unit}, beyond the limit {excess.limit:g}"
        )
        remedy = "slow the motion down or raise the limit; robodyn torques says when"
        yield Fault(getattr(joint.limit, name).span, what, remedy, excess.value, excess.limit)


_MOST = 3
_LONGEST = 300
_SAYS = {Verdict.LOADS: "loads it as it is", Verdict.ALTERS: "loads it with changes", Verdict.REJECTS: "rejects it"}

_TOOL = a_link("tool") + a_joint("yaw", "cross", "tool")

_KNOWN = "\n".join(f"{fact.target} {fact.verdict.name.lower()}: it {fact.does} [{fact.source}]." for fact in FACTS)


@rule(
    "RD901",
    Severity.NOTE,
    Stage.TREE,
    explanation=f"""For each program asked for ({", ".join(TARGETS)}) its verdict: loads, alters, or rejects and why. A
rejection by a program that is asked for is an error, all else a remark. {" and ".join(INSTALLABLE)} are run where they
are installed, in a process of their own, and what they say is given; what they alter, and what others do, is looked up
in a table. Without being asked nothing is run, and only what the table knows {" and ".join(INSTALLABLE)} to reject is
reported where no other rule tells of the same link or joint why. Of meshes RD601 and RD607 tell. The table:
{_KNOWN}""",
    good=arm(more=a_link("cross") + a_joint("pitch", "upper", "cross") + _TOOL),
    bad=arm(more=a_link("cross", "") + a_joint("pitch", "upper", "cross") + _TOOL),
)
def consumer_verdict(context: Context) -> Faults:
    """The programs that a description is meant for take it as it is."""
    for target in context.asked.targets:
        yield _verdict(context, opinion(context, target))
    alone = {*map(named, context.view.links), *map(named, context.view.joints)}
    for target in () if context.asked.targets else INSTALLABLE:
        for fact, found in refusals(context, target):
            does = f"{target} rejects it: it {fact.does}"
            for at, one in found:
                yield Fault(at, does if one in alone else f"{does} ({one})", f"known from {fact.source}", kind=does)


def _verdict(context: Context, one: Opinion) -> Fault:
    shown = [entry for entry in one.found if entry[0].verdict is one.verdict]
    reasons = []
    for fact, found in shown:
        more = f" and {len(found) - _MOST} more" if len(found) > _MOST else ""
        reasons.append(f"it {fact.does} ({', '.join(each for _, each in found[:_MOST])}{more})")
    sources, answer = dict.fromkeys(fact.source for fact, _ in shown), one.answer
    if answer is not None and answer.refusal is not None:
        reasons.insert(0, f'it says "{answer.refusal[:_LONGEST]}"')
    what = f"{one.target} {_SAYS[one.verdict]}" + (f": {'; '.join(reasons)}" if reasons else "")
    known = [f"known from {'; '.join(sources)}"] if sources else []
    if answer is not None:
        known.insert(0, f"run in version {answer.version}" if answer.version else "not run, since it is not installed")
    at, severity = shown[0][1][0][0] if shown else context.view.root.span, Severity.ERROR
    severity = severity if one.verdict is Verdict.REJECTS else Severity.NOTE
    return Fault(at, what, "; ".join(known) or "nothing to do", subject=None, severity=severity)


@rule("RD902", Severity.WARNING, Stage.MODEL, good=arm(), bad=('value="2"', 'value="2.2"'))
def regression(context: Context) -> Faults:
    """The dynamics are those of the earlier version.

    With --against REF, the robot is compared with what git has of the same file at that revision: joints that come,
    go, move or change their order, types, axes, limits and friction; masses, centres of mass and inertias of the
    moving bodies, with everything fixed to them; and the torques of both in random states, in percent of the
    largest. Moving a fixed frame, renaming a fixed joint or splitting a link changes nothing here. The examples are
    two versions of a file: the bad one is compared with the good one.
    """
    against = context.asked.against
    if against is None:
        return
    from robodyn.checks.regression import changes, model_at

    before = model_at(context.reading.file, against)
    if before is None:
        return
    parts: dict[Subject, LinkView | JointView] = {part.subject: part for part in context.view.links}
    parts |= {part.subject: part for part in context.view.joints}
    for change in changes(before, context.model):
        subject, measured = Subject(change.kind, change.name), change.size if isfinite(change.size) else None
        at = parts[subject].name_span if subject in parts else context.view.root.span
        what = f"{change.what}, against {against}"
        yield Fault(at, what, "see that the change is meant", measured, subject=subject)
