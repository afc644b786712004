"""Mistakes that explain an inertia: units, signs, reference point, axes, order of entries, and the one cause."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from robodyn.checks.bodies.bodies import bodies, given, shaped, weighed
from robodyn.checks.bodies.masses import Tensor, broken_law
from robodyn.checks.examples import IMAGE, SHAPED_INERTIA, a_shaped_link, inertia, two_arms
from robodyn.checks.mirror import Pair, apart, both_ways, link_inertia, pairs
from robodyn.checks.rule import ERROR, TREE, WARNING, Context, Edit, Fault, Faults, Fix, rule
from robodyn.programs.vectors import product
from robodyn.robot.masses.mistakes import COPIED, NINE, QUANTITIES, UPPER, Given, Mistake, corrections
from robodyn.robot.urdf.parts import INERTIA
from robodyn.robot.urdf.view import LinkView
from robodyn.solids.inertia.laws import symmetric
from robodyn.support.floats import Floats
from robodyn.support.wording import figure, one_of

DIFFERENT = 0.10
"""How far a tensor may be from its twin's mirror image before something is wrong, relative to its largest entry."""
SAME = 0.02  # how near a correction must come to the twin's mirror image
_BEYOND = 1.0  # a tensor that is as far from that of the link's shapes as this is large, is beyond them
_DIGITS = 12
_HIDDEN = frozenset({"RD307", "RD309", "RD313"})  # the causes that leave a tensor possible
_MOST_LISTED, _MOST_NAMED = 4, 2
_ALONE = 0.8  # of the probability of a cause: the share of one correction that is the only one
_ONE_SIDED = frozenset({"RD307", "RD308", "RD309"})  # the causes of which it is plain which one of two twins is wrong


@dataclass(frozen=True, eq=False)
class Cause:
    """What explains a wrong tensor, with the code of the rule that documents it, the corrected entries (None where they
    cannot be told) and the edit that writes them (nor where it may as well be the twin that is wrong). A body could
    have a `physical` one, so that no other rule reports it; `by_image` is one that the twin alone shows."""

    code: str
    what: str
    tensor: Tensor | None
    fix: Fix | None
    physical: bool
    by_image: bool = False


def causes(context: Context) -> Mapping[str, Cause]:
    """Return by link the cause of its wrong tensor where there is exactly one. From stage DOCUMENT on. The link's own
    shapes name it (see `mistakes`), or else its mirror twin: the tensor is more than 10 % from the mirror image of the
    twin's, and one correction alone is possible, not beyond the link's shapes, and within 2 % of that image. The twin
    counts only where it is possible itself, and its shapes blame nothing on it; it is the one that is wrong where the
    correction would carry the tensor away from the link's shapes. Two corrections explain nothing, but a copy of the
    twin has wrong signs, too, and orders of the entries are one cause."""
    twins, found = {pair.right.name: pair for pair in context.once(pairs)}, dict[str, Cause]()
    for link in context.view.links:
        twin, wrong = twins.get(link.name), link
        cause = _cause(context, link, twin)
        if twin and cause is not None and cause.by_image and cause.tensor is not None:
            now, then = (_from_shapes(context, link, I) for I in (link.tensor or (), cause.tensor))
            if now is not None and then is not None and now < then:
                wrong = context.view.link[twin.left.name]
                cause = _cause(context, wrong, twin.turned)
        if cause is not None:
            found[wrong.name] = cause
    return found


def _from_shapes(context: Context, link: LinkView, tensor: Tensor | Floats) -> float | None:
    """How far a tensor is from that of the link's shapes, relative to this; None where that is not known."""
    shape, said = context.once(shaped).get(link.name) if context.tree_or_none else None, given(link)
    if shape is None or said is None:
        return None
    I = tensor if isinstance(tensor, np.ndarray) else symmetric(tensor)
    return shape.solid.along(said.R).apart(I, said.mass)


def _allowed(context: Context, link: LinkView, I: Floats) -> bool:
    """Whether a body can have a tensor, by the thresholds of RD206 and RD207, and the link's shapes, if known."""
    away = _from_shapes(context, link, I)
    return not broken_law(tuple(I[UPPER].tolist()), context.thresholds) and (away is None or away <= _BEYOND)


def _explained(
    context: Context, link: LinkView, said: Given, image: Floats | None = None
) -> list[tuple[Mistake, Floats]]:
    """Return the mistakes whose corrections leave nothing to explain, beside the mirror image of a twin's tensor if
    there is one; of one kind and correction the first."""
    kept: list[tuple[Mistake, Floats]] = []
    for mistake, I in zip(*corrections(said), strict=True):
        fits = mistake.common if image is None else apart(I, image) <= SAME
        again = any(mistake.code == other.code and apart(I, J) <= SAME for other, J in kept)
        if fits and not again and _allowed(context, link, I):
            kept.append((mistake, I))
    return kept


