"""Transmissions, ros2_control, Gazebo and SRDF entries name links and joints that exist.

Controllers fail at start, or the entry is dropped without a word, where a joint was renamed in
one place and not in the others. Asked are <joint> in <transmission> and <ros2_control>, the reference of <gazebo>, the
joints and bodies that its plugins name (jointName, mimicJoint, bodyName and so on; no frames, which others may
publish), and the SRDF of the same name (or the only one for this robot) beside the file or in a folder config or srdf:
its groups, chains, states, end effectors, passive and virtual joints. Collisions of links that do not exist, and an
SRDF of another name, which may belong to a variant of the robot, are warnings. root_joint, as Pinocchio calls a free
base, is understood.
"""

from collections.abc import Collection, Iterator

from robodyn.checks.examples import arm
from robodyn.checks.ros.gazebo import named_by_plugins
from robodyn.checks.ros.srdf import Named, srdf
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.robot.urdf.elements import Element
from robodyn.robot.urdf.numbers import value_span
from robodyn.robot.urdf.view import Subject
from robodyn.robot.urdf.xml_reader import unexpanded
from robodyn.support.wording import alternatives, shown

_PAIRS_ONLY = frozenset({"disable_collisions", "enable_collisions", "disable_default_collisions"})

_TRANSMISSION = """
  <transmission name="drive">
    <type>transmission_interface/SimpleTransmission</type>
    <joint name="shoulder"><hardwareInterface>hardware_interface/EffortJointInterface</hardwareInterface></joint>
    <actuator name="motor"><mechanicalReduction>50</mechanicalReduction></actuator>
  </transmission>"""


@rule(Severity.ERROR, good=arm(more=_TRANSMISSION), bad=('<joint name="shoulder"><', '<joint name="sholder"><'))
def check(context: Context) -> Faults:
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
            what = f"there is no {used.kind} {shown(used.name)} in the robot"
            remedy = remedies[used.name]
            at = value_span(used.element, used.attribute)
            yield Fault(at, what, remedy, subject=Subject(owner.tag, owner.get("name") or owner.get("reference") or ""))
    yield from _in_srdf(context)


def _uses(owner: Element) -> Iterator[Named]:
    """Yield the names that an element of the robot uses."""
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
    """Yield one fault for each name; of an SRDF of another name, which may be of a variant of the robot, one warning;
    none where all of it is another robot's, which RD706 says."""
    found, view = context.once(srdf), context.view
    if found is None or found.is_of_another:
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
