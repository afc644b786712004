"""The worked solution as text, LaTeX and a page: each equation as rows, left = right, in the notation of each."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from textwrap import wrap
from typing import Any, NamedTuple

import numpy as np

from robodyn.equations.derive import Derivation, Equation, Step, joined
from robodyn.report.document import Block, Document, Formula, Heading, Paragraph, Section, Table
from robodyn.report.equations.latex import escaped
from robodyn.report.renderers.letters import Latex, Text
from robodyn.report.table import gravity_text

WIDTH = 100
"""Characters up to which a vector stands in one line, and after which a sum of LaTeX goes on in the next."""
LINE = 120
"""Characters of a line of text."""
FOLDED = 6000
"""Characters of LaTeX beyond which a page folds a part."""
NEXT = r" \\ "
_TOKEN = re.compile(r" x |\^-?\w|sum_k|[A-Za-z]+(?:_\w+)?")
_WHOLE = re.compile(r"(?<=[-+=x]) | x|\([^()]{,60}\)")
"""What a line of text does not break: after a sign, about a cross, in a short bracket."""
_NAMES = re.compile(r"g|\w+_\w+(, \w+_\w+)*")
"""A cell of names alone."""


class Row(NamedTuple):
    """left = right, and a word for it; without a left side the equation before goes on; a term is indented."""

    left: str
    right: str
    word: str = ""
    term: bool = False


class Plain:
    """Writes names, expressions, vectors and matrices as text."""

    printer: Text = Text()

    def name(self, text: str) -> str:
        return text

    def sum(self, expression: Any) -> str:
        return self.printer.sum(expression)

    def vector(self, entries: Sequence[str]) -> str:
        return f"({', '.join(entries)})"

    def matrix(self, rows: Sequence[Sequence[str]]) -> str:
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        lines = ["  ".join(f"{x:{w}}" for x, w in zip(row, widths, strict=True)) for row in rows]
        return "\n".join(f"[ {line} ]" for line in lines)

    def row(self, row: Row) -> str:
        start = f"{'      ' if row.term else '  '}{row.left or ' '} = "
        rest = " " * (len(start) if len(start) < LINE / 3 else 10)
        first, *others = row.right.split("\n")
        line = f"{start}{first}{f'   ({row.word})' if row.word else ''}"
        whole = _WHOLE.sub(lambda found: found[0].replace(" ", "\0"), line)
        pieces = wrap(whole, LINE, subsequent_indent=rest, break_long_words=False, break_on_hyphens=False)
        return "\n".join([*pieces, *(rest + other for other in others)]).replace("\0", " ")


class Mathematics(Plain):
    """Writes them as LaTeX."""

    printer: Text = Latex()

    def name(self, text: str) -> str:
        def symbol(found: re.Match[str]) -> str:
            word = found[0]
            if word == " x ":
                return r" \times "
            if word[0] == "^":
                return f"^{{{word[1:]}}}"
            return r"\sum_{k}" if word == "sum_k" else self.printer.symbol(word)

        return re.sub(r"\)_(\w)", r")_{\1}", _TOKEN.sub(symbol, text))

    def sum(self, expression: Any) -> str:
        lines = [""]
        for term in self.printer.terms(expression):
            if len(lines[-1]) > WIDTH:
                lines.append("")
            lines[-1] += " " * bool(lines[-1]) + term
        return " \\\\\n&\\quad ".join(lines)

    def vector(self, entries: Sequence[str]) -> str:
        return self.matrix([[entry] for entry in entries])

    def matrix(self, rows: Sequence[Sequence[str]]) -> str:
        lines = [" & ".join(row) for row in rows]
        return rf"\begin{{pmatrix}} {NEXT.join(lines)} \end{{pmatrix}}"

    def row(self, row: Row) -> str:
        end = rf" \quad \text{{({row.word})}}" if row.word else ""
        return f"& \\quad {row.left} = {row.right}{end}" if row.term else f"{row.left} &= {row.right}{end}"


Plain.printer.digits = 6
STYLES = PLAIN, MATHEMATICS = Plain(), Mathematics()


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
    if sum(map(len, map(PLAIN.sum, value))) <= WIDTH:
        return [Row(style.name(name), style.vector(list(map(style.printer.sum, value))))]
    places = [f"({name})_{k}" for k in ("xyz" if len(value) == 3 else range(1, len(value) + 1))]
    if len(value) == 3 and re.fullmatch(r"\w+", name):
        places = [name + axis for axis in "xyz"]
    return [Row(style.name(place), style.sum(x)) for place, x in zip(places, value, strict=True) if x != 0]


def _formula(by_style: Iterable[Iterable[Row]], title: str = "") -> Formula:
    """Return rows of text and of LaTeX, below a title that a page unfolds if they are long."""
    lines, latex = ([style.row(row) for row in found] for style, found in zip(STYLES, by_style, strict=True))
    return Formula(tuple("\n".join(lines).split("\n")), tuple(latex), title if sum(map(len, latex)) > FOLDED else "")


def derive_sections(found: Derivation) -> Iterator[Section]:
    """Yield what is known, and the steps with their laws and equations, as text."""
    for section in _sections(found):
        blocks: list[Block] = []
        for block in section:
            blocks += map(Paragraph, wrap(block.text, WIDTH + 10)) if isinstance(block, Paragraph) else [block]
        yield blocks


def _sections(found: Derivation) -> Iterator[Section]:
    how = "in numbers" if found.numbers else "as formulas"
    yield [Paragraph(f"{found.robot}: worked solution {how}, {gravity_text(found.gravity)}, SI units")]
    head = ("", "value", "what it is")
    letters = [(letter.name, f"{letter.value:.6g}", letter.meaning) for letter in found.letters]
    for k, step in enumerate(found.steps, 1):
        yield [Heading(f"Step {k}. {step.title}"), *map(Paragraph, step.words)]
        if k == 1:
            known = [(name, meaning) for name, _, meaning in found.known]
            yield [Table("Coordinates", *((head, found.known) if found.numbers else (head[::2], known)))]
            yield [Table("Letters", head, letters)] if letters else []
            yield [Paragraph(notation(found))]
        if step.laws:
            yield _laws(step)
        if step.counts:
            titles, *cells = step.counts
            yield [Table("", titles, cells)]
        for part in step.parts:
            words = [Paragraph(text) for text in (part.title, part.words) if text]
            by_style = [[row for one in part.equations for row in rows(one, style)] for style in STYLES]
            yield [*words, _formula(by_style, part.title)] if part.equations else words


def _laws(step: Step) -> Section:
    """Return the general laws of a step."""
    general = "In general, for body i on body j" * any("_i" in law for law in step.laws)
    general += ", which carries bodies k" * any("_k" in law for law in step.laws)
    laws = [(*re.split(" = | [|] ", law), "")[:3] for law in step.laws]
    found = _formula(
        [[Row(style.name(left), style.name(right), word) for left, right, word in laws] for style in STYLES]
    )
    return [*([Paragraph(f"{general}:")] if general else []), found]


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

    def cell(text: str) -> str:
        names = text.split(", ") if _NAMES.fullmatch(text) else []
        return ", ".join(f"${MATHEMATICS.name(name)}$" for name in names) or escaped(text)

    out = ["% Needs \\usepackage{amsmath} and \\setcounter{MaxMatrixCols}{40}."]
    for block in (block for section in _sections(found) for block in section):
        if isinstance(block, Formula):
            out.append("\\begin{align*}\n" + " \\\\\n".join(block.latex) + "\n\\end{align*}")
        elif isinstance(block, Table):
            lines = [" & ".join(map(cell, row)) + r" \\" for row in (block.head, *block.rows)]
            out.append(f"\\begin{{tabular}}{{{'l' * len(block.head)}}}\n" + "\n".join(lines) + "\n\\end{tabular}")
        else:
            assert isinstance(block, (Heading, Paragraph))
            words = escaped(block.text)
            out.append(f"\\section*{{{words}}}" if isinstance(block, Heading) else words)
    return "\n\n".join(out) + "\n"


def derive_page(found: Derivation) -> Document:
    subtitle = "worked solution " + ("in numbers" if found.numbers else "as formulas")
    _, *sections = _sections(found)
    return Document(found.robot, subtitle, tuple(block for section in sections for block in section))