def explained(context: Context, fault: Fault, link: LinkView) -> Fault:
    """Return the fault of a link's tensor that no body has, with its cause and the fix for it; where nothing explains
    it alone, with what may; where there is at most one such cause, with the tensor of its twin or its shapes."""
    cause, said, verdict = context.once(causes).get(link.name), given(link), context.once(weighed).get(link.name)
    if cause is not None:
        return replace(fault, cause=f"{cause.what} ({cause.code})", fix=cause.fix)
    if said is None:
        return fault
    alone = (one for one, _ in _explained(context, link, said) if one.code not in _HIDDEN) if verdict is None else ()
    may_be = [one.what for one in (alone if verdict is None else verdict.causes)]
    if verdict is not None or len(may_be) <= _MOST_LISTED:
        fault = replace(fault, cause=one_of(may_be))
    return fault if len(may_be) > 1 else replace(fault, fix=_of_another(context, link, said))


def _of_another(context: Context, link: LinkView, said: Given) -> Fix | None:
    """The tensor to write where it is not known what went wrong: the mirror image of the twin's or, where the one that
    stands there is farther from it than it is large, that of the link's shapes at its mass."""
    for twin in both_ways(context):
        left = twin.left.inertial
        if twin.right.name != link.name or left is None or not left.mass > 0 or twin.left.name in context.once(causes):
            continue
        image = said.mass / left.mass * product(said.R.T, twin.reflected(left)[1], said.R)
        if _allowed(context, link, image):
            return _fix(link, _entries(image, said), f"the mirror image of that of '{twin.left.name}'")
    away = _from_shapes(context, link, said.tensor)
    if away is None or away <= _BEYOND:
        return None
    uniform = context.once(shaped)[link.name].solid.along(said.R).inertia(said.mass)
    return _fix(link, _entries(uniform, said), "that of its shapes, uniform, of its mass")


def faults(context: Context, code: str) -> Iterator[Fault]:
    """Yield the findings of one cause: of tensors that a body could have, for RD206 and RD207 report the others."""
    for link in context.view.links:
        cause = context.once(causes).get(link.name)
        if link.inertial is None or cause is None or cause.code != code or not cause.physical:
            continue
        changed = [k for k in range(6) if cause.tensor and link.tensor and cause.tensor[k] != link.tensor[k]]
        if code == "RD313":
            remedy = "write its mirror image, or allow it where the same part is mounted on both sides"
        elif cause.tensor is not None:
            entries = " ".join(f'{name}="{value:.6g}"' for name, value in zip(INERTIA, cause.tensor, strict=True))
            remedy = f"{'write' if cause.fix else 'correct its twin or write'} {entries}"
        elif code == "RD312":
            remedy = "write it in the axes of the link"
        else:
            remedy = "write the entries in URDF's order, ixx ixy ixz iyy iyz izz, about the centre of mass"
        at = link.inertial.entries[changed[0] if changed else 0].span
        yield Fault(at, cause.what, remedy, fix=cause.fix, kind=code)


def _cause(context: Context, link: LinkView, twin: Pair | None) -> Cause | None:
    said, verdicts = given(link), context.once(weighed)
    verdict = verdicts.get(link.name)
    if said is None or (verdict is not None and verdict.units):
        return None
    physical = broken_law(said.entries, context.thresholds) is None
    if verdict is not None and verdict.named:
        first, code = verdict.named[0], verdict.named[0].mistake.code
        alike = [one for one in verdict.named if apart(one.I, first.I) <= SAME]
        share = sum(one.probability for one in alike) / sum(one.probability for one in verdict.named)
        now, then = (f"{figure(round(100 * part, 2), 2)} %" for part in (verdict.apart, first.apart))
        shown = f"corrected, it is {then} from the inertia of the link's shapes, as it stands {now}"
        if share < _ALONE:
            what = " or ".join(one.what for one in verdict.named[:_MOST_NAMED])
            return Cause(code, f"{what}: {shown}", None, None, physical)
        tensor, what = _entries(first.I, said), f"{first.what}: {shown}"
        fix = _fix(link, tensor, first.what) if _allowed(context, link, first.I) else None
        return Cause(code, what, tensor, fix, physical)
    if not physical and said.nine_as_six:
        return Cause("RD310", NINE, None, None, physical=False)
    blamed = twin is None or (twin.left.name in verdicts and verdicts[twin.left.name].named)
    return None if twin is None or blamed else _by_twin(context, link, said, twin, physical)


