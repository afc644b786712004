"""The one place where input files are opened: regular files, and what the user gives as standard input.

A robot's folder may come from anybody, and links in it may lead to a pipe that never ends, or to a device. So a name
that was found is opened only if it is that of a regular file; one that the user typed may besides be that of a
descriptor of this process, as `<(zcat log.csv.gz)` of shells is. A few kilobytes can ask for gigabytes or hours: a
reader compares what it finds with the table `InputLimits` before it makes room for it, and refuses by `beyond`.
"""

from __future__ import annotations

import errno
import os
import re
import stat
import sys
from collections.abc import Iterator
from dataclasses import dataclass, fields
from functools import cache
from io import BufferedReader
from typing import Any, BinaryIO, TypeVar

from robodyn.errors import InputError

VARIABLE = "ROBODYN_LIMITS"
"""`ROBODYN_LIMITS=csv_columns=5000,file_bytes=4e9` changes limits by name; child processes inherit it."""

_Error = TypeVar("_Error", bound=InputError)
LFS_POINTER = b"version https://git-lfs.github.com/spec/"
"""How a file begins that stands for another, which Git LFS has not fetched."""

_PART = 1 << 20
_AT_ONCE = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOCTTY", 0)
"""Opens without waiting for the other end of a pipe; this also never waits for what special files may bring."""
_DESCRIPTOR = re.compile(r"/dev/(stdin|fd/\d+)|/proc/self/fd/\d+")
_KINDS = {stat.S_IFIFO: "a pipe", stat.S_IFSOCK: "a socket", stat.S_IFCHR: "a device", stat.S_IFBLK: "a device"}


@dataclass(frozen=True)
class InputLimits:
    """Each limit, what it counts, and why a reader needs it; all are of one file."""

    file_bytes: int = 1 << 30
    """Bytes of a file that is held in memory whole."""
    stream_bytes: int = 1 << 34
    """Bytes taken from standard input or another pipe, which are copied to a temporary file."""
    nesting: int = 32
    """Depth of lists and tables within each other, in YAML and TOML: parts of a dotted key, too."""
    toml_bytes: int = 1 << 20
    """Bytes of a scene or of settings, in TOML."""
    catalogue_bytes: int = 1 << 23
    """Bytes of a catalogue of motors or gears."""
    catalogue_pairs: int = 1_000_000
    """Motors of a catalogue times gears in a ratio."""
    table_columns: int = 10_000
    """Columns of a table of any format."""
    name_characters: int = 4096
    """Characters in the name of a column."""
    csv_line_bytes: int = 1 << 20
    """Bytes in a line of a table as text, the header among them."""
    message_values: int = 2_000_000
    """Values in JSON, and in messages as text: numbers, names, lists, and the ends of lists in YAML."""
    log_values: int = 30_000_000
    """Cells of the table that messages make: stamps times columns."""
    yaml_metadata_bytes: int = 1 << 18
    """Bytes of the metadata of a bag."""
    bag_chunk_bytes: int = 1 << 26
    """Bytes that come out of one compressed chunk or message of a bag."""
    bag_expansion: int = 100
    """Times the bytes of a bag that come out of all of its chunks, beyond the first 256 MiB."""
    bag_records: int = 4_000_000
    """Records in the chunks of an MCAP file."""
    bag_steps: int = 1_000_000_000
    """Steps of SQLite over a bag that is a database."""
    mesh_nodes: int = 10_000
    """Nodes of a scene of meshes (GLB, glTF, COLLADA), shared ones as often as they are used."""
    mesh_items: int = 3_000
    """Objects of a 3MF, shared ones as often as they are used."""
    mesh_faces: int = 5_000_000
    """Triangles of all geometries of a scene of meshes, shared ones as often as they are used."""
    mesh_depth: int = 200
    """Nodes of a scene of meshes in one another."""
    mesh_unpacked: int = 1 << 27
    """Bytes of all files in an archive of meshes (3MF, ZAE), or that the accessors of a glTF stand for."""
    mesh_shape: int = 2_000_000
    """Triangles of a mesh whose symmetry and facets are asked for: each takes 800 bytes of memory."""
    mesh_nesting: int = 30_000
    """Points of shells of a mesh that are tried for lying in another shell."""
    mesh_overlaps: int = 200_000
    """Pairs of shells with overlapping boxes that are united exactly; more are measured by columns."""


