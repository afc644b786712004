"""The worked solution as text, LaTeX and a page: each equation as rows, left = right, in the notation of each."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from textwrap import wrap
from typing import Any, NamedTuple

import numpy as np

from robodyn.equations.derive import Derivation, Equation, joined
from robodyn.report.document import Block, Document, Formula, Heading, Paragraph, Section, Table
from robodyn.report.renderers.latex import escaped
from robodyn.report.renderers.letters import Latex, Text
from robodyn.report.table import gravity_text

WIDTH = 100
"""Characters after which a sum goes on in the next line."""
FOLDED = 6000
"""Characters of LaTeX beyond which a page folds a part."""
BREAK = r" \\ "
_TOKEN = re.compile(r" x |\^-?\w|sum_k|[A-Za-z]+(?:_\w+)?")


class Row(NamedTuple):
    """left = right, and a word for it; without a left side the equation before goes on; a term is indented."""

    left: str
    right: str
    word: str = ""
    term: bool = False


class Plain:
    """Writes names, vectors and matrices as text."""

    printer: Text = Text()
    gap = "\n    "

    def name(self, text: str) -> str:
        return text

    def vector(self, entries: Sequence[str]) -> str:
        return f"({', '.join(entries)})"

    def matrix(self, rows: Sequence[Sequence[str]]) -> str:
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        lines = ["  ".join(f"{x:{w}}" for x, w in zip(row, widths, strict=True)).rstrip() for row in rows]
        return "\n".join(f"[ {line:{max(map(len, lines))}} ]" for line in lines)

    def component(self, name: str, k: int, many: int) -> str:
        index = "xyz"[k] if many == 3 else str(k + 1)
        return self.name(f"{name}{index}" if many == 3 and re.fullmatch(r"\w+", name) else f"({name})_{index}")

    def sum(self, expression: Any) -> str:
        lines = [""]
        for term in self.printer.terms(expression):
            if len(lines[-1]) > WIDTH:
                lines.append("")
            lines[-1] += " " * bool(lines[-1]) + term
        return self.gap.join(lines)


class Mathematics(Plain):
    """Writes them as LaTeX."""

    printer: Text = Latex()
    gap = " \\\\\n&\\quad "

    def name(self, text: str) -> str:
        def symbol(found: re.Match[str]) -> str:
            word = found[0]
            if word == " x ":
                return r" \times "
            if word[0] == "^":
                return f"^{{{word[1:]}}}"
            return r"\sum_{k}" if word == "sum_k" else self.printer.symbol(word)

        return re.sub(r"\)_(\w)", r")_{\1}", _TOKEN.sub(symbol, text))

    def vector(self, entries: Sequence[str]) -> str:
        return self.matrix([[entry] for entry in entries])

    def matrix(self, rows: Sequence[Sequence[str]]) -> str:
        return f"\\begin{{pmatrix}} {BREAK.join(' & '.join(row) for row in rows)} \\end{{pmatrix}}"


Plain.printer.digits = 6
PLAIN, MATHEMATICS = Plain(), Mathematics()


def rows(equation: Equation, style: Plain) -> Iterator[Row]:
    """Yield an equation: names of what is summed, each term with its value, the sum. What vanishes is left out."""
    terms = [term for term in equation.terms if np.any(np.asarray(term.value) != 0)]
    left, names = style.name(equation.left), style.name(joined(terms))
    if equation.grid:
        yield Row(left, style.matrix([[style.name(x) for x in row] for row in equation.grid]))
    if equation.total is None or str(equation.total) == equation.left:
        return
    if equation.value is not None:
        yield Row(left, names)
        for k, (a, b) in enumerate(zip(equation.value, equation.total, strict=True), equation.number):
            yield Row(style.sum(a), style.sum(b), str(k), True)
        return
    short, *components = _values(equation.left, equation.total, style)
    if len(terms) == 1 and short.left == left:
        yield Row(left, f"{names} = {short.right}", terms[0].word)
        return
    if terms:
        yield Row(left, names, terms[0].word if len(terms) == 1 else "")
    for term in terms if len(terms) > 1 else ():
        for row in _values(term.name, term.value, style):
            yield row._replace(word=term.word, term=True)
    goes_on = short.left == left and (terms or equation.grid)
    yield from (short._replace(left="") if goes_on else short, *components)


def _values(name: str, value: Any, style: Plain) -> list[Row]:
    """Return name = value, of a long vector by components, those that are zero left out."""
    if np.ndim(value) == 0:
        return [Row(style.name(name), style.sum(value))]
    if np.ndim(value) == 2:
        return [Row(style.name(name), style.matrix([list(map(style.printer.sum, row)) for row in value]))]
    if sum(map(len, map(PLAIN.printer.sum, value))) <= WIDTH:
        return [Row(style.name(name), style.vector([style.printer.sum(x) for x in value]))]
    return [Row(style.component(name, k, len(value)), style.sum(x)) for k, x in enumerate(value) if x != 0]


def _lines(found: Sequence[Row]) -> Iterator[str]:
    """Yield rows as lines of text."""
    for left, right, word, term in found:
        start = f"{'      ' if term else '  '}{left or ' '} = "
        first, *others = right.split("\n")
        yield f"{start}{first}{f'   ({word})' if word else ''}"
        yield from (" " * len(start) + other for other in others)


def formula(equations: Iterable[Equation], title: str = "") -> Formula:
    """Return equations in all forms, below a title that a page unfolds if they are long."""
    lines, latex = list[str](), list[str]()
    for equation in equations:
        lines += _lines(list(rows(equation, PLAIN)))
        for left, right, word, term in rows(equation, MATHEMATICS):
            end = rf" \quad \text{{({word})}}" if word else ""
            latex.append(f"& \\quad {left} = {right}{end}" if term else f"{left} &= {right}{end}")
    return Formula(tuple(lines), tuple(latex), title if sum(map(len, latex)) > FOLDED else "")


def derive_sections(found: Derivation) -> Iterator[Section]:
    """Yield what is known, and the steps with their laws and equations, as text."""
    for section in _sections(found):
        blocks: list[Block] = []
        for block in map(plain, section):
            blocks += map(Paragraph, wrap(block.text, WIDTH + 10)) if isinstance(block, Paragraph) else [block]
        yield blocks


def _sections(found: Derivation) -> Iterator[Section]:
    """Yield them with formulas in tables between backticks."""
    how = "in numbers" if found.numbers else "as formulas"
    yield [Paragraph(f"{found.robot}: worked solution {how}, {gravity_text(found.gravity)}, SI units")]
    known = [(f"`{name}`", value, meaning) for name, value, meaning in found.known]
    letters = [(f"`{letter.name}`", f"{letter.value:.6g}", letter.meaning) for letter in found.letters]
    for k, step in enumerate(found.steps, 1):
        yield [Heading(f"Step {k}. {step.title}"), *map(Paragraph, step.words)]
        if k == 1:
            head = ("", "value", "what it is") if found.numbers else ("", "what it is")
            yield [Table("Coordinates", head, known if found.numbers else [(a, c) for a, _, c in known])]
            yield [Table("Letters", ("", "value", "what it is"), letters)] if letters else []
            yield [Paragraph(notation(found))]
        if step.laws:
            latex, lines = [], list[Row]()
            for law, _, word in (law.partition(" | ") for law in step.laws):
                left, _, right = law.partition(" = ")
                lines.append(Row(left, right, word))
                words = rf" \quad \text{{({word})}}" if word else ""
                latex.append(f"{MATHEMATICS.name(left)} &= {MATHEMATICS.name(right)}{words}")
            general = "In general, for body i on body j" * any("_i" in law for law in step.laws)
            general += ", which carries bodies k" * any("_k" in law for law in step.laws)
            yield [*([Paragraph(f"{general}:")] if general else []), Formula(tuple(_lines(lines)), tuple(latex))]
        if step.counts:
            titles, *cells = step.counts
            yield [Table("", titles, [[f"`{x}`" if "_" in x else x for x in row] for row in cells])]
        for part in step.parts:
            block: list[Block] = [Paragraph(text) for text in (part.title, part.words) if text]
            yield [*block, formula(part.equations, part.title)] if part.equations else block


def notation(found: Derivation) -> str:
    """Return how formulas are to be read."""
    words = "x, y, z after the name of a vector is a component; components that are not shown are zero."
    if not found.numbers:
        words = f"c_1 is cos(q_1), s_12 is sin(q_1 + q_2), and so on; {words}"
    if not found.written_out:
        words += " Long expressions are not written out: a line uses the components that lines before it define."
    return words


def derive_latex(found: Derivation) -> str:
    """Return the solution for a document that uses amsmath."""

    def words(text: str) -> str:
        pieces = re.split(r"`([^`]*)`", text)
        named = [", ".join(f"${MATHEMATICS.name(x)}$" for x in piece.split(", ")) for piece in pieces[1::2]]
        return "".join(escaped(a) + b for a, b in zip(pieces[::2], [*named, ""], strict=True))

    out = ["% Needs \\usepackage{amsmath} and \\setcounter{MaxMatrixCols}{40}."]
    for block in (block for section in _sections(found) for block in section):
        if isinstance(block, Heading):
            out.append(f"\\section*{{{words(block.text)}}}")
        elif isinstance(block, Formula):
            out.append("\\begin{align*}\n" + " \\\\\n".join(block.latex) + "\n\\end{align*}")
        elif isinstance(block, Table):
            lines = [" & ".join(map(words, row)) + r" \\" for row in (block.head, *block.rows)]
            out.append(f"\\begin{{tabular}}{{{'l' * len(block.head)}}}\n" + "\n".join(lines) + "\n\\end{tabular}")
        else:
            assert isinstance(block, Paragraph)
            out.append(words(block.text))
    return "\n\n".join(out) + "\n"


def derive_page(found: Derivation) -> Document:
    subtitle = "worked solution " + ("in numbers" if found.numbers else "as formulas")
    _, *sections = _sections(found)
    return Document(found.robot, subtitle, tuple(plain(block) for section in sections for block in section))


def plain(block: Block) -> Block:
    """Return a block without marks of formulas in its words."""
    if isinstance(block, Table):
        return replace(block, rows=[[cell.replace("`", "") for cell in row] for row in block.rows])
    return block
