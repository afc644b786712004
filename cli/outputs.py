"""What a command writes is never what it reads, nor a file that robodyn has not written."""

from __future__ import annotations

import os
import re
import stat
from collections.abc import Iterable, Iterator
from contextlib import suppress

import click

from robodyn.cli.options import Output, Parsed, kept_value
from robodyn.errors import InputError
from robodyn.support.input_file import open_input

_OURS = {
    "a table": rb'\A(\xef\xbb\xbf)?"?time\b|\APAR1|\APK',
    "an archive": rb"\APK",
    "a report": rb"robodyn [0-9][^\n]*Python [0-9]",
    "a result of a batch": rb'"digest": "[0-9a-f]{40}"',
    "a calibrated description": rb"identified by robodyn",
    "a scene that was identified": rb"\A# identified by robodyn",
    "a covariance": rb'\A\{"parameters"',
    "source code": rb"written by robodyn",
    "a baseline": rb'"robodyn_baseline"',
    "a picture": rb"\A\x89PNG|\A%PDF|\A<\?xml[^<]*<!DOCTYPE svg",
    "a drawing": rb"\A<svg ",
}
"""What the beginning or the end of a file has that robodyn writes, by its kind."""
_READ = 1 << 16
"""Bytes of the beginning and of the end that are looked at."""


def check_outputs(ctx: click.Context, writes: Iterable[str] = ()) -> None:
    """Raise if a file that the command is to write is one that it reads or another that it writes, or is not ours.

    Args:
        writes: names of parameters whose files are written in this call, though others only read them.

    Raises:
        InputError: so it is, by whatever names: links, hard links, other spellings.
    """
    writes = {*writes}
    read: list[str] = []
    written: list[tuple[str, click.Parameter]] = []
    for param in ctx.command.params:
        name = param.name or ""
        value = ctx.params[name] if name in ctx.params else kept_value(name, None)
        if isinstance(param.type, Output) or name in writes:
            written += [(place, param) for place in _names(value)]
        elif isinstance(param.type, Parsed) and param.type.name in ("file", "dir"):
            read += _names(value)
    for k, (place, param) in enumerate(written):
        remedy = f"give {param.opts[0]} another name"
        if any(same_file(place, other) for other in read):
            raise InputError("the output would overwrite an input", remedy=remedy, file=place)
        if any(same_file(place, other) for other, _ in written[:k]):
            raise InputError("two outputs have this name", remedy="give each its own", file=place)
        refuse_foreign(place, param.type.kind if isinstance(param.type, Output) else "a baseline", remedy)


def inputs_of(ctx: click.Context) -> list[str]:
    """Return the files that a call names to be read."""
    found: list[str] = []
    for param in ctx.command.params:
        if isinstance(param.type, Parsed) and param.type.name == "file" and not isinstance(param.type, Output):
            name = param.name or ""
            found += _names(ctx.params[name] if name in ctx.params else kept_value(name, None))
    return found


def _names(value: object) -> Iterator[str]:
    """Yield the names of files that an option's value has: itself, or what it was read from."""
    for each in value if isinstance(value, tuple) else (value,):
        if (name := getattr(each, "file", each)) and isinstance(name, str):
            yield name


def same_file(one: str, other: str) -> bool:
    """Return whether two names are of one regular file, which may not be there yet."""
    with suppress(OSError, ValueError):
        status = os.stat(one)
        return stat.S_ISREG(status.st_mode) and os.path.samestat(status, os.stat(other))
    with suppress(OSError, ValueError):
        return not os.path.exists(one) and os.path.realpath(one) == os.path.realpath(other)
    return False


def refuse_foreign(path: str, kind: str, remedy: str) -> None:
    """Raise if there is a file, neither empty nor such as robodyn writes.

    Args:
        kind: of file that is to be written, one of those that are known here.
    """
    try:
        with open_input(path) as stream:
            head = stream.read(_READ)
            size = stream.seek(0, os.SEEK_END)
            stream.seek(max(len(head), size - _READ))
            tail = stream.read(_READ)
    except (OSError, ValueError):  # nothing, or no file: a pipe, a folder; writing tells what is wrong
        return
    pattern = re.compile(_OURS[kind])
    if head and not (pattern.search(head) or (not _OURS[kind].startswith(rb"\A") and pattern.search(tail))):
        raise InputError(
            f"is there already, and is no {kind.partition(' ')[2]} that robodyn has written",
            remedy=f"delete it, or {remedy}",
            file=path,
        )
