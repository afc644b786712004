"""What becomes of many trajectories as text for a person: a line for each, and a summary."""

from __future__ import annotations

from robodyn.batch_result import Batch, Outcome, Status, Worst
from robodyn.report.table import PLAIN, Content, Page, number, printable
from robodyn.report.text_torques import count, use

_LISTED = 3
"""Exceeded limits that a line names."""


def outcome_line(outcome: Outcome) -> str:
    """What became of one trajectory."""
    name = printable(outcome.trajectory)
    if outcome.status == "failed":
        return f"{name}: failed"
    before = "finished before, " if outcome.status == "finished before" else ""
    more = f" and {len(outcome.exceeded) - _LISTED} more" if len(outcome.exceeded) > _LISTED else ""
    limits = f", LIMITS EXCEEDED: {printable(', '.join(outcome.exceeded[:_LISTED]))}{more}" if outcome.exceeded else ""
    samples = f"{count(outcome.samples, 'sample')}, {outcome.duration:.6g} s"
    return f"{name}: {before}{samples}{limits} -> {printable(outcome.table)}"


def batch_text(batch: Batch, page: Page = PLAIN) -> str:
    """The summary: how many there are of each kind, and the worst of each joint."""
    kinds: tuple[Status, ...] = ("computed", "finished before", "failed")
    found = [f"{amount} {kind}" for kind in kinds if (amount := batch.count(kind))]
    head = f"{printable(batch.robot)}: {count(len(batch.outcomes), 'file')}, {', '.join(found)}\n"
    worst = batch.worst
    if not worst:
        return head
    limits = sum(not outcome.within_limits for outcome in batch.outcomes)
    over = f"LIMITS EXCEEDED in {count(limits, 'file')}" if limits else "No limit is exceeded."
    return f"{head}\nThe worst of each joint\n{page.table(_table(worst))}\n{over}\n"


def _table(worst: tuple[Worst, ...]) -> Content:
    rows = []
    for joint in worst:
        speed = "m/s" if joint.unit == "N" else "rad/s"
        row = [
            joint.name,
            f"{number(joint.peak)} {joint.unit}",
            f"{joint.peak_time:.6g}",
            joint.peak_in,
            use(joint.peak, joint.effort_limit),
            number(joint.rms),
            joint.rms_in,
            f"{number(joint.max_speed)} {speed}",
            joint.max_speed_in,
            use(joint.max_speed, joint.velocity_limit),
        ]
        rows.append(row if joint.level is None else [*row, joint.level, joint.level_in])
    head = ["joint", "peak", "at [s]", "in", "of effort limit", "RMS", "in", "max speed", "in", "of velocity limit"]
    return (head if worst[0].level is None else [*head, "verdict", "in"]), rows
