"""Making the fixes that rules propose, until nothing is left to fix."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from robodyn.checks.edits import edited, together
from robodyn.checks.proof import change_of_dynamics, unproven
from robodyn.checks.reading import read
from robodyn.checks.rule import Finding, Fix
from robodyn.errors import InputError

ROUNDS = 20
"""Each makes the fixes that do not touch one another; more than a few mean that two rules undo each other's work."""

Check = Callable[[bytes], tuple[Finding, ...]]
Pairs = list[tuple[Finding, Fix]]


@dataclass(frozen=True)
class Made:
    """A fix that was made; `change` of an unsafe one is what all of its round changed (see `change_of_dynamics`)."""

    finding: Finding
    fix: Fix
    change: float | None = None


@dataclass(frozen=True)
class Refused:
    """A fix that was offered and not made, and why."""

    finding: Finding
    fix: Fix
    why: str


@dataclass(frozen=True)
class Fixed:
    """A text before and after its fixes."""

    file: str
    before: bytes
    after: bytes
    made: tuple[Made, ...] = ()
    refused: tuple[Refused, ...] = ()


def fixed(data: bytes, file: str, check: Check, *, unsafe: bool = False) -> Fixed:
    """The text with its fixes made: bytes that no fix names stay as they are.

    Safe fixes come first. Each round's are proven to leave the dynamics alone by computing inverse dynamics before and
    after; where the proof fails for all together each is tried by itself, and one without proof is not made. Unsafe
    ones follow, if wanted, and it is computed what they change. Then the text is checked again, until it offers no
    more. The result has nothing left to fix that could be fixed: fixing it again changes nothing.

    Args:
        data: the bytes of the file.
        check: finds the faults in such bytes.
        unsafe: make fixes that change the dynamics, too.
    """
    text, made = data, list[Made]()
    reading = read(data, file)
    encoding = reading.encoding
    if reading.data != data:
        why = "the file is UTF-16; save it as UTF-8 first"
        offered = ((finding, finding.fix) for finding in check(data) if finding.fix is not None)
        return Fixed(file, data, data, (), tuple(Refused(finding, fix, why) for finding, fix in offered))
    for _ in range(ROUNDS):
        findings = check(text)
        text_before = text
        text, safe, refused = _safely(text, together(findings, True), encoding)
        made += safe
        if unsafe and text == text_before:
            text, more = _boldly(text, together(findings, False), encoding)
            made += more
        if text == text_before:
            return Fixed(file, data, text, tuple(made), tuple(refused))
    why = f"the fixes do not settle in {ROUNDS} rounds"
    return Fixed(file, data, data, (), tuple(Refused(one.finding, one.fix, why) for one in made))


def _safely(text: bytes, pairs: Pairs, encoding: str) -> tuple[bytes, list[Made], list[Refused]]:
    """The text with those fixes made that are proven to leave the dynamics alone."""
    after = edited(text, (fix for _, fix in pairs), encoding)
    if not pairs or unproven(text, after) is None:
        return after, [Made(*pair) for pair in pairs], []
    made, refused = list[Made](), list[Refused]()
    after = text
    for finding, fix in pairs:
        candidate = edited(text, [*(one.fix for one in made), fix], encoding)
        why = unproven(text, candidate)
        if why is None:
            after = candidate
            made.append(Made(finding, fix))
        else:
            refused.append(Refused(finding, fix, why))
    return after, made, refused


def _boldly(text: bytes, pairs: Pairs, encoding: str) -> tuple[bytes, list[Made]]:
    after = edited(text, (fix for _, fix in pairs), encoding)
    try:
        change = change_of_dynamics(text, after) if pairs else None
    except InputError:
        change = None
    return after, [Made(finding, fix, change) for finding, fix in pairs]
