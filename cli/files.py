"""Files that are named on the command line: `-` is standard input; what is written is never what is read, nor a file
that robodyn has not written."""

from __future__ import annotations

import os
import re
import stat
import sys
from collections.abc import Iterator
from contextlib import suppress
from typing import TYPE_CHECKING

import click

from robodyn.cli.options import ROBOT_SUFFIXES, TABLE_SUFFIXES, Call, Output, Parsed
from robodyn.errors import InputError, SceneError
from robodyn.support.input_file import open_input, read_standard_input

if TYPE_CHECKING:
    from robodyn.robot.model import Model
    from robodyn.scene.scene import Scene

STANDARD_INPUT = "-"
ROBOT, TABLE, SCENE_FILE = "a robot description", "a table", "a scene"
_KINDS = {
    ROBOT: ROBOT_SUFFIXES,
    TABLE: TABLE_SUFFIXES,
    SCENE_FILE: (".toml",),
    "a mesh": (".stl", ".obj", ".ply", ".off", ".dae", ".glb", ".gltf", ".3mf"),
}
"""What files are, by suffixes that only such files have."""


def robot_in_scene(
    call: Call, urdf: str, scene_file: str | None = None, *, loops: bool = False, contacts: bool = False
) -> tuple[Model, Scene]:
    """Return the robot of a file, and the scene of the call, with what the description says of it (`scene_of`).

    Args:
        scene_file: in place of --scene.
        loops, contacts: whether the scene may have some.
    """
    from robodyn.robot.load import load
    from robodyn.scene.fit import check_scene, known, refuse_constraints, scene_of
    from robodyn.scene.scene import DEFAULT

    files = call.scene_files if scene_file in (None, call.scene_name) else (scene_file,)
    scene_file = scene_file or call.scene_name
    for path in files:
        expect(SCENE_FILE, path)
    scene, keys = DEFAULT, frozenset[str]()
    if files:
        from robodyn.scene.read import scene_from, scene_sources, scene_tables

        if len(files) > 1 and STANDARD_INPUT in files:
            raise InputError("one of several scenes cannot be standard input", remedy="name a file", file="<stdin>")
        given = files == (STANDARD_INPUT,)
        sources = [(read_standard_input(), "<stdin>")] if given else scene_sources(*files)
        tables = scene_tables(sources)
        scene, keys = scene_from(tables, sources), frozenset(tables)
    model = load(robot_source(urdf), moving_base=scene.moving_base, **call.lookup)
    scene = scene_of(model, scene, keys).changed(call.gravity, held=call.base_held)
    check_scene(scene, model, scene_file)
    for payload in call.payloads:
        known("--payload", "link", payload.link, model.links)
    scene = scene.changed(payloads=call.payloads)
    refuse_constraints(scene, scene_file, loops=loops, contacts=contacts)
    return model, scene


def check_table(call: Call, table: str | None, scene: Scene, scene_file: str | None = None) -> None:
    """Raise if a table is given for a simulation and no scene names a column of it."""
    if table is None or scene.table_columns:
        return
    scene_file = scene_file or call.scene_name
    remedy = 'e.g. drive.elbow = { kp = 100, kd = 10, reference = "q_elbow" }'
    if scene_file is None:
        what, remedy = f"no scene says what the columns of {table} drive", f"give --scene FILE.toml, with {remedy}"
        raise InputError(what, remedy=remedy)
    raise SceneError(f"no column of {table} is named, so that it drives nothing", remedy=remedy, file=scene_file)


def robot_source(urdf: str, expected: bool = True) -> str | bytes:
    """Return what describes a robot: the name of a file, of no other kind, or what is on standard input."""
    if expected:
        expect(ROBOT, urdf)
    return read_standard_input() if urdf == STANDARD_INPUT else urdf


