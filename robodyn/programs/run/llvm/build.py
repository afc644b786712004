"""Functions of machine code, made once and kept between processes."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from robodyn.programs.run.llvm.machine import Function, host, machine_code
from robodyn.support.cache import Key, ObjectCache, cache_folder, code_digest


@cache
def generator() -> str:
    """Return a digest of the modules that write and run the code: with any change of them, code is made anew."""
    return code_digest(Path(__file__).parent.parent)


def kept_objects() -> ObjectCache:
    """The cache; it keeps nothing where robodyn is installed without its sources, by which versions are told apart."""
    return ObjectCache(cache_folder() if generator() else None)


def code_key(content: object) -> Key:
    """What names machine code: what it computes; the machine, the compiler's versions and robodyn's code generator."""
    return Key(repr(content), repr((generator(), host())))


def built(name: str, content: object, ir: Callable[[], str], *arguments: Any) -> Function:
    """Return the function of this name with these ctypes arguments, from the cache or compiled; `ir` writes the module,
    which depends on `content`, whose `repr` tells every difference. ImportError, OSError or RuntimeError where llvmlite
    is not there, or does not compile it."""
    objects = kept_objects()
    key = code_key(content)
    code = objects.get(key)
    if code is None:
        code = machine_code(ir())
        objects.put(key, code)
    return Function(code, name, *arguments)
