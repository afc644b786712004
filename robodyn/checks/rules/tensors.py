"""Inertia tensors by themselves: physical, and no stand-ins."""

from __future__ import annotations

from math import isclose, log10

from robodyn.checks.bodies.bodies import given
from robodyn.checks.bodies.masses import (
    POINT,
    gyration,
    is_a_point,
    principal_moments,
    severity_of_zero,
    tensors,
    trace,
    widest,
)
from robodyn.checks.bodies.shapes import shaped
from robodyn.checks.examples import INERTIA, inertia, longer_arm, one_link
from robodyn.checks.mirror import pairs
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.checks.rules.inertia_mistakes import explained
from robodyn.robot.urdf.view import LinkView
from robodyn.support.wording import figure


@rule(
    "RD204",
    Severity.ERROR,
    good=longer_arm(),
    bad=longer_arm(inertial='<mass value="1"/>' + inertia("0 0 0 0 0 0")),
    explains=("RD402", "RD901"),
)
def zero_tensor(context: Context) -> Faults:
    """What has mass has moments of inertia.

    Only a point has none. Simulators refuse such a body or put in a number of their own. It is a remark where
    heavier links are fixed to this one, and a warning for the base, which most often stands still.
    """
    for link in context.view.links:
        if link.inertial is None or not link.mass or link.mass < 0 or not is_a_point(link):
            continue
        what = f"a mass of {link.mass:g} kg has no moments of inertia: it would be a point"
        remedy = "write the inertia of the part; robodyn inertia computes it from its mesh"
        yield Fault(link.inertial.entries[0].span, what, remedy, measured=0.0, severity=_of_zero(context, link))


def _of_zero(context: Context, link: LinkView) -> Severity:
    """A remark where heavier links are fixed to it and give the body an inertia, or there is no tree that tells."""
    if context.tree_or_none is None:
        return Severity.NOTE
    group = context.tree_or_none.group[link.name]
    if group.mass is None or link.mass is None:
        return Severity.ERROR
    if group.mass > 2 * link.mass and (gyration(context, group) or 0.0) > POINT:
        return Severity.NOTE
    return Severity.ERROR if group.joint is not None else Severity.WARNING


@rule("RD205", Severity.WARNING, good=longer_arm("tip", "flange", inside="", kind="fixed"), bad=('"1"', '"0"'))
def tensor_without_mass(context: Context) -> Faults:
    """What has no mass has no moments of inertia.

    A moment of inertia is mass times distance squared. The zero is often a mass that was rounded away, or a
    placeholder that was forgotten. A body that moves without any mass is RD201's.
    """
    for link in context.view.links:
        if link.inertial is None or link.mass != 0 or link.tensor is None or not any(link.tensor):
            continue
        if severity_of_zero(context, link) is not Severity.ERROR:
            what = f"the mass is 0, and the moments of inertia add up to {trace(link.tensor):g} kg m^2"
            remedy = "write the mass of the part, or zeros for its inertia"
            yield Fault(link.inertial.mass.span, what, remedy, trace(link.tensor), 0.0)


@rule(
    "RD206", Severity.ERROR, good=one_link(), bad=('"0.01"', '"-0.01"'), explains=("RD301", "RD303", "RD402", "RD901")
)
def not_positive_definite(context: Context) -> Faults:
    """The inertia matrix is positive definite.

    A principal moment of inertia is a sum of mass times distance squared. With one that is zero or negative simulations
    gain energy from nothing. The principal moments are the eigenvalues of the matrix: large products make one negative
    although the diagonal is positive. Where no cause explains the tensor, the unsafe fix is the nearest that a body can
    have. Traversaro, Brossette, Escande, Nori, Identification of fully physical consistent inertial parameters (IROS
    2016).
    """
    bound = context.thresholds.positive_definite
    for link, inertial, tensor in tensors(context):
        small, middle, large = principal_moments(tensor)
        if small > bound * large:
            continue
        what = (
            "the inertia matrix is not positive definite: its principal moments are "
            f"{small:.6g}, {middle:.6g}, {large:.6g} kg m^2"
        )
        remedy = "every principal moment of a body is positive; write its inertia about the centre of mass"
        fault = Fault(inertial.entries[widest(tensor)].span, what, remedy, small, bound * large)
        yield explained(context, fault, link)


