"""The loops of a simulated closed chain as text."""

from __future__ import annotations

import numpy as np

from robodyn.report.sizes import sizes
from robodyn.report.table import Page, drift_text, number, printable
from robodyn.simulation.loop_figures import LoopFigures


def loops_text(loops: LoopFigures, page: Page, reach: float) -> str:
    """How many equations there are, what each loop carries at most, and how far it comes apart.

    Args:
        reach: of the robot [m].
    """
    force, moment = (np.sqrt(np.square(loops.wrenches[:, :, part]).sum(axis=2)) for part in (slice(3), slice(3, 6)))
    size = sizes(force.ravel().tolist(), moment.ravel().tolist(), reach)
    apart = max(reach, 1.0)
    rows = [
        (
            printable(name),
            number(f, size["N"]),
            number(m, size["N m"]),
            drift_text(gap, apart),
            drift_text(slip, apart),
        )
        for name, f, m, gap, slip in zip(
            loops.names, force.max(axis=0), moment.max(axis=0), loops.gap, loops.slip, strict=True
        )
    ]
    head = ("loop", "largest force [N]", "largest moment [N m]", "|phi| [m, rad]", "|phi'| [m/s, rad/s]")
    return f"{_counted(loops)}\n{page.table((head, rows))}"


def _counted(loops: LoopFigures) -> str:
    kept = loops.equations - len(loops.dropped)
    count = "1 equation" if loops.equations == 1 else f"{loops.equations} equations"
    lines = [f"loops: {count}, {loops.rank} of them independent at the start"]
    lines[0] += f"; degrees of freedom left: {loops.freedoms}; {loops.stabilised}"
    if loops.dropped:
        names = ", ".join(map(printable, loops.dropped[:NAMED]))
        more = len(loops.dropped) - NAMED
        lines.append(f"left out, for the others imply them: {names}{f' and {more} more' if more > 0 else ''}")
    if loops.rank < kept:
        lines.append(f"{kept - loops.rank} depend on the others there: how they share their reactions is arbitrary")
    return "".join(f"{line}\n" for line in lines)


NAMED = 8
"""Equations that are named; of more, the number."""