def _by_twin(context: Context, link: LinkView, said: Given, twin: Pair, physical: bool) -> Cause | None:
    left = twin.left.inertial
    if left is None or not left.mass > 0:
        return None
    reflected, copy = (product(said.R.T, I, said.R) for I in (twin.reflected(left)[1], link_inertia(left)[1]))
    image = said.mass / left.mass * reflected
    impossible = broken_law(tuple(image[UPPER].tolist()), context.thresholds)
    if impossible or (physical and apart(said.tensor, image) <= DIFFERENT):
        return None
    if physical and bool(np.abs(said.tensor - copy).max() <= 1e-6 * np.abs(copy).max()):
        return Cause("RD313", COPIED, None, None, physical)
    found = _explained(context, link, said, image)
    if len(found) > 1 and {mistake.code for mistake, _ in found} == {"RD310"}:
        return Cause("RD310", " or ".join(mistake.what for mistake, _ in found), None, None, physical)
    if len(found) != 1:
        return None
    mistake, I = found[0]
    tensor = _entries(I, said)
    fix = None if physical and mistake.code not in _ONE_SIDED else _fix(link, tensor, mistake.what)
    possible = "no body can have this tensor, but one can have the corrected one"
    why = "corrected, it is the mirror image of its twin's" if physical else possible
    return Cause(mistake.code, f"{mistake.what}: {why}", tensor, fix, physical, physical)


def _entries(I: Floats, said: Given) -> Tensor:
    """Return the six entries to the digits that are known, and as they stand where they do not change."""
    size = float(np.abs(I).max())
    values = []
    for value, old in zip(I[UPPER].tolist(), said.entries, strict=True):
        rounded = 0.0 if abs(value) < 1e-15 * size else float(f"{value:.{_DIGITS}g}")
        values.append(old if abs(value - old) <= 1e-15 * size else rounded)
    return tuple(values)


def _fix(link: LinkView, tensor: Tensor, what: str) -> Fix | None:
    if link.tensor is None or link.inertial is None:
        return None
    entries = zip(link.inertial.entries, tensor, link.tensor, strict=True)
    edits = tuple(Edit(entry.span.start, entry.span.end, repr(new)) for entry, new, old in entries if new != old)
    return Fix(f"correct the inertia: {what}", edits, safe=False)


@rule("RD305", ERROR, TREE, good=a_shaped_link(), bad=(SHAPED_INERTIA, inertia("12600 0 0 12400 0 3200")))
def unit_slip(context: Context) -> Faults:
    """Mass, inertia and centre of mass are in kg, kg m^2 and m.

    One unit, or one system of units, explains what does not fit the shapes: g, mg, lb or t for kg, mm, cm or in for m,
    and all their products for kg m^2, in one of the three quantities or in several. The link is weighed by the uniform
    solid that its own shapes are: by density, centre, size and form. A unit is named where it is nine times as probable
    as everything else together, any factor that belongs to no unit included; or else the candidates are listed in a
    warning. Tensors near a multiple of the identity and round numbers are made up, not in other units. RD301 to RD304
    are silent about such a link."""
    for name, verdict in context.once(weighed).items():
        if not verdict.units:
            continue
        body, first = context.once(bodies)[name], (verdict.named or verdict.either)[0]
        factors, wrong = first.mistake.factors, first.mistake.wrong
        assert factors is not None, "it is one of units"
        mass, xyz = body.inertial.mass, body.inertial.origin.xyz
        at = body.tensor_span if QUANTITIES[wrong[0]] == "inertia" else (mass, xyz)[wrong[0]].span
        if verdict.named:
            solid, apart = context.once(shaped)[name].solid, figure(100.0 * first.apart, 2)
            fits = f"(then {figure(first.mass / solid.volume)} kg/m^3, and an inertia {apart} % from the shapes')"
            undone = [
                f"divide the {QUANTITIES[k]} by {factors[k]:g}"
                if factors[k] > 1
                else f"multiply the {QUANTITIES[k]} by {1 / factors[k]:g}"
                for k in wrong
            ]
            what, remedy, severity = f"{first.what} {fits}", f"{' and '.join(undone)} if that is so", None
            given, edits = ([mass], [xyz], body.inertial.entries), list[Edit]()
            for each, factor in zip(given, factors, strict=True):
                for number in each if factor != 1 else ():
                    values = " ".join(repr(float(f"{value / factor:.15g}")) for value in number.values or ())
                    edits += [Edit(number.span.start, number.span.end, values)] if values else []
            fix = Fix("write kg, m and kg m^2", tuple(edits), safe=False)
        else:
            what, remedy = one_of([one.what for one in verdict.either]) or "", "see which it is, and correct it"
            severity, fix = WARNING, None
        yield Fault(at, what, remedy, factors[wrong[0]], 1.0, severity=severity, subject=body.link.subject, fix=fix)


