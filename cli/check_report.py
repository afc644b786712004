"""The findings of `robodyn check` in the form that was asked for."""

from __future__ import annotations

from collections.abc import Sequence

import click

from robodyn.checks.catalogue import RULES
from robodyn.checks.run import Checked, Task
from robodyn.cli.screen import page
from robodyn.report.check import check_text
from robodyn.report.json.descriptions import check_json
from robodyn.report.renderers.github import check_github
from robodyn.report.renderers.junit import check_junit
from robodyn.report.renderers.sarif import check_sarif
from robodyn.report.rules import check_statistics
from robodyn.robot.urdf.packages import EXPANDED


def report(checked: Checked, tasks: Sequence[Task], form: str, strict: bool, statistics: bool) -> str:
    """Return the text for standard output; what lines of expanded files mean is said on standard error."""
    for name in checked.files:
        if name.endswith(EXPANDED):
            click.echo(f"{name}: lines are those that `xacro {name.removesuffix(EXPANDED)}` prints", err=True)
    if statistics:
        return check_statistics(checked.findings, page())
    if form == "sarif":
        readings = {task.name: task.reading for task in tasks}
        return check_sarif(checked.findings, RULES, lambda name: readings[name](), checked.unread)
    if form == "junit":
        return check_junit(checked, strict)
    if form == "github":
        return check_github(checked.findings, checked.unread)
    return check_json(checked) if form == "json" else check_text(checked)
