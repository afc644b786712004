"""Masses and inertia tensors by themselves: positive, physical, such as parts of a robot have, no stand-ins."""

from __future__ import annotations

import re
from math import isclose, log10

from robodyn.checks.bodies.bodies import bodies, given, link_boxes, real_shapes, repeated, shaped, size_of
from robodyn.checks.bodies.masses import (
    POINT,
    broken_law,
    carried_masses,
    gyration,
    is_a_point,
    principal_moments,
    severity_of_zero,
    tensors,
    widest,
)
from robodyn.checks.context import Group
from robodyn.checks.examples import INERTIA, a_joint, a_link, a_tower, arm, inertia, longer_arm, one_link, two_arms
from robodyn.checks.mirror import named_pairs, pairs
from robodyn.checks.rule import ERROR, MODEL, NOTE, TREE, WARNING, Context, Fault, Faults, rule
from robodyn.checks.rules.inertia_mistakes import explained
from robodyn.programs.vectors import length
from robodyn.robot.base_guess import untouched
from robodyn.robot.urdf.parts import INERTIA as ENTRIES
from robodyn.robot.urdf.view import LinkView
from robodyn.support.wording import figure, listed


@rule("RD201", ERROR, good=arm(), bad=one_link(f'<mass value="-2"/>{INERTIA}'), explains=("RD901",))
def mass_not_positive(context: Context) -> Faults:
    """Masses are positive.

    No body has a negative mass, and one of zero mass that moves takes on any acceleration. A zero counts only where the
    whole rigid group (links joined by fixed joints) has no mass; it is a warning where the group carries on to one that
    has mass, as in a universal joint: MuJoCo refuses such a group, and Gazebo drops it and all that it carries."""
    for link in context.view.links:
        if link.inertial is None or link.mass is None or link.mass > 0:
            continue
        severity = ERROR if link.mass < 0 else severity_of_zero(context, link)
        if severity is not None:
            what = f"the mass is {link.mass:g} kg, not positive"
            what += "; MuJoCo refuses it, Gazebo drops it and what it carries" * (link.mass == 0)
            remedy = "write the mass of the part, or fix the link to one that has mass"
            yield Fault(link.inertial.mass.span, what, remedy, link.mass, 0.0, severity=severity)


@rule(
    "RD202",
    ERROR,
    TREE,
    good=longer_arm("tip", "flange", "", "", "fixed"),
    bad=longer_arm("tip", "wrist", ""),
    explains=("RD901",),
)
def massless_group(context: Context) -> Faults:
    """Whatever a joint moves has mass.

    Links joined by fixed joints are one body, a rigid group. A moving group without any mass makes the mass matrix
    singular. Where the group carries other bodies with mass, it is a warning: the mass matrix is regular then, but
    MuJoCo makes up a mass from collision shapes or refuses the robot, and Gazebo drops it all."""
    carried = context.once(carried_masses)
    for group in context.tree.groups:
        if group.joint is None or any(link.inertial is not None for link in group.links):
            continue
        onward = carried[group] > 0
        with_it = f" with {listed([link.name for link in group.links[1:]])}" if len(group.links) > 1 else ""
        what = f"joint '{group.joint.name}' moves it{with_it}, and it has no mass"
        what += f"; what it carries has {carried[group]:g} kg" if onward else ""
        shaped = any(real_shapes(link, "collision") for link in group.links)
        does = "invents a mass from its collision shapes" if shaped else "refuses it"
        what += f"; MuJoCo {does}, Gazebo drops it" + " and what it carries" * onward
        remedy = "add an <inertial>" if onward else "add an <inertial>, or make the joint fixed"
        severity = WARNING if onward else ERROR
        at, kind = group.links[0].name_span, "a joint moves no mass"
        yield Fault(at, what, remedy, measured=0.0, severity=severity, kind=kind)


