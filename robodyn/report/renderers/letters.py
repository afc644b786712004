r"""Expressions in the letters of a robot as text and as LaTeX, in the order and notation of a textbook.

Sines and cosines of sums of coordinates are s and c with the numbers of the joints: `c_23` is cos(q_2 + q_3), `s_223`
sin(2 q_2 + q_3); differences stay cos(q_1 - q_2). In text `*` multiplies and `^` is a power, `c_2^2` the square of
`c_2`. In LaTeX all that follows an underscore is an index, `I_{1xx}`; `qd_1` is \dot{q}_{1}, `w_x` \omega_{x}.
"""

from __future__ import annotations

import re
from typing import Any

_RATES = ("qd", "qdd", "w", "wd", "v", "a")
_LETTERS = ("A", "m", "l", "c", "I", "g")
_HEADS = {"qd": r"\dot{q}", "qdd": r"\ddot{q}", "w": r"\omega", "wd": r"\dot{\omega}"}
_HEADS |= {"Pd": r"\dot{P}", "Hd": r"\dot{H}", "Vd": r"\dot{V}", "tau": r"\tau", "Gamma": r"\Gamma", "Phi": r"\Phi"}


class Text:
    """Writes expressions as text; numbers with 15 digits, sines and cosines of sums of up to 6 coordinates by
    indices."""

    digits, times, indices = 15, "*", 6

    def sum(self, expression: Any) -> str:
        return " ".join(self.terms(expression))

    def terms(self, expression: Any) -> list[str]:
        """Return the terms of a sum with their signs, that of the first joined to it if it is negative: one that is
        positive leads, if there is one."""
        parts = [term.as_coeff_Mul() for term in (expression.args if expression.is_Add else [expression])]
        parts.sort(key=lambda part: _order(part[1]))
        first = next((k for k, (number, _) in enumerate(parts) if number >= 0), 0)
        parts.insert(0, parts.pop(first))
        texts = [self._product(abs(number), rest) for number, rest in parts]
        lead, *signs = ("-" if number < 0 else "+" for number, _ in parts)
        return [lead.strip("+") + texts[0], *(f"{sign} {text}" for sign, text in zip(signs, texts[1:], strict=True))]

    def _product(self, number: Any, rest: Any) -> str:
        above, below = list[str](), list[str]()
        for factor in sorted(_factors(rest), key=_rank):
            divides = factor.is_Pow and factor.exp.is_number and factor.exp < 0
            (below if divides else above).append(self._factor(1 / factor if divides else factor))
        if float(number) != 1.0 or not above:
            above.insert(0, self.number(number))
        text = self.times.join(above)
        return self.quotient(text, self.times.join(below), len(below)) if below else text

    def _factor(self, factor: Any) -> str:
        if factor.is_Number or factor.is_Symbol:
            return self.number(factor) if factor.is_Number else self.symbol(factor.name)
        if factor.is_Pow and factor.exp.is_Integer:
            return self.raised(self._factor(factor.base), str(factor.exp))
        if factor.is_Pow and 2 * factor.exp == 1:
            return self.root(self.sum(factor.base))
        if factor.is_Function:
            return self._call(factor.func.__name__, factor.args[0])
        return self.bracketed(self.sum(factor))

    def _call(self, name: str, argument: Any) -> str:
        """Return a sine or cosine with indices, if it is of a sum of few coordinates."""
        numbers = ""
        for term in argument.args if argument.is_Add else [argument]:
            many, rest = term.as_coeff_Mul()
            coordinate = re.fullmatch(r"q_(\d)", str(rest))
            if name not in ("sin", "cos") or not coordinate or not (many.is_Integer and 0 < many <= self.indices):
                break
            numbers += coordinate[1] * int(many)
        else:
            if len(numbers) <= self.indices:
                return self.indexed(name[0], "".join(sorted(numbers)))
        return self.called(name, self.sum(argument))

    def symbol(self, name: str) -> str:
        return name

    def number(self, value: Any) -> str:
        return str(int(value)) if _is_short(value) else f"{float(value):.{self.digits}g}"

    def indexed(self, letter: str, index: str) -> str:
        return f"{letter}_{index}"

    def bracketed(self, text: str) -> str:
        return f"({text})"

    def raised(self, base: str, exponent: str) -> str:
        return f"{base}^{exponent}"

    def root(self, text: str) -> str:
        return f"sqrt({text})"

    def quotient(self, above: str, below: str, factors: int) -> str:
        return f"{above}/{self.bracketed(below) if factors > 1 else below}"

    def called(self, name: str, argument: str) -> str:
        return f"{name.lower()}({argument})"


