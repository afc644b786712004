"""Make the fixes that rules propose, until nothing is left to fix; prove that safe ones leave the dynamics alone."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import pairwise

from robodyn.checks.rule import Edit, Finding, Fix, Severity
from robodyn.errors import InputError
from robodyn.robot.urdf.document import read
from robodyn.robot.urdf.edits import edited

ROUNDS = 20
"""Each makes the fixes that do not touch one another; more than a few mean that two rules undo each other's work."""

Check = Callable[[bytes], tuple[Finding, ...]]
Pairs = list[tuple[Finding, Fix]]
STATES = 16
SAME = 64 * 2.0**-52  # of the largest torque: what rounding may make of the same dynamics


def together(findings: Iterable[Finding], safe: bool) -> Pairs:
    """Return fixes that do not touch each other, the earlier in the text first, then the lower code; each whole or
    not."""

    def touch(a: Edit, b: Edit) -> bool:
        if a.start == a.end or b.start == b.end:  # at a border of the other nothing is inserted, either
            return a.start <= b.end and b.start <= a.end
        return a.start < b.end and b.start < a.end

    offered = [(finding, finding.fix) for finding in findings if finding.fix is not None and finding.fix.safe is safe]
    offered.sort(key=lambda pair: (min(edit.start for edit in pair[1].edits), pair[0].code, pair[0].start))
    chosen, taken = Pairs(), list[Edit]()
    for finding, fix in offered:
        edits = sorted(fix.edits, key=lambda edit: edit.start)
        others = [(edit, other) for edit in edits for other in taken]
        if not any(touch(*both) for both in (*pairwise(edits), *others)):
            chosen.append((finding, fix))
            taken += edits
    return chosen


@dataclass(frozen=True)
class Made:
    """A fix that was made; `change` of an unsafe one is what all of its round changed (see `change_of_dynamics`)."""

    finding: Finding
    fix: Fix
    change: float | None = None

    @property
    def effect(self) -> str:
        if self.fix.safe:
            return "safe: the dynamics stay as they are"
        if self.change is None:
            return "unsafe: by how much the torques change cannot be computed"
        return f"unsafe: torques change by up to {100 * self.change:.3g} % of the largest"


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
    """Return the text with its fixes made: bytes that no fix names stay as they are. Safe fixes come first, proven to
    leave the dynamics alone by inverse dynamics before and after, all together or else each by itself; one without
    proof is not made. Unsafe ones follow, if wanted, but of inertias those after which the link has another error or
    warning, and it is computed what they change. Then `check` looks at the text again, until nothing is left."""

    def unchanged(offered: Iterable[tuple[Finding, Fix]], why: str) -> Fixed:
        return Fixed(file, data, data, (), tuple(Refused(finding, fix, why) for finding, fix in offered))

    reading = read(data, file)
    if reading.data != data:
        offered = ((finding, finding.fix) for finding in check(data) if finding.fix is not None)
        return unchanged(offered, "the file is UTF-16; save it as UTF-8 first")
    text, made = data, list[Made]()
    for _ in range(ROUNDS):
        findings, before = check(text), text
        text, safe, refused = _safely(text, together(findings, True), reading.encoding)
        made += safe
        if unsafe and text == before:
            unsafely, others = healing(text, findings, check, reading.encoding)
            refused += others
            text = _edited(text, [(one.finding, one.fix) for one in unsafely], reading.encoding)
            made += unsafely
        if text == before:
            return Fixed(file, data, text, tuple(made), tuple(refused))
    return unchanged(((one.finding, one.fix) for one in made), f"the fixes do not settle in {ROUNDS} rounds")


def _safely(text: bytes, pairs: Pairs, encoding: str) -> tuple[bytes, list[Made], list[Refused]]:
    after = _edited(text, pairs, encoding)
    if not pairs or unproven(text, after) is None:
        return after, [Made(*pair) for pair in pairs], []
    proven, refused = Pairs(), list[Refused]()
    for pair in pairs:
        why = unproven(text, _edited(text, [*proven, pair], encoding))
        if why is None:
            proven.append(pair)
        else:
            refused.append(Refused(*pair, why))
    return _edited(text, proven, encoding), [Made(*pair) for pair in proven], refused


def healing(text: bytes, findings: Iterable[Finding], check: Check, encoding: str) -> tuple[list[Made], list[Refused]]:
    """Return the unsafe fixes that may be made together, and what they change; and those of masses and inertias after
    which the link has an error or a warning."""
    pairs, kept, refused = together(findings, False), Pairs(), list[Refused]()
    after = check(_edited(text, pairs, encoding)) if pairs else ()
    left = {one.subject: one for one in after if one.severity is not Severity.NOTE}
    for finding, fix in pairs:
        worst = left.get(finding.subject) if finding.code.startswith(("RD2", "RD3")) else None
        if worst is None:
            kept.append((finding, fix))
        else:
            refused.append(Refused(finding, fix, f"it would leave {worst.code}: {worst.what}"))
    try:
        change = change_of_dynamics(text, _edited(text, kept, encoding)) if kept else None
    except InputError:
        change = None
    return [Made(*pair, change) for pair in kept], refused


def _edited(text: bytes, pairs: Pairs, encoding: str) -> bytes:
    return edited(text, [edit for _, fix in pairs for edit in fix.edits], encoding)


def change_of_dynamics(before: bytes, after: bytes) -> float:
    """Return max |tau' - tau| / max |tau| of inverse dynamics in random states; infinity of other coordinates. The base
    is free, so that its inertia counts; states are normal with variance 1, the same for both. InputError where a text
    cannot be loaded. Accuracy: below `SAME` where only rounding differs."""
    import numpy as np

    from robodyn.dynamics.inverse import inverse_dynamics
    from robodyn.robot.load import load

    old, new = load(before, moving_base=True), load(after, moving_base=True)
    if (old.rates, old.nq) != (new.rates, new.nq):
        return math.inf
    random = np.random.default_rng(0)
    q, qd, qdd = (random.standard_normal((STATES, count)) for count in (old.nq, old.n, old.n))
    torques = [inverse_dynamics(model, q, qd, qdd, executor="numpy") for model in (old, new)]
    largest, change = np.max(np.abs(torques[0])), np.max(np.abs(torques[1] - torques[0]))
    if change == 0:
        return 0.0
    ratio = float(change / largest) if largest > 0 else math.inf
    return ratio if math.isfinite(ratio) else math.inf


def unproven(before: bytes, after: bytes) -> str | None:
    """Return why it is not shown that both describe the same dynamics; None where it is."""
    try:
        change = change_of_dynamics(before, after)
    except InputError as error:
        return f"the dynamics cannot be computed: {error.what}"
    return None if change <= SAME else f"it changes the dynamics by {change:.2g} of the largest torque"
