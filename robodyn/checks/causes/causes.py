"""Why an inertia tensor is wrong, where exactly one cause explains it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from robodyn.checks.bodies.masses import Tensor, nearest
from robodyn.checks.bodies.weighed import given, weighed
from robodyn.checks.causes.evidence import SAME, Evidence, Symptom, apart, evidence_of, leads_away
from robodyn.checks.context import Context
from robodyn.checks.mirror.pairs import Pair, pairs
from robodyn.checks.rule import Edit, Fault, Fix
from robodyn.programs.vectors import length
from robodyn.robot.masses.slips import (
    COPIED,
    NINE,
    UPPER,
    Given,
    Slip,
    copied,
    corrections,
    nine_as_six,
    tensors,
)
from robodyn.robot.masses.weighing import Weighed
from robodyn.robot.urdf.parts import INERTIA
from robodyn.robot.urdf.view import LinkView
from robodyn.support.floats import Floats
from robodyn.support.wording import figure, one_of

_DIGITS = 12

_HIDDEN = frozenset({"RD307", "RD309", "RD313"})
"""The causes that leave a tensor possible."""
_MOST_LISTED, _MOST_NAMED = 4, 2
_ALONE = 0.8
"""Of the probability of a cause: the share of one correction that is the only one."""

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
        by_image: whether all that shows it is the mirror twin, which may as well be wrong.
    """

    code: str
    what: str
    tensor: Tensor | None
    fix: Fix | None
    physical: bool
    by_image: bool = False


def causes(context: Context) -> Mapping[str, Cause]:
    """Return by link the cause of its wrong tensor where there is exactly one. From stage DOCUMENT on.

    The link's own shapes name it (see `robodyn.robot.masses.weighing`), or else its mirror twin: the tensor is more
    than 10 % from the mirror image of the twin's, and one correction alone is possible, within the link's shapes, and
    within 2 % of that image. The twin counts only where it is possible itself, and its shapes blame nothing on it; it
    is the one that is wrong where the correction would carry the tensor away from the link's shapes. Two
    corrections that explain it explain nothing, but that a copy of the twin also has wrong signs, and that several
    orders of the entries are one cause without a correction.
    """
    twins = {pair.right.name: pair for pair in context.once(pairs)}
    found = {}
    for link in context.view.links:
        twin, wrong = twins.get(link.name), link
        cause = _cause(context, link, twin)
        if twin is not None and cause is not None and cause.by_image and leads_away(context, link, cause.tensor):
            wrong = context.view.link[twin.left.name]
            cause = _cause(context, wrong, twin.turned)
        if cause is not None:
            found[wrong.name] = cause
    return found


def explained(context: Context, fault: Fault, link: LinkView) -> Fault:
    """Return the fault of a link's tensor that no body has, with its cause and the fix for it.

    Where nothing explains it alone, it is said what may, and the fix is the nearest that a body can have, unless that
    goes beyond the link's shapes.
    """
    cause = context.once(causes).get(link.name)
    if cause is not None:
        return replace(fault, cause=f"{cause.what} ({cause.code})", fix=cause.fix)
    said = given(link)
    if said is None:
        return fault
    evidence, said = evidence_of(context, link, said, None)
    fault = replace(fault, cause=_may_be(context, link, said, evidence))
    near = nearest(said.tensor)
    if near is None or not evidence.allows(near, said.tensor):
        return fault
    change = float(length(near - said.tensor) / length(said.tensor))
    what = f"the nearest one that a body can have, {figure(100 * change, 2)} % away"
    return replace(fault, fix=_fix(link, _entries(near, said), what))


def _may_be(context: Context, link: LinkView, said: Given, evidence: Evidence) -> str | None:
    """Return what may explain a tensor that no body has: by its shapes, or else whatever makes it possible."""
    verdict = _weighed(context).get(link.name)
    if verdict is not None:
        return one_of([one.what for one in verdict.causes])
    found = [slip for slip, _ in _explained(said, evidence) if slip.code not in _HIDDEN]
    return one_of([slip.what for slip in found]) if len(found) <= _MOST_LISTED else None


def faults(context: Context, code: str) -> Iterator[Fault]:
    """Yield the findings of the rule of one cause: of tensors that a body could have. RD206 and RD207 report the
    others."""
    for link in context.view.links:
        cause = context.once(causes).get(link.name)
        if cause is None or cause.code != code or not cause.physical:
            continue
        assert link.inertial is not None, "it has a tensor"
        at = link.inertial.entries[_first_changed(link, cause)].span
        yield Fault(at, cause.what, _remedy(cause), fix=cause.fix, kind=code)


def _remedy(cause: Cause) -> str:
    if cause.code == "RD313":
        return "write its mirror image, or allow it where the same part is mounted on both sides"
    if cause.tensor is None and cause.code == "RD312":
        return "write it in the axes of the link"
    if cause.tensor is None:
        return "write the entries in URDF's order, ixx ixy ixz iyy iyz izz, about the centre of mass"
    return ("write " if cause.fix else "correct its twin or write ") + " ".join(
        f'{name}="{value:.6g}"' for name, value in zip(INERTIA, cause.tensor, strict=True)
    )


