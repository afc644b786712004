r"""Equations in the LaTeX that `derive` writes, as MathML, which browsers show without a script or a font."""

from __future__ import annotations

import re
from collections.abc import Iterable
from html import escape

_TOKEN = re.compile(r"\\text\{[^}]*\}|\\begin\{\w+\}|\\end\{\w+\}|\\operatorname\{\w+\}|\\[A-Za-z]+|\\.|\d+\.?\d*|\S")
_OPERATORS = {r"\times": "×", r"\cdot": "·", r"\sum": "∑", "-": "−", "'": "′"}  # noqa: RUF001
_LETTERS = {r"\omega": "ω", r"\tau": "τ", r"\Gamma": "Γ", r"\Phi": "Φ"}
_ACCENTS = {r"\dot": "\u0307", r"\ddot": "\u0308"}
"""Combining characters: accents of MathML sit well in mathematical fonts alone."""


def mathml(rows: Iterable[str]) -> str:
    """Return rows of align, each `left &= right`, as one block of MathML."""
    lines = [line for row in rows for line in _Reader(row).rows()]
    table = "".join(
        f'<mtr><mtd class="left">{left}</mtd><mtd class="right">{"".join(right)}</mtd></mtr>' for left, *right in lines
    )
    return f'<math display="block"><mtable>{table}</mtable></math>'


class _Reader:
    """Reads tokens from the first to the last."""

    def __init__(self, latex: str) -> None:
        self._tokens = [token for token in _TOKEN.findall(latex) if token not in (r"\left", r"\right")]
        self._tokens.reverse()

    def rows(self, end: str = "") -> list[list[str]]:
        r"""Return cells of rows between & and \\, up to a token that ends them."""
        found = [[""]]
        while self._tokens and self._tokens[-1] != end:
            if self._tokens[-1] == "&":
                found[-1].append("")
            elif self._tokens[-1] == r"\\":
                found.append([""])
            else:
                found[-1][-1] += self._scripted()
                continue
            self._tokens.pop()
        if end:
            self._tokens.pop()
        return found

    def _scripted(self) -> str:
        """Return an atom with its index and its power."""
        base, scripts = self._atom(), {}
        while self._tokens and self._tokens[-1] in "_^":
            script = self._tokens.pop()
            scripts[script] = self._atom()
        tag = {"": "", "_": "msub", "^": "msup"}.get("".join(scripts), "msubsup")
        return f"<{tag}>{base}{scripts.get('_', '')}{scripts.get('^', '')}</{tag}>" if tag else base

    def _atom(self) -> str:
        token = self._tokens.pop()
        name = token.lstrip("\\")
        if token in "{(":
            inside = "".join(self.rows("}" if token == "{" else ")")[0])
            found = f"<mrow>{inside}</mrow>" if token == "{" else f"<mrow><mo>(</mo>{inside}<mo>)</mo></mrow>"
        elif token == r"\begin{pmatrix}":
            cells = (f"<mtr><mtd>{'</mtd><mtd>'.join(row)}</mtd></mtr>" for row in self.rows(r"\end{pmatrix}"))
            found = f'<mtable class="matrix">{"".join(cells)}</mtable>'
        elif token in _ACCENTS:
            found = re.sub(r"<mi>(.)</mi>", rf'<mi class="dotted">\1{_ACCENTS[token]}</mi>', self._atom())
        elif token in (r"\frac", r"\sqrt"):
            found = f"<m{name}>{self._atom()}{self._atom() if name == 'frac' else ''}</m{name}>"
        elif token.startswith((r"\text", r"\operatorname")):
            found = f"<mtext>{escape(token.partition('{')[2][:-1])}</mtext>"
        elif token == r"\quad":
            found = '<mspace width="1em"/>'
        elif token[0].isdigit():
            found = f"<mn>{token}</mn>"
        elif name.isalpha() and token not in _OPERATORS:
            found = f"<mi>{_LETTERS.get(token, name)}</mi>"
        else:
            found = f"<mo>{_OPERATORS.get(token, escape(token))}</mo>"
        return found
