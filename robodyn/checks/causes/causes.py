"""Why an inertia tensor is wrong, where exactly one cause explains it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from math import isfinite

import numpy as np

from robodyn.checks.bodies.masses import Tensor, nearest, pose
from robodyn.checks.causes.evidence import SAME, UPPER, Evidence, Symptom, apart, evidence_of
from robodyn.checks.causes.forms import FORMS, Given, Proposal
from robodyn.checks.context import Context
from robodyn.checks.mirror.pairs import Pair, pairs
from robodyn.checks.rule import Edit, Fault, Fix
from robodyn.programs.vectors import length, product
from robodyn.robot.urdf.parts import INERTIA
from robodyn.robot.urdf.view import LinkView
from robodyn.support.floats import Floats
from robodyn.support.wording import figure

_DIGITS = 12

TELLS = {
    Symptom.IMPOSSIBLE: frozenset({"RD306", "RD308", "RD310", "RD311", "RD312"}),
    Symptom.TOO_LARGE: frozenset({"RD307", "RD308", "RD309", "RD312"}),
    Symptom.NO_IMAGE: frozenset(FORMS),
}
"""The causes that a symptom tells from each other; with a twin to believe, every symptom tells all."""

ONE_SIDED = frozenset({"RD307", "RD308", "RD309"})
"""The causes of which it is plain which one of two twins is wrong."""


@dataclass(frozen=True, eq=False)
class Cause:
    """What explains a wrong tensor.

    Attributes:
        code: of the rule that documents it.
        what: what went wrong, and what shows it.
        tensor: the corrected entries; None where they cannot be told.
        fix: the edit that writes them; None likewise, and where it may as well be the twin that is wrong.
        physical: whether a body could have the tensor as it stands, so that no other rule reports it.
    """

    code: str
    what: str
    tensor: Tensor | None
    fix: Fix | None
    physical: bool


def causes(context: Context) -> Mapping[str, Cause]:
    """Return by link the cause of its wrong tensor where there is exactly one. From stage DOCUMENT on.

    A tensor is wrong if no body can have it, if it is too large for the link's shapes (where all are primitives), or if
    it is more than 10 % from the mirror image of its twin's. A cause explains it if its correction alone is physical,
    within the shapes, and within 2 % of the twin's mirror image; the twin counts only where it is physical itself. Two
    causes or two corrections that explain it explain nothing, but that a copy of the twin also has wrong signs, and
    that several orders of the entries are one cause without a correction.
    """
    twins = {pair.right.name: pair for pair in context.once(pairs)}
    found = {}
    for link in context.view.links:
        cause = _cause(context, link, twins.get(link.name))
        if cause is not None:
            found[link.name] = cause
    return found


def explained(context: Context, fault: Fault, link: LinkView) -> Fault:
    """Return the fault of a link's tensor that no body has, with its cause and the fix for it.

    Where nothing explains it, the fix is the nearest that a body can have.
    """
    cause = context.once(causes).get(link.name)
    if cause is not None:
        return replace(fault, cause=f"{cause.what} ({cause.code})", fix=cause.fix)
    given = _given(link)
    near = None if given is None else nearest(given.tensor)
    if given is None or near is None:
        return fault
    change = float(length(near - given.tensor) / length(given.tensor))
    what = f"the nearest one that a body can have, {figure(100 * change, 2)} % away"
    return replace(fault, fix=_fix(link, _entries(near, given), what))


def faults(context: Context, code: str) -> Iterator[Fault]:
    """Yield the findings of the rule of one cause: of tensors that a body could have. RD206 and RD207 report the
    others."""
    for link in context.view.links:
        cause = context.once(causes).get(link.name)
        if cause is None or cause.code != code or not cause.physical:
            continue
        assert link.inertial is not None, "it has a tensor"
        at = link.inertial.entries[_first_changed(link, cause)].span
        yield Fault(at, cause.what, _remedy(cause), fix=cause.fix)


def _remedy(cause: Cause) -> str:
    if cause.code == "RD310" and cause.tensor is None:
        return "write the entries in URDF's order, ixx ixy ixz iyy iyz izz"
    if cause.tensor is None:
        return "write its mirror image, or allow it where the same part is mounted on both sides"
    return ("write " if cause.fix else "correct its twin or write ") + " ".join(
        f'{name}="{value:.6g}"' for name, value in zip(INERTIA, cause.tensor, strict=True)
    )


def _first_changed(link: LinkView, cause: Cause) -> int:
    if cause.tensor is None or link.tensor is None:
        return 0
    return next((k for k in range(6) if cause.tensor[k] != link.tensor[k]), 0)


def _cause(context: Context, link: LinkView, twin: Pair | None) -> Cause | None:
    given = _given(link)
    if given is None:
        return None
    evidence, given = evidence_of(context, link, given, twin)
    symptom = evidence.symptom(given.tensor)
    if symptom is None:
        return None
    explained = _explained(given, evidence, symptom)
    if len(explained) > 1 and {code for code, _ in explained} == {"RD310"}:
        explained = [("RD310", Proposal(" or ".join(proposal.what for _, proposal in explained), None))]
    if len(explained) != 1:
        return None
    code, proposal = explained[0]
    tensor = None if proposal.I is None else _entries(proposal.I, given)
    what = proposal.what if tensor is None else f"{proposal.what}: {symptom.value}"
    either = symptom is Symptom.NO_IMAGE and code not in ONE_SIDED
    fix = None if either else _fix(link, tensor, proposal.what)
    return Cause(code, what, tensor, fix, symptom is not Symptom.IMPOSSIBLE)


def _explained(given: Given, evidence: Evidence, symptom: Symptom) -> list[tuple[str, Proposal]]:
    """Return the causes that explain the tensor, each with its correction."""
    possible = TELLS[symptom if evidence.image is None else Symptom.NO_IMAGE]
    explained: list[tuple[str, Proposal]] = []
    for code in sorted(possible, reverse=True):
        kept: list[Proposal] = []
        for proposal in FORMS[code](given):
            if proposal.I is None:
                if symptom is (Symptom.NO_IMAGE if code == "RD313" else Symptom.IMPOSSIBLE):
                    return [(code, proposal)]
            elif evidence.explains(proposal.I) and not any(_same(proposal, other) for other in kept):
                kept.append(proposal)
        explained += [(code, proposal) for proposal in kept]
    return explained


def _given(link: LinkView) -> Given | None:
    if link.inertial is None or link.tensor is None or not link.mass or link.mass < 0 or not any(link.tensor):
        return None
    placed = pose(link.inertial.origin)
    if placed is None or not all(map(isfinite, link.tensor)):
        return None
    return Given(link.mass, product(placed.R.T, placed.p), placed.R, link.tensor)


def _same(one: Proposal, other: Proposal) -> bool:
    return one.I is not None and other.I is not None and apart(one.I, other.I) <= SAME


def _entries(I: Floats, given: Given) -> Tensor:
    """Return the six entries to the digits that are known, and as they stand where they do not change."""
    size = float(np.abs(I).max())
    values = []
    for value, old in zip(I[UPPER].tolist(), given.entries, strict=True):
        rounded = 0.0 if abs(value) < 1e-15 * size else float(f"{value:.{_DIGITS}g}")
        values.append(old if abs(value - old) <= 1e-15 * size else rounded)
    return tuple(values)


def _fix(link: LinkView, tensor: Tensor | None, what: str) -> Fix | None:
    if tensor is None or link.tensor is None or link.inertial is None:
        return None
    entries = zip(link.inertial.entries, tensor, link.tensor, strict=True)
    edits = tuple(Edit(entry.span.start, entry.span.end, repr(new)) for entry, new, old in entries if new != old)
    return Fix(f"correct the inertia: {what}", edits, safe=False)
