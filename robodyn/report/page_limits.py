"""How much of its limits each joint uses, as a part of a report on torques."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.loads.result import Result
from robodyn.report.document import Block, Heading, HeatMap, Table
from robodyn.report.limits_words import LINES, effort_use, exceeded_table, speed_use, use


def limits_blocks(result: Result) -> Iterator[Block]:
    """A map of all joints, and a table of the limits that are exceeded where the verdict does not name them all.

    Args:
        result: with the joints that exceed limits first.
    """
    found = heat_map(result)
    if found is None:
        return
    yield Heading("Use of limits")
    if len(result.exceeded) > LINES + 1:
        yield Table("Limits that are exceeded", *exceeded_table(result.exceeded))
    yield found


def heat_map(result: Result) -> HeatMap | None:
    """Return how much of its limits of effort and velocity each joint uses; None where there are no limits."""
    rows = []
    for joint in result.joints:
        cells = (
            (use(joint.peak, joint.effort_limit), None if joint.effort_limit is None else effort_use(joint)),
            (use(joint.max_speed, joint.velocity_limit), None if joint.velocity_limit is None else speed_use(joint)),
        )
        rows.append((joint.name, cells))
    if all(share is None for _, cells in rows for _, share in cells):
        return None
    return HeatMap("How much of its limits each joint uses", ("effort", "velocity"), rows)
