r"""Equations in the LaTeX that `derive` writes, as MathML, which browsers show without a script or a font."""

from __future__ import annotations

import re
from collections.abc import Iterable
from html import escape

_TOKEN = re.compile(r"\\text\{[^}]*\}|\\begin\{\w+\}|\\end\{\w+\}|\\operatorname\{\w+\}|\\[A-Za-z]+|\\.|\d+\.?\d*|\S")
_OPERATORS = {r"\times": "×", r"\cdot": "·", r"\sum": "∑", "-": "−", "'": "′", r"\left": "", r"\right": ""}  # noqa: RUF001
_LETTERS = {r"\omega": "ω", r"\tau": "τ", r"\Gamma": "Γ", r"\Phi": "Φ"}
_ACCENTS = {r"\dot": "\u0307", r"\ddot": "\u0308"}
"""Combining characters: accents of MathML sit well in mathematical fonts alone."""


def mathml(rows: Iterable[str]) -> str:
    """Return rows of align, each `left &= right`, as one block of MathML."""
    cells = [_Reader(row).rows() for row in rows]
    lines = [line for part in cells for line in part]
    table = "".join(
        f'<mtr><mtd class="left">{line[0]}</mtd><mtd class="right">{"".join(line[1:])}</mtd></mtr>' for line in lines
    )
    return f'<math display="block"><mtable>{table}</mtable></math>'


class _Reader:
    """Reads tokens from the first to the last."""

    def __init__(self, latex: str) -> None:
        self._tokens, self._next = _TOKEN.findall(latex), 0

    def rows(self, end: str = "") -> list[list[str]]:
        r"""Return cells of rows between & and \\, up to a token that ends them."""
        found = [[""]]
        while self._next < len(self._tokens) and self._tokens[self._next] != end:
            token = self._tokens[self._next]
            if token in ("&", r"\\"):
                self._next += 1
                if token == "&":
                    found[-1].append("")
                else:
                    found.append([""])
            else:
                found[-1][-1] += self._scripted()
        self._next += 1
        return found

    def _scripted(self) -> str:
        """Return an atom with its index and its power."""
        base, below, above = self._atom(), "", ""
        while self._next < len(self._tokens) and self._tokens[self._next] in "_^":
            script, self._next = self._tokens[self._next], self._next + 1
            if script == "_":
                below = self._atom()
            else:
                above = self._atom()
        if below and above:
            return f"<msubsup>{base}{below}{above}</msubsup>"
        if below or above:
            return f"<msub>{base}{below}</msub>" if below else f"<msup>{base}{above}</msup>"
        return base

    def _atom(self) -> str:
        token, self._next = self._tokens[self._next], self._next + 1
        if token == "{":
            return f"<mrow>{self._row('}')}</mrow>"
        if token == "(":
            return f"<mrow><mo>(</mo>{self._row(')')}<mo>)</mo></mrow>"
        if token in (r"\left", r"\right") or token in (r"\,", r"\;"):
            return ""
        if token == r"\begin{pmatrix}":
            body = "".join(
                f"<mtr>{''.join(f'<mtd>{cell}</mtd>' for cell in row)}</mtr>" for row in self.rows(r"\end{pmatrix}")
            )
            return f'<mtable class="matrix">{body}</mtable>'
        if token in _ACCENTS:
            return re.sub(r"<mi>(.)</mi>.*", rf'<mi class="dotted">\1{_ACCENTS[token]}</mi>', self._row_of_atom())
        if token == r"\frac":
            return f"<mfrac>{self._atom()}{self._atom()}</mfrac>"
        if token == r"\sqrt":
            return f"<msqrt>{self._atom()}</msqrt>"
        if token == r"\quad":
            return '<mspace width="1em"/>'
        if token.startswith((r"\text", r"\operatorname")):
            return f"<mtext>{escape(token.partition('{')[2][:-1])}</mtext>"
        if token in _LETTERS or token.isalpha():
            return f"<mi>{_LETTERS.get(token, token)}</mi>"
        if token[0].isdigit():
            return f"<mn>{token}</mn>"
        if token.startswith("\\") and token not in _OPERATORS:
            return f"<mi>{escape(token[1:])}</mi>"
        return f"<mo>{_OPERATORS.get(token, escape(token))}</mo>"

    def _row_of_atom(self) -> str:
        return self._atom().removeprefix("<mrow>").removesuffix("</mrow>")

    def _row(self, end: str) -> str:
        return "".join(self.rows(end)[0])
