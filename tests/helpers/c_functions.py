"""C text as functions that Python calls; needs a C compiler."""

from __future__ import annotations

import ctypes
import shutil
import subprocess

import numpy as np
import pytest

CC = shutil.which("cc") or shutil.which("gcc")
needs_c = pytest.mark.skipif(CC is None, reason="there is no C compiler here")
STRICT = ("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror")


def compiled_c(text, folder, *more):
    """The library that the text compiles to, without a warning."""
    source, library = folder / "robot.c", folder / "robot.so"
    source.write_text(text, encoding="ascii")
    done = subprocess.run(
        [CC, *STRICT, "-O0", *more, "-shared", "-fPIC", "-o", library, source, "-lm"],
        capture_output=True,
        check=False,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    return ctypes.CDLL(str(library))


def called(function, sources, outputs):
    """The outputs for every row of the sources, which are given in the function's order."""
    function.restype = None
    rows = [np.ascontiguousarray(source, dtype=float) for source in sources]
    out = np.full((len(rows[0]), outputs), np.nan)
    for k, row in enumerate(out):
        function(*(source[k].ctypes.data_as(ctypes.c_void_p) for source in rows), row.ctypes.data_as(ctypes.c_void_p))
    return out
