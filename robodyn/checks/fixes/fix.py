"""Make the fixes that rules propose, until nothing is left to fix."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import pairwise

from robodyn.checks.fixes.proof import change_of_dynamics, unproven
from robodyn.checks.rule import Edit, Finding, Fix
from robodyn.errors import InputError
from robodyn.robot.urdf.document import read


def together(findings: Iterable[Finding], safe: bool) -> list[tuple[Finding, Fix]]:
    """Return fixes of one kind that do not touch each other: the earlier in the text first, then the lower code.

    A fix is taken with all its edits or not at all.
    """
    offered = [(finding, finding.fix) for finding in findings if finding.fix is not None and finding.fix.safe is safe]
    offered.sort(key=lambda pair: (min(edit.start for edit in pair[1].edits), pair[0].code, pair[0].start))
    chosen: list[tuple[Finding, Fix]] = []
    taken: list[Edit] = []
    for finding, fix in offered:
        edits = sorted(fix.edits, key=lambda edit: edit.start)
        alone = not any(_touch(a, b) for a, b in pairwise(edits))
        if alone and not any(_touch(edit, other) for edit in edits for other in taken):
            chosen.append((finding, fix))
            taken += edits
    return chosen


def edited(data: bytes, fixes: Iterable[Fix], encoding: str) -> bytes:
    """Return the text with the edits made; what the encoding lacks is written as a character reference."""
    parts, place = [], 0
    for edit in sorted((edit for fix in fixes for edit in fix.edits), key=lambda edit: edit.start):
        parts += [data[place : edit.start], edit.text.encode(encoding, "xmlcharrefreplace")]
        place = edit.end
    return b"".join([*parts, data[place:]])


def _touch(a: Edit, b: Edit) -> bool:
    """Return whether they overlap, or one inserts at a border of the other."""
    if a.start == a.end or b.start == b.end:
        return a.start <= b.end and b.start <= a.end
    return a.start < b.end and b.start < a.end


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
    """Return the text with its fixes made: bytes that no fix names stay as they are.

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
            text, more = apply_unsafe_fixes(text, together(findings, False), encoding)
            made += more
        if text == text_before:
            return Fixed(file, data, text, tuple(made), tuple(refused))
    why = f"the fixes do not settle in {ROUNDS} rounds"
    return Fixed(file, data, data, (), tuple(Refused(one.finding, one.fix, why) for one in made))


def _safely(text: bytes, pairs: Pairs, encoding: str) -> tuple[bytes, list[Made], list[Refused]]:
    """Return the text with those fixes made that are proven to leave the dynamics alone."""
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


def apply_unsafe_fixes(text: bytes, pairs: Pairs, encoding: str) -> tuple[bytes, list[Made]]:
    after = edited(text, (fix for _, fix in pairs), encoding)
    try:
        change = change_of_dynamics(text, after) if pairs else None
    except InputError:
        change = None
    return after, [Made(finding, fix, change) for finding, fix in pairs]
