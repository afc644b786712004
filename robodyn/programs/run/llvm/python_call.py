"""A program as one LLVM function of a single sample, called from Python without a layer of Python in between.

CPython calls `call` as a method with fast arguments. It looks whether every argument is the array that is expected,
hands the arrays' memory to the kernel and returns the array of results; whatever else it is given goes to a slower
function, which converts it or says what is wrong with it.
"""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from importlib import import_module
from typing import Any

import numpy as np

from robodyn.programs.program import Program
from robodyn.programs.run.llvm.build import built
from robodyn.programs.run.llvm.functions import Code
from robodyn.programs.run.llvm.kernel import Writer, fused_products
from robodyn.programs.run.llvm.machine import Function

FRAME = """\
{declared}
define i64 @sample({arguments}, ptr %to) #0 {{
entry:
{body}
  ret i64 0
{refused}
}}
define i64 @arrays(ptr %all) #0 {{
entry:
{loads}
  %flag = call i64 @sample({given}, ptr %to)
  ret i64 %flag
}}
attributes #0 = {{ nounwind }}
"""
_KEYWORDS, _FAST = 0x0002, 0x0080


def sample_kernel(program: Program, widths: Mapping[str, int]) -> str:
    """Return the LLVM IR of `i64 sample(const double *source..., double *to)`, and of `i64 arrays(double **all)`.

    There is an argument for every source of `widths`, in this order, and the outputs come last. All inputs are read
    before the first output is written, so the arrays may overlap. The function returns 0, or 1 and writes nothing where
    an angle is too large to be reduced accurately or is not finite. `arrays` is given the addresses of all in one.
    """
    writer = _Sample(program, widths)
    writer.write()
    names = [f"%source{k}" for k in range(len(widths))]
    loads = (f"  {name} = load ptr, %all[{k}]" for k, name in enumerate([*names, "%to"]))
    given = ", ".join(f"ptr {name}" for name in names)
    return FRAME.format(
        declared="\n".join(sorted(writer.code.declared)),
        arguments=given,
        given=given,
        loads="\n".join(loads),
        body="\n".join(writer.code.lines),
        refused="refused:\n  ret i64 1" if writer.angles else "",
    )


class _Sample(Writer):
    def __init__(self, program: Program, widths: Mapping[str, int]) -> None:
        super().__init__(program, program.rows(widths), Code("double", 1), fused_products(program), False)
        self.results: list[tuple[str, int]] = []
        self.arrays = {source: f"%source{k}" for k, source in enumerate(widths)}

    def write(self, first: int = 0, until: int = sys.maxsize) -> None:
        super().write(first, until)
        if self.angles:
            self.code.lines.append(f"  br i1 {self.too_large()}, label %refused, label %fine\nfine:")
        for value, row in self.results:
            address = self.code.new(f"getelementptr double, ptr %to, i64 {row - self.first_row['']}")
            self.code.do(f"store <1 x double> {value}, ptr {address}, align 8")

    def _store(self, value: str, row: int) -> None:
        self.results.append((value, row))

    def _input(self, source: str, column: int) -> str:
        address = self.code.new(f"getelementptr double, ptr {self.arrays[source]}, i64 {column}")
        return self.code.new(f"load <1 x double>, ptr {address}, align 8")


