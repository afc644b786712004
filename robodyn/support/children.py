"""Starting other processes, the one place that does: none finds its modules or its program in the current folder."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Mapping

_NEEDED = ("LD_LIBRARY_PATH", "DYLD_LIBRARY_PATH", "DYLD_FALLBACK_LIBRARY_PATH", "SYSTEMROOT", "PYTHONHOME")
"""Variables without which the interpreter or the system's libraries may not be found."""

_START = """
import json, os, site, sys
from importlib import import_module, util
function, paths, user, here, first = json.loads(sys.argv.pop(1))
for folder in user:
    site.addsitedir(folder)
own = frozenset(sys.path)
sys.path[:] = [path for path in paths if path in own or (os.path.isabs(path) and os.path.realpath(path) != here)]
spec = util.spec_from_file_location("robodyn", first, submodule_search_locations=[os.path.dirname(first)])
sys.modules["robodyn"] = util.module_from_spec(spec)
spec.loader.exec_module(sys.modules["robodyn"])
module, name = function.split(":")
getattr(import_module(module), name)(*sys.argv[1:])
"""
"""What a process begins with. Its path is its parent's without the current folder, and its robodyn is its parent's,
wherever that is."""


def start_python(
    function: str,
    *arguments: str,
    environment: Mapping[str, str] | None = None,
    folder: str | None = None,
    stderr: int | None = None,
) -> subprocess.Popen[bytes]:
    """Return a process of Python that calls a function, with pipes to its standard input and from its standard output.

    It is isolated (`-I`: neither PYTHON... variables nor the current folder count), and imports from where this one
    does, see `_START`. Its variables and its folder are those of this process by default.

    Args:
        function: `module:name`; arguments: for it.
    """
    import robodyn

    here, first = os.path.realpath(os.curdir), os.path.abspath(robodyn.__file__)
    site = sys.modules.get("site")  # whose folder of packages of this user has .pth files of editable installations
    user = [site.getusersitepackages()] if site is not None and site.ENABLE_USER_SITE else []
    start = json.dumps([function, sys.path, user, here, first])
    variables = dict(os.environ)
    if environment is not None:
        variables = {name: os.environ[name] for name in _NEEDED if name in os.environ} | {**environment}
    flags = ["-I", *["-B"] * bool(sys.dont_write_bytecode), *["-X", "utf8"] * bool(sys.flags.utf8_mode)]
    return subprocess.Popen(
        [sys.executable, *flags, "-c", _START, start, *arguments],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=stderr,
        cwd=folder,
        env={**variables, "PYTHONSAFEPATH": "1"},  # for what libraries start, from Python 3.11 on
    )


def run_program(name: str, *arguments: str, folder: str, **variables: str) -> subprocess.CompletedProcess[bytes]:
    """Return what came of a program on the search path, run in a folder without input, with variables added.

    Raises:
        FileNotFoundError: there is none. The current folder is not looked in, as Windows would.
    """
    folders = filter(os.path.isabs, os.environ.get("PATH", os.defpath).split(os.pathsep))
    program = next(filter(None, (shutil.which(os.path.join(each, name)) for each in folders)), None)
    if program is None:
        raise FileNotFoundError(f"there is no {name} on PATH")
    environment = {**os.environ, **variables}
    return subprocess.run(
        [program, *arguments], stdin=subprocess.DEVNULL, capture_output=True, check=False, cwd=folder, env=environment
    )