class Latex(Text):
    """Writes expressions as LaTeX; numbers with 6 digits."""

    digits, times = 6, " "

    def symbol(self, name: str) -> str:
        head, _, index = name.partition("_")
        letter = _HEADS.get(head, head)
        return self.indexed(letter, index.replace("_", ",")) if index else letter

    def number(self, value: Any) -> str:
        mantissa, _, exponent = super().number(value).partition("e")
        return rf"{mantissa} \cdot 10^{{{int(exponent)}}}" if exponent else mantissa

    def indexed(self, letter: str, index: str) -> str:
        return f"{letter}_{{{index}}}"

    def bracketed(self, text: str) -> str:
        return rf"\left({text}\right)"

    def raised(self, base: str, exponent: str) -> str:
        return f"{base}^{{{exponent}}}"

    def root(self, text: str) -> str:
        return rf"\sqrt{{{text}}}"

    def quotient(self, above: str, below: str, factors: int) -> str:
        return rf"\frac{{{above}}}{{{below}}}"

    def called(self, name: str, argument: str) -> str:
        if name == "exp":
            return f"e^{{{argument}}}"
        if name == "Abs":
            return rf"\left|{argument}\right|"
        function = r"\operatorname{sgn}" if name == "sign" else f"\\{name}"
        return rf"{function}\left({argument}\right)"


class Python(Text):
    """Writes expressions as Python with all digits."""

    indices = 0

    def number(self, value: Any) -> str:
        return str(int(value)) if _is_short(value) else repr(float(value))

    def raised(self, base: str, exponent: str) -> str:
        return f"{base}**{exponent}"


def text_of(expression: Any) -> str:
    """Return an expression as text."""
    return Text().sum(expression)


def latex_of(expression: Any) -> str:
    """Return an expression as LaTeX, in one line."""
    return Latex().sum(expression)


def _is_short(value: Any) -> bool:
    return bool(abs(value) < 1e15 and value == int(value))


def _factors(product: Any) -> list[Any]:
    return [x for x in (product.args if product.is_Mul else [product]) if x != 1]


def _rank(factor: Any) -> tuple[int, str]:
    """Where a factor stands in a product: letters, sums of these, coordinates, functions, other sums, rates."""
    base = factor.base if factor.is_Pow else factor
    if base.is_Symbol:
        head, _, index = base.name.partition("_")
        place = 5 if head in _RATES else 2 if head == "q" else 0
        letter = _LETTERS.index(head) if head in _LETTERS else len(_LETTERS)
        return place, f"{letter}{head}_{re.sub('[0-9]+', lambda digits: digits[0].zfill(6), index)}"
    if base.is_Add:
        ranks = [_rank(x) for term in base.args for x in _factors(term)]
        return 4 if max(ranks)[0] > 1 else 1, str(sorted(key for _, key in ranks))
    if base.is_Function:
        return 3, f"{'+'.join(_order(base.args[0])[1])} {base.func.__name__}"
    return 0, ""


def _order(term: Any) -> tuple[list[str], ...]:
    """Where a term stands in a sum: by rates, then by functions and coordinates, then by letters."""
    keys: tuple[list[str], ...] = ([], [], [])
    for factor in _factors(term):
        place, key = _rank(factor)
        power = factor.exp if factor.is_Pow and factor.exp.is_Integer else 1
        keys[0 if place == 5 else 1 if place > 1 else 2].extend([key] * max(int(power), 1))
    return tuple(map(sorted, keys))
