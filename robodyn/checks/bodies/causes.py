"""Why an inertia tensor is wrong: what speaks against it, what it was meant to be, and the one cause of it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import floor, log10

import numpy as np

from robodyn.checks.bodies.bodies import given, weighed
from robodyn.checks.bodies.masses import Tensor, is_physical, nearest
from robodyn.checks.bodies.shapes import box_of, real_shapes, shaped, solids
from robodyn.checks.context import Context
from robodyn.checks.mirror import Pair, link_inertia, pairs
from robodyn.checks.rule import Edit, Fault, Fix
from robodyn.programs.vectors import length, product
from robodyn.robot.kinematics import Pose
from robodyn.robot.masses.inertia_mistakes import (
    COPIED,
    NINE,
    UPPER,
    Given,
    Mistake,
    copied,
    corrections,
    nine_as_six,
    tensors,
)
from robodyn.robot.masses.mistake_posterior import Cause as NamedCause
from robodyn.robot.masses.mistake_posterior import Posterior
from robodyn.robot.masses.mistake_posterior import apart as from_shapes
from robodyn.robot.urdf.parts import INERTIA
from robodyn.robot.urdf.view import LinkView
from robodyn.solids.inertia.laws import second_moments, symmetric
from robodyn.support.floats import Floats
from robodyn.support.wording import figure, one_of

DIFFERENT = 0.10
"""How far a tensor may be from its twin's mirror image before something is wrong, relative to its largest entry."""
SAME = 0.02
"""How near a correction must come to the twin's mirror image."""
_BEYOND = 1.05
"""A second moment this many times the most that the link's shapes allow is beyond them."""
_DIGITS = 12
_HIDDEN = frozenset({"RD307", "RD309", "RD313"})
"""The causes that leave a tensor possible."""
_MOST_LISTED, _MOST_NAMED = 4, 2
_ALONE = 0.8
"""Of the probability of a cause: the share of one correction that is the only one."""
_ONE_SIDED = frozenset({"RD307", "RD308", "RD309"})
"""The causes of which it is plain which one of two twins is wrong."""


@dataclass(frozen=True, eq=False)
class Evidence:
    """What a link's tensor is measured against, in the axes of the inertial: the laws of bodies, the link's shapes, and
    `image`, the mirror image of its twin's tensor, scaled to this link's mass; None without a twin to believe."""

    context: Context
    link: LinkView
    given: Given
    image: Floats | None = None

    @cached_property
    def most(self) -> Floats | None:
        """(3,) m (hi - c)(c - lo), the most that the second moments can be in the box around the link's shapes by
        Bhatia and Davis, 0 of a centre that is outside; None where a shape of it is not known."""
        turned = Pose(self.given.R.T, np.zeros(3))
        box, c = box_of(real_shapes(self.link), self.context.once(solids), turned), self.given.c
        if box is None:
            return None
        most: Floats = self.given.mass * np.maximum(box.hi - c, 0.0) * np.maximum(c - box.lo, 0.0)
        return most

    def possible(self, I: Floats) -> bool:
        """Whether a body can have a tensor, by the thresholds of RD206 and RD207."""
        return is_physical(tuple(I[UPPER].tolist()), self.context.thresholds)

    def explains(self, I: Floats) -> bool:
        """Whether nothing is left to explain about a corrected tensor."""
        mirrored = self.image is None or _apart(I, self.image) <= SAME
        return mirrored and self.possible(I) and self.allows(I)

    def allows(self, I: Floats, now: Floats | None = None) -> bool:
        """Whether mass inside the link's shapes may have a tensor; or one that goes no farther beyond them than it does
        now."""
        if self.most is None:
            return True
        most = _BEYOND * self.most if now is None else np.maximum(_BEYOND * self.most, _second(now))
        return bool((_second(I) <= most).all())


