"""The text: well-formed XML, elements and attributes that URDF knows, numbers, the version, waivers."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

from robodyn.checks.examples import INERTIA, arm, inertia, one_link
from robodyn.checks.rule import ERROR, NOTE, WARNING, Context, Edit, Fault, Faults, Fix, Stage, rule, text_faults
from robodyn.checks.waivers import Waiver, waivers
from robodyn.robot.urdf.document import Element, unexpanded
from robodyn.robot.urdf.parts import INERTIA as ENTRIES
from robodyn.robot.urdf.parts import SIZES
from robodyn.robot.urdf.view import Subject, numbers, value_span
from robodyn.support.wording import alternatives, shown


class Kind(NamedTuple):
    """One element: how many numbers each attribute holds (0: text), which of them it must have, its children, those of
    which there may be several, and attributes of which it must have at least one."""

    attributes: Mapping[str, int]
    needed: tuple[str, ...] = ()
    children: tuple[str, ...] = ()
    repeated: tuple[str, ...] = ()
    some: tuple[str, ...] = ()


_MATERIAL = {"material": Kind({"name": 0}, (), ("color", "texture"))}
_SHAPE_KINDS = {
    **{tag: Kind({size: 3 if size == "size" else 1 for size in sizes}, sizes) for tag, sizes in SIZES.items()},
    "mesh": Kind({"filename": 0, "scale": 3}),
}
_LINK_KINDS = {
    "link": Kind({"name": 0}, (), ("inertial", "visual", "collision", "contact"), ("visual", "collision")),
    "inertial": Kind({}, (), ("origin", "mass", "inertia")),
    "mass": Kind({"value": 1}),
    "inertia": Kind(dict.fromkeys((*ENTRIES, "iyx", "izx", "izy"), 1)),
    "origin": Kind({"xyz": 3, "rpy": 3, "quat_xyzw": 4}),
    "visual": Kind({"name": 0}, (), ("origin", "geometry", "material")),
    "collision": Kind({"name": 0}, (), ("origin", "geometry", "material", "verbose")),
    "verbose": Kind({"value": 0}),
    "geometry": Kind({}, (), tuple(_SHAPE_KINDS)),
    "color": Kind({"rgba": 4}),
    "texture": Kind({"filename": 0}),
}
_JOINT_KINDS = {
    "joint": Kind(
        {"name": 0, "type": 0, "dont_collapse": 0},
        (),
        ("origin", "parent", "child", "axis", "limit", "dynamics", "mimic", "safety_controller", "calibration"),
    ),
    "parent": Kind({"link": 0}),
    "child": Kind({"link": 0}),
    "axis": Kind({"xyz": 3}, ("xyz",)),
    "limit": Kind(dict.fromkeys(("lower", "upper", "effort", "velocity", "acceleration", "deceleration", "jerk"), 1)),
    "dynamics": Kind({"damping": 1, "friction": 1}, some=("damping", "friction")),
    "mimic": Kind({"joint": 0, "multiplier": 1, "offset": 1}),
    "safety_controller": Kind(
        dict.fromkeys(("soft_lower_limit", "soft_upper_limit", "k_position", "k_velocity"), 1), ("k_velocity",)
    ),
    "calibration": Kind({"rising": 1, "falling": 1, "reference_position": 1}),
}
_OWN = ("link", "joint", "material")
_ELSEWHERE = ("transmission", "gazebo", "ros2_control", "sensor", "group_state", "mujoco", "loop_joint")
"""Elements of the robot that other tools read. Bullet's <contact> in a link and Isaac's dont_collapse are known too."""
KINDS: Mapping[str, Kind] = {
    "robot": Kind({"name": 0, "version": 0}, (), (*_OWN, *_ELSEWHERE), (*_OWN, *_ELSEWHERE)),
    **_LINK_KINDS,
    **_JOINT_KINDS,
    **_MATERIAL,
    **_SHAPE_KINDS,
}


def own_elements(context: Context) -> Sequence[tuple[Element, Kind, Subject | None]]:
    """The elements that URDF knows, in the order of the file, each with what it is a part of; not what others read."""
    root, found = context.view.root, list[tuple[Element, Kind, Subject | None]]()
    waiting: list[tuple[Element, Subject | None]] = [(root, None)]
    while waiting:
        element, subject = waiting.pop()
        kind = KINDS[element.tag]
        found.append((element, kind, subject))
        for child in reversed(element.children):
            if child.tag in (_OWN if element is root else kind.children) and child.tag in KINDS:
                name = child.get("name") if element is root else None
                waiting.append((child, Subject(child.tag, name) if name else subject))
    return found


@rule("RD001", ERROR, Stage.TEXT, good=one_link(), bad=("</link>", ""))
def malformed_xml(context: Context) -> Faults:
    """The file must be well-formed XML with the root element <robot>.

    Readers that recover from broken XML guess what was meant, and drop links without a word. What follows is not
    checked."""
    return text_faults(context, "RD001")


@rule(
    "RD002",
    ERROR,
    Stage.TEXT,
    good=one_link(),
    bad='<!DOCTYPE robot [<!ENTITY m "2">]>\n' + one_link().replace('"2"', '"&m;"'),
)
def document_type(context: Context) -> Faults:
    """A description has no document type and no entities.

    An entity can name a file of the machine or of another one, or expand to gigabytes. URDF needs neither, readers
    differ in what they do, and robodyn neither expands nor fetches any."""
    return text_faults(context, "RD002")


_EXTENSION = '\n  <drake:joint name="shoulder"/>'


@rule(
    "RD003",
    ERROR,
    Stage.TEXT,
    good=arm(more=_EXTENSION).replace("<robot ", '<robot xmlns:drake="http://drake.mit.edu" '),
    bad=arm(more=_EXTENSION),
)
def undeclared_prefix(context: Context) -> Faults:
    """A namespace prefix is declared before it is used.

    To a namespace-aware parser (lxml, Qt, browsers) an undeclared prefix is an error, and the whole file is refused.
    tinyxml, and with it urdfdom, does not mind, so that the mistake stays unseen."""
    return text_faults(context, "RD003")


@rule("RD004", ERROR, Stage.TEXT, good=one_link(), bad=('"2"', '"${arm_mass}"'))
def unexpanded_xacro(context: Context) -> Faults:
    """Nothing is left of xacro: no xacro: element, no ${...}, no $(...).

    A reader takes ${mass} for a text, not for a number, and drops the element that it stands in. Where an element of
    xacro is left, links may be missing, and nothing else is checked."""
    return text_faults(context, "RD004")


_OF_DRAKE = {
    "controller_gains": "the <actuator> of a <transmission>",
    "rotor_inertia": "the <actuator> of a <transmission>",
    "gear_ratio": "the <actuator> of a <transmission>",
    "proximity_properties": "a <collision>",
}
"""Elements that Drake knows by its prefix, and where."""
_CALLED = {"min": "lower", "max": "upper"}  # what other formats call an attribute
_NUMBERS = frozenset(name for kind in KINDS.values() for name, count in kind.attributes.items() if count)
"""Attributes that hold numbers, somewhere in URDF."""


@rule("RD005", WARNING, good=one_link(f'<mass value="2"/>{INERTIA}<origin xyz="0 0 0.1"/>'), bad=("<origin", "<orgin"))
def unknown_element(context: Context) -> Faults:
    """Elements and attributes are those of URDF, and each stands where URDF has it and as often.

    urdfdom and most other readers ignore what they do not know: a misspelt <inertal> makes a link without mass. What is
    like a name that is missing, what URDF has elsewhere (an <origin> in a <link>, an rpy of an <axis>), and an element
    none of whose attributes is read are warnings. Other names are most often the additions of one tool, and remarks.
    Elements with a namespace prefix, and those of other tools at the top (gazebo, ros2_control, ...), are left
    alone."""
    for element, kind, subject in context.once(own_elements):
        seen: dict[str, Element] = {}
        for child in element.children:
            known = child.tag in kind.children
            if not known and ":" not in child.tag and (element.tag != "robot" or _is_near(child.tag, kind.children)):
                what = f"<{element.tag}> has no element {shown(child.tag)} in URDF; readers ignore it"
                remedy = alternatives(child.tag, kind.children, "elements") if kind.children else "delete it"
                if child.tag in _OF_DRAKE:
                    remedy = f"Drake reads it as <drake:{child.tag}> in {_OF_DRAKE[child.tag]}; otherwise delete it"
                meant = child.tag in KINDS or child.tag in _OF_DRAKE or _is_near(child.tag, [*KINDS, *kind.children])
                yield Fault(child.span, what, remedy, subject=subject, severity=None if meant else NOTE)
            elif known and child.tag not in kind.repeated and child.tag in seen:
                first = f"the first is in line {seen[child.tag].line}"
                what = f"a second <{child.tag}> in <{element.tag}>, {first}; readers differ in which they take"
                yield Fault(child.span, what, "keep one of them", subject=subject)
            seen.setdefault(child.tag, child)
        nothing_read = kind.attributes and not (kind.children or element.values.keys() & kind.attributes.keys())
        for name in element.values:
            if name not in kind.attributes and ":" not in name and name != "xmlns":
                what = f"<{element.tag}> has no attribute {shown(name)} in URDF; readers ignore it"
                remedy = alternatives(name, kind.attributes, "attributes") if kind.attributes else "delete it"
                absent, other = kind.attributes.keys() - element.values, _CALLED.get(name, "")
                if other in absent:
                    remedy = f"did you mean {shown(other)}?"
                meant = nothing_read or name in _NUMBERS or other in absent or _is_near(name, absent)
                at, severity = element.attributes[name].span, None if meant else NOTE
                yield Fault(at, what, remedy, subject=subject, severity=severity)


def _is_near(tag: str, known: Collection[str]) -> bool:
    """Whether it is a slip of the pen: at the top other tools may keep elements of any name."""
    from difflib import get_close_matches

    shuffled = any(sorted(tag) == sorted(name) for name in known)
    return len(tag) < 30 and (shuffled or bool(get_close_matches(tag.lower(), known, n=1, cutoff=0.75)))


_PAIRS = (("iyx", "ixy"), ("izx", "ixz"), ("izy", "iyz"))


@rule("RD006", WARNING, good=one_link(), bad=('iyz="', 'iyx="0.001" iyz="'))
def transposed_product(context: Context) -> Faults:
    """Products of inertia are called ixy, ixz and iyz.

    The inertia matrix is symmetric and URDF has its upper triangle. Readers ignore iyx, izx and izy; where one of them
    stands in place of its twin, the product is taken for 0 or the whole inertial is dropped."""
    for link in context.view.links:
        inertia = None if link.inertial is None else link.inertial.inertia_element
        for lower, upper in _PAIRS:
            if inertia is None or inertia.get(lower) is None:
                continue
            below, above = numbers(inertia, lower, 1).value, numbers(inertia, upper, 1).value
            state = f"{lower} is ignored" if below is None else f"{lower} = {below:g} is ignored"
            if below is not None and above is not None and below != above:
                state += f", and differs from {upper} = {above:g}"
            what = f"{state}: URDF has the upper triangle of the matrix only"
            remedy = f"delete {lower}, and see that {upper} is right"
            fix, at = None, inertia.attributes[lower].span
            if below is not None and inertia.get(upper) is None:
                fix = Fix(f"call it {upper}", (Edit(at.start, at.start + len(lower), upper),), safe=False)
            elif below is not None and above == below:
                start = len(inertia.positions.data[: at.start].rstrip(b" \t\r\n"))
                fix = Fix(f"delete {lower}", (Edit(start, at.end, ""),), safe=True)
            yield Fault(at, what, remedy, below, above, fix=fix)


_LONGEST = 2000  # characters of an attribute of numbers


@rule("RD007", ERROR, good=one_link(f'<origin xyz="0 0.1 0"/><mass value="2"/>{INERTIA}'), bad=("0.1", "0,1"))
def bad_number(context: Context) -> Faults:
    """Numbers are finite, decimal, no larger than 1e30, and as many as the attribute holds.

    NaN and infinity, decimal commas, units, and too few or too many numbers. urdfdom then drops the whole element and
    reports success; other readers take a part of the text. A <safety_controller> without k_velocity and a <dynamics>
    without damping and friction make it refuse the file."""
    for element, kind, subject in context.once(own_elements):
        if kind.some and not any(name in element.values for name in kind.some):
            what = f"<{element.tag}> has neither {' nor '.join(kind.some)}, and urdfdom refuses the file"
            yield Fault(element.span, what, f"write one of them, or delete <{element.tag}>", subject=subject)
        for name, count in kind.attributes.items():
            if not count:
                continue
            found, text = numbers(element, name, count), element.get(name) or ""
            if len(text) > _LONGEST:
                what, remedy = f"{name} of <{element.tag}> has {len(text)} characters", f"write {count} numbers"
            elif found.problem is not None and not unexpanded(text):
                what, remedy = f"{name} of <{element.tag}> {found.problem}", found.problem.remedy
            elif not found.given and name in kind.needed:
                what, remedy = f"<{element.tag}> has no attribute '{name}'", f'write {name}="..."'
            else:
                continue
            yield Fault(found.span, what, remedy, subject=subject)


_IDENTITY = '<mass value="2"/>' + inertia("1 0 0 1 0 1")


@rule(
    "RD008",
    WARNING,
    good=one_link(f"{_IDENTITY} <!-- robodyn: allow RD208 a test weight, its tensor does not matter -->"),
    bad=one_link(f"<!-- robodyn: allow RD208 -->{_IDENTITY}"),
)
def waiver_not_in_force(context: Context) -> Faults:
    """A waiver names rules that exist, and says why.

    A comment `<!-- robodyn: allow RD208 no tensor is published, see issue 52 -->` above an element, or behind it on its
    line, allows the finding there. A waiver without a reason is not in force; nor is one with a code that no rule has,
    or a comment that begins with `robodyn:` and goes on in another way."""
    for waiver in context.once(waivers):
        if not waiver.in_force(context.codes):
            what, remedy = waiver.problem(context.codes)
            yield Fault(waiver.at, what, remedy, subject=None)


@rule("RD009", WARNING, good=one_link(), bad=("<mass", "<!-- robodyn: allow RD208 no tensor is published --><mass"))
def unused_waiver(context: Context) -> Faults:
    """A waiver allows a finding that is there.

    A waiver that outlives its finding would hide the next one. It is reported if its rule has run and has found nothing
    in the element that the waiver is about."""
    return ()


def without_use(waiver: Waiver, code: str) -> Fault:
    what = f"the waiver of {code} has nothing to waive"
    remedy = "delete it, or put it above the element that the finding is in"
    fix = Fix("delete the waiver", (Edit(*waiver.erased, ""),), safe=True) if len(waiver.codes) == 1 else None
    return Fault(waiver.at, what, remedy, fix=fix, subject=None)


_KNOWN = re.compile(r"1\.[0-2]")


@rule("RD010", ERROR, good=one_link().replace("<robot ", '<robot version="1.0" '), bad=('"1.0"', '"2.0"'))
def version(context: Context) -> Faults:
    """The version of a description is one that readers know.

    urdfdom reads version="1.0" to "1.2", and refuses any other: also "1" and "2.0". Without one it is 1.0."""
    root = context.view.root
    version = root.get("version")
    if version is not None and not _KNOWN.fullmatch(version):
        what = f"the version is {shown(version)}; urdfdom reads 1.0 to 1.2 and refuses others"
        yield Fault(value_span(root, "version"), what, 'write version="1.0", or leave it out', subject=None)
