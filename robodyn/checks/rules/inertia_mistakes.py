"""Mistakes that explain an inertia: units, signs, reference point, axes, order of entries."""

from __future__ import annotations

from robodyn.checks.bodies.bodies import bodies, weighed
from robodyn.checks.bodies.causes import faults
from robodyn.checks.bodies.shapes import shaped
from robodyn.checks.examples import IMAGE, SHAPED_INERTIA, a_shaped_link, inertia, two_arms
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule
from robodyn.robot.masses.mistakes import QUANTITIES
from robodyn.support.wording import figure, one_of


@rule(
    "RD305", Severity.ERROR, Stage.TREE, good=a_shaped_link(), bad=(SHAPED_INERTIA, inertia("12600 0 0 12400 0 3200"))
)
def unit_slip(context: Context) -> Faults:
    """Mass, inertia and centre of mass are in kg, kg m^2 and m.

    One unit, or one system of units, explains what does not fit the shapes: g, mg, lb or t for kg, mm, cm or in for m,
    and all their products for kg m^2, in one of the three quantities or in several. The link is weighed by the uniform
    solid that its own shapes are: by density, centre, size and form. A unit is named where it is nine times as probable
    as everything else together, any factor that belongs to no unit included; otherwise the candidates are listed in a
    warning. Tensors near a multiple of the identity and round numbers are made up, not in other units. RD301 to RD304
    are silent about such a link.
    """
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
        else:
            what, remedy = one_of([one.what for one in verdict.either]) or "", "see which it is, and correct it"
            severity = Severity.WARNING
        yield Fault(at, what, remedy, factors[wrong[0]], 1.0, severity=severity, subject=body.link.subject)


@rule("RD306", Severity.WARNING, good=two_arms(), bad=(IMAGE, inertia("0.02 0.004 -0.002 0.03 0.003 0.025")))
def product_signs(context: Context) -> Faults:
    """Products of inertia have the sign of a matrix entry.

    URDF's ixy is an entry of the inertia matrix, minus the integral of x y dm. Many CAD programs print plus that
    integral, and then all three signs are wrong, but not the diagonal. RD206 and RD207 name the cause of tensors that
    no body has; this rule reports those that a body could have, but not this link, by its mirror twin or its shapes.
    """
    return faults(context, "RD306")


@rule("RD307", Severity.WARNING, good=two_arms(), bad=(IMAGE, inertia("0.105 0.006 -0.038 0.13 0.017 0.05")))
def about_origin(context: Context) -> Faults:
    """The tensor is about the centre of mass.

    URDF requires the tensor about the centre of mass, where the origin of <inertial> is. About the link's origin it is
    larger by m (|c|^2 1 - c c^T). Such a tensor is physical, and so it takes the link's shapes or its mirror twin to
    see it: corrected, it is within 20 % of the inertia of the uniform solid that the shapes are, and twice as near as
    it stands.
    """
    return faults(context, "RD307")


@rule("RD308", Severity.WARNING, good=two_arms(), bad=(IMAGE, inertia("0.19 0.016 -0.078 0.23 0.037 0.075")))
def parallel_axis_again(context: Context) -> Faults:
    """The parallel axis theorem is applied once.

    A tensor that is about the centre of mass already becomes too small, and often impossible, where m (|c|^2 1 - c c^T)
    is subtracted from it, and too large where the term is added twice. That adding the term makes a tensor possible is
    no evidence: the shapes or the twin have to agree. RD206 and RD207 name the cause of tensors that no body has; this
    rule reports the others.
    """
    return faults(context, "RD308")


_ORIGIN = '<origin xyz="0.1 -0.05 0.2" rpy="0 0 1.5707963267948966"/>'
_TURNED = inertia("0.03 0.004 -0.003 0.02 -0.002 0.025")


@rule("RD309", Severity.WARNING, good=two_arms(right=f'{_ORIGIN}<mass value="2"/>{_TURNED}'), bad=(_TURNED, IMAGE))
def rpy_not_applied(context: Context) -> Faults:
    """The tensor is in the axes of its <origin>.

    Where <origin> in <inertial> has an rpy, the tensor is in the axes turned by it. A tensor in the link's axes is
    right with rpy 0 only. Its principal moments are right either way: it takes the link's shapes or its mirror twin
    to see it.
    """
    return faults(context, "RD309")


@rule("RD310", Severity.WARNING, good=two_arms(), bad=(IMAGE, inertia("0.02 0.002 -0.004 0.03 -0.003 0.025")))
def entry_order(context: Context) -> Faults:
    """The entries are in URDF's order: ixx ixy ixz iyy iyz izz.

    MuJoCo's fullinertia is ixx iyy izz ixy ixz iyz, Voigt's order ixx iyy izz iyz ixz ixy, and a triangle by columns
    ixx ixy iyy ixz iyz izz; a matrix of nine entries, row by row, has iyx in fourth place. Pasting one for another
    gives a tensor that no body has, whose cause RD206 and RD207 name, or wrong products, which this rule reports by the
    link's mirror twin or its shapes.
    """
    return faults(context, "RD310")


@rule("RD311", Severity.WARNING, good=two_arms(), bad=('"-0.004"', '"-0.0004"'))
def entry_decade(context: Context) -> Faults:
    """No entry is off by a power of ten.

    A slip of the exponent in one entry. Without a twin to compare with, only a moment can be told from others, by the
    link's shapes. RD206 and RD207 name the cause of tensors that no body has; this rule reports the others.
    """
    return faults(context, "RD311")


@rule(
    "RD312",
    Severity.WARNING,
    good=two_arms(),
    bad=(IMAGE, inertia("0.03 -0.004 -0.003 0.02 0.002 0.025")),
    explains=("RD302",),
)
def permuted_axes(context: Context) -> Faults:
    """The tensor is in the axes of the link, not in another program's.

    Programs differ in which axis points up or forward. A tensor with x, y and z exchanged has the right principal
    moments about the wrong axes, and a centre of mass outside the shapes is one in those axes, too (RD302). RD206 and
    RD207 name the cause of tensors that no body has; this rule reports those that a body could have, but not this link,
    by its mirror twin or its shapes.
    """
    return faults(context, "RD312")