@rule("RD203", ERROR, good=one_link(), bad=(INERTIA, ""), explains=("RD901",))
def incomplete_inertial(context: Context) -> Faults:
    """An <inertial> has a <mass> and an <inertia> with all six entries.

    urdfdom drops an incomplete <inertial>, and the link has no mass; other readers take 0 or 1 for what is missing."""
    for link in context.view.links:
        inertial = link.inertial
        if inertial is None:
            continue
        absent = [name for name, entry in zip(ENTRIES, inertial.entries, strict=True) if not entry.given]
        lacking = []
        if inertial.mass_element is None:
            lacking.append((inertial.element, "<inertial> has no <mass>", '<mass value="..."/>'))
        elif not inertial.mass.given:
            lacking.append((inertial.mass_element, "<mass> has no value", 'value="..."'))
        if inertial.inertia_element is None:
            lacking.append((inertial.element, "<inertial> has no <inertia>", "<inertia ixx=... izz=.../>"))
        elif absent:
            lacking.append((inertial.inertia_element, f"<inertia> has no {', '.join(absent)}", f'{absent[0]}="..."'))
        for element, what, remedy in lacking:
            yield Fault(element.span, what, f"write {remedy}")


@rule(
    "RD209",
    WARNING,
    TREE,
    good=longer_arm("tip", "wrist"),
    bad=longer_arm("tip", "wrist", '<mass value="1e-5"/>' + inertia("1e-8 0 0 1e-8 0 1e-8")),
)
def tiny_body(context: Context) -> Faults:
    """A moving body has a mass and a size that a machine part can have.

    A rigid group (links joined by fixed joints) of less than 0.1 g, or of a radius of gyration below 0.1 mm, is a slip
    of units or put in to satisfy a program. It makes the mass matrix ill-conditioned and asks for tiny steps."""
    limits = context.thresholds
    for group in context.tree.groups:
        if group.joint is None or not group.mass or group.mass < 0:
            continue
        radius, (_, inertial) = gyration(context, group), group.heaviest
        if group.mass < limits.least_mass:
            numbers, quantity, value, bound, unit = inertial.mass, "mass", group.mass, limits.least_mass, "kg"
        elif radius is not None and POINT < radius < limits.least_gyration:
            quantity, value, bound, unit = "radius of gyration", radius, limits.least_gyration, "m"
            numbers = inertial.entries[0]
        else:
            continue
        what = f"what moves with it has a {quantity} of {value:.3g} {unit}, less than {bound:g} {unit}"
        remedy = "check the unit (kg, m); write the inertia of the part, or fix the link to its neighbour"
        yield Fault(numbers.span, what, remedy, value, bound)


@rule("RD210", WARNING, TREE, good=longer_arm(), bad=('"1"', '"5000"'))
def mass_ratio(context: Context) -> Faults:
    """The bodies on both sides of a joint differ in mass by less than a factor of 1000.

    A factor of 1000 is most often grams for kilograms. Where it is real, the mass matrix is ill-conditioned, and
    iterative solvers of simulators need many more steps."""
    bound, least = context.thresholds.mass_ratio, context.thresholds.least_mass
    reported: set[Group] = set()
    for group in context.tree.groups:
        inner = None if group.parent is None else group.parent.mass
        if group.joint is None or group.parent is None or not group.mass or not inner:
            continue
        ratio = max(group.mass / inner, inner / group.mass)
        odd = group if group.mass > inner else group.parent if group.parent.joint is not None else group
        if min(group.mass, inner) < least or ratio <= bound or odd in reported:
            continue
        reported.add(odd)
        what = f"it joins bodies of {inner:g} kg and {group.mass:g} kg, a ratio of {ratio:.3g}"
        remedy = "check the unit of both masses (kg)"
        yield Fault(odd.heaviest[1].mass.span, what, remedy, ratio, bound, subject=group.joint.subject)


@rule("RD211", NOTE, TREE, good=arm(), bad=arm().replace('<link name="base"/>', a_link("base").strip()))
def root_with_inertia(context: Context) -> Faults:
    """KDL ignores the inertia of the root.

    kdl_parser warns of it and drops it. It matters for a robot whose base moves; nothing is wrong for others."""
    root = context.tree.root
    if root.inertial is not None and root.mass and context.view.joints:
        what = f"the root has a mass of {root.mass:g} kg, which KDL ignores"
        remedy = "where KDL or robot_state_publisher matters, put an empty root link above it with a fixed joint"
        yield Fault(root.inertial.element.span, what, remedy, measured=root.mass)


