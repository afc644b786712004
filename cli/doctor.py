"""`robodyn doctor`: whether robodyn can work here."""

from __future__ import annotations

import click

from robodyn.cli.options import FORMAT, Call, takes
from robodyn.cli.screen import answer
from robodyn.measure.doctor import doctor, healthy
from robodyn.report.accuracy import doctor_json, doctor_sections


@click.command("doctor", short_help="Tell what this machine and installation can do.")
@takes(FORMAT)
def command(call: Call) -> int:
    """Tell what robodyn finds here: libraries, processor, executors, cache; what is missing and what that costs.
    The exit status is 1 if something is broken that should be repaired.

    \b
    Example:
      robodyn doctor
    """
    lines = doctor()
    answer(call, doctor_sections(lines), json=lambda: doctor_json(lines))
    return int(not healthy(lines))
