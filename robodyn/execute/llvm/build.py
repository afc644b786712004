"""Functions of machine code, made once and kept between processes."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from robodyn.execute.llvm.machine import Function, host, machine_code
from robodyn.execute.object_cache import ObjectCache, cache_folder


@cache
def _generator() -> str:
    """A digest of the modules that write the code: with any change of them, code is made anew."""
    digest = hashlib.sha256()
    for path in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def code_key(content: object) -> str:
    """What names machine code: what it computes, the machine, the compiler's version and robodyn's code generator."""
    return repr((_generator(), host(), content))


def is_kept(content: object) -> bool:
    """Whether the machine code for this content lies in the cache."""
    return ObjectCache(cache_folder()).has(code_key(content))


def built(name: str, content: object, ir: Callable[[], str], *arguments: Any) -> Function:
    """The function of this name, from the cache or compiled.

    Args:
        content: what its IR depends on, with a `repr` that tells every difference.
        ir: writes the module.
        arguments: ctypes types of the function's arguments.

    Raises:
        ImportError, OSError: llvmlite is not there.
    """
    objects = ObjectCache(cache_folder())
    key = code_key(content)
    code = objects.get(key)
    if code is None:
        code = machine_code(ir())
        objects.put(key, code)
    return Function(code, name, *arguments)
