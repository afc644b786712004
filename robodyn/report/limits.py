"""The verdict on a motion: which limits of robot, motors and gears it exceeds, what was not checked or is in doubt."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from robodyn.errors import Caveat
from robodyn.loads.result import JointLoad, Result
from robodyn.report.document import Bars, Block, Level, Section, Table, Verdict, paragraphs, select
from robodyn.report.motor_loads import in_words, probability, uses
from robodyn.report.table import first_names, is_noise, number, percent, printable
from robodyn.robot.limits import Coverage, Excess
from robodyn.support.floats import ranked, steady
from robodyn.support.wording import count

if TYPE_CHECKING:
    from robodyn.loads.result import Promise, Sizing
    from robodyn.loads.uncertainty_result import Uncertain
    from robodyn.simulation.result import JointUse, Simulation

LINES = 15
"""So many limits are named at the top of a page."""


def verdict_on_limits(
    joints: int,
    over: Sequence[tuple[str, str]],
    limits: Sequence[Coverage],
    caveats: Sequence[Caveat] = (),
    motors: bool = False,
) -> Verdict:
    """Return the verdict on so many joints, of which some exceed limits (joint, sentence), green only where every limit
    was checked and nothing is in doubt."""
    doubts = (*(caveat.text for caveat in caveats), *unchecked_words(limits))
    names, lines = {joint for joint, _ in over}, [line for _, line in over]
    if names:
        who = f"{len(names)} of {joints} joints" if joints > 1 else "The joint"
        does = "exceeds its limits" if len(names) == 1 else "exceed their limits"
        if motors:
            does = f"{'asks' if len(names) == 1 else 'ask'} more than motors, gears or limits bear"
        if len(lines) > LINES + 1:
            lines[LINES:] = [f"{len(lines) - LINES} more limits are exceeded: see the table below."]
        return Verdict("bad", f"{who} {does}", (*lines, *doubts))
    clauses = ", ".join(caveat.kind for caveat in caveats)
    checked, partly = any(each.checked for each in limits), any(each.unchecked for each in limits)
    level: Level = "doubtful" if caveats else "good" if checked and not partly else "neutral"
    if checked:
        headline = f"No limit is exceeded {'where there is one ' * partly}{clauses}"
    elif motors:
        headline = f"No limit of a motor or gear is exceeded, and the description gives none {clauses}"
    else:
        headline = f"Nothing was checked: {'the description gives no limits' if joints else 'the robot has no joints'}"
    return Verdict(level, headline.strip(), doubts)


def limits_verdict(result: Result | Simulation) -> Verdict:
    """Return the verdict: bad if a limit of robot, motor or gear is exceeded or the accuracy asked for is missed."""
    over = _exceeded(result)
    sizing: Sizing | None = getattr(result, "sizing", None)
    unsure: Uncertain | None = getattr(result, "uncertainty", None)
    accuracy: Promise | None = getattr(result, "accuracy", None)
    motors = sizing is not None and (sizing.exceeded if over else any(joint.motor for joint in sizing.joints))
    verdict = verdict_on_limits(len(result.joints), over, result.limits, result.caveats, motors)
    missed = [] if accuracy is None or accuracy.met else [f"The accuracy asked for is not met: {accuracy.said}."]
    if over:
        return replace(verdict, reasons=(*verdict.reasons, *missed))
    chance = None if unsure is None else unsure.suffices
    sure = [] if chance is None else [f"All limits are kept with {probability(chance)}."]
    verdict = replace(verdict, reasons=(*missed, *sure, *verdict.reasons))
    return replace(verdict, level="bad", headline="The accuracy asked for is not met") if missed else verdict


def verdict_section(result: Result | Simulation) -> Section:
    """Return the verdict as the last lines of a text: what was not checked, then the headline with the worst."""
    verdict = limits_verdict(result)
    if not result.joints and verdict.level == "neutral":
        return ()
    if verdict.level == "bad":
        more = len({line for _, line in _exceeded(result)}) - 1
        others = f" {count(more, 'more limit is', 'more limits are')} exceeded." if more > 0 else ""
        return paragraphs([f"{verdict.headline}: {verdict.reasons[0]}{others}"])
    warned = [caveat.text for caveat in result.caveats]
    return paragraphs([*(line for line in verdict.reasons if line not in warned), f"{verdict.headline}."])


def exceeded_section(result: Result | Simulation) -> Section:
    """Return a table of the limits of the description that are exceeded, joint by joint; nothing without."""
    found: dict[str, dict[str, list[str]]] = {}
    for excess in result.exceeded:
        cell = f"{excess.value:.6g} {excess.unit}, limit {excess.limit:.6g}"
        found.setdefault(excess.joint, {}).setdefault(excess.quantity, []).append(cell)
    quantities = [name for name in ("effort", "velocity", "position") if any(name in row for row in found.values())]
    rows = [(joint, *("; ".join(row.get(name, ())) for name in quantities)) for joint, row in found.items()]
    title = f"LIMITS EXCEEDED by {len(rows)} of {count(len(result.joints), 'joint')}"
    return [Table(title, ("joint", *quantities), rows)] if rows else []


def unchecked_words(limits: Sequence[Coverage]) -> tuple[str, ...]:
    """Return a sentence for each quantity of which joints have no limit: none is given, 0, or a huge number."""
    lines = []
    for each in limits:
        why: dict[str, list[str]] = {}
        for one in each.unchecked:
            none = one.given is not None and one.given <= 0.0
            said = (
                "" if one.given is None else f"{one.given:g}, which {'means none' if none else 'limits nothing'}, for "
            )
            why.setdefault(said, []).append(one.joint)
        if why:
            who = "; ".join(f"{said}{first_names(names, most=4)}" for said, names in why.items())
            joints = f"{len(each.unchecked)} of {len(each.unchecked) + len(each.checked)} joints"
            lines.append(f"{joints} have no {each.quantity} limit: not checked ({who}).")
    return tuple(lines)


def limits_data(limits: Sequence[Coverage]) -> dict[str, Any]:
    """Return by quantity the joints whose limits were checked, and those without, with what is given instead."""
    return {each.quantity: select(each, "checked unchecked") for each in limits}


def exceeded_words(excess: Excess) -> str:
    name, value, limit, unit = printable(excess.joint), excess.value, excess.limit, excess.unit
    if excess.quantity == "position":
        side = "below its lower" if value < limit else "above its upper"
        return f"{name} goes to {value:.6g} {unit}, {side} limit of {limit:.6g} {unit}."
    beyond = "" if not excess.seconds else f"; it is beyond the limit for {excess.seconds:.3g} s"
    over = f"{100 * value / limit:.0f}"
    over = f"{100 * value / limit:.6g}" if over == "100" else over
    share = f"{over} % of its limit of {limit:g} {unit}{beyond}."
    if excess.quantity == "velocity":
        return f"{name} moves at {number(value)} {unit}, {share}"
    what = "force" if unit == "N" else "torque"
    when = "" if excess.time is None else f" at {excess.time:.6g} s"
    return f"{name} needs a {what} of {number(value)} {unit}{when}, {share}"


def _exceeded(result: Result | Simulation) -> list[tuple[str, str]]:
    """Return joint and sentence of all that is exceeded, once: first what breaks, by how many times the limit it is."""
    found: list[tuple[bool, float, str, str]] = []
    for excess in result.exceeded:
        beyond, position = abs(excess.value - excess.limit), excess.quantity == "position"
        times = float(steady(1.0 + beyond if position else excess.value / excess.limit))  # [rad, m] beyond a position
        found.append((False, -times, excess.joint, exceeded_words(excess)))
    sizing = getattr(result, "sizing", None)
    for joint in sizing.joints if sizing else ():
        for each in joint.exceeded:
            if each.quantity not in ("effort", "velocity"):
                times = each.value / each.limit if each.limit > 0.0 else float("inf")
                line = f"{printable(joint.name)}: {in_words(each)}."
                found.append((each.level != "over peak", -float(steady(times)), joint.name, line))
    return [(joint, line) for _, _, joint, line in sorted(found)]


def offenders(result: Result) -> frozenset[str]:
    """Return the names of the joints that exceed a limit of the description, or of their motor or gear."""
    return frozenset(joint for joint, _ in _exceeded(result))


def use_bars(result: Result | Simulation) -> list[Block]:
    """Return of every joint with a limit how much of it the motion uses, the worst first: effort, speed, and of motor
    and gear peak, continuous, speed."""
    sizing, rows = getattr(result, "sizing", None), []
    joints: Sequence[JointLoad | JointUse] = result.joints
    for k, load in enumerate(joints):
        bars, shares = [], uses(load, sizing.joints[k] if sizing else None)
        for share, what in shares:
            colour = "bad" if share > 100.0 else "doubtful" if share > 80.0 else "good"
            bars.append((f"{percent(share)} % of {what}", 0.0, min(share, 100.0), colour))
        if any(each.joint == load.name and each.quantity == "position" for each in result.exceeded):
            shares.append((101.0, "position"))
            bars.append(("beyond a position limit", 0.0, 100.0, "bad"))
        if bars:
            rows.append((max(shares)[0], load.name, bars, ""))
    ordered = [row[1:] for row in ranked(rows, key=lambda row: row[0])]
    return [Bars("How much of its limits each joint uses", ordered)] if ordered else []


def worst_joint(result: Result) -> int | None:
    """Return the joint that uses most of its effort limit; the one with the largest peak where there are none."""
    joints = result.joints
    limited = [k for k, joint in enumerate(joints) if joint.effort_limit]
    key = (lambda k: effort_use(joints[k])) if limited else (lambda k: abs(joints[k].peak))
    return next(iter(ranked(limited or range(len(joints)), key)), None)


def effort_use(joint: JointLoad | JointUse) -> float:
    """Return |peak| / limit; 0 without a limit."""
    return abs(joint.peak) / joint.effort_limit if joint.effort_limit else 0.0


def use(value: float, limit: float | None) -> str:
    """Return how much of a limit a value takes, in percent."""
    if limit is None:
        return "-"
    return f"{percent(0.0 if is_noise(abs(value), limit) else 100.0 * abs(value) / limit)}% of {limit:g}"
