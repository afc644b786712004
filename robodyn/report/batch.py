"""What becomes of many trajectories as text for a person: a line for each, and a summary."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from robodyn.loads.many import Batch, Outcome, Status, Worst
from robodyn.report.document import Paragraph, Section, Table, paragraphs
from robodyn.report.limits import unchecked_words, use, verdict_on_limits
from robodyn.report.sizes import speed_unit
from robodyn.report.table import Content, moment, number, printable
from robodyn.support.wording import count

_LISTED = 3
"""Exceeded limits that a line names."""


def outcome_line(outcome: Outcome) -> str:
    """Return what became of one trajectory."""
    name = printable(outcome.trajectory)
    if outcome.status == "failed":
        return f"{name}: failed"
    before = "finished before, " if outcome.status == "finished before" else ""
    more = f" and {len(outcome.exceeded) - _LISTED} more" if len(outcome.exceeded) > _LISTED else ""
    limits = f", LIMITS EXCEEDED: {printable(', '.join(outcome.exceeded[:_LISTED]))}{more}" if outcome.exceeded else ""
    samples = f"{count(outcome.samples, 'sample')}, {outcome.duration:.6g} s"
    return f"{name}: {before}{samples}{limits} -> {printable(outcome.table)}"


def batch_sections(batch: Batch) -> Iterator[Section]:
    """Yield the summary: how many there are of each kind, and the worst of each joint."""
    kinds: tuple[Status, ...] = ("computed", "finished before", "failed")
    found = [f"{amount} {kind}" for kind in kinds if (amount := batch.count(kind))]
    done = [outcome for outcome in batch.outcomes if outcome.status != "failed"]
    yield [Paragraph(f"{batch.robot}: {count(len(batch.outcomes), 'file')}, {', '.join(found)}")]
    if batch.worst:
        yield [Table("The worst of each joint", *worst_table(batch.worst))]
    if done:
        yield paragraphs(_limits(done))


def _limits(done: Sequence[Outcome]) -> list[str]:
    """Return the verdict on the limits of all motions, and what is in doubt, each with the files that it is about."""
    doubts = {doubt.clause: doubt for outcome in done for doubt in reversed(outcome.doubts)}
    limits, over = done[0].limits, sum(bool(outcome.exceeded) for outcome in done)
    verdict = verdict_on_limits(len(done[0].joints), (), limits, tuple(doubts.values()))
    said = f"LIMITS EXCEEDED in {count(over, 'file')}" if over else f"{verdict.headline}."
    lines = [said, *unchecked_words(limits)]
    for clause in doubts:
        about = [(x.trajectory, doubt.said) for x in done for doubt in x.doubts if doubt.clause == clause]
        others = f" and {count(len(about) - 1, 'other file')}" if len(about) > 1 else ""
        lines.append(f"warning: {about[0][0]}{others}: {about[0][1]}")
    return lines


def worst_table(worst: tuple[Worst, ...]) -> Content:
    loads, speeds = (_largest(worst, what) for what in ("peak", "max_speed"))
    rows = []
    for joint in worst:
        load, fastest, speed = loads[joint.unit], speeds[joint.unit], speed_unit(joint.unit)
        row = [
            joint.name,
            f"{number(joint.peak, load)} {joint.unit}",
            moment(joint.peak_time, joint.peak, load),
            joint.peak_in,
            use(joint.peak, joint.effort_limit),
            number(joint.rms, load),
            joint.rms_in,
            f"{number(joint.max_speed, fastest)} {speed}",
            joint.max_speed_in,
            use(joint.max_speed, joint.velocity_limit),
        ]
        rows.append(row if joint.level is None else [*row, joint.level, joint.level_in])
    head = ["joint", "peak", "at [s]", "in", "of effort limit", "RMS", "in", "max speed", "in", "of velocity limit"]
    return (head if worst[0].level is None else [*head, "verdict", "in"]), rows


def _largest(worst: Sequence[Worst], what: str) -> dict[str, float]:
    """Return the largest magnitude of a figure among all joints of a unit, beside which noise vanishes."""
    found: dict[str, float] = {}
    for joint in worst:
        found[joint.unit] = max(found.get(joint.unit, 0.0), abs(getattr(joint, what)))
    return found
