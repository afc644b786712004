"""The verdict on a motion: which limits of robot, motors and gears it exceeds, what was not checked or is in doubt."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from robodyn.errors import Caveat
from robodyn.loads.result import JointLoad, Result
from robodyn.report.document import Bars, Block, Level, Paragraph, Section, Table, Verdict, paragraphs, select
from robodyn.report.table import first_names, is_noise, number, printable
from robodyn.robot.limits import Coverage, Excess
from robodyn.support.floats import ranked, steady
from robodyn.support.wording import count

if TYPE_CHECKING:
    from robodyn.simulation.result import JointUse, Simulation

LINES = 15
"""So many limits are named at the top of a page."""


def verdict_on_limits(
    joints: int,
    exceeded: Sequence[Excess],
    limits: Sequence[Coverage],
    caveats: Sequence[Caveat] = (),
    nearest: Sequence[str] = (),
) -> Verdict:
    """Return the verdict on so many joints, green only where every limit was checked and nothing is in doubt."""
    doubtful = tuple(caveat.text for caveat in caveats)
    over = len({excess.joint for excess in exceeded})
    if over:
        who = f"{over} of {joints} joints" if joints > 1 else "The joint"
        verb = "exceeds its limits" if over == 1 else "exceed their limits"
        reasons = (*doubtful, *shortened([exceeded_words(excess) for excess in exceeded]), *unchecked_words(limits))
        return Verdict("bad", f"{who} {verb}", reasons)
    clauses = "".join(f", {caveat.kind}" if k else f" {caveat.kind}" for k, caveat in enumerate(caveats))
    if not any(each.checked for each in limits):
        why = "the description gives no limits" if joints else "the robot has no joints"
        reasons = (*doubtful, *unchecked_words(limits))
        return Verdict("doubtful" if caveats else "neutral", f"Nothing was checked: {why}", reasons)
    partly = any(each.unchecked for each in limits)
    headline = f"No limit is exceeded{' where there is one' if partly else ''}{clauses}"
    level: Level = "doubtful" if caveats else "neutral" if partly else "good"
    return Verdict(level, headline, (*doubtful, *unchecked_words(limits), *nearest))


def unchecked_words(limits: Sequence[Coverage]) -> tuple[str, ...]:
    """Return a sentence for each quantity of which joints have no limit: none is given, 0, or a huge number."""
    lines = []
    for each in limits:
        if each.unchecked:
            silent = [one.joint for one in each.unchecked if one.given is None]
            zero = [one.joint for one in each.unchecked if one.given is not None and one.given <= 0.0]
            huge = {one.joint: one.given for one in each.unchecked if one.given is not None and one.given > 0.0}
            least = f"{min(huge.values(), default=0.0):g}{' or more' if len(set(huge.values())) > 1 else ''}"
            words = {"": silent, "0, which means none, for ": zero, f"{least}, which limits nothing, for ": list(huge)}
            who = "; ".join(f"{why}{first_names(names, most=4)}" for why, names in words.items() if names)
            count = f"{len(each.unchecked)} of {len(each.unchecked) + len(each.checked)} joints"
            lines.append(f"{count} have no {each.quantity} limit: not checked ({who}).")
    return tuple(lines)


def limits_data(limits: Sequence[Coverage]) -> dict[str, Any]:
    """Return by quantity the joints whose limits were checked, and those without, with what is given instead."""
    return {each.quantity: select(each, "checked unchecked") for each in limits}


def shortened(lines: list[str]) -> tuple[str, ...]:
    """Return the first of many lines; the tables have all."""
    if len(lines) <= LINES + 1:
        return tuple(lines)
    return (*lines[:LINES], f"{len(lines) - LINES} more limits are exceeded: see the table below.")


def exceeded_words(excess: Excess) -> str:
    name, value, limit, unit = printable(excess.joint), excess.value, excess.limit, excess.unit
    if excess.quantity == "position":
        side = "below its lower" if value < limit else "above its upper"
        return f"{name} goes to {value:.6g} {unit}, {side} limit of {limit:.6g} {unit}."
    beyond = "" if excess.seconds is None else f"; it is beyond the limit for {excess.seconds:.3g} s"
    percent = f"{100 * value / limit:.0f} % of its limit of {limit:g} {unit}{beyond}."
    if excess.quantity == "velocity":
        return f"{name} moves at {number(value)} {unit}, {percent}"
    what = "force" if unit == "N" else "torque"
    when = "" if excess.time is None else f" at {excess.time:.6g} s"
    return f"{name} needs a {what} of {number(value)} {unit}{when}, {percent}"


def offenders(result: Result) -> frozenset[str]:
    """Return the names of the joints that exceed a limit of the description, or of their motor or gear."""
    sized = result.sizing.joints if result.sizing else ()
    return frozenset((*(each.joint for each in result.exceeded), *(joint.name for joint in sized if joint.exceeded)))


def use_bars(result: Result | Simulation) -> list[Block]:
    """Return of every joint with a limit how much of it the motion uses, the worst first: effort, speed, and of motor
    and gear peak, continuous, speed."""
    from robodyn.report.sizing import uses

    sizing, rows = getattr(result, "sizing", None), []
    joints: Sequence[JointLoad | JointUse] = result.joints
    for k, load in enumerate(joints):
        shares = uses(load, sizing.joints[k] if sizing else None)
        if shares:
            bars = [(f"{_percent(share)} of {what}", 0.0, min(share, 100.0), _colour(share)) for share, what in shares]
            rows.append((max(share for share, _ in shares), load.name, bars, ""))
    ordered = [row[1:] for row in ranked(rows, key=lambda row: row[0])]
    return [Bars("How much of its limits each joint uses", ordered)] if ordered else []


def _colour(share: float) -> str:
    return "bad" if share > 100.0 else "doubtful" if share > 80.0 else "good"


def _percent(share: float) -> str:
    return f"{'<1' if 0.0 < share < 0.5 else f'{share:.0f}'} %"


def worst_joint(result: Result) -> int | None:
    """Return the joint that uses most of its effort limit; the one with the largest peak where there are none."""
    joints = result.joints
    limited = [k for k, joint in enumerate(joints) if joint.effort_limit]
    key = (lambda k: effort_use(joints[k])) if limited else (lambda k: abs(joints[k].peak))
    return next(iter(ranked(limited or range(len(joints)), key)), None)


def effort_use(joint: JointLoad | JointUse) -> float:
    """Return |peak| / limit; 0 without a limit."""
    return abs(joint.peak) / joint.effort_limit if joint.effort_limit else 0.0


def speed_use(joint: JointLoad | JointUse) -> float:
    """Return |speed| / limit; 0 without a limit."""
    return abs(joint.max_speed) / joint.velocity_limit if joint.velocity_limit else 0.0


def nearest_limits(joints: Sequence[JointLoad | JointUse]) -> Iterator[str]:
    """Return sentences on the joints that come nearest to their limits."""
    for use, what in ((effort_use, "effort"), (speed_use, "speed")):
        for joint in ranked((joint for joint in joints if use(joint)), key=use)[:1]:
            yield f"Nearest to its limit of {what} is {printable(joint.name)}, at {100 * use(joint):.0f} % of it."


def limits_verdict(result: Simulation) -> Verdict:
    """Return whether a simulated motion keeps to the limits of the description, as far as that was checked."""
    nearest = tuple(nearest_limits(result.joints))
    return verdict_on_limits(len(result.joints), result.exceeded, result.limits, result.caveats, nearest)


def limits_section(result: Simulation) -> Section:
    """Return the verdict's headline, or a table of what is exceeded, and what could not be checked."""
    exceeded = exceeded_section(result) or [Paragraph(f"{limits_verdict(result).headline}.")]
    return [*exceeded, *paragraphs(unchecked_words(result.limits))]


