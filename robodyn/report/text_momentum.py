"""Momentum and energy along a motion, as rows of text."""

from __future__ import annotations

from robodyn.momentum import GROUND
from robodyn.report.table import Content, number, printable
from robodyn.result import MomentumReport

_UNITS = {"com": "m", "p": "kg m/s", "L": "kg m^2/s", "T": "J", "V": "J", "power": "W"}


def momentum_table(report: MomentumReport) -> tuple[str, Content]:
    """A title that says about what and in which frame, and for each quantity its least and its greatest."""
    owner = "the ground" if report.frame == GROUND else printable(report.frame)
    about = {"origin": "the origin", "com": "the mass centre"}.get(str(report.about)) or "({:g}, {:g}, {:g}) m".format(
        *report.about
    )
    scales: dict[str, float] = {}
    for row in report.ranges:
        kind = row.name.partition("_")[0]
        scales[kind] = max(scales.get(kind, 0.0), abs(row.least), abs(row.greatest))
    rows = []
    for row in report.ranges:
        kind = row.name.partition("_")[0]
        least, greatest = (number(x, scales[kind]) for x in (row.least, row.greatest))
        rows.append(
            (f"{row.name} [{_UNITS[kind]}]", least, f"{row.least_time:.6g}", greatest, f"{row.greatest_time:.6g}")
        )
    title = f"Momentum and energy in the frame of {owner}, L about {about}; power is tau . qd"
    return title, (("", "least", "at [s]", "greatest", "at [s]"), rows)
