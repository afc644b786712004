"""What is written on standard output, and how the terminal wants it."""

from __future__ import annotations

import os
import sys
from contextlib import suppress

from robodyn.report.table import PLAIN, Page


def page() -> Page:
    """As wide as the terminal and with bold headers; plain where the output is no terminal or NO_COLOR is set."""
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


def discard_output() -> None:
    """Let what is still to be written on standard output, at the latest when Python ends, go nowhere."""
    with suppress(AttributeError, OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
