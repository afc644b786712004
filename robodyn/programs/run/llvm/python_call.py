"""A function of machine code as a callable of Python, without a layer of Python in between.

CPython calls `call` as a method with fast arguments. It looks whether every argument is the array that is expected,
hands the arrays' memory to the kernel and returns the array of results; whatever else it is given goes to a slower
function, which converts it or says what is wrong with it.
"""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Callable, Sequence
from functools import cache
from importlib import import_module
from typing import Any

import numpy as np

from robodyn.programs.run.llvm.build import built
from robodyn.programs.run.llvm.machine import Function
from robodyn.programs.run.llvm.python_call_text import TEXT

MOST_ARGUMENTS, MOST_DIMENSIONS = 8, 3
_ALIGNED_ROWS, _WRITEABLE = 0x101, 0x400
_TYPE, _DATA, _DIMENSIONS, _SHAPE, _DTYPE, _FLAGS = 8, 16, 24, 32, 56, 64
"""Where an array's object holds these, in bytes; tuples hold their length and items at `_DATA` and `_DIMENSIONS`."""
_EMPTY = 184
"""The place of PyArray_Empty in NumPy's table of functions, which keeps its order from release to release."""

_FIELDS = (
    "kernel",
    "count",
    "array_type",
    "dtype",
    "out",
    "empty",
    "keep",
    "drop",
    "vectorcall",
    "otherwise",
    "dimensions",
)
_PLACE = {name: k for k, name in enumerate((*_FIELDS, "shape"))}
_WIDTHS = _PLACE["shape"] + MOST_DIMENSIONS


def callable_of(
    kernel: int, widths: Sequence[int], shape: tuple[int, ...], otherwise: Callable[..., Any], keep: object
) -> Callable[..., Any]:
    """Return a function of arrays of doubles (width,) that returns one of `shape`, or fills `out=` and returns it.

    Args:
        kernel: the address of `i64 kernel(double **arrays)`: of the arguments, then of the result. Where it does not
            return 0, and for arguments that are no such arrays, `otherwise` is called with them.
        keep: what must live as long as the function, as that which holds the kernel.

    Raises:
        ImportError, OSError, RuntimeError: there is no compiler, or objects of this Python are not laid out as usual.
    """
    if not _usual():
        raise RuntimeError("objects of this Python are not laid out as usual")
    if len(widths) > MOST_ARGUMENTS or not 0 < len(shape) <= MOST_DIMENSIONS:
        raise ValueError("too many arguments or dimensions")
    api = ctypes.pythonapi
    functions = (api.Py_IncRef, api.Py_DecRef, api.PyObject_Vectorcall)
    keep_one, drop, vectorcall = (ctypes.cast(each, ctypes.c_void_p).value for each in functions)
    dtype, out = np.dtype(np.float64), sys.intern("out")
    head = (kernel, len(widths), id(np.ndarray), id(dtype), id(out), _numpys_empty(), keep_one, drop, vectorcall)
    sizes = (*shape, *(0,) * (MOST_DIMENSIONS - len(shape)))
    table = np.array((*head, id(otherwise), len(shape), *sizes, *widths), np.uint64).view(_Table)
    method = _Method(b"function", _call().address, _FAST | _KEYWORDS, None)
    table.kept = (keep, otherwise, dtype, out, method, _call())
    new = api.PyCFunction_NewEx
    new.restype, new.argtypes = ctypes.py_object, [ctypes.c_void_p, ctypes.py_object, ctypes.c_void_p]
    found: Callable[..., Any] = new(ctypes.addressof(method), table, None)
    return found


class _Table(np.ndarray[Any, np.dtype[np.uint64]]):
    """The numbers that `call` needs, with what must not end before they do."""

    kept: object = None


class _Method(ctypes.Structure):
    _fields_ = (
        ("name", ctypes.c_char_p),
        ("address", ctypes.c_void_p),
        ("flags", ctypes.c_int),
        ("doc", ctypes.c_char_p),
    )


_KEYWORDS, _FAST = 0x0002, 0x0080


@cache
def _call() -> Function:
    """Return the function that all callables share."""
    numbers: dict[str, int] = {
        "WRITEABLE_ROWS": _ALIGNED_ROWS | _WRITEABLE,
        "ALIGNED_ROWS": _ALIGNED_ROWS,
        "ARRAYS": MOST_ARGUMENTS + 1,
        "WIDTHS": _WIDTHS,
        "DIMENSIONS": _DIMENSIONS,
        "SHAPE": _SHAPE,
        "DTYPE": _DTYPE,
        "FLAGS": _FLAGS,
        "TYPE": _TYPE,
        "DATA": _DATA,
        **_PLACE,
    }
    text = TEXT
    for name in sorted(numbers, key=len, reverse=True):
        text = text.replace(f"${name}", str(numbers[name]))
    return built("call", ("call", text), lambda: text)


def _numpys_empty() -> int:
    """Return the address of PyArray_Empty."""
    api = import_module("numpy._core._multiarray_umath")._ARRAY_API
    pointer = ctypes.pythonapi.PyCapsule_GetPointer
    pointer.restype, pointer.argtypes = ctypes.c_void_p, [ctypes.py_object, ctypes.c_char_p]
    table = ctypes.cast(pointer(api, None), ctypes.POINTER(ctypes.c_void_p))
    return int(table[_EMPTY] or 0)


@cache
def _usual() -> bool:
    """Return whether CPython and NumPy lay arrays and tuples out as `call` takes them to."""
    if sys.implementation.name != "cpython" or ctypes.sizeof(ctypes.c_void_p) != 8:
        return False
    array, pair = np.zeros((2, 3)), ("out", "in")

    def word(thing: object, offset: int) -> int:
        return ctypes.c_uint64.from_address(id(thing) + offset).value

    as_array = (
        word(array, _TYPE) == id(np.ndarray)
        and word(array, _DATA) == array.ctypes.data
        and word(array, _DIMENSIONS) & 0xFFFFFFFF == array.ndim
        and word(array, _DTYPE) == id(array.dtype)
        and word(array, _FLAGS) & 0xFFFFFFFF == array.flags.num
    )
    if not as_array or (ctypes.c_int64 * 2).from_address(word(array, _SHAPE))[:] != list(array.shape):
        return False
    return word(pair, _TYPE) == id(tuple) and word(pair, _DATA) == 2 and word(pair, _DIMENSIONS) == id(pair[0])
