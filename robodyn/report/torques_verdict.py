"""The one verdict on a motion: what is exceeded of robot, motors and gears, what is in doubt, the worst first."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

from robodyn.loads.result import Result
from robodyn.report.document import Block, Paragraph, Section, Table, Verdict, paragraphs
from robodyn.report.limits import exceeded_table, exceeded_words, nearest_limits, shortened, verdict_on_limits
from robodyn.report.table import printable
from robodyn.robot.limits import Excess
from robodyn.support.floats import steady
from robodyn.support.wording import count


class _Excess(NamedTuple):
    """A limit that is exceeded: of which joint, in words; what wears out comes after what breaks, then by how much."""

    wears: bool
    times: float
    joint: str
    line: str


def torques_verdict(result: Result) -> Verdict:
    """Return the verdict: bad if a limit of robot, motor or gear is exceeded or an accuracy that was asked for is not
    met; doubtful, neutral or good as `verdict_on_limits` has it."""
    over, sizing = sorted(_exceeded(result)), result.sizing
    doubtful = tuple(caveat.text for caveat in result.caveats)
    kept, unmet = _kept(result), _unmet(result)
    if over:
        names = {each.joint for each in over}
        who = f"{len(names)} of {len(result.joints)} joints" if len(result.joints) > 1 else "The joint"
        one, motors = len(names) == 1, sizing is not None and sizing.exceeded
        verb = "asks" if one else "ask"
        does = f"{verb} more than motors, gears or limits bear" if motors else "exceeds its" if one else "exceed their"
        lines = shortened([each.line for each in over])
        unchecked = [line for line in kept.reasons if line not in (*doubtful, *nearest_limits(result.joints))]
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
        more = len({each.line for each in _exceeded(result)}) - 1
        others = f" {count(more, 'more limit is', 'more limits are')} exceeded." if more > 0 else ""
        return paragraphs([f"{verdict.headline}: {verdict.reasons[0]}{others}"])
    shown = (*(caveat.text for caveat in result.caveats), *nearest_limits(result.joints))  # among warnings, and tables
    return paragraphs([*(line for line in verdict.reasons if line not in shown), f"{verdict.headline}."])


def exceeded_section(result: Result) -> Section:
    """Return a table of the limits of the description that are exceeded; nothing without."""
    if not result.exceeded:
        return ()
    head, rows = exceeded_table(result.exceeded)
    return [Table(f"LIMITS EXCEEDED by {len(rows)} of {count(len(result.joints), 'joint')}", head, rows)]


def accuracy_blocks(result: Result) -> Iterator[Block]:
    """Yield what became of an accuracy that was asked for."""
    if result.accuracy:
        yield Paragraph(f"accuracy: {'' if result.accuracy.met else 'NOT MET: '}{result.accuracy.said}")


def _exceeded(result: Result) -> Iterator[_Excess]:
    """Yield everything that is exceeded, what the description limits and sizing repeats once."""
    for excess in result.exceeded:
        yield _Excess(False, -_times(excess), excess.joint, exceeded_words(excess))
    if result.sizing is None or not result.sizing.exceeded:
        return
    from robodyn.report.sizing import in_words

    for joint in result.sizing.joints:
        for each in joint.exceeded:
            if each.quantity not in ("effort", "velocity"):
                times = each.value / each.limit if each.limit > 0.0 else float("inf")
                line = f"{printable(joint.name)}: {in_words(each)}."
                yield _Excess(each.level == "over continuous", -float(steady(times)), joint.name, line)


def _times(excess: Excess) -> float:
    """Return how many times its limit something is; of a position 1 and how far it is beyond [rad, m]."""
    beyond = abs(excess.value - excess.limit)
    return float(steady(1.0 + beyond if excess.quantity == "position" else excess.value / excess.limit))


def _unmet(result: Result) -> tuple[str, ...]:
    accuracy = result.accuracy
    return () if accuracy is None or accuracy.met else (f"The accuracy asked for is not met: {accuracy.said}.",)


def _kept(result: Result) -> Verdict:
    """Return the verdict on a motion that exceeds nothing."""
    nearest, sizing = tuple(nearest_limits(result.joints)), result.sizing
    verdict = verdict_on_limits(len(result.joints), (), result.limits, result.caveats, nearest)
    if not any(each.checked for each in result.limits) and sizing and any(joint.motor for joint in sizing.joints):
        clauses = ", ".join(caveat.kind for caveat in result.caveats)
        headline = f"No limit of a motor or gear is exceeded, and the description gives none {clauses}".strip()
        verdict = replace(verdict, headline=headline)
    unsure = result.uncertainty
    if unsure is not None and unsure.suffices is not None:
        from robodyn.report.uncertainty import probability

        said = f"All limits are kept with {probability(unsure.suffices)}."
        verdict = replace(verdict, reasons=(said, *verdict.reasons))
    return verdict