def _first_changed(link: LinkView, cause: Cause) -> int:
    if cause.tensor is None or link.tensor is None:
        return 0
    return next((k for k in range(6) if cause.tensor[k] != link.tensor[k]), 0)


def _weighed(context: Context) -> Mapping[str, Weighed]:
    return {} if context.tree_or_none is None else context.once(weighed)


def _cause(context: Context, link: LinkView, twin: Pair | None) -> Cause | None:
    said = given(link)
    if said is None:
        return None
    verdicts = _weighed(context)
    verdict = verdicts.get(link.name)
    if verdict is not None and verdict.units:
        return None
    if twin is not None and twin.left.name in verdicts and verdicts[twin.left.name].named:
        twin = None
    evidence, said = evidence_of(context, link, said, twin)
    if verdict is not None and verdict.named:
        return _by_shapes(link, said, evidence, verdict)
    symptom = evidence.symptom(said.tensor)
    if symptom is Symptom.IMPOSSIBLE and nine_as_six(said):
        return Cause("RD310", NINE, None, None, physical=False)
    if symptom is None or evidence.image is None:
        return None
    return _by_twin(link, said, evidence, symptom)


def _by_shapes(link: LinkView, said: Given, evidence: Evidence, verdict: Weighed) -> Cause:
    """Return the cause that the shapes name, with its correction if there is one only."""
    first = verdict.named[0]
    alike = [one for one in verdict.named if _same(one.I, first.I)]
    share = sum(one.probability for one in alike) / sum(one.probability for one in verdict.named)
    physical = evidence.possible(said.tensor)
    shown = (
        f"corrected, it is {_percent(first.apart)} from the inertia of the link's shapes, as it stands "
        f"{_percent(verdict.apart)}"
    )
    if share < _ALONE:
        what = " or ".join(one.what for one in verdict.named[:_MOST_NAMED])
        return Cause(first.code, f"{what}: {shown}", None, None, physical)
    tensor, what = _entries(first.I, said), f"{first.what}: {shown}"
    allowed = evidence.possible(first.I) and evidence.allows(first.I, said.tensor)
    return Cause(first.code, what, tensor, _fix(link, tensor, first.what) if allowed else None, physical)


def _percent(part: float) -> str:
    return f"{figure(round(100 * part, 2), 2)} %"


def _by_twin(link: LinkView, said: Given, evidence: Evidence, symptom: Symptom) -> Cause | None:
    """Return the cause that the mirror twin names."""
    physical = symptom is not Symptom.IMPOSSIBLE
    if physical and copied(said):
        return Cause("RD313", COPIED, None, None, physical)
    explained = _explained(said, evidence)
    if len(explained) > 1 and {slip.code for slip, _ in explained} == {"RD310"}:
        return Cause("RD310", " or ".join(slip.what for slip, _ in explained), None, None, physical)
    if len(explained) != 1:
        return None
    ((slip, I),) = explained
    tensor = _entries(I, said)
    either = physical and slip.code not in ONE_SIDED
    fix = None if either else _fix(link, tensor, slip.what)
    return Cause(slip.code, f"{slip.what}: {symptom.value}", tensor, fix, physical, physical)


def _explained(said: Given, evidence: Evidence) -> list[tuple[Slip, Floats]]:
    """Return the slips that explain the tensor, each with its correction; of one kind and correction the first."""
    kept: list[tuple[Slip, Floats]] = []
    slips, entries = corrections(said)
    for slip, I in zip(slips, tensors(entries), strict=True):
        asked = slip.common or evidence.image is not None
        if asked and evidence.explains(I) and not any(slip.code == other.code and _same(I, J) for other, J in kept):
            kept.append((slip, I))
    return kept


def _same(one: Floats, other: Floats) -> bool:
    return apart(one, other) <= SAME


def _entries(I: Floats, said: Given) -> Tensor:
    """Return the six entries to the digits that are known, and as they stand where they do not change."""
    size = float(np.abs(I).max())
    values = []
    for value, old in zip(I[UPPER].tolist(), said.entries, strict=True):
        rounded = 0.0 if abs(value) < 1e-15 * size else float(f"{value:.{_DIGITS}g}")
        values.append(old if abs(value - old) <= 1e-15 * size else rounded)
    return tuple(values)


def _fix(link: LinkView, tensor: Tensor | None, what: str) -> Fix | None:
    if tensor is None or link.tensor is None or link.inertial is None:
        return None
    entries = zip(link.inertial.entries, tensor, link.tensor, strict=True)
    edits = tuple(Edit(entry.span.start, entry.span.end, repr(new)) for entry, new, old in entries if new != old)
    return Fix(f"correct the inertia: {what}", edits, safe=False)
