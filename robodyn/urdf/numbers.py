"""Numbers as URDF writes them: decimal, blanks between them, whatever the locale."""

from __future__ import annotations

from math import isfinite

from robodyn.wording import shown


class NumbersError(ValueError):
    """What is wrong, and as `remedy` what to write."""

    def __init__(self, what: str, remedy: str) -> None:
        super().__init__(what)
        self.remedy = remedy


def parse_numbers(text: str, count: int) -> tuple[float, ...]:
    """Exactly `count` finite numbers.

    Python's float() is locale-proof and correctly rounded; what it takes beyond URDF (`1_000`, `inf`, `nan`, digits
    and blanks outside ASCII) is refused.

    Raises:
        NumbersError: with what is wrong and what to write.
    """
    try:
        numbers = tuple(map(float, text.split()))
    except ValueError:
        raise _not_numbers(text) from None
    if "_" in text or not text.isascii():
        raise _not_numbers(text)
    if len(numbers) != count:
        raise NumbersError(f"has {len(numbers)} numbers, not {count}: {shown(text)}", f"write {_numerals(count)}")
    for number in numbers:
        if not isfinite(number):
            raise NumbersError(f"is not finite: {shown(text)}", "write a finite number")
    return numbers


def _not_numbers(text: str) -> NumbersError:
    if "," in text:
        return NumbersError(f"has a comma: {shown(text)}", "separate numbers with blanks and write a decimal point")
    return NumbersError(f"is not a number: {shown(text)}", "write a decimal number such as -1.5e-3")


def _numerals(count: int) -> str:
    return "one number" if count == 1 else f"{count} numbers with blanks between them"
