"""What commands answer: text or JSON, and reports in files, `--report FILE.html` and `--report FILE.md`."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from importlib import import_module
from threading import Thread
from typing import TYPE_CHECKING, Any

from robodyn.cli.options import Call, report_form
from robodyn.cli.screen import page, show
from robodyn.report.document import Document, Section, text

if TYPE_CHECKING:
    from robodyn.support.floats import Floats

_LIBRARIES = ("robodyn", "numpy", "scipy", "llvmlite", "matplotlib", "yourdfpy", "trimesh")


def get_ready(call: Call) -> None:
    """Import what draws figures while what they show is still being computed."""

    def load() -> None:
        with suppress(ImportError):
            for name in ("matplotlib.figure", "matplotlib.backends.backend_svg", "jinja2"):
                import_module(name)

    if call.pictured:
        Thread(target=load, daemon=True).start()


def answer(
    call: Call,
    sections: Iterable[Section],
    document: Callable[[bool], Document] | None = None,
    written: str = "",
    form: str = "",
    last: Section = (),
    **others: Callable[[], str],
) -> None:
    """Show a result in the form that is asked for, after its report is written if there shall be one.

    Args:
        document: the report, with figures or without.
        written: lines on other files, below the text; last: what stands below these.
        form: in place of --format.
        others: forms that are not text.
    """
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

    used = [f"{name} {version_of(name)}" for name in _LIBRARIES if name in sys.modules]
    machine = f"Python {platform.python_version()}", f"{platform.system()} on {platform.machine()}"
    whole = replace(document, command=shlex.join(["robodyn", *sys.argv[1:]]), versions=(*used, *machine))
    if report_form(path) == "html":
        from robodyn.report.renderers.html import html

        content = html(whole)
    else:
        from robodyn.report.renderers.markdown import markdown

        content = markdown(whole)
    data = content.encode("utf-8", errors="backslashreplace")
    write_whole(path, data, remedy="name another file")
    return f"\nwritten: {path}, {max(1, len(data) // 1000)} kB\n"