def limits() -> InputLimits:
    """Return the limits that hold now; InputError where the variable of the environment names none, or no number."""
    return _asked_for(os.environ.get(VARIABLE, ""))


def beyond(name: str, what: str, kind: type[_Error], **place: Any) -> _Error:
    """Return the error of an input that is beyond a limit, a field of `InputLimits`: "20000 columns, at most ..."."""
    value = getattr(limits(), name)
    remedy = f"if it is meant, {VARIABLE}={name}=NUMBER allows more"
    return kind(f"{what}, at most {value} are read", remedy=remedy, **place)


@cache
def _asked_for(text: str) -> InputLimits:
    known = {each.name for each in fields(InputLimits)}
    found: dict[str, int] = {}
    for part in filter(None, map(str.strip, text.split(","))):
        name, _, number = map(str.strip, part.partition("="))
        try:
            found[name] = int(float(number))
        except (ValueError, OverflowError):
            raise InputError(f"{VARIABLE}: {part!r:.60} is not NAME=NUMBER", remedy="e.g. file_bytes=4e9") from None
        if name not in known or found[name] < 0:
            what = f"{VARIABLE}: {name!r:.60} is no limit" if name not in known else f"{VARIABLE}: {part!r:.60}"
            raise InputError(what, remedy=f"limits: {', '.join(sorted(known))}; each a number from 0 on")
    return InputLimits(**found)


def open_input(path: str | os.PathLike[str], typed: bool = False) -> BufferedReader:
    """Return a regular file opened for reading; nothing that this opens can block or never end.

    If the user `typed` this very name, a descriptor of this process (`/dev/stdin`, `/dev/fd/63`) may be a pipe.

    Raises:
        OSError, ValueError: it cannot be opened, or is a folder, a pipe or a device; this is not the name of a file.
    """
    stream = open(path, "rb", opener=lambda path, flags: os.open(path, flags | _AT_ONCE))  # noqa: SIM115
    try:
        mode = os.fstat(stream.fileno()).st_mode
        if not stat.S_ISREG(mode):
            if not (typed and _DESCRIPTOR.fullmatch(os.fspath(path)) and stat.S_ISFIFO(mode)):
                what = f"this is {_KINDS.get(stat.S_IFMT(mode), 'no file')}, not a file"
                raise OSError(errno.EINVAL, what)
            os.set_blocking(stream.fileno(), True)
    except OSError:
        stream.close()
        raise
    return stream


def read_input(path: str | os.PathLike[str], most: int | None = None, typed: bool = False) -> bytes:
    """Return all bytes of a file, or the first `most`; InputError where all are more than are held in memory."""
    with open_input(path, typed) as stream:
        return b"".join(_parts(stream, "file_bytes", os.fspath(path))) if most is None else stream.read(most) or b""


def read_standard_input() -> bytes:
    """Return all bytes of standard input; InputError where it is closed, or they are more than are held in memory."""
    if sys.stdin is None:
        raise InputError("standard input is closed", remedy="name a file, or pipe one in", file="<stdin>")
    return b"".join(_parts(sys.stdin.buffer, "file_bytes", "<stdin>"))


def parse_json(text: bytes, file: str) -> Any:
    """Return what JSON says; InputError if there are more values than are read, before each a comma or a bracket."""
    import json

    if sum(map(text.count, (b",", b"[", b"{"))) > limits().message_values:
        raise beyond("message_values", "too many values", InputError, file=file)
    return json.loads(text)


def vetted(path: str | os.PathLike[str]) -> str:
    """Return the name of a regular file, for a library that has to open it itself; see `open_input`."""
    open_input(path).close()
    return os.fspath(path)


def copied(stream: BinaryIO, file: str) -> BinaryIO:
    """Return a temporary file with all that comes out of a pipe; InputError beyond the limit."""
    import tempfile

    copy = tempfile.TemporaryFile()  # noqa: SIM115
    try:
        for part in _parts(stream, "stream_bytes", file):
            copy.write(part)
    except BaseException:
        copy.close()
        raise
    return copy


def _parts(stream: BinaryIO, limit: str, file: str) -> Iterator[bytes]:
    """Yield all bytes by parts, up to a limit: asked for 1 GiB at once, Python makes the room before it reads."""
    most, size = getattr(limits(), limit), 0
    while part := stream.read(_PART):
        size += len(part)
        if size > most:
            raise beyond(limit, "too many bytes", InputError, file=file)
        yield part