@rule(
    "RD207",
    Severity.ERROR,
    good=one_link(),
    bad=('izz="0.02"', 'izz="0.05"'),
    explains=("RD301", "RD303", "RD402", "RD901"),
)
def triangle_inequality(context: Context) -> Faults:
    """The largest principal moment is no greater than the sum of the other two.

    I_1 + I_2 - I_3 is twice the second moment of the mass along the third axis, a sum of mass times distance squared,
    and so never negative. The law holds for the principal moments, in every axes; the diagonal says too little. Where
    no cause explains the tensor, the unsafe fix is the nearest that a body can have. Wensing, Kim, Slotine, Linear
    matrix inequalities for physically consistent inertial parameter identification (RA-L 2018).
    """
    limits = context.thresholds
    for link, inertial, tensor in tensors(context):
        small, middle, large = principal_moments(tensor)
        if small <= limits.positive_definite * large or small + middle >= (1 - limits.triangle) * large:
            continue
        diagonal = {k: tensor[k] for k in (0, 3, 5)}
        largest = max(diagonal, key=lambda k: diagonal[k])
        lack = figure(100 - 100 * (small + middle) / large, 2)
        what = (
            f"no body has the principal moments {small:.6g}, {middle:.6g}, {large:.6g} kg m^2: the two smaller "
            f"add up to {small + middle:.6g}, {lack} % less than the largest"
        )
        remedy = "the largest may not exceed the sum of the others; robodyn inertia computes them from a mesh"
        fault = Fault(inertial.entries[largest].span, what, remedy, large, small + middle)
        yield explained(context, fault, link)


_FRACTION = 0.01
"""Of the mass of its rigid group; a placeholder on less than this is a remark."""

_NEAR = 0.05


@rule(
    "RD208",
    Severity.WARNING,
    good=one_link(),
    bad=(INERTIA, inertia("1 0 0 1 0 1")),
    explains=("RD206", "RD207", "RD301", "RD303", "RD402"),
)
def placeholder_tensor(context: Context) -> Faults:
    """The inertia is that of the part, not a stand-in.

    The identity matrix, a power of ten times it, six equal entries, and numbers copied from a link of another mass are
    stand-ins; of left and right RD401 judges the masses. An inertia of 1 kg m^2 is that of a solid ball of 2 kg with a
    radius of 1.1 m. Numbers within 5 % of the inertia of the link's own shapes are no stand-in.
    """
    first_with: dict[tuple[float, ...], LinkView] = {}
    mirrored = {frozenset((pair.left.name, pair.right.name)) for pair in context.once(pairs)}
    for link, inertial, tensor in tensors(context):
        if not link.mass:
            continue
        twin = first_with.setdefault(tensor, link)
        pattern = _pattern(tensor)
        unlike = twin.mass and not isclose(twin.mass, link.mass, rel_tol=0.1)
        if pattern is None and twin.mass and unlike and frozenset((link.name, twin.name)) not in mirrored:
            pattern = (
                f"the same six numbers as link '{twin.name}', whose mass is {twin.mass:g} kg and not {link.mass:g}"
            )
        said, shape = given(link), context.once(shaped).get(link.name)
        own = said and shape and shape.solid.along(said.R).apart(said.tensor, said.mass) <= _NEAR
        if pattern is not None and not own:
            tree, what = context.tree_or_none, f"the inertia looks like a placeholder: {pattern}"
            whole = None if tree is None else tree.group[link.name].mass
            small = tree is None or (whole and link.mass < _FRACTION * whole)
            remedy = "write the inertia of the part; robodyn inertia computes it from its mesh"
            severity = Severity.NOTE if small else Severity.WARNING
            yield Fault(inertial.entries[0].span, what, remedy, tensor[0], severity=severity)


def _pattern(tensor: tuple[float, ...]) -> str | None:
    xx, xy, xz, yy, yz, zz = tensor
    if len(set(tensor)) == 1:
        return f"six times {xx:g}"
    if any((xy, xz, yz)) or not xx == yy == zz or xx < 0:
        return None
    power = log10(xx)
    if power == 0:
        return "the identity matrix, 1 kg m^2 three times"
    return f"{xx:g} times the identity" if isclose(power, round(power), abs_tol=1e-12) else None