TEXT = """\
define internal ptr @memory(ptr %o, ptr %table, i32 %dimensions, ptr %shape, i32 %flags) #0 {
entry:
  %type = load ptr, %o[$TYPE]
  %array_type = load ptr, %table[$array_type]
  %is_array = icmp eq ptr %type, %array_type
  br i1 %is_array, label %array, label %other
array:
  %dtype = load ptr, %o[$DTYPE]
  %double = load ptr, %table[$dtype]
  %is_double = icmp eq ptr %dtype, %double
  %given_flags = load i32, %o[$FLAGS]
  %common = and i32 %given_flags, %flags
  %plain = icmp eq i32 %common, %flags
  %given_dimensions = load i32, %o[$DIMENSIONS]
  %as_many = icmp eq i32 %given_dimensions, %dimensions
  %fits = and i1 %is_double, %plain
  %fits_all = and i1 %fits, %as_many
  br i1 %fits_all, label %sizes, label %other
sizes:
  %given_shape = load ptr, %o[$SHAPE]
  br label %size
size:
  %k = phi i32 [ 0, %sizes ], [ %k1, %next ]
  %place = zext i32 %k to i64
  %given = load i64, %given_shape[%place]
  %wanted = load i64, %shape[%place]
  %same = icmp eq i64 %given, %wanted
  br i1 %same, label %next, label %other
next:
  %k1 = add i32 %k, 1
  %more = icmp slt i32 %k1, %dimensions
  br i1 %more, label %size, label %found
found:
  %data = load ptr, %o[$DATA]
  ret ptr %data
other:
  ret ptr null
}

define ptr @call(ptr %self, ptr %given, i64 %count, ptr %names) #0 {
entry:
  %arrays = alloca [$ARRAYS x ptr]
  %table = load ptr, %self[$DATA]
  %wanted = load i64, %table[$count]
  %as_many = icmp eq i64 %count, %wanted
  br i1 %as_many, label %each, label %otherwise
each:
  %k = phi i64 [ 0, %entry ], [ %k1, %got ]
  %one = load ptr, %given[%k]
  %place = add i64 %k, $WIDTHS
  %width_at = getelementptr i64, ptr %table, i64 %place
  %memory = call ptr @memory(ptr %one, ptr %table, i32 1, ptr %width_at, i32 $ALIGNED_ROWS)
  %none = icmp eq ptr %memory, null
  br i1 %none, label %otherwise, label %got
got:
  store ptr %memory, %arrays[%k]
  %k1 = add i64 %k, 1
  %more = icmp slt i64 %k1, %count
  br i1 %more, label %each, label %target
target:
  %dimensions_64 = load i64, %table[$dimensions]
  %dimensions = trunc i64 %dimensions_64 to i32
  %shape = getelementptr i64, ptr %table, i64 $shape
  %keep = load ptr, %table[$keep]
  %unnamed = icmp eq ptr %names, null
  br i1 %unnamed, label %new, label %named
named:
  %length = load i64, %names[$DATA]
  %single = icmp eq i64 %length, 1
  br i1 %single, label %name, label %otherwise
name:
  %word = load ptr, %names[$DIMENSIONS]
  %out = load ptr, %table[$out]
  %is_out = icmp eq ptr %word, %out
  br i1 %is_out, label %old, label %otherwise
old:
  %old_array = load ptr, %given[%count]
  %old_memory = call ptr @memory(ptr %old_array, ptr %table, i32 %dimensions, ptr %shape, i32 $WRITEABLE_ROWS)
  %unfit = icmp eq ptr %old_memory, null
  br i1 %unfit, label %otherwise, label %kept
kept:
  call void %keep(ptr %old_array)
  br label %run
new:
  %dtype = load ptr, %table[$dtype]
  call void %keep(ptr %dtype)
  %empty = load ptr, %table[$empty]
  %new_array = call ptr %empty(i32 %dimensions, ptr %shape, ptr %dtype, i32 0)
  %failed = icmp eq ptr %new_array, null
  br i1 %failed, label %nothing, label %made
made:
  %new_memory = load ptr, %new_array[$DATA]
  br label %run
run:
  %result = phi ptr [ %old_array, %kept ], [ %new_array, %made ]
  %result_memory = phi ptr [ %old_memory, %kept ], [ %new_memory, %made ]
  store ptr %result_memory, %arrays[%count]
  %kernel = load ptr, %table[$kernel]
  %flag = call i64 %kernel(ptr %arrays)
  %fine = icmp eq i64 %flag, 0
  br i1 %fine, label %done, label %flagged
flagged:
  %drop = load ptr, %table[$drop]
  call void %drop(ptr %result)
  br label %otherwise
otherwise:
  %slow = load ptr, %table[$otherwise]
  %vectorcall = load ptr, %table[$vectorcall]
  %answer = call ptr %vectorcall(ptr %slow, ptr %given, i64 %count, ptr %names)
  ret ptr %answer
done:
  ret ptr %result
nothing:
  ret ptr null
}
attributes #0 = { nounwind }
"""


MOST_ARGUMENTS, MOST_DIMENSIONS = 8, 3
_ALIGNED_ROWS, _WRITEABLE = 0x101, 0x400
_TYPE, _DATA, _DIMENSIONS, _SHAPE, _DTYPE, _FLAGS = 1, 2, 3, 4, 7, 8
"""Where an array's object holds these, in words; tuples hold their length and items at `_DATA` and `_DIMENSIONS`."""
_EMPTY = 184
"""The place of PyArray_Empty in NumPy's table of functions, which keeps its order from release to release."""
_FIELDS = "kernel count array_type dtype out empty keep drop vectorcall otherwise dimensions shape"
_PLACE = {name: k for k, name in enumerate(_FIELDS.split())}
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
    pointer = api.PyCapsule_GetPointer
    pointer.restype, pointer.argtypes = ctypes.c_void_p, [ctypes.py_object, ctypes.c_char_p]
    numpys = pointer(import_module("numpy._core._multiarray_umath")._ARRAY_API, None)
    empty = ctypes.cast(numpys, ctypes.POINTER(ctypes.c_void_p))[_EMPTY] or 0
    functions = (api.Py_IncRef, api.Py_DecRef, api.PyObject_Vectorcall)
    keep_one, drop, vectorcall = (ctypes.cast(each, ctypes.c_void_p).value for each in functions)
    dtype, out = np.dtype(np.float64), sys.intern("out")
    head = (kernel, len(widths), id(np.ndarray), id(dtype), id(out), empty, keep_one, drop, vectorcall)
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
    _fields_ = [
        ("name", ctypes.c_char_p),
        ("address", ctypes.c_void_p),
        ("flags", ctypes.c_int),
        ("doc", ctypes.c_char_p),
    ]


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


@cache
def _usual() -> bool:
    """Return whether CPython and NumPy lay arrays and tuples out as `call` takes them to."""
    if sys.implementation.name != "cpython" or ctypes.sizeof(ctypes.c_void_p) != 8:
        return False
    array, pair = np.zeros((2, 3)), ("out", "in")

    def word(thing: object, offset: int) -> int:
        return ctypes.c_uint64.from_address(id(thing) + 8 * offset).value

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
