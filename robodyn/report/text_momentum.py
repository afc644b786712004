"""Momentum and energy along a motion, as rows of text."""

from __future__ import annotations

from robodyn.dynamics.momenta import GROUND
from robodyn.loads.result import MomentumReport
from robodyn.report.table import Content, moment, number, printable

_UNITS = {"com": "m", "p": "kg m/s", "L": "kg m^2/s", "T": "J", "V": "J", "power": "W"}


def momentum_table(report: MomentumReport) -> tuple[str, Content]:
    """A title that says about what and in which frame, and for each quantity its least and its greatest."""
    owner = "the ground" if report.frame == GROUND else printable(report.frame)
    about = {"origin": "the origin", "com": "the mass centre"}.get(str(report.about)) or "({:g}, {:g}, {:g}) m".format(
        *report.about
    )
    scales = _scales(report)
    rows = []
    for row in report.ranges:
        kind = row.name.partition("_")[0]
        name = f"{row.name} [{_UNITS[kind]}]"
        least, greatest = (
            (number(value, scales[kind]), moment(time, value, scales[kind]))
            for value, time in ((row.least, row.least_time), (row.greatest, row.greatest_time))
        )
        rows.append((name, *least, *greatest))
    title = f"Momentum and energy in the frame of {owner}, L about {about}; power is tau . qd"
    return title, (("", "least", "at [s]", "greatest", "at [s]"), rows)


def _scales(report: MomentumReport) -> dict[str, float]:
    """Return what is noise beside: L also beside p at the mass centre's distance, energies beside their largest."""
    scales: dict[str, float] = {}
    for row in report.ranges:
        kind = row.name.partition("_")[0]
        scales[kind] = max(scales.get(kind, 0.0), abs(row.least), abs(row.greatest))
    scales["L"] = max(scales["L"], scales["p"] * scales["com"])
    scales["T"] = scales["V"] = max(scales["T"], scales["V"])
    return scales
