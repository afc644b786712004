"""Expanding xacro files, by way of xacrodoc where that is installed.

xacro keeps what it is at in variables of its modules, and prints; so each file is expanded by a process of its own.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Mapping, Sequence
from contextlib import redirect_stdout, suppress
from io import StringIO
from typing import Any, NamedTuple

from robodyn.errors import InputError, NoRobotError
from robodyn.robot.urdf.packages import Search
from robodyn.support.extras import need
from robodyn.support.wording import alternatives, shown

PATIENCE = 60.0
"""Seconds that an expansion may take; the largest robots take a few."""
_MEMORY = 1 << 33
"""Bytes that it may take, where the system can bound them."""
_MARK = "\x1e"
"""Before the answer of a process, which libraries may print to as well."""
_PROCESS = """
import json, sys
sys.path[:], question = json.load(sys.stdin)
from robodyn.robot.urdf.xacro import answer, bound_memory
bound_memory()
print("\x1e" + json.dumps(answer(*question)))
"""


class Expansion(NamedTuple):
    """The URDF that a xacro file stands for.

    Attributes:
        text: what the command `xacro FILE` prints.
        files: those that its elements were written in.
        places: of each element of the text, in its order, the number of that file and the byte where it begins there;
            for an element that no start tag stands for, those of the element around it.
    """

    text: bytes
    files: tuple[str, ...]
    places: tuple[tuple[int, int], ...]


def expanded(path: str, package_paths: Sequence[str] = (), args: Mapping[str, str] | None = None) -> Expansion:
    """Return the URDF that a xacro file stands for, and where each element of it was written.

    The text is what the command `xacro FILE` prints, so that lines can be looked up there. Packages that it includes
    from are looked for as those of meshes are. xacro evaluates the file's expressions in Python, with a restricted set
    of names.

    Args:
        args: values of its arguments by name; defaults hold for the others.

    Raises:
        InputError: xacrodoc is not installed, the file cannot be read or expanded, or has no such argument.
    """
    if not os.path.isfile(path):
        raise InputError("there is no such file", remedy="check the name", file=path)
    need("xacro files", "xacrodoc", otherwise=f"expand it first: xacro {path} > robot.urdf", file=path)
    given = dict(args or {})
    found = _asked(path, package_paths, given)
    if "problem" in found:
        what = found["problem"]
        if found["parts"]:
            raise no_robot(path)
        raise InputError(f"xacro cannot expand it: {what}", remedy=_remedy(path, what), file=path)
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


def _asked(*question: Any) -> dict[str, Any]:
    """Return what a process of its own answers; see `answer`."""
    import subprocess

    asked = json.dumps([sys.path, question]).encode()
    call = [sys.executable, "-c", _PROCESS]
    try:
        done = subprocess.run(call, input=asked, capture_output=True, check=False, timeout=PATIENCE)
    except subprocess.TimeoutExpired:
        return {"problem": f"it is not done after {PATIENCE:g} s", "parts": False}
    if done.returncode:
        return {"problem": f"its process ended with status {done.returncode}", "parts": False}
    found: dict[str, Any] = json.loads(done.stdout.rpartition(_MARK.encode())[2])
    return found


def answer(path: str, package_paths: Sequence[str], args: Mapping[str, str]) -> dict[str, Any]:
    """Expand a file in this process, which must have no other work.

    Returns:
        `text`, `files` and `places` (see `Expansion`), and the names of its `arguments`; or a `problem`, and whether
        the file has nothing but `parts` of robots, which may need what those that include it define.
    """
    given = _Arguments(args)
    try:
        import xacro
        import xacrodoc  # its xacro needs no ROS

        from robodyn.robot.urdf.xacro_places import Places

        xacrodoc.packages._finder = _Packages(path, package_paths)
        marks = Places(xacro.parse)
        xacro.parse = marks.parse
        with redirect_stdout(StringIO()):
            document = xacro.process_file(path, mappings=given)
            places = marks.taken(document.documentElement)
            text = document.toprettyxml(indent="  ")
    except (Exception, SystemExit) as error:
        problem = " ".join(str(error).split()) or type(error).__name__
        return {"problem": problem, "parts": only_defines(path)}
    return {"text": text, "files": marks.files, "places": places, "arguments": list(given.known)}


def no_robot(path: str) -> NoRobotError:
    """Return what to raise of a file that describes no robot."""
    return NoRobotError("it defines parts and describes no robot", remedy="name the file that uses them", file=path)


_DEFINITIONS = frozenset(f"xacro:{name}" for name in ("macro", "property", "arg", "include"))


def only_defines(path: str) -> bool:
    """Return whether a file has a macro, and beside definitions nothing else."""
    from xml.dom.minidom import parse

    try:
        root: Any = parse(path).documentElement
    except Exception:  # whatever is wrong with it is said by xacro
        return False
    names = {child.tagName for child in root.childNodes if child.nodeType == child.ELEMENT_NODE}
    return "xacro:macro" in names and names <= _DEFINITIONS


def bound_memory() -> None:
    """Let this process take no more than `_MEMORY`."""
    with suppress(ImportError, OSError, ValueError):
        import resource

        _, most = resource.getrlimit(resource.RLIMIT_AS)
        least = _MEMORY if most == resource.RLIM_INFINITY else min(_MEMORY, most)
        resource.setrlimit(resource.RLIMIT_AS, (least, most))


class _Packages:
    """What xacro asks for the folder of a package."""

    def __init__(self, path: str, package_paths: Sequence[str]) -> None:
        self._search = Search(path, tuple(package_paths))

    def get_path(self, name: str) -> str:
        found = self._search.share(name)
        if found is None:
            raise LookupError(f"the package {shown(name)} is not found")
        return os.path.abspath(found)


class _Arguments(dict[str, Any]):
    """Values of arguments that note which ones a file has: xacro asks whether one has a value, or for it."""

    def __init__(self, given: Mapping[str, str]) -> None:
        super().__init__(given)
        self.known: dict[str, None] = {}

    def __contains__(self, name: object) -> bool:
        self.known[str(name)] = None
        return super().__contains__(name)

    def __getitem__(self, name: str) -> Any:
        self.known[name] = None
        return super().__getitem__(name)


def _remedy(path: str, what: str) -> str:
    if "the package '" in what:
        return "--package-path DIR names the package or the folder it is in"
    if "argument" in what:
        return "--xacro-arg NAME:=VALUE gives it a value"
    return f"try: xacro {path}"
