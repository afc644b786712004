"""What transmissions, ros2_control, Gazebo's plugins and the SRDF name; transmissions themselves."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from robodyn.checks.examples import arm
from robodyn.checks.rule import Context, Fault, Faults, Severity, namesakes, rule
from robodyn.checks.srdf import Named, own_srdf
from robodyn.robot.urdf.document import Element, unexpanded
from robodyn.robot.urdf.view import TEXT, Subject, View, numbers, value_span
from robodyn.support.wording import alternatives, shown, slip_of

_PAIRS_ONLY = frozenset({"disable_collisions", "enable_collisions", "disable_default_collisions"})

_TRANSMISSION = """
  <transmission name="drive">
    <type>transmission_interface/SimpleTransmission</type>
    <joint name="shoulder"><hardwareInterface>hardware_interface/EffortJointInterface</hardwareInterface></joint>
    <actuator name="motor"><mechanicalReduction>50</mechanicalReduction></actuator>
  </transmission>"""


@rule(
    "RD701",
    Severity.ERROR,
    good=arm(more=_TRANSMISSION),
    bad=('<joint name="shoulder"><', '<joint name="sholder"><'),
)
def names_nothing(context: Context) -> Faults:
    """Transmissions, ros2_control, Gazebo and SRDF entries name links and joints that exist.

    Controllers fail at start, or the entry is dropped without a word, where a joint was renamed in one place and not in
    the others. Asked are <joint> in <transmission> and <ros2_control>, the reference of <gazebo>, the joints and bodies
    that its plugins name (jointName, mimicJoint, bodyName and so on; no frames, which others may publish), and the SRDF
    of the same name (or the only one for this robot) beside the file or in a folder config or srdf. Collisions of links
    that do not exist, and an SRDF of another name, which may belong to a variant of the robot, are warnings.
    root_joint, as Pinocchio calls a free base, is understood.
    """
    view = context.view
    both = {**view.link, **view.joint}
    remedies: dict[str, str] = {}
    for owner in view.root.children:
        for used in _uses(owner):
            names: Collection[str] = view.joint if used.kind == "joint" else both
            if used.name in names or unexpanded(used.name):
                continue
            if used.name not in remedies:
                remedies[used.name] = alternatives(used.name, names, "joints" if used.kind == "joint" else "links")
            what, at = (
                f"there is no {used.kind} {shown(used.name)} in the robot",
                value_span(used.element, used.attribute),
            )
            subject = Subject(owner.tag, owner.get("name") or owner.get("reference") or "")
            yield Fault(at, what, remedies[used.name], subject=subject)
    yield from _in_srdf(context)


def _uses(owner: Element) -> Iterator[Named]:
    if owner.tag in ("transmission", "ros2_control"):
        for inner in (owner, *owner.findall("transmission")):
            for joint in inner.findall("joint"):
                if joint.get("name"):
                    yield Named("joint", joint.values["name"], joint, "name")
    reference = owner.get("reference")
    if owner.tag == "gazebo":
        if reference:
            yield Named("link or joint", reference, owner, "reference")
        yield from named_by_plugins(owner)


def _in_srdf(context: Context) -> Iterator[Fault]:
    """Yield one fault for each name; one warning of an SRDF of another name, which may be of a variant of the robot."""
    found, view = own_srdf(context), context.view
    if found is None:
        return
    missing, more = found.missing, ""
    if not found.is_namesake and missing[1:]:
        missing, more = missing[:1], f", and {len(missing) - 1} more names that are not in the robot"
    for used in missing:
        names: Collection[str] = view.link if used.kind == "link" else view.joint
        yield Fault(
            value_span(used.element, used.attribute),
            f"there is no {used.kind} {shown(used.name)} in the robot {shown(view.root.get('name') or '')}{more}",
            alternatives(used.name, names, f"{used.kind}s"),
            subject=Subject(used.element.tag, used.element.get("name") or ""),
            severity=None if found.is_namesake and used.element.tag not in _PAIRS_ONLY else Severity.WARNING,
            document=found.document,
        )


_SIDES = ("left", "right", "leftfront", "leftrear", "rightfront", "rightrear")
_JOINTS = ("joint", "jointname", "jointnames", "mimicjoint", "actuatedjoint", *(f"{side}joint" for side in _SIDES))
_NAMES = {
    **dict.fromkeys(_JOINTS, "joint"),
    **dict.fromkeys(("bodyname", "linkname", "canonicalbody"), "link"),
}
"""Tags of plugins, in lower case and without _, whose text names a joint or a link; no frames: others may make them."""


def named_by_plugins(gazebo: Element) -> Iterator[Named]:
    """Yield what the plugins in an element <gazebo> name, without what it makes itself."""
    made = {element.get("name") for element in gazebo.walk() if element.tag.partition(":")[0] in ("joint", "link")}
    for plugin in (element for element in gazebo.walk() if element.tag == "plugin"):
        for element in plugin.walk():
            kind = _NAMES.get(element.tag.lower().replace("_", ""), "")
            for name in element.text.replace(",", " ").split() if kind and not element.children else ():
                if name.rpartition("::")[2] not in {"world", *made}:
                    yield Named(kind, name.rpartition("::")[2], element, "")
            if element.tag == "virtualJoint" and (inner := element.find("name")) is not None and inner.text.strip():
                yield Named("joint", inner.text.strip(), inner, "")


_TYPES = ("SimpleTransmission", "DifferentialTransmission", "FourBarLinkageTransmission")
_INTERFACES = tuple(
    f"{kind}Interface"
    for kind in ("EffortJoint", "PositionJoint", "VelocityJoint", "PosVelJoint", "PosVelAccJoint", "JointState")
)
_REDUCTIONS = ("mechanicalReduction", "mechanical_reduction")


@rule("RD703", Severity.ERROR, good=arm(more=_TRANSMISSION), bad=(">50<", ">0<"))
def transmission(context: Context) -> Faults:
    """A transmission has a name of its own and a type, and drives moving joints, each once, by a ratio that is not 0.

    A joint in two transmissions gets two drives, or the later one replaces the earlier. A reduction of 0 is refused.
    One without a type is passed over, and so is a joint whose hardware interface has a name that nobody offers; a drive
    of a fixed joint moves nothing. Types and interfaces of other packages are not judged, but for those that are the
    usual ones' but for a slip.
    """
    root = context.view.root
    inside = [each for control in root.findall("ros2_control") for each in control.findall("transmission")]
    for transmissions in (root.findall("transmission"), inside):
        driven = [(joint, _subject(each)) for each in transmissions for joint in each.findall("joint")]
        subjects = {id(joint): subject for joint, subject in driven}
        for joint, first in namesakes(joint for joint, _ in driven):
            what = f"joint '{joint.get('name')}' is driven a second time; the first is in line {first.line}"
            yield Fault(value_span(joint, "name"), what, "keep one of the two", subject=subjects[id(joint)])
        for each in transmissions:
            yield from _reductions(each)
    for again, first in namesakes(root.findall("transmission")):
        what = f"a second transmission of this name; the first is in line {first.line}"
        at = value_span(again, "name")
        yield Fault(at, what, "rename one of them", subject=_subject(again), severity=Severity.WARNING)
    for each in root.findall("transmission"):
        yield from _drives_nothing(each, context.view)


def _drives_nothing(transmission: Element, view: View) -> Iterator[Fault]:
    subject, kind = _subject(transmission), transmission.find("type")
    said = transmission.get("type") if kind is None else kind.text.strip()
    if not said:
        what = "the transmission has no type: readers pass over it"
        remedy = f"write <type>transmission_interface/{_TYPES[0]}</type>"
        yield Fault(transmission.span, what, remedy, subject=subject, severity=Severity.WARNING)
    elif meant := slip_of(said.rpartition("/")[2], _TYPES):
        what, remedy = f"nobody offers the type {shown(said)}", f"did you mean {shown(meant)}?"
        yield Fault((kind or transmission).span, what, remedy, subject=subject, severity=Severity.WARNING)
    for joint in transmission.findall("joint"):
        moved = view.joint.get(joint.get("name") or "")
        if moved is not None and moved.type == "fixed":
            what = f"it drives joint {shown(moved.name)}, which is fixed in line {moved.element.line}"
            remedy = "delete the transmission, or let the joint move (type=...)"
            yield Fault(value_span(joint, "name"), what, remedy, subject=subject, severity=Severity.WARNING)
        for interface in joint.findall("hardwareInterface"):
            name = interface.text.strip().rpartition("/")[2]
            if meant := slip_of(name, _INTERFACES):
                what, remedy = f"nobody offers the interface {shown(name)}", f"did you mean {shown(meant)}?"
                yield Fault(interface.span, what, remedy, subject=subject, severity=Severity.WARNING)


def _reductions(transmission: Element) -> Iterator[Fault]:
    subject = _subject(transmission)
    for element in (transmission, *transmission.children):
        for reduction in (child for child in element.children if child.tag in _REDUCTIONS):
            ratio = numbers(reduction, TEXT, 1)
            if unexpanded(reduction.text):
                continue
            if ratio.problem is not None:
                yield Fault(reduction.span, f"the reduction {ratio.problem}", ratio.problem.remedy, subject=subject)
            elif ratio.value == 0:
                what = "the reduction is 0: its inverse is infinite"
                yield Fault(reduction.span, what, "write turns in per turn out", 0.0, None, subject)


def _subject(transmission: Element) -> Subject:
    return Subject("transmission", transmission.get("name") or "")