_SPHERE = '<collision><geometry><sphere radius="0.1"/></geometry></collision>'
_CART = two_arms().replace("arm", "wheel").replace("shoulder", "axle")
_CART = _CART.replace('<link name="base"/>', a_link("base", more=_SPHERE).strip())


@rule("RD212", WARNING, MODEL, good=_CART, bad=(f'<inertial><mass value="1"/>{INERTIA}</inertial>', ""))
def root_mass_invented(context: Context) -> Faults:
    """A root with a collision shape has an <inertial>, unless it stands still.

    MuJoCo takes the mass of a body without an inertial from its shapes, at the density of water, and other programs
    take none. A base that stands still, as an arm's, is not affected, since MuJoCo makes it a part of the ground: asked
    are robots that stand on two or more legs or wheels, or fly, by their links."""
    root = context.tree.root
    shapes = [shape for shape in root.geometries if shape.kind == "collision"]
    if root.inertial is None and shapes and context.model.n and untouched(context.model):
        what = "the root has a collision shape and no <inertial>: MuJoCo gives it the mass of water in that shape"
        yield Fault(root.name_span, what, "write its <inertial>")


_BODY = '<mass value="1.25"/>' + inertia("0.002 0 0 0.003 0 0.0035")


@rule(
    "RD213",
    WARNING,
    TREE,
    good=arm(more=a_link("fore", _BODY) + a_joint("elbow", "upper", "fore")).replace("\n</robot>\n", "")
    + a_link("tool", "")
    + a_joint("mount", "fore", "tool", "", "fixed")
    + "\n</robot>\n",
    bad=('<link name="tool">', f'<link name="tool"><inertial>{_BODY}</inertial>'),
)
def mass_repeated(context: Context) -> Faults:
    """The mass of a body is not written twice, on links that are fixed to each other.

    A frame that is fixed to a part, for a tool or a camera, and has the part's inertial again doubles the mass.
    Reported are links fixed to each other with the same mass, of 1 % of what moves with them or more, and either one
    centre of mass, within 1 mm, or the same numbers throughout, where the child has no shape that the other has not.
    Stand-ins, which have the same moment three times, do not count. Of other shapes RD208 tells."""
    known = context.once(bodies)
    for name, joint in context.once(repeated).items():
        again = known[name]
        what = f"its mass of {again.mass:g} kg is that of link '{joint.parent}', to which it is fixed, again"
        remedy = "leave the <inertial> of one of them out, if it is one part"
        yield Fault(again.inertial.mass.span, what, remedy, again.mass, 0.0)


_OTHERS, _MOST = 3, 0.9
"""Least number of other links with shapes, and the share of those with an <inertial>. Of 86 published robots one has
moving links with shapes and no <inertial> beside others that have one, and of its links with shapes half have one."""
_LONG = 0.5  # how long it is at least, by the longest link of its rigid group


@rule(
    "RD214",
    WARNING,
    TREE,
    good=a_tower(last="fixed"),
    bad=re.sub(r'(<link name="hand">)<inertial>.*?</inertial>', r"\1", a_tower(last="fixed")),
)
def unweighed_part(context: Context) -> Faults:
    """A part that is seen has mass, as the other parts have.

    Where nine of ten of the other links with shapes have an `<inertial>`, three at least, a moving link with shapes and
    without one lost it: what is fixed to it has mass, so that the robot still loads, but too light. It is at least half
    as long as the longest link that is fixed to it, for a small one, such as a camera, may be weighed with what carries
    it. A group that has no mass at all is RD202's."""
    shaped = [link for link in context.view.links if real_shapes(link)]
    weighed = sum(link.inertial is not None for link in shaped)
    others = len(shaped) - 1
    if others < _OTHERS or weighed < _MOST * others:
        return
    boxes = {name: size_of(box) for name, box in context.once(link_boxes).items() if box is not None}
    for group in context.tree.groups:
        longest = max((boxes.get(link.name, 0.0) for link in group.links), default=0.0)
        for link in group.links if group.joint is not None and group.mass else ():
            if link.inertial is None and boxes.get(link.name, 0.0) >= _LONG * longest > 0:
                what = f"it has shapes and no <inertial>, and {weighed} of {others} other links with shapes have one: "
                what += f"what moves with it weighs {group.mass:.4g} kg without it"
                yield Fault(link.name_span, what, "write its <inertial>", measured=0.0)