def _evidence(context: Context, link: LinkView, given: Given, twin: Pair | None) -> Evidence:
    alone = Evidence(context, link, given)
    if twin is None or twin.left.inertial is None or not twin.left.inertial.mass > 0:
        return alone
    _, I = twin.reflected(twin.left.inertial)
    if not alone.possible(I):
        return alone
    scale = given.mass / twin.left.inertial.mass
    image, copy = (product(given.R.T, tensor, given.R) for tensor in (I, link_inertia(twin.left.inertial)[1]))
    return Evidence(context, link, replace(given, copy=copy), scale * image)


def _second(I: Floats) -> Floats:
    return np.diagonal(second_moments(I))


def _apart(I: Floats, other: Floats) -> float:
    return float(np.abs(I - other).max() / max(np.abs(I).max(), np.abs(other).max()))


@dataclass(frozen=True, eq=False)
class Cause:
    """What explains a wrong tensor, with the code of the rule that documents it, the corrected entries (None where they
    cannot be told) and the edit that writes them (nor where it may as well be the twin that is wrong).

    A body could have a `physical` one, so that no other rule reports it; `by_image` is one that the twin alone shows.
    """

    code: str
    what: str
    tensor: Tensor | None
    fix: Fix | None
    physical: bool
    by_image: bool = False


def causes(context: Context) -> Mapping[str, Cause]:
    """Return by link the cause of its wrong tensor where there is exactly one. From stage DOCUMENT on.

    The link's own shapes name it (see `mistake_posterior`), or else its mirror twin: the tensor is more than 10 % from
    the mirror image of the twin's, and one correction alone is possible, within the link's shapes, and within 2 % of
    that image. The twin counts only where it is possible itself, and its shapes blame nothing on it; it is the one that
    is wrong where the correction would carry the tensor away from the link's shapes. Two corrections that explain it
    explain nothing, but that a copy of the twin also has wrong signs, and that several orders of the entries are one
    cause without a correction.
    """
    twins, found = {pair.right.name: pair for pair in context.once(pairs)}, dict[str, Cause]()
    shapes = {} if context.tree_or_none is None else context.once(shaped)
    for link in context.view.links:
        twin, wrong, said = twins.get(link.name), link, given(link)
        cause, shape = _cause(context, link, twin), shapes.get(link.name)
        if twin and said and shape and cause is not None and cause.by_image and cause.tensor is not None:
            solid = shape.solid.along(said.R)
            now, then = (from_shapes(I, said.mass, solid) for I in (said.tensor, symmetric(cause.tensor)))
            if now < then:
                wrong = context.view.link[twin.left.name]
                cause = _cause(context, wrong, twin.turned)
        if cause is not None:
            found[wrong.name] = cause
    return found


def explained(context: Context, fault: Fault, link: LinkView) -> Fault:
    """Return the fault of a link's tensor that no body has, with its cause and the fix for it; where nothing explains
    it alone, with what may, and the nearest that a body can have, unless that goes beyond the link's shapes."""
    cause = context.once(causes).get(link.name)
    if cause is not None:
        return replace(fault, cause=f"{cause.what} ({cause.code})", fix=cause.fix)
    said = given(link)
    if said is None:
        return fault
    evidence = _evidence(context, link, said, None)
    verdict = context.once(weighed).get(link.name)
    may_be: Sequence[Mistake | NamedCause] = (
        [mistake for mistake, _ in _explained(evidence) if mistake.code not in _HIDDEN]
        if verdict is None
        else verdict.causes
    )
    if verdict is not None or len(may_be) <= _MOST_LISTED:
        fault = replace(fault, cause=one_of([one.what for one in may_be]))
    near = nearest(said.tensor)
    if near is None or not evidence.allows(near, said.tensor):
        return fault
    change = float(length(near - said.tensor) / length(said.tensor))
    what = f"the nearest one that a body can have, {figure(100 * change, 2)} % away"
    known = _DIGITS - 1 - floor(log10(np.abs(near).max()))  # decimals below the largest entry's digits are rounding
    near = np.array([[round(entry, known) for entry in row] for row in near.tolist()])
    return replace(fault, fix=_fix(link, _entries(near, said), what))


