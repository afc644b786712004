"""Editing the files of `robodyn check --fix`, or showing the edits."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress

import click

from robodyn.checks.project import Task, fix_task
from robodyn.cli.progress import robots_done
from robodyn.cli.screen import show
from robodyn.errors import InputError
from robodyn.report.fixes_check import check_diff, fix_lines
from robodyn.support.files import write_whole


def fix_files(tasks: Sequence[Task], unsafe: bool, diff: bool) -> bool:
    """Edit the files, or show how they would be; the return value is whether there is such a difference to show."""
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