@rule(
    "RD204",
    ERROR,
    good=longer_arm(),
    bad=longer_arm(inertial='<mass value="1"/>' + inertia("0 0 0 0 0 0")),
    explains=("RD402", "RD901"),
)
def zero_tensor(context: Context) -> Faults:
    """What has mass has moments of inertia.

    Only a point has none. Simulators refuse such a body or put in a number of their own. It is a remark where heavier
    links are fixed to this one, and a warning for the base, which most often stands still."""
    for link in context.view.links:
        if link.inertial is None or not link.mass or link.mass < 0 or not is_a_point(link):
            continue
        what = f"a mass of {link.mass:g} kg has no moments of inertia: it would be a point"
        remedy = "write the inertia of the part; robodyn inertia computes it from its mesh"
        group = None if context.tree_or_none is None else context.tree.group[link.name]
        severity = WARNING if group is not None and group.mass is not None and group.joint is None else None
        if group is None or ((group.mass or 0.0) > 2 * link.mass and (gyration(context, group) or 0.0) > POINT):
            severity = NOTE
        yield Fault(link.inertial.entries[0].span, what, remedy, measured=0.0, severity=severity)


@rule("RD205", WARNING, good=longer_arm("tip", "flange", inside="", kind="fixed"), bad=('"1"', '"0"'))
def tensor_without_mass(context: Context) -> Faults:
    """What has no mass has no moments of inertia.

    A moment of inertia is mass times distance squared. The zero is often a mass that was rounded away, or a placeholder
    that was forgotten. A body that moves without any mass is RD201's."""
    for link in context.view.links:
        if link.inertial is None or link.mass != 0 or link.tensor is None or not any(link.tensor):
            continue
        if severity_of_zero(context, link) is not ERROR:
            trace = sum(link.tensor[k] for k in (0, 3, 5))
            what = f"the mass is 0, and the moments of inertia add up to {trace:g} kg m^2"
            remedy = "write the mass of the part, or zeros for its inertia"
            yield Fault(link.inertial.mass.span, what, remedy, trace, 0.0)


@rule("RD206", ERROR, good=one_link(), bad=('"0.01"', '"-0.01"'), explains=("RD301", "RD303", "RD402", "RD901"))
def not_positive_definite(context: Context) -> Faults:
    """The inertia matrix is positive definite.

    A principal moment of inertia is a sum of mass times distance squared. With one that is zero or negative simulations
    gain energy from nothing. The principal moments are the eigenvalues of the matrix: large products make one negative
    although the diagonal is positive. Where no cause explains the tensor, the unsafe fix is the mirror image of its
    twin's or, where it is farther from that of the link's shapes than that is large, the tensor of these. Traversaro,
    Brossette, Escande, Nori, Identification of fully physical consistent inertial parameters (IROS 2016)."""
    for link, inertial, tensor in tensors(context):
        if broken_law(tensor, context.thresholds) != "RD206":
            continue
        small, middle, large = principal_moments(tensor)
        what = "the inertia matrix is not positive definite: its principal moments are "
        what += f"{small:.6g}, {middle:.6g}, {large:.6g} kg m^2"
        remedy = "every principal moment of a body is positive; write its inertia about the centre of mass"
        bound = context.thresholds.positive_definite * large
        fault = Fault(inertial.entries[widest(tensor)].span, what, remedy, small, bound)
        yield explained(context, fault, link)