def check_names(*writes: str) -> None:
    """Raise if standard input is asked for twice or is not there; or if a file that the command is to write is one that
    it reads or another that it writes, by whatever name: links, hard links, other spellings; or is not ours. `writes`
    are parameters whose files are written in this call, though others only read them."""
    ctx = click.get_current_context()
    files = inputs_of(ctx)
    if files.count(STANDARD_INPUT) > 1:
        raise InputError("standard input is asked for twice", remedy="name a file for one of them", file="<stdin>")
    if STANDARD_INPUT in files and sys.stdin is None:
        raise InputError("standard input is closed", remedy="name a file, or pipe one in", file="<stdin>")
    read: list[str] = []
    written: list[tuple[str, click.Parameter]] = []
    for param in ctx.command.params:
        places = _names(ctx.params.get(param.name or ""))
        if isinstance(param.type, Output) or param.name in writes:
            written += [(place, param) for place in places]
        elif isinstance(param.type, Parsed) and param.type.name in ("file", "dir"):
            read += places
    for k, (place, param) in enumerate(written):
        remedy = f"give {param.opts[0]} another name"
        if any(same_file(place, other) for other in read):
            raise InputError("the output would overwrite an input", remedy=remedy, file=place)
        if any(same_file(place, other) for other, _ in written[:k]):
            raise InputError("two outputs have this name", remedy="give each its own", file=place)
        refuse_foreign(place, param.type.kind if isinstance(param.type, Output) else "a baseline", remedy)


def expect(kind: str, path: str) -> None:
    """Raise if a file is of another kind by its suffix: arguments are swapped, or an option is missing."""
    found = next((other for other, suffixes in _KINDS.items() if path.lower().endswith(suffixes)), kind)
    ctx = click.get_current_context(silent=True)
    if found == kind or ctx is None:
        return
    values = [ctx.params.get(each.name or "") for each in ctx.command.params if isinstance(each, click.Argument)]
    given = [word for value in values for word in (value if isinstance(value, tuple) else (value,))]
    right = [word for word in given if isinstance(word, str) and word.lower().endswith(_KINDS[kind])]
    order = " ".join([ctx.command_path, *(piece for piece in ctx.command.collect_usage_pieces(ctx) if piece[0] != "[")])
    remedy = "robodyn scene init URDF writes one" if kind == SCENE_FILE else f"the order: {order}"
    swapped = f"is it swapped with {right[0]}? " if right else ""
    raise InputError(f"this is {found}, and {kind} is expected here", remedy=swapped + remedy, file=path)


_OURS = {
    "a table": rb'\A(\xef\xbb\xbf)?"?time\b|\APAR1|\APK',
    "an archive": rb"\APK",
    "a report": rb"robodyn [0-9][^\n]*Python [0-9]",
    "a result of a batch": rb'"digest": "[0-9a-f]{40}"',
    "a calibrated description": rb"identified by robodyn",
    "a scene that was identified": rb"\A# identified by robodyn",
    "a scene of chosen motors": rb"\A# motors chosen by robodyn",
    "a covariance": rb'\A\{"parameters"',
    "source code": rb"written by robodyn",
    "a converted description": rb"converted by robodyn",
    "a converted mesh": rb"\Awritten by robodyn",
    "a baseline": rb'"robodyn_baseline"',
    "a list of findings": rb'<testsuites name="robodyn |\A\{\s*"(findings|\$schema)"|\A::\w+ file=|files? checked'
    rb"|(error|warning|note) RD\d",
    "a drawing": rb"\A<svg ",
}
"""What the beginning or the end of a file has that robodyn writes, by its kind."""
_READ = 1 << 16
"""Bytes of the beginning and of the end that are looked at."""


def inputs_of(ctx: click.Context) -> list[str]:
    """Return the files that a call names to be read."""
    kinds = ((param, param.type) for param in ctx.command.params)
    inputs = [param for param, kind in kinds if isinstance(kind, Parsed) and not isinstance(kind, Output)]
    return [name for each in inputs if each.type.name == "file" for name in _names(ctx.params.get(each.name or ""))]


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
    """Raise if there is a file, neither empty nor of this kind and such as robodyn writes."""
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
        what = f"is there already, and is no {kind.partition(' ')[2]} that robodyn has written"
        raise InputError(what, remedy=f"delete it, or {remedy}", file=path)
