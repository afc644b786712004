"""What is shown on the terminal and written as reports, and how failures end: one line and an exit status."""

from __future__ import annotations

import io
import os
import re
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any

import click

from robodyn.cli.options import TABLE_SUFFIXES, Call, report_form
from robodyn.errors import RobodynError
from robodyn.report.table import PLAIN, Page, printable
from robodyn.support.wording import alternatives

if TYPE_CHECKING:
    from robodyn.report.document import Document, Section
    from robodyn.support.floats import Floats

TRACEBACK = "ROBODYN_TRACEBACK"
"""The variable that asks for the traceback of an error above its line: any value but 0 or none."""
_PLAIN = {
    "is not a valid (float|float range)$": "is no number",
    "is not a valid (integer|integer range)$": "is no whole number",
    r"is not in the range x>=(\S+)$": r"is less than \1",
}
"""Sentences of click in words that need no mathematics."""
_OPTIONS = {".toml": "--scene", **dict.fromkeys(TABLE_SUFFIXES, "--traj")}
"""Options that take files which are given without one."""


def page() -> Page:
    """Return a page as wide as the terminal, with bold headers; a plain one without a terminal or with NO_COLOR."""
    if sys.stdout is None or not sys.stdout.isatty():
        return PLAIN
    import shutil

    plain = bool(os.environ.get("NO_COLOR")) or os.environ.get("TERM") == "dumb"
    return Page(shutil.get_terminal_size().columns, bold=not plain)


def show(text: str) -> None:
    """Write text on standard output; a reader that has gone away, as `head` does, is no error."""
    try:
        print(text, end="", flush=True)  # click.echo takes escape sequences out, of names of files too
    except BrokenPipeError:
        discard_output()


def show_file(text: str) -> None:
    """Write what a file shall hold on standard output: in UTF-8, by which it is read, unless a terminal shows it."""
    if isinstance(sys.stdout, io.TextIOWrapper) and not sys.stdout.isatty():
        sys.stdout.reconfigure(encoding="utf-8", errors="backslashreplace")
    show(text)


def discard_output() -> None:
    """Let what is still to be written on standard output, at the latest when Python ends, go nowhere."""
    with suppress(AttributeError, OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


@contextmanager
def reported(interrupted: Callable[[], bool]) -> Iterator[None]:
    """Turn what is raised inside into one line and an exit status; after an interrupt nothing else is told."""
    try:
        yield
        return
    except click.UsageError as error:
        command = error.ctx.command_path if error.ctx else "robodyn"
        complain(f"{_sentence(error)} (try: {command} --help)")
    except click.ClickException as error:
        complain(_sentence(error))
    except (RobodynError, MemoryError) as error:
        complain(str(error) or "out of memory")
    except BrokenPipeError:
        discard_output()
        sys.exit(0)
    except OSError as error:
        discard_output()
        complain(f"{error.filename or 'standard output'}: {(error.strerror or str(error)).lower()}")
    except (KeyboardInterrupt, click.Abort):
        sys.exit(130)
    except Exception as error:
        if interrupted():
            sys.exit(130)
        from traceback import extract_tb

        place = extract_tb(error.__traceback__)[-1]
        where = f"{os.path.basename(place.filename)}:{place.lineno}"
        complain(f"internal error at {where}: {type(error).__name__}: {error} (please report this line with the files)")
    sys.exit(2)


def complain(error: object) -> None:
    """Print one line of error, below its traceback where that is asked for; by `print`, which stands above a bar."""
    if sys.stderr is None:
        return
    raised = error if isinstance(error, BaseException) else sys.exc_info()[1]
    if raised is not None and os.environ.get(TRACEBACK, "0") not in ("", "0"):
        from traceback import print_exception

        print_exception(raised)
    print(f"error: {printable(' '.join(str(error).split()))}", file=sys.stderr)


def _sentence(error: click.ClickException) -> str:
    if isinstance(error, click.NoSuchOption) and error.possibilities:
        near = alternatives(error.option_name, error.possibilities, "options")
        return f"no such option {error.option_name!r}; {near}"
    text = " ".join(error.format_message().split()).rstrip(".")
    for pattern, plain in _PLAIN.items():
        text = re.sub(pattern, plain, text)
    text = text[:1].lower() + text[1:]
    extra = re.fullmatch(r"Got unexpected extra arguments? \((.*)\)", error.message)
    if extra and isinstance(error, click.UsageError) and error.ctx is not None:
        option = _OPTIONS.get(os.path.splitext(extra[1])[1].lower())
        if any(option in each.opts for each in error.ctx.command.params):
            text += f"; did you mean {option} {extra[1]}?"
    return text


def answer(
    call: Call,
    sections: Iterable[Section],
    document: Callable[[bool], Document] | None = None,
    written: str = "",
    form: str = "",
    last: Section = (),
    **others: Callable[[], str],
) -> None:
    """Show a result in the form asked for (`form` in place of --format, `others` are not text) after its report is
    written, if there shall be one; `written` are lines on other files, `last` stands below these."""
    from robodyn.report.document import text

    form = form or call.form
    if call.report is not None and document is not None:
        written += write_report(call.report, document(call.pictured))
    end = "\n" + text([last], page()) if last else ""
    show(others[form]() if form in others else text(sections, page()) + written + end)


def write_table(out: str | None, names: Sequence[str], time: Floats, columns: Any) -> str:
    """Write a motion where that is asked for; a line that says so."""
    from robodyn.trajectory.write import open_writer

    if out is None:
        return ""
    with open_writer(out, names) as writer:
        writer.write(time, columns)
    return f"\nwritten: {out}, {len(time)} rows of time and {len(names)} columns\n"


def write_report(path: str, document: Document) -> str:
    """Write a document with the command and the versions of what is loaded at its foot; a line that says so."""
    import platform
    import shlex
    from dataclasses import replace

    from robodyn.support.files import write_whole
    from robodyn.support.libraries import version_of

    libraries = ("robodyn", "numpy", "scipy", "llvmlite", "yourdfpy", "trimesh")
    used = [f"{name} {version_of(name)}" for name in libraries if name in sys.modules]
    machine = f"Python {platform.python_version()}", f"{platform.system()} on {platform.machine()}"
    whole = replace(document, command=shlex.join(["robodyn", *sys.argv[1:]]), versions=(*used, *machine))
    if report_form(path) == "html":
        from robodyn.report.renderers.pages import html

        content = html(whole)
    else:
        from robodyn.report.renderers.pages import markdown

        content = markdown(whole)
    data = content.encode("utf-8", errors="backslashreplace")
    write_whole(path, data, remedy="name another file")
    return f"\nwritten: {path}, {max(1, len(data) // 1000)} kB\n"
