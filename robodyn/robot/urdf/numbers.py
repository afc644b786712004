"""Numbers as URDF writes them: decimal, blanks between them, whatever the locale."""

from __future__ import annotations

import unicodedata
from dataclasses import dataclass
from functools import lru_cache
from math import isfinite

from robodyn.robot.urdf.elements import Element, Span
from robodyn.support.floats import LARGEST, SMALLEST
from robodyn.support.wording import shown

TEXT = ""
"""The name that stands for the text of an element where its attributes are named."""


class NumbersError(ValueError):
    """What is wrong, and as `remedy` what to write."""

    def __init__(self, what: str, remedy: str) -> None:
        super().__init__(what)
        self.remedy = remedy


_UNBOUNDED = ("limit", "safety_controller")
"""Elements in which files write the largest float for no limit at all."""


def parse_numbers(text: str, count: int, tag: str = "") -> tuple[float, ...]:
    """Return exactly `count` finite numbers of an element with this tag, of a size that `robodyn.support.floats` has.

    What is next to nothing is 0, but of axes, which are made to unit vectors. Limits may be of any size: they are
    compared, not calculated with. What float() takes beyond URDF (`1_000`, `inf`, `nan`, digits outside ASCII) is
    refused.

    Raises:
        NumbersError: with what is wrong and what to write.
    """
    return (_parsed_before if len(text) <= _SHORT else _parsed)(text, count, tag)


def _parsed(text: str, count: int, tag: str) -> tuple[float, ...]:
    words = text.split()
    try:
        numbers = tuple(map(float, words))
    except ValueError:
        raise _not_numbers(text) from None
    if "_" in text or not text.isascii():
        raise _not_numbers(text)
    if len(numbers) != count:
        wanted = "one number" if count == 1 else f"{count} numbers with blanks between them"
        raise NumbersError(f"has {len(numbers)} numbers, not {count}: {shown(text)}", f"write {wanted}")
    for number in numbers:
        if not isfinite(number):
            raise NumbersError(f"is not finite: {shown(text)}", "write a finite number")
        if abs(number) > LARGEST and tag not in _UNBOUNDED:
            raise NumbersError(f"is too large: {shown(text)}", f"nothing of a robot exceeds {LARGEST:g} in SI units")
    return tuple(number if abs(number) >= SMALLEST or not number or tag == "axis" else 0.0 for number in numbers)


_SHORT = 80
_parsed_before = lru_cache(maxsize=1 << 14)(_parsed)
"""For short texts: rules and strict reading ask for the same, and most of a description is "0 0 0" and the like."""


def _not_numbers(text: str) -> NumbersError:
    strange = next((character for character in text if not character.isascii()), None)
    if strange is not None:
        name = f"{unicodedata.name(strange, 'a character').lower()} (U+{ord(strange):04X})"
        better = "a hyphen for minus" if strange in "\u2212\u2013" else "ASCII"
        better = "a plain blank" if strange.isspace() else better
        article = "an" if name[0] in "aeiou" else "a"
        return NumbersError(f"has {article} {name}: {shown(text)}", f"write {better} in its place")
    if "," in text:
        return NumbersError(f"has a comma: {shown(text)}", "separate numbers with blanks and write a decimal point")
    return NumbersError(f"is not a number: {shown(text)}", "write a decimal number such as -1.5e-3")


@dataclass(slots=True, eq=False)
class Numbers:
    """The numbers of one attribute, or what is wrong with them: `values` is None where it is absent or has a `problem`.

    `element` is None where that of the attribute is absent, too.
    """

    element: Element | None
    attribute: str
    given: bool
    values: tuple[float, ...] | None = None
    problem: NumbersError | None = None

    @property
    def value(self) -> float | None:
        """The first number, which of most attributes is the only one."""
        return None if self.values is None else self.values[0]

    @property
    def span(self) -> Span:
        """What stands between the quotes; of an absent attribute the element's start tag."""
        assert self.element is not None, "a number without an element has no place"
        return value_span(self.element, self.attribute)

    def or_default(self, *default: float) -> tuple[float, ...] | None:
        """Return the values; the default where the attribute is absent; None where it cannot be read."""
        return self.values if self.given else default


def numbers(element: Element | None, attribute: str, count: int) -> Numbers:
    """Return the numbers of an attribute, or of the element's `TEXT`, with what is wrong with them as data."""
    text = None if element is None else element.text if attribute == TEXT else element.values.get(attribute)
    if element is None or text is None:
        return Numbers(element, attribute, False)
    try:
        return Numbers(element, attribute, True, parse_numbers(text, count, element.tag))
    except NumbersError as error:
        return Numbers(element, attribute, True, None, error)


def value_span(element: Element, attribute: str) -> Span:
    """Return what stands between the quotes of an attribute; the start tag where it is absent."""
    found = element.attributes.get(attribute)
    return element.span if found is None else found.value_span
