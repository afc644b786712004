r"""The closed form of the equations of motion as LaTeX, to be put into a document that uses amsmath."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from robodyn.equations.closed import Closed, decimal
from robodyn.programs.run.symbolic import module
from robodyn.report.equations import checked

DIGITS = 6
WIDTH = 120
"""Characters of LaTeX after which a sum goes on in the next line."""
ESCAPES = {
    "\\": r"\textbackslash{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    **{character: "\\" + character for character in "&%$#_{}"},
}


def closed_latex(closed: Closed) -> str:
    r"""Return a sentence on coordinates and notation, then M, gravity, Coriolis and all else in `align*`."""
    n = len(closed.joints)
    x, y, z = closed.gravity
    entries = {f"M_{{{i + 1}{j + 1}}}": closed.M[i][j] for i in range(n) for j in range(i, n)}
    for effect, share in closed.bias.items():
        entries |= {_part(effect, str(i + 1)): entry for i, entry in enumerate(share)}
    bias = " + ".join(_part(effect, "") for effect in closed.bias)
    coordinates = ", ".join(
        f"$q_{{{i + 1}}}$ ({escaped(name)}, {'m' if kind == 'prismatic' else 'rad'})"
        for i, (name, kind) in enumerate(zip(closed.joints, closed.kinds, strict=True))
    )
    return (
        f"% {' '.join(checked(closed).split())}\n"
        "% Needs \\usepackage{amsmath}.\n"
        f"The equations of motion of {escaped(closed.robot)} are\n"
        f"\\[ M(q)\\,\\ddot{{q}}{' + ' * bool(bias)}{bias} = \\tau \\]\n"
        f"with the coordinates {coordinates}, gravity $({x:g}, {y:g}, {z:g})$\\,m/s$^2$, SI units, coefficients to\n"
        f"{DIGITS} digits, $c_{{i}} = \\cos q_{{i}}$, $s_{{i}} = \\sin q_{{i}}$, "
        "$c_{ij} = \\cos(q_{i} + q_{j})$, $s_{ij} = \\sin(q_{i} + q_{j})$\n"
        "and so on, $M_{ij} = M_{ji}$, and\n" + _aligned(entries, closed)
    )


def _part(effect: str, index: str) -> str:
    if effect in ("gravity", "coriolis"):
        letter, arguments = ("G", "(q)") if effect == "gravity" else ("V", r"(q, \dot{q})")
        return letter + (f"_{{{index}}}" if index else arguments)
    name = rf"\tau^{{\text{{{effect}}}}}"
    return name + (f"_{{{index}}}" if index else "")


def _aligned(entries: Mapping[str, Any], closed: Closed) -> str:
    lines = [f"{name} &= {_broken(entry, closed)}" for name, entry in entries.items()]
    return "\\begin{align*}\n" + " \\\\\n".join(lines) + "\n\\end{align*}\n"


def _broken(expression: Any, closed: Closed) -> str:
    """Return the expression, a long sum on several lines."""
    sympy, printer = module(), _printer(len(closed.q))
    numbered = {
        old: new
        for k, pair in enumerate(zip(closed.q, closed.qd, strict=True), 1)
        for old, new in zip(pair, _symbols(k), strict=True)
    }
    sum_of = decimal(expression).xreplace(numbered)
    lines = [""]
    for term in printer._as_ordered_terms(sum_of) if isinstance(sum_of, sympy.Add) else [sum_of]:
        text = printer.doprint(term)
        if len(lines[-1]) > WIDTH:
            lines.append("")
        sign = "" if text.startswith("-") or lines == [""] else "+ "
        lines[-1] += f"{' ' * bool(lines[-1])}{sign}{text}"
    return " \\\\\n    &\\quad ".join(lines)


def _symbols(k: int) -> tuple[Any, Any]:
    """Return symbols of coordinate k from 1 and of its rate; sums and products come in the order of joints."""
    sympy = module()
    return sympy.Symbol(f"q_{k}", real=True), sympy.Symbol(f"qd_{k}", real=True)


def _printer(n: int) -> Any:
    from sympy.printing.latex import LatexPrinter

    numbers = {_symbols(k)[0]: k for k in range(1, n + 1)}
    names = {symbol: f"q_{{{k}}}" for symbol, k in numbers.items()}
    names |= {_symbols(k)[1]: rf"\dot{{q}}_{{{k}}}" for k in range(1, n + 1)}

    class Printer(LatexPrinter):  # type: ignore[misc,unused-ignore]
        def _print_Float(self, value: Any) -> str:
            mantissa, _, exponent = f"{float(value):.{DIGITS}g}".partition("e")
            return f"{mantissa} \\cdot 10^{{{int(exponent)}}}" if exponent else mantissa

        def _print_cos(self, wave: Any, exp: str | None = None) -> str:
            return self._short("c", r"\cos", wave.args[0], exp)

        def _print_sin(self, wave: Any, exp: str | None = None) -> str:
            return self._short("s", r"\sin", wave.args[0], exp)

        def _short(self, letter: str, function: str, angle: Any, exp: str | None) -> str:
            power = f"^{{{exp}}}" if exp else ""
            if all(term in numbers for term in angle.as_ordered_terms()):
                digits = "".join(str(k) for k in sorted(numbers[term] for term in angle.as_ordered_terms()))
                return f"{letter}_{{{digits}}}{power}"
            return f"{function}{power}\\left({self._print(angle)}\\right)"

        def _print_sign(self, call: Any, exp: str | None = None) -> str:
            power = f"^{{{exp}}}" if exp else ""
            return f"\\operatorname{{sgn}}\\left({self._print(call.args[0])}\\right){power}"

    return Printer({"symbol_names": names})


def escaped(text: str) -> str:
    """Return the text as LaTeX prints it."""
    printable = "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)
    return "".join(ESCAPES.get(character, character) for character in printable)
