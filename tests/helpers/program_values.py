"""The simplest executor there is: a program's operations one by one in Python floats."""

from __future__ import annotations

import math
import operator

from robodyn.programs.scalar import CONSTANT, INPUT

OPERATIONS = {
    "add": operator.add,
    "sub": operator.sub,
    "mul": operator.mul,
    "div": operator.truediv,
    "neg": operator.neg,
    "sqrt": math.sqrt,
    "sin": math.sin,
    "cos": math.cos,
    "exp": math.exp,
    "sign": lambda x: float((x > 0) - (x < 0)),
}


def evaluated(program, sources):
    """The outputs of a program for one sample, given a sequence of numbers per source."""
    values = []
    for op, a, b in program.operations:
        if op == INPUT:
            values.append(float(sources[a][b]))
        elif op == CONSTANT:
            values.append(a)
        else:
            values.append(OPERATIONS[op](*(values[k] for k in (a, b) if k is not None)))
    return [values[k] for k in program.outputs]
