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
BACKSLASH = "\\"
SPACE = {"<mo></mo>": "", "<mi>quad</mi>": '<mspace width="1em"/>'}


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
        if token in "{(":
            inside = self._row("}" if token == "{" else ")")
            return f"<mrow>{inside}</mrow>" if token == "{" else f"<mrow><mo>(</mo>{inside}<mo>)</mo></mrow>"
        if token == r"\begin{pmatrix}":
            cells = (f"<mtr><mtd>{'</mtd><mtd>'.join(row)}</mtd></mtr>" for row in self.rows(r"\end{pmatrix}"))
            found = f'<mtable class="matrix">{"".join(cells)}</mtable>'
        elif token in _ACCENTS:
            found = re.sub(r"<mi>(.)</mi>", rf'<mi class="dotted">\1{_ACCENTS[token]}</mi>', self._atom())
        elif token == r"\frac":
            found = f"<mfrac>{self._atom()}{self._atom()}</mfrac>"
        elif token == r"\sqrt":
            found = f"<msqrt>{self._atom()}</msqrt>"
        elif token.startswith((r"\text", r"\operatorname")):
            found = f"<mtext>{escape(token.partition('{')[2][:-1])}</mtext>"
        elif token[0].isdigit():
            found = f"<mn>{token}</mn>"
        elif token in _OPERATORS or not (token in _LETTERS or token.isalpha() or token[0] == "\\"):
            found = f"<mo>{_OPERATORS.get(token, escape(token))}</mo>"
        else:
            found = f"<mi>{_LETTERS.get(token, escape(token.lstrip(BACKSLASH)))}</mi>"
        return found if found not in ("<mo></mo>", "<mi>quad</mi>") else SPACE[found]

    def _row(self, end: str) -> str:
        return "".join(self.rows(end)[0])
