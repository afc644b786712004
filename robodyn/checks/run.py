"""Checking files: rules in, findings out."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from warnings import warn

from robodyn.checks.catalogue import CODES
from robodyn.checks.context import DEFAULT, NOTHING, Asked, Context, Thresholds
from robodyn.checks.every_place import every_place
from robodyn.checks.groups import grouped, one_each, places
from robodyn.checks.origins import Origins
from robodyn.checks.rule import Finding, Severity
from robodyn.checks.selection import BY_CODE, rules_for, shown_of
from robodyn.checks.sources import each_in_a_process, worth_processes
from robodyn.errors import InputError, NoRobotError, RobodynWarning
from robodyn.robot.urdf.document import Document, read
from robodyn.robot.urdf.packages import EXPANDED
from robodyn.robot.urdf.sources import is_xacro
from robodyn.robot.urdf.view import Subject
from robodyn.support.wording import call_of

Source = str | os.PathLike[str] | bytes
STDIN = "<stdin>"


@dataclass(frozen=True, repr=False)
class Options:
    """What is checked, and against what.

    Attributes:
        select: codes (RD207) or beginnings of codes (RD2) of the rules to run, ALL, or DEFAULT, which is meant if it is
            empty: errors, and what is likely a defect.
        ignore: codes or beginnings of the rules not to run.
        thresholds: what the rules measure against.
        package_path: folders in which `package://` names are looked up first.
        xacro_args: names and values of the arguments of xacro files.
        trust_xacro: whether xacro files may do whatever Python can.
        asked: what is asked beyond the files themselves.
    """

    select: tuple[str, ...] = ()
    ignore: tuple[str, ...] = ()
    thresholds: Thresholds = DEFAULT
    package_path: tuple[str, ...] = ()
    xacro_args: tuple[tuple[str, str], ...] = ()
    trust_xacro: bool = False
    asked: Asked = NOTHING

    def __repr__(self) -> str:
        return call_of(self)


STANDARD = Options()
"""What holds where nothing else is asked: the default set, and the thresholds as they are."""


@dataclass(frozen=True)
class Unread:
    """A file that could not be checked, and why."""

    file: str
    error: InputError

    @property
    def why(self) -> str:
        """Without the name of the file, unless another one is at fault."""
        return self.error.sentence if self.error.file in (None, self.file) else str(self.error)


@dataclass(frozen=True)
class Checked:
    """The files that were checked, and what was found, file by file and each in the order of its text.

    Attributes:
        unread: the other files.
        hidden: findings that are not in the default set.
    """

    files: tuple[str, ...]
    findings: tuple[Finding, ...]
    unread: tuple[Unread, ...] = ()
    hidden: tuple[Finding, ...] = ()

    def count(self, severity: Severity) -> int:
        return sum(finding.severity is severity for finding in self.findings)

    @property
    def fit(self) -> bool:
        """Whether there are no errors."""
        return not self.count(Severity.ERROR)

    def of_link(self, name: str) -> Checked:
        """Return the findings about a link."""
        subject = Subject("link", name)
        every = (self.findings, self.hidden)
        findings, hidden = (grouped(one for one in places(found) if one.subject == subject) for found in every)
        return replace(self, findings=findings, hidden=hidden)


@dataclass(frozen=True)
class Found:
    """What is shown of the findings in a file, and what is not."""

    shown: tuple[Finding, ...]
    hidden: tuple[Finding, ...] = ()


@dataclass(frozen=True)
class Task:
    """A file, or the bytes of standard input, and how to check it."""

    source: str | bytes
    options: Options

    @property
    def name(self) -> str:
        """The file as findings show it."""
        return STDIN if isinstance(self.source, bytes) else self.source


def check_tasks(tasks: Sequence[Task], done: Callable[[], None] = lambda: None) -> Checked:
    """Return the findings in all of them; many files are shared out among processes, one for each core.

    One that cannot be read stops no other; one that describes no robot is skipped, with a warning.

    Args:
        tasks: the files.
        done: called after each.
    """
    shared_out = worth_processes([task.source for task in tasks])
    each = each_in_a_process(_outcome, [(task,) for task in tasks]) if shared_out else map(_outcome, tasks)
    files, found, hidden, unread = list[str](), list[Finding](), list[Finding](), list[Unread]()
    for task, outcome in zip(tasks, each, strict=True):
        if isinstance(outcome, NoRobotError):
            warn(f"{outcome}: skipped", RobodynWarning, stacklevel=2)
        elif isinstance(outcome, InputError):
            unread.append(Unread(task.name, outcome))
        else:
            files.append(task.name)
            found += outcome.shown
            hidden += outcome.hidden
        done()
    return Checked(tuple(files), tuple(found), tuple(unread), tuple(hidden))


def _outcome(task: Task) -> Found | InputError:
    try:
        return found_in(task.source, task.options)
    except InputError as error:
        return error


def found_in(source: Source, options: Options = STANDARD, name: str | None = None) -> Found:
    """Return what is found in one file or its bytes: one finding for each cause, shown or hidden as is selected."""
    return sifted(check_one(source, options, name), options)


def sifted(every: Sequence[Finding], options: Options) -> Found:
    """Return what `check_one` returns, with one finding for each cause, as what is shown and what is not."""
    single, is_shown = one_each(every, BY_CODE), shown_of(options.select, options.asked)
    return Found(
        grouped(finding for finding in single if is_shown(finding)),
        grouped(finding for finding in single if not is_shown(finding)),
    )


def check_one(source: Source, options: Options = STANDARD, name: str | None = None) -> tuple[Finding, ...]:
    """Return what the rules find in one file or its bytes: every place by itself, in the order of the text; of a xacro
    file, of its expansion."""
    if isinstance(source, bytes) or not is_xacro(source):
        return _found(read(source, name), options)
    from robodyn.robot.urdf.xacro import expanded, no_robot

    path = os.fspath(source)
    expansion = expanded(path, options.package_path, dict(options.xacro_args), options.trust_xacro)
    reading = read(expansion.text, (name or path) + EXPANDED)
    if reading.robot is not None and not any(part.tag in ("link", "joint") for part in reading.root.children):
        raise no_robot(path)
    return tuple(map(Origins(reading, expansion).located, _found(reading, options)))


def _found(reading: Document, options: Options) -> tuple[Finding, ...]:
    context = Context(reading, options.thresholds, options.package_path, options.asked, CODES)
    return every_place(context, rules_for(options.select, options.ignore))
