"""`robodyn check`: what is wrong with robot descriptions."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import click

from robodyn.checks import groups as baselines
from robodyn.checks.catalogue import RULES, WORDS
from robodyn.checks.check import Options, Task, check_tasks, fix_task, tasks_for
from robodyn.checks.context import Asked
from robodyn.checks.rule import Severity
from robodyn.cli.files import STANDARD_INPUT, check_names, robot_source
from robodyn.cli.options import (
    DESCRIPTION,
    FOLDER_THERE,
    PATH,
    READING,
    REPORT,
    Call,
    Output,
    Parsed,
    option,
    refuse_where,
    takes,
)
from robodyn.cli.progress import robots_done
from robodyn.cli.screen import complain, page, show, write_report
from robodyn.errors import InputError, RobodynError
from robodyn.report.check import (
    check_diff,
    check_json,
    check_page,
    check_sections,
    fix_lines,
    short_sections,
    statistics_sections,
)
from robodyn.report.document import text
from robodyn.report.renderers.findings import check_github, check_junit, check_sarif
from robodyn.report.table import PLAIN, Page
from robodyn.robot.urdf.document import read
from robodyn.robot.urdf.sources import is_xacro
from robodyn.support.files import write_whole
from robodyn.support.wording import count

if TYPE_CHECKING:
    from robodyn.robot.model import Model


def _codes(text: str) -> tuple[str, ...]:
    codes = [code.strip() for code in text.split(",")]
    return tuple(code.upper() if code[:2].upper() == "RD" or code.upper() in WORDS else code for code in codes)


CODES = Parsed("codes", _codes)
PROGRAMS = Parsed("names", lambda text: tuple(code.strip().lower() for code in text.split(",")))
_DRAWN = 4
"""Robots that a page shows at most."""
FORMATS = ("text", "short", "json", "sarif", "junit", "github")


class Also(NamedTuple):
    """A file that findings are written to as well."""

    form: str
    file: str


def _also(text: str) -> Also:
    form, equals, file = text.partition("=")
    if form not in FORMATS or not equals or not file:
        raise ValueError(f"{text!r} is not FORMAT=FILE; formats are {', '.join(FORMATS)}")
    return Also(form, file)


ALSO = Output("a list of findings", _also)


def _fix(tasks: Sequence[Task], unsafe: bool, diff: bool) -> bool:
    """Edit the files, or show how they would be; return whether there is such a difference."""
    files = []
    with robots_done(len(tasks), "fixing") as done:
        for task in tasks:
            with suppress(InputError):  # the check says why
                files.append(fix_task(task, unsafe))
            done()
    changed = [one for one in files if one.after != one.before]
    for one in changed:
        if diff:
            show(check_diff(one))
        else:
            write_whole(one.file, one.after)
    for line in fix_lines(files, "would fix" if diff else "fixed"):
        click.echo(line, err=True)
    return diff and bool(changed)


def _models(tasks: Sequence[Task], call: Call) -> dict[str, Model]:
    """Return the models of the files that can be loaded."""
    from robodyn.robot.load import load

    models = {}
    for task in tasks:
        with suppress(RobodynError):
            models[task.name] = load(task.source, **call.lookup)
    return models


@click.command("check", short_help="Find what is wrong with descriptions, for people and CI.")
@click.argument("urdfs", nargs=-1, type=PATH, required=True, metavar="URDF...")
@takes(
    option("--select CODES", "Rules to run: RD207,RD5; ALL; default DEFAULT.", CODES),
    option("--ignore CODES", "Rules not to run.", CODES),
    option("--strict", "Exit with 1 on warnings, too."),
    option("--format", "Default text.", FORMATS, "form", default="text"),
    option(
        "--also FORMAT=FILE*",
        "Write it in another format, too: sarif=a.sarif; repeatable.",
        Output("a list of findings", _also),
    ),
    option("--statistics", "Count findings by rule in place of listing them."),
    DESCRIPTION,
    option("--target NAMES", "What mujoco, drake, gz, kdl, isaac do.", PROGRAMS, "targets"),
    option("--against REF", "Compare the dynamics with the file's version at a git revision."),
    option("--trajectory FILE", "Hold the limits against the loads along a motion.", PATH),
    option("--config FILE", "Settings, in place of robodyn.toml or pyproject.toml above a file.", PATH),
    option("--baseline FILE", "Pass over the findings that this file has.", PATH),
    option("--write-baseline", "Write today's findings to the file of --baseline."),
    option("--fix", "Edit the files where an edit is right and leaves the dynamics alone."),
    option("--unsafe-fixes", "With --fix or --diff: edits that change the dynamics, too."),
    option("--expanded-to DIR", "Where xacro files are expanded to, which meshes are relative to.", FOLDER_THERE),
    option("--including", "Of a xacro file that others include, check those."),
    option("--diff", "Print what --fix would change, and change nothing."),
    READING,
    REPORT,
)
def command(
    call: Call,
    urdfs: tuple[str, ...],
    select: tuple[str, ...] | None,
    ignore: tuple[str, ...] | None,
    strict: bool,
    also: tuple[Also, ...],
    statistics: bool,
    targets: tuple[str, ...] | None,
    against: str | None,
    trajectory: str | None,
    config: str | None,
    baseline: str | None,
    write_baseline: bool,
    fix: bool,
    unsafe_fixes: bool,
    diff: bool,
    expanded_to: str | None,
    including: bool,
) -> int:
    """Find what is wrong with robot descriptions, down to the attribute.
    A file named - is standard input; a folder means every .urdf below it and every .xacro that no other includes; a
    .xacro file is expanded first; a mesh or an SRDF means the descriptions of its package that name it, and a .xacro
    file of macros those that include it.
    Errors are shown, and what is likely a defect; `--select ALL` shows all.
    The exit status is 1 if an error is found, 2 if a file cannot be read, which stops no other.
    `robodyn rule CODE` explains a finding.

    \b
    Examples:
      robodyn check robots/ --ignore RD110
      robodyn check robots/puma.urdf --report findings.html
    """
    check_names(*["baseline"] * write_baseline)
    stdin, plain = STANDARD_INPUT in urdfs, not any(map(is_xacro, urdfs))
    refuse_where(
        (plain and call.xacro_args, "--xacro-arg goes with a file that is xacro (xacro files end in .xacro)"),
        (call.trust_xacro and not all(map(os.path.isfile, urdfs)), "--trust-xacro goes with the names of files"),
        (write_baseline and not baseline, "--write-baseline needs --baseline FILE"),
        (unsafe_fixes and not (fix or diff), "--unsafe-fixes needs --fix or --diff"),
        (fix and stdin and not diff, "--fix cannot edit standard input; --diff shows the edit"),
        (statistics and call.form not in ("text", "short"), "--statistics is text; leave --format out"),
    )
    chosen = Options(
        select or (),
        ignore or (),
        package_path=call.package_paths,
        xacro_args=tuple(dict(call.xacro_args).items()),
        trust_xacro=call.trust_xacro,
        asked=Asked(targets or (), against, trajectory, call.reading),
        expanded_to=expanded_to or "",
        including=including,
    )
    tasks = tasks_for([robot_source(urdf, expected=False) for urdf in urdfs], chosen, config)
    shown = (fix or diff) and _fix(tasks, unsafe_fixes, diff)
    with robots_done(len(tasks)) as done:
        checked = check_tasks(tasks, done)
    for line in dict.fromkeys(str(each.error) for each in checked.unread):
        complain(line)
    if checked.unread and len(tasks) == 1 and call.form not in ("sarif", "junit", "github"):  # which show that, too
        return 2
    if shown:
        return 2 if checked.unread else 1
    if write_baseline and baseline:
        places = baselines.write_baseline(checked.findings, baseline)
        click.echo(f"written: {baseline}, {count(places, 'place')}", err=True)
        return 2 if checked.unread else 0
    if baseline:
        new, known, gone = baselines.compared(checked.findings, baseline)
        more = f"; {gone} of it no longer found, --write-baseline drops them" if gone else ""
        click.echo(f"{baseline}: {count(known, 'place')} passed over{more}", err=True)
        checked = replace(checked, findings=new)
    if not diff:
        given = {task.name: task.source for task in tasks}
        others: dict[str, Callable[[], str]] = {
            "json": lambda: check_json(checked),
            "sarif": lambda: check_sarif(
                checked.findings, RULES, lambda name: read(given.get(name, name), name), checked.unread
            ),
            "junit": lambda: check_junit(checked, strict),
            "github": lambda: check_github(checked.findings, checked.unread),
        }

        def written(form: str, onto: Page = PLAIN) -> str:
            listed = statistics_sections if statistics else short_sections if form == "short" else check_sections
            return others[form]() if form in others else text(listed(checked), onto)

        show(written(call.form, page()))
        for form, file in also:
            write_whole(file, written(form).encode("utf-8", "backslashreplace"))
    if call.report is not None:
        models = _models(tasks[:_DRAWN], call) if call.pictured else {}
        click.echo(write_report(call.report, check_page(checked, models)).strip(), err=True)
    fatal = (Severity.ERROR, Severity.WARNING) if strict else (Severity.ERROR,)
    return 2 if checked.unread else int(any(checked.count(severity) for severity in fatal))