def faults(context: Context, code: str) -> Iterator[Fault]:
    """Yield the findings of the rule of one cause: of tensors that a body could have. RD206 and RD207 report the
    others."""
    for link in context.view.links:
        cause = context.once(causes).get(link.name)
        if cause is None or cause.code != code or not cause.physical:
            continue
        assert link.inertial is not None, "it has a tensor"
        changed = [k for k in range(6) if cause.tensor and link.tensor and cause.tensor[k] != link.tensor[k]]
        at = link.inertial.entries[changed[0] if changed else 0].span
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


def _cause(context: Context, link: LinkView, twin: Pair | None) -> Cause | None:
    said, verdicts = given(link), context.once(weighed)
    verdict = verdicts.get(link.name)
    if said is None or (verdict is not None and verdict.units):
        return None
    if twin is not None and twin.left.name in verdicts and verdicts[twin.left.name].named:
        twin = None
    evidence = _evidence(context, link, said, twin)
    if verdict is not None and verdict.named:
        return _by_shapes(evidence, verdict)
    if not evidence.possible(said.tensor):
        if nine_as_six(said):
            return Cause("RD310", NINE, None, None, physical=False)
        return None if evidence.image is None else _by_twin(evidence, physical=False)
    if evidence.image is None or _apart(said.tensor, evidence.image) <= DIFFERENT:
        return None
    return _by_twin(evidence, physical=True)


def _by_shapes(evidence: Evidence, verdict: Posterior) -> Cause:
    link, said, first = evidence.link, evidence.given, verdict.named[0]
    alike = [one for one in verdict.named if _apart(one.I, first.I) <= SAME]
    share = sum(one.probability for one in alike) / sum(one.probability for one in verdict.named)
    physical = evidence.possible(said.tensor)
    now, then = (f"{figure(round(100 * part, 2), 2)} %" for part in (verdict.apart, first.apart))
    shown = f"corrected, it is {then} from the inertia of the link's shapes, as it stands {now}"
    if share < _ALONE:
        what = " or ".join(one.what for one in verdict.named[:_MOST_NAMED])
        return Cause(first.code, f"{what}: {shown}", None, None, physical)
    tensor, what = _entries(first.I, said), f"{first.what}: {shown}"
    allowed = evidence.possible(first.I) and evidence.allows(first.I, said.tensor)
    return Cause(first.code, what, tensor, _fix(link, tensor, first.what) if allowed else None, physical)


def _by_twin(evidence: Evidence, physical: bool) -> Cause | None:
    """Return the cause that the mirror twin names, of a tensor that a body could have (`physical`) or not."""
    if physical and copied(evidence.given):
        return Cause("RD313", COPIED, None, None, physical)
    explained = _explained(evidence)
    if len(explained) > 1 and {mistake.code for mistake, _ in explained} == {"RD310"}:
        return Cause("RD310", " or ".join(mistake.what for mistake, _ in explained), None, None, physical)
    if len(explained) != 1:
        return None
    ((mistake, I),) = explained
    tensor = _entries(I, evidence.given)
    either = physical and mistake.code not in _ONE_SIDED
    fix = None if either else _fix(evidence.link, tensor, mistake.what)
    why = "no body can have this tensor, but one can have the corrected one"
    if physical:
        why = "corrected, it is the mirror image of its twin's"
    return Cause(mistake.code, f"{mistake.what}: {why}", tensor, fix, physical, physical)


def _explained(evidence: Evidence) -> list[tuple[Mistake, Floats]]:
    """Return the mistakes that explain the tensor, each with its correction; of one kind and correction the first."""
    kept: list[tuple[Mistake, Floats]] = []
    mistakes, entries = corrections(evidence.given)
    for mistake, I in zip(mistakes, tensors(entries), strict=True):
        if (mistake.common or evidence.image is not None) and evidence.explains(I):
            again = any(mistake.code == other.code and _apart(I, J) <= SAME for other, J in kept)
            kept += [] if again else [(mistake, I)]
    return kept


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
