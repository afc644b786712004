"""`robodyn check`: what is wrong with robot descriptions."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import click

from robodyn.checks.asked import Asked
from robodyn.checks.baseline import compared, write_baseline
from robodyn.checks.project import check_tasks, tasks_for
from robodyn.checks.rule import Severity
from robodyn.checks.run import Checked, Options
from robodyn.cli.check_fix import fix_files
from robodyn.cli.check_options import OPTIONS, check_flags
from robodyn.cli.check_report import report
from robodyn.cli.failures import complain
from robodyn.cli.files import check_names, source_of
from robodyn.cli.options import PATH, lookup
from robodyn.cli.progress import robots_done
from robodyn.cli.reading_options import READING, reading
from robodyn.cli.reports import REPORT, write_report
from robodyn.cli.screen import show


@click.command("check", short_help="Find what is wrong with descriptions, for people and CI.")
@click.argument("urdfs", nargs=-1, type=PATH, required=True, metavar="URDF...")
@OPTIONS
@READING
@REPORT
def command(urdfs: tuple[str, ...], **flags: Any) -> int:
    """Find what is wrong with robot descriptions, down to the attribute.
    A file named - is standard input; a folder means every .urdf below it; a .xacro file is expanded first.
    The exit status is 1 if an error is found, 2 if a file cannot be read, which stops no other.
    `robodyn rule CODE` explains a finding.

    \b
    Examples:
      robodyn check robots/ --ignore RD110
      robodyn check robots/puma.urdf --report findings.html
    """
    check_names([*urdfs], flags["report"])
    check_flags(flags, urdfs)
    asked = Asked(flags["targets"] or (), flags["against"], flags["trajectory"], reading())
    how = lookup()
    given = Options(
        flags["select"] or (),
        flags["ignore"] or (),
        package_path=how["package_paths"],
        xacro_args=tuple(how["xacro_args"].items()),
        asked=asked,
    )
    sources = [source_of(urdf) for urdf in urdfs]
    tasks = tasks_for(sources, given, flags["config"])
    shown = (flags["fix"] or flags["diff"]) and fix_files(tasks, flags["unsafe_fixes"], flags["diff"])
    with robots_done(len(tasks)) as done:
        checked = check_tasks(tasks, done)
    for line in dict.fromkeys(str(each.error) for each in checked.unread):
        complain(line)
    if checked.unread and len(tasks) == 1:
        return 2
    if shown:
        return 2 if checked.unread else 1
    if flags["write_baseline"]:
        count = write_baseline(checked.findings, flags["baseline"])
        click.echo(f"written: {flags['baseline']}, {count} findings", err=True)
        return 2 if checked.unread else 0
    if flags["baseline"]:
        checked = _new(checked, flags["baseline"])
    if not flags["diff"]:
        show(report(checked, tasks, flags["form"], flags["strict"], flags["statistics"]))
    if flags["report"]:
        from robodyn.report.page_check import check_page

        click.echo(write_report(flags["report"], check_page(checked)).strip(), err=True)
    fatal = (Severity.E, Severity.W) if flags["strict"] else (Severity.E,)
    return 2 if checked.unread else int(any(checked.count(severity) for severity in fatal))


def _new(checked: Checked, baseline: str) -> Checked:
    """What the baseline does not have."""
    found = compared(checked.findings, baseline)
    gone = f"; {found.gone} of it no longer found, --write-baseline drops them" if found.gone else ""
    click.echo(f"{baseline}: {found.known} findings passed over{gone}", err=True)
    return replace(checked, findings=found.new)