def use(value: float, limit: float | None) -> str:
    """Return how much of a limit a value takes, in percent."""
    if limit is None:
        return "-"
    percent = 0.0 if is_noise(abs(value), limit) else 100.0 * abs(value) / limit
    return f"{'<1' if 0.0 < percent < 0.5 else f'{percent:.0f}'}% of {limit:g}"


def torques_verdict(result: Result) -> Verdict:
    """Return the verdict: bad if a limit of robot, motor or gear is exceeded or the accuracy asked for is missed."""
    over, sizing, unsure = _exceeded_things(result), result.sizing, result.uncertainty
    doubtful, nearest = tuple(caveat.text for caveat in result.caveats), tuple(nearest_limits(result.joints))
    kept = verdict_on_limits(len(result.joints), (), result.limits, result.caveats, nearest)
    if not any(each.checked for each in result.limits) and sizing and any(joint.motor for joint in sizing.joints):
        clauses = ", ".join(caveat.kind for caveat in result.caveats)
        headline = f"No limit of a motor or gear is exceeded, and the description gives none {clauses}".strip()
        kept = replace(kept, headline=headline)
    if unsure is not None and unsure.suffices is not None:
        from robodyn.report.sizing import probability

        said = f"All limits are kept with {probability(unsure.suffices)}."
        kept = replace(kept, reasons=(said, *kept.reasons))
    accuracy = result.accuracy
    unmet = () if accuracy is None or accuracy.met else (f"The accuracy asked for is not met: {accuracy.said}.",)
    if over:
        names = {joint for joint, _ in over}
        who = f"{len(names)} of {len(result.joints)} joints" if len(result.joints) > 1 else "The joint"
        one, motors = len(names) == 1, sizing is not None and sizing.exceeded
        verb = "asks" if one else "ask"
        does = f"{verb} more than motors, gears or limits bear" if motors else "exceeds its" if one else "exceed their"
        lines = shortened([line for _, line in over])
        unchecked = [line for line in kept.reasons if line not in (*doubtful, *nearest)]
        return Verdict("bad", f"{who} {does}{'' if motors else ' limits'}", (*lines, *unmet, *doubtful, *unchecked))
    if unmet:
        return Verdict("bad", "The accuracy asked for is not met", (*unmet, *kept.reasons))
    return kept