@rule("RD306", WARNING, good=two_arms(), bad=(IMAGE, inertia("0.02 0.004 -0.002 0.03 0.003 0.025")))
def product_signs(context: Context) -> Faults:
    """Products of inertia have the sign of a matrix entry.

    URDF's ixy is an entry of the inertia matrix, minus the integral of x y dm. Many CAD programs print plus that
    integral, and then all three signs are wrong, but not the diagonal. RD206 and RD207 name the cause of tensors that
    no body has; this rule reports those that a body could have, but not this link, by its mirror twin or its shapes."""
    return faults(context, "RD306")


@rule("RD307", WARNING, good=two_arms(), bad=(IMAGE, inertia("0.105 0.006 -0.038 0.13 0.017 0.05")))
def about_origin(context: Context) -> Faults:
    """The tensor is about the centre of mass.

    URDF requires the tensor about the centre of mass, where the origin of <inertial> is. About the link's origin it is
    larger by m (|c|^2 1 - c c^T), the term of the parallel axis theorem. Such a tensor is physical, and so it takes the
    link's shapes or its mirror twin to see it: corrected, it is within 20 % of the inertia of the uniform solid that
    the shapes are, and twice as near as it stands."""
    return faults(context, "RD307")


@rule("RD308", WARNING, good=two_arms(), bad=(IMAGE, inertia("0.19 0.016 -0.078 0.23 0.037 0.075")))
def parallel_axis_again(context: Context) -> Faults:
    """The parallel axis theorem is applied once.

    A tensor that is about the centre of mass already becomes too small, and often impossible, where m (|c|^2 1 - c c^T)
    is subtracted from it, and too large where the term is added twice. That adding the term makes a tensor possible is
    no evidence: the shapes or the twin have to agree. RD206 and RD207 name it of tensors that no body has."""
    return faults(context, "RD308")


_ORIGIN = '<origin xyz="0.1 -0.05 0.2" rpy="0 0 1.5707963267948966"/>'
_TURNED = inertia("0.03 0.004 -0.003 0.02 -0.002 0.025")


@rule("RD309", WARNING, good=two_arms(right=f'{_ORIGIN}<mass value="2"/>{_TURNED}'), bad=(_TURNED, IMAGE))
def rpy_not_applied(context: Context) -> Faults:
    """The tensor is in the axes of its <origin>.

    Where <origin> in <inertial> has an rpy, the tensor is in the axes turned by it. In the link's axes it is right with
    rpy 0 only. Its principal moments tell nothing: the link's shapes or its mirror twin do."""
    return faults(context, "RD309")


@rule("RD310", WARNING, good=two_arms(), bad=(IMAGE, inertia("0.02 0.002 -0.004 0.03 -0.003 0.025")))
def entry_order(context: Context) -> Faults:
    """The entries are in URDF's order: ixx ixy ixz iyy iyz izz.

    MuJoCo's fullinertia is ixx iyy izz ixy ixz iyz, Voigt's order ixx iyy izz iyz ixz ixy, and a triangle by columns
    ixx ixy iyy ixz iyz izz; a matrix of nine entries, row by row, has iyx in fourth place. Pasting one for another
    gives a tensor that no body has, whose cause RD206 and RD207 name, or wrong products, which the twin or the shapes
    show."""
    return faults(context, "RD310")


@rule("RD311", WARNING, good=two_arms(), bad=('"-0.004"', '"-0.0004"'))
def entry_decade(context: Context) -> Faults:
    """No entry is off by a power of ten.

    A slip of the exponent in one entry. Without a twin to compare with, only a moment can be told from others, by the
    link's shapes. RD206 and RD207 name the cause of tensors that no body has; this rule reports the others."""
    return faults(context, "RD311")


@rule(
    "RD312", WARNING, good=two_arms(), bad=(IMAGE, inertia("0.03 -0.004 -0.003 0.02 0.002 0.025")), explains=("RD302",)
)
def permuted_axes(context: Context) -> Faults:
    """The tensor is in the axes of the link, not in another program's.

    Programs differ in which axis is up. A tensor with x, y and z exchanged has the right principal moments about the
    wrong axes, and a centre of mass outside the shapes is one in those axes, too (RD302). RD206 and RD207 name the
    cause of tensors that no body has; this rule reports those that a body could have, but not this link, by its mirror
    twin or its shapes."""
    return faults(context, "RD312")