@rule("RD207", ERROR, good=one_link(), bad=('izz="0.02"', 'izz="0.05"'), explains=("RD301", "RD303", "RD402", "RD901"))
def triangle_inequality(context: Context) -> Faults:
    """The largest principal moment is no greater than the sum of the other two.

    I_1 + I_2 - I_3 is twice the second moment of the mass along the third axis, a sum of mass times distance squared,
    and so never negative. The law holds for the principal moments, in every axes; the diagonal says too little. Where
    no cause explains the tensor, the unsafe fix is the mirror image of its twin's or, where it is farther from that of
    the link's shapes than that is large, the tensor of these. Wensing, Kim, Slotine, Linear matrix inequalities for
    physically consistent inertial parameter identification (RA-L 2018)."""
    for link, inertial, tensor in tensors(context):
        if broken_law(tensor, context.thresholds) != "RD207":
            continue
        small, middle, large = principal_moments(tensor)
        largest = max((0, 3, 5), key=lambda k: tensor[k])
        lack = figure(100 - 100 * (small + middle) / large, 2)
        what = f"no body has the principal moments {small:.6g}, {middle:.6g}, {large:.6g} kg m^2: the two smaller "
        what += f"add up to {small + middle:.6g}, {lack} % less than the largest"
        remedy = "the largest may not exceed the sum of the others; robodyn inertia computes them from a mesh"
        fault = Fault(inertial.entries[largest].span, what, remedy, large, small + middle)
        yield explained(context, fault, link)


_FRACTION = 0.01  # of the mass of its rigid group; a placeholder on less than this is a remark
_NEAR = 0.05


@rule(
    "RD208",
    WARNING,
    good=one_link(),
    bad=(INERTIA, inertia("1 0 0 1 0 1")),
    explains=("RD206", "RD207", "RD301", "RD303", "RD402"),
)
def placeholder_tensor(context: Context) -> Faults:
    """The inertia is that of the part, not a stand-in.

    The identity matrix, a power of ten times it, six equal entries, and numbers copied from a link of another mass are
    stand-ins; of left and right RD401 judges the masses. An inertia of 1 kg m^2 is that of a solid ball of 2 kg with a
    radius of 1.1 m. Numbers within 5 % of the inertia of the link's own shapes are no stand-in."""
    first_with: dict[tuple[float, ...], LinkView] = {}
    mirrored = {frozenset((pair.left.name, pair.right.name)) for pair in context.once(pairs)}
    for link, inertial, tensor in tensors(context):
        if not link.mass:
            continue
        twin = first_with.setdefault(tensor, link)
        pattern = _pattern(tensor)
        unlike = twin.mass and not isclose(twin.mass, link.mass, rel_tol=0.1)
        paired = frozenset((link.name, twin.name)) in mirrored
        if pattern is None and not paired and _pasted(context, link, twin):
            pattern = f"mass, centre and inertia are those of link '{twin.name}', which has other shapes"
        if pattern is None and twin.mass and unlike and not paired:
            whose = f"whose mass is {twin.mass:g} kg and not {link.mass:g}"
            pattern = f"the same six numbers as link '{twin.name}', {whose}"
        said, shape = given(link), context.once(shaped).get(link.name)
        own = said and shape and shape.solid.along(said.R).apart(said.tensor, said.mass) <= _NEAR
        if pattern is not None and not own:
            tree, what = context.tree_or_none, f"the inertia looks like a placeholder: {pattern}"
            whole = None if tree is None else tree.group[link.name].mass
            small = tree is None or (whole and link.mass < _FRACTION * whole)
            remedy = "write the inertia of the part; robodyn inertia computes it from its mesh"
            severity = NOTE if small else WARNING
            yield Fault(inertial.entries[0].span, what, remedy, tensor[0], severity=severity)


def _pasted(context: Context, link: LinkView, other: LinkView) -> bool:
    """Whether a link has the mass, the centre and the inertia, with three products, of one whose shapes are others."""
    known = {} if context.tree_or_none is None else context.once(shaped)
    if link.inertial is None or other.inertial is None or not {link.name, other.name} <= known.keys():
        return False
    one, its = known[link.name].solid, known[other.name].solid
    alike = isclose(one.volume, its.volume, rel_tol=0.1) and length(one.c - its.c) <= 0.1 * one.spread**0.5
    same = link.mass == other.mass and link.inertial.origin.xyz.values == other.inertial.origin.xyz.values
    products = all((link.tensor or (0.0,) * 6)[k] for k in (1, 2, 4))
    return same and products and not alike and link is not other and not [*named_pairs([link.name, other.name])]


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