def verdict_section(result: Result) -> Section:
    """Return the verdict as the last lines of a text: what was not checked, then the headline with the worst."""
    verdict = torques_verdict(result)
    if not result.joints and verdict.level == "neutral":
        return ()
    if verdict.level == "bad":
        more = len({line for _, line in _exceeded_things(result)}) - 1
        others = f" {count(more, 'more limit is', 'more limits are')} exceeded." if more > 0 else ""
        return paragraphs([f"{verdict.headline}: {verdict.reasons[0]}{others}"])
    shown = (*(caveat.text for caveat in result.caveats), *nearest_limits(result.joints))  # among warnings, and tables
    return paragraphs([*(line for line in verdict.reasons if line not in shown), f"{verdict.headline}."])


def exceeded_section(result: Result | Simulation) -> Section:
    """Return a table of the limits of the description that are exceeded, joint by joint; nothing without."""
    if not result.exceeded:
        return ()
    found: dict[str, dict[str, list[str]]] = {}
    for excess in result.exceeded:
        cell = f"{excess.value:.6g} {excess.unit}, limit {excess.limit:.6g}"
        found.setdefault(excess.joint, {}).setdefault(excess.quantity, []).append(cell)
    quantities = [name for name in ("effort", "velocity", "position") if any(name in row for row in found.values())]
    rows = [(joint, *("; ".join(row.get(name, ())) for name in quantities)) for joint, row in found.items()]
    title = f"LIMITS EXCEEDED by {len(rows)} of {count(len(result.joints), 'joint')}"
    return [Table(title, ("joint", *quantities), rows)]


def _exceeded_things(result: Result) -> list[tuple[str, str]]:
    """Return joint and sentence of all that is exceeded, once: first what breaks, by how many times the limit it is."""
    found: list[tuple[bool, float, str, str]] = []
    for excess in result.exceeded:
        beyond, position = abs(excess.value - excess.limit), excess.quantity == "position"
        times = float(steady(1.0 + beyond if position else excess.value / excess.limit))  # [rad, m] beyond a position
        found.append((False, -times, excess.joint, exceeded_words(excess)))
    if result.sizing is not None and result.sizing.exceeded:
        from robodyn.report.sizing import in_words

        for joint in result.sizing.joints:
            for each in joint.exceeded:
                if each.quantity not in ("effort", "velocity"):
                    times = each.value / each.limit if each.limit > 0.0 else float("inf")
                    line = f"{printable(joint.name)}: {in_words(each)}."
                    found.append((each.level == "over continuous", -float(steady(times)), joint.name, line))
    return [(joint, line) for _, _, joint, line in sorted(found)]
