"""The closed form as a Python module that needs NumPy alone."""

from __future__ import annotations

import re

from robodyn.equations.closed import Closed
from robodyn.programs.export import docstring
from robodyn.report.equations.equations import checked, coordinate_lines
from robodyn.report.renderers.letters import Python

FUNCTIONS = ("abs", "cos", "exp", "sign", "sin", "sqrt")
MODULE = '''{title}
{imports}

def equations(q, qd{parameters}):
    {notes}
{body}
    return M, bias


def torques(q, qd, qdd, **symbols):
    """Return tau = M qdd + the bias, for numbers or arrays; `symbols` are those of `equations`."""
    M, bias = equations(q, qd, **symbols)
    rows = zip(M, zip(*bias.values())) if bias else ((row, ()) for row in M)
    return [sum(m * a for m, a in zip(row, qdd)) + sum(parts) for row, parts in rows]
'''


def closed_python(closed: Closed) -> str:
    """Return a module with the function `equations` of M and the parts of the bias, and `torques` from these; letters
    are parameters, their values the defaults."""
    write, n = Python().sum, len(closed.rates)
    notes = [
        "Return the rows of M and the parts of the bias by name: M qdd + their sum = tau, in SI units.",
        "",
    ]
    notes += [f"    {line}" for line in coordinate_lines(closed)]
    notes += [f"    {letter.name}: {letter.meaning}" for letter in closed.symbols]
    body = [
        f"[{', '.join(str(x) for x in closed.q if x is not None)}] = q",
        f"[{', '.join(map(str, closed.qd))}] = qd",
        *(f"{name} = {write(x)}" for name, x in closed.constants.items()),
        *(f"M_{i + 1}_{j + 1} = {write(closed.M[i][j])}" for i in range(n) for j in range(i, n)),
        "M = [",
        *(f"    [{', '.join(f'M_{min(i, j) + 1}_{max(i, j) + 1}' for j in range(n))}]," for i in range(n)),
        "]",
        "bias = {",
        *(
            line
            for name, part in closed.bias.items()
            for line in (f"    {name!r}: [", *(f"        {write(x)}," for x in part), "    ],")
        ),
        "}",
    ]
    used = [name for name in FUNCTIONS if any(re.search(rf"\b{name}\(", line) for line in body)]
    return MODULE.format(
        title=docstring(f"Equations of motion of {closed.robot} in closed form. {checked(closed)}"),
        imports=f"\nfrom numpy import {', '.join(used)}\n" if used else "",
        parameters="".join([", *" * bool(closed.symbols), *(f", {x.name}={x.value!r}" for x in closed.symbols)]),
        notes=docstring("\n".join(notes)),
        body="\n".join(f"    {line}" for line in body),
    )
