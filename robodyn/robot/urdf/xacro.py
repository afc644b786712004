"""Expanding xacro files, by way of xacro where that is installed, in a process of its own; see `xacro_child`."""

from __future__ import annotations

import json
import os
import signal
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple
from xml.parsers import expat

from robodyn.errors import InputError, NoRobotError
from robodyn.robot.urdf.sources import VARIABLES
from robodyn.support.extras import need
from robodyn.support.input_file import read_input
from robodyn.support.wording import alternatives, shown

PATIENCE = 20.0
"""Seconds that an expansion may take; the largest robots take a few."""
_TRUST = "--trust-xacro lifts this, and lets the file do whatever Python can"


class Expansion(NamedTuple):
    """The URDF that a xacro file stands for.

    Attributes:
        text: what the command `xacro FILE` prints.
        files: those that its elements were written in.
        places: of each element of the text the number of that file and the byte where it begins there, or where the
            element around it does.
    """

    text: bytes
    files: tuple[str, ...]
    places: tuple[tuple[int, int], ...]


def expanded(
    path: str, package_paths: Sequence[str] = (), args: Mapping[str, str] | None = None, trusted: bool = False
) -> Expansion:
    """Return the URDF that a xacro file stands for, with these arguments, and where each element of it was written.

    Packages are looked for as those of meshes are. Unless it is trusted, a file may compute what `xacro_expressions`
    lists, read what `Reach` allows, and know the environment's variables about packages; else whatever Python
    can, within time and memory.

    Raises:
        InputError: xacro is not installed, the file cannot be read or expanded, asks for what it may not, with the
            line, or has no such argument.
    """
    if not os.path.isfile(path):
        raise InputError("there is no such file", remedy="check the name", file=path)
    need("xacro files", "xacrodoc", otherwise=f"expand it first: xacro {path} > robot.urdf", file=path)
    given = dict(args or {})
    found = _asked(path, package_paths, given, trusted)
    if "problem" in found:
        if only_defines(path):
            raise no_robot(path)
        what, line = found["problem"], found.get("line")
        file = _as_named(path, found["file"]) if found.get("file") else path
        if not found["refused"]:
            remedy = f"try: xacro {path}"
            if "the package '" in what:
                remedy = "--package-path DIR names the package or the folder it is in"
            elif "argument" in what:
                remedy = "--xacro-arg NAME:=VALUE gives it a value"
            raise InputError(f"xacro cannot expand it: {what}", remedy=remedy, file=file, line=line)
        remedy = "; ".join(filter(None, (found["remedy"], _TRUST)))
        raise InputError(f"{what} is refused", remedy=remedy, file=file, line=line)
    for name in given:
        if name not in found["arguments"]:
            remedy = alternatives(name, found["arguments"], "arguments")
            raise InputError(f"the file has no argument {shown(name)}", remedy=remedy, file=path)
    files = tuple(_as_named(path, file) for file in found["files"])
    return Expansion(found["text"].encode(), files, tuple((k, start) for k, start in found["places"]))


def _as_named(path: str, file: str) -> str:
    """Return the name of an included file: relative, as that of the file which includes it, if it is below here."""
    relative = os.path.relpath(file)
    return file if os.path.isabs(path) or relative.startswith(os.pardir) else relative


def _asked(path: str, package_paths: Sequence[str], args: Mapping[str, str], trusted: bool) -> dict[str, Any]:
    import subprocess

    from robodyn.support.children import start_python

    question = {"path": path, "package_paths": list(package_paths), "args": args, "trusted": trusted}
    environment = {name: os.environ[name] for name in (*VARIABLES, "PWD") if name in os.environ}
    child = start_python(
        "robodyn.robot.urdf.xacro_child:serve", environment=None if trusted else environment, stderr=subprocess.DEVNULL
    )
    asking, child.stdin = child.stdin, None  # open for as long as this process lives, which is how the child knows
    assert asking is not None
    late = {"problem": f"it is not done after {PATIENCE:g} s", "refused": False}
    try:
        asking.write(json.dumps({**question, "seconds": PATIENCE}).encode() + b"\n")
        asking.flush()
        said, _ = child.communicate(timeout=PATIENCE)
    except subprocess.TimeoutExpired:
        return late
    except BrokenPipeError:
        said = b""
    finally:
        child.kill()
        child.communicate()
        asking.close()
    if child.returncode == -getattr(signal, "SIGXCPU", 0) < 0:
        return late
    if child.returncode or not said:
        return {"problem": f"its process ended with status {child.returncode}", "refused": False}
    found: dict[str, Any] = json.loads(said)
    return found


def no_robot(path: str) -> NoRobotError:
    """Return what to raise of a file that describes no robot."""
    return NoRobotError("it defines parts and describes no robot", remedy="name the file that uses them", file=path)


def only_defines(path: str) -> bool:
    """Return whether a file has a macro, and beside definitions nothing else."""
    parser, names, depth = expat.ParserCreate(), set[str](), 0

    def start(name: str, _: Any) -> None:
        nonlocal depth
        if depth == 1:
            names.add(name)
        depth += 1

    def end(_: str) -> None:
        nonlocal depth
        depth -= 1

    def entity(*_: Any) -> None:
        raise ValueError("entities may be without end")

    parser.StartElementHandler, parser.EndElementHandler, parser.EntityDeclHandler = start, end, entity
    try:
        parser.Parse(read_input(path, most=1 << 24), True)
    except (OSError, ValueError, expat.ExpatError):  # whatever is wrong with it is said by xacro
        return False
    return "xacro:macro" in names and names <= {"xacro:macro", "xacro:property", "xacro:arg", "xacro:include"}
