"""Inertia, centre of mass and density against the shapes of the link."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np

from robodyn.checks.bodies.bodies import (
    Body,
    around_known,
    box_of,
    judged,
    outside,
    real_shapes,
    shaped,
    size_of,
    solids,
    suspected,
    weighed,
)
from robodyn.checks.bodies.masses import broken_law, is_a_point, link_poses, principal_moments
from robodyn.checks.examples import SHAPED_INERTIA, a_shaped_link, inertia
from robodyn.checks.mirror import twins
from robodyn.checks.rule import ERROR, NOTE, TREE, WARNING, Context, Fault, Faults, Severity, rule
from robodyn.programs.vectors import length, product
from robodyn.robot.masses.mistakes import Uniform
from robodyn.solids.inertia.laws import inertia_matrix
from robodyn.solids.inertia.validity import Box
from robodyn.support.floats import Floats, first_largest
from robodyn.support.linear import eigen
from robodyn.support.wording import figure, one_of

FAR = 4.0  # times the bound that are an error
_SLIGHT = 1.1
_EDGE = 1e-3  # of the squared side of a box: a centre of mass this near a face may as well be in the middle
_ADVICE = "check the unit (kg m^2) and the point (the centre of mass) of the inertia, and the mass"


@rule("RD301", ERROR, TREE, good=a_shaped_link(), bad=(SHAPED_INERTIA, inertia("0.3 0 0 0.32 0 0.28")))
def inertia_beyond_shapes(context: Context) -> Faults:
    """The second moments are no larger than the link's shapes allow for its mass.

    Whatever the density, mass within a distance r of its centre has second moments with a trace of at most m r^2; and
    along an axis on which the shapes reach from lo to hi at most m (hi - c)(c - lo) (Bhatia and Davis). The shapes are
    those of all links that fixed joints join, each in its box. A trace above its bound is a warning, above four times
    its bound an error, unless it is the root's; above four times what the link's own shapes allow a warning. The second
    bound is a remark, and a warning where it is exceeded four times wherever the centre is. Links of less than 1 % of
    the mass that they are fixed to are passed over."""
    for body in judged(context):
        fault = None if body.S is None else _beyond_reach(body, body.S) or _beyond_box(body)
        if fault is not None:
            stands = context.tree.group[body.link.name].joint is None and fault.severity is ERROR
            severity = WARNING if stands else fault.severity
            yield replace(fault, cause=suspected(context, body), severity=severity)


def _beyond_reach(body: Body, S: Floats) -> Fault | None:
    """tr(S) > m r^2, r being the distance from the centre of mass to the farthest corner."""
    if body.box is None:
        return None
    spread = float(np.trace(S)) / body.mass
    own = _reach(body.box, body.c)
    group = own if body.group is None else _reach(body.group, body.in_group[0])
    if spread <= group and spread <= FAR * own:
        return None
    bound, which = (group, "its rigid group") if spread > group else (own, "the link")
    what = f"its inertia is that of mass {spread**0.5:.3g} m from its centre (root mean square), but the shapes of "
    many = figure(spread / bound)
    what += f"{which} reach {bound**0.5:.3g} m from there: {many} times the second moment that is possible"
    return _fault(body, ERROR if spread > FAR * group else WARNING, what, spread, bound)


def _beyond_box(body: Body) -> Fault | None:
    """S_ii / m > (hi_i - c_i)(c_i - lo_i), with the box of the rigid group."""
    c, S = body.in_group
    if S is None or body.group is None:
        return None
    sides = body.group.hi - body.group.lo
    bound = (body.group.hi - c) * (c - body.group.lo)
    if not (bound > -_EDGE * sides**2).all():
        return None
    bound = np.where(bound > _EDGE * sides**2, bound, sides**2 / 4)
    spread = np.diagonal(S) / body.mass
    axis = first_largest(spread / bound)
    ratio = float(spread[axis] / bound[axis])
    if ratio <= _SLIGHT:
        return None
    severity = WARNING if ratio > FAR and spread[axis] > sides[axis] ** 2 / 4 else NOTE
    what = f"along {'xyz'[axis]} its inertia needs {figure(ratio)} times the second moment that any mass in the box"
    what += " around the shapes can have"
    return _fault(body, severity, what, float(spread[axis]), float(bound[axis]))


def _reach(box: Box, c: Floats) -> float:
    return float((np.maximum(box.hi - c, c - box.lo) ** 2).sum())


def _fault(body: Body, severity: Severity, what: str, *spread: float) -> Fault:
    measured, bound = (each * body.mass for each in spread)
    return Fault(body.tensor_span, what, _ADVICE, measured, bound, severity=severity, kind="beyond the shapes")


_OFF = 0.1  # of the size of the box: as little may be a part that is not drawn
_NEAR = 0.3  # of its distance from the middle of the shapes: as far from it a centre may be whose sign was wrong


@rule("RD302", WARNING, TREE, good=a_shaped_link(), bad=('"0 0 0.12"', '"0 0 0.5"'))
def centre_outside_shapes(context: Context) -> Faults:
    """The centre of mass lies within the shapes of the link and what is fixed to it.

    The centre of mass of a body is inside its convex hull, and so in the box around all shapes of its rigid group along
    the axes of the group's first link. Up to a tenth of the box's diagonal outside is passed over, for parts that are
    not drawn; beyond one diagonal it is an error, unless the group is the root's. Where the mesh of a shape is not
    known the group is not judged. Where one coordinate with the other sign is in the middle of the link's own shapes,
    that is said; where its mirror twin tells where the centre is, RD403 does."""
    images = {one.link.name: one.c for one in context.once(twins) if one.shift > one.most_shift}
    for body in judged(context, tensors=False):
        if body.group is None:
            continue
        away, size = outside(body.group, body.in_group[0]), size_of(body.group)
        if away <= _OFF * size:
            continue
        moves = context.tree.group[body.link.name].joint is not None
        origin = body.inertial.origin
        severity = ERROR if away > size and moves else WARNING
        image = images.get(body.link.name)
        if severity is WARNING and image is not None and body.box and not outside(body.box, image):
            continue
        what = f"the centre of mass is {away:.3g} m outside the box around the shapes, which is {size:.3g} m across"
        remedy = "check the unit (m), the signs, and that it is in the link's frame, not the mesh's or the world's"
        at = body.inertial.element.span if origin.element is None else origin.xyz.span
        cause, shape = suspected(context, body, centre=True), context.once(shaped).get(body.link.name)
        if cause is None and shape is not None and body.box is not None:
            now, flipped = length(body.c - shape.solid.c), body.c * (1.0 - 2.0 * np.eye(3))
            near = [not outside(body.box, c) and length(c - shape.solid.c) <= _NEAR * now for c in flipped]
            cause = one_of(f"{axis} has the wrong sign" for axis, yes in zip("xyz", near, strict=True) if yes)
        yield Fault(at, what, remedy, away, size, severity=severity, cause=cause)


_LEAST, _LEAST_SHELL = 0.05, 0.1
_DENSEST = 19300.0  # of tungsten [kg/m^3]
_FAR = 0.01  # of the ball's moment: what is less is a mass or a size that no link has, of which RD209 and RD210 tell
_REMEDY = "check the unit (kg m^2) and the mass; write the inertia of the part"


@rule("RD303", WARNING, TREE, good=a_shaped_link(), bad=(SHAPED_INERTIA, inertia("4e-5 0 0 5e-5 0 3e-5")))
def inertia_below_shell(context: Context) -> Faults:
    """The inertia is not far below that of the link's shapes.

    About each principal axis of the uniform solid that the link's shapes are (visual ones, or else collision shapes),
    the moment of inertia is at least a twentieth of that of the solid with the link's mass. Less means that nearly all
    mass is in one spot or, where it is one axis only, on a line. Where a shape encloses no definite volume, the largest
    principal moment is at least a tenth of that of the largest shell that fits into the box around the shapes, 2/3 m
    r^2; without shapes at least that of a ball of tungsten, where a hundredth of it or less is RD209's and RD210's. A
    point is RD204's, a mass beyond any solid RD304's."""
    known = context.once(shaped)
    for body in judged(context):
        tensor, shape = body.link.tensor, known.get(body.link.name)
        if body.S is None or tensor is None or is_a_point(body.link) or broken_law(tensor, context.thresholds):
            continue
        if shape is not None and body.mass > context.thresholds.most_density * shape.solid.volume:
            continue
        found = _below_shell(body) if shape is None or not shape.definite else _below_solid(body, shape.solid)
        if found is not None:
            measured, bound, what = found
            yield Fault(body.tensor_span, what, _REMEDY, measured, bound, cause=suspected(context, body))


def _below_solid(body: Body, solid: Uniform) -> tuple[float, float, str] | None:
    """The moment about the solid's principal axis about which it is least, beside the solid's, and what to say."""
    moments, axes = eigen(solid.inertia(body.mass))
    assert body.S is not None, "there is a tensor"
    own = np.diagonal(product(axes, inertia_matrix(body.S), axes.T))
    if not (moments > 0).all():
        return None
    k = first_largest(-own / moments)
    measured, right = float(own[k]), float(moments[k])
    if not 0 < measured < _LEAST * right:
        return None
    about = " ".join(f"{x + 0.0:.2g}" for x in np.round(axes[k], 3).tolist())
    what = f"the moment {measured:.3g} kg m^2 about the axis ({about}) is {measured / right:.2g} of that of a solid of "
    what += f"its shapes and mass, {right:.3g}"
    return measured, _LEAST * right, what


def _below_shell(body: Body) -> tuple[float, float, str] | None:
    """The largest principal moment beside that of a shell in the shapes or, without shapes, of a ball of tungsten."""
    largest, box = principal_moments(body.link.tensor or (0.0,) * 6)[2], body.own
    if box is not None:
        radius = float((box.hi - box.lo).min()) / 2
        shell = 2 / 3 * body.mass * radius**2
        least, bound, ball = 0.0, _LEAST_SHELL * shell, "shell of its mass that fits into its shapes"
    else:
        radius = (3 * body.mass / (4 * pi * _DENSEST)) ** (1 / 3)
        shell = bound = 2 / 5 * body.mass * radius**2
        least, ball = _FAR * bound, "ball of its mass of tungsten"
    if not least < largest < bound:
        return None
    what = f"the largest principal moment {largest:.3g} kg m^2 is {largest / shell:.2g} of that of a {ball}"
    return largest, bound, f"{what} (radius {radius:.3g} m)"


@rule(
    "RD304",
    WARNING,
    TREE,
    good=a_shaped_link(),
    bad=a_shaped_link("90", inertia("0.3 0 0 0.32 0 0.1")),
    explains=("RD301", "RD302"),
)
def density_out_of_band(context: Context) -> Faults:
    """The mass fits the size of the shapes.

    The mass of a rigid group over the volume of the box around its visual shapes (or else its collision shapes) is
    between 10 and 9000 kg/m^3, which the thresholds `least-density` and `most-density` set: most of a box is air, and
    solid steel that fills it has 7850. Where mass and shapes do not fit each other, it is no second defect that the
    inertia or the centre of mass does not fit the shapes (RD301, RD302)."""
    known, poses, limits = context.once(solids), context.once(link_poses), context.thresholds
    explained = {name for name, one in context.once(weighed).items() if one.units}
    for group in context.tree.groups:
        if not group.mass or group.mass < limits.least_mass or any(link.name in explained for link in group.links):
            continue
        kinds = ("visual",) if any(real_shapes(link, "visual") for link in group.links) else ()
        each = ((real_shapes(link, *kinds), poses.get(link.name)) for link in group.links)
        box = around_known([box_of(shapes, known, at) if at else None for shapes, at in each if shapes])
        volume = 0.0 if box is None else float((box.hi - box.lo).prod())
        if not volume > 0:
            continue
        density = group.mass / volume
        if limits.least_density <= density <= limits.most_density:
            continue
        dense = density > limits.most_density
        _, inertial = group.heaviest
        what = f"what moves with it weighs {group.mass:.4g} kg, which is {figure(density)} kg/m^3 of the box around "
        what += f"its shapes, {'denser than solid steel' if dense else 'lighter than foam'}"
        remedy = "check the unit of the mass (kg) and the size of the shapes"
        yield Fault(inertial.mass.span, what, remedy, density, limits.most_density if dense else limits.least_density)
