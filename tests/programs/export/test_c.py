"""Programs as C functions."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.c_functions import called, compiled_c, needs_c
from helpers.compiled_programs import program_of
from helpers.oracles import worst

from robodyn.errors import InputError
from robodyn.programs.export import c_function, comment
from robodyn.programs.run.numpy_blocks import NumpyBlocks
from robodyn.programs.vectors import cos, exp, sign, sin


@needs_c
def test_every_operation(tmp_path):
    def function(x, y):
        return [x + y, x - y, x * y, x / y, -x, (x * x).sqrt(), sin(x), cos(y), exp(x), sign(x), sign(y), x, 2.5]

    program = program_of(function, 2)
    source = next(iter(program.inputs))[0]
    library = compiled_c(
        "#include <math.h>\n" + c_function("f", program, {source: 2}, {"out": len(program.outputs)}), tmp_path
    )
    states = np.array([[0.3, -2.0], [-1.5, 0.7], [0.0, 1e-3], [-0.0, 5.0]])
    expected = NumpyBlocks(program, {source: 2})({source: states}, len(states))
    found = called(library.f, [states], expected.shape[1])
    assert worst(found, expected) <= 1e-15
    assert (found[:, 9:] == expected[:, 9:]).all()


@needs_c
def test_it_may_write_to_what_it_reads(tmp_path):
    program = program_of(lambda x, y: [y, x, x + y], 2)
    source = next(iter(program.inputs))[0]
    library = compiled_c(
        "#include <math.h>\n" + c_function("f", program, {source: 3}, {"out": len(program.outputs)}), tmp_path
    )
    values = np.array([2.0, 5.0, 0.0])
    library.f.restype = None
    library.f(values.ctypes, values.ctypes)
    assert values.tolist() == [5.0, 2.0, 7.0]


def test_a_constant_that_overflows():
    with pytest.raises(InputError, match="a constant of the equations overflows"):
        c_function("f", program_of(lambda x: [x * float("inf")], 1), {"q": 1}, {"out": 1})


@pytest.mark.parametrize("text", ["*/ int x; /*", "??/", "*??/\n/", "Gr\u00fc\u00dfe \x1b", "/*/"])
def test_nothing_ends_a_comment(text):
    plain = comment(text)
    assert plain.isascii()
    assert not any(ending in plain for ending in ("*/", "/*", "??"))
