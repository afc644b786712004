"""What URDF knows: the elements inside <robot>, their attributes, and which of these are numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from robodyn.checks.context import Context
from robodyn.robot.urdf.elements import Element
from robodyn.robot.urdf.parts import INERTIA, SIZES
from robodyn.robot.urdf.view import Subject


@dataclass(frozen=True, slots=True)
class Kind:
    """One element: how many numbers each attribute holds (0: text), which of them it must have, and its children."""

    attributes: Mapping[str, int]
    needed: tuple[str, ...] = ()
    children: tuple[str, ...] = ()
    repeated: tuple[str, ...] = ()
    """Children of which there may be several."""
    some: tuple[str, ...] = ()
    """Attributes of which it must have at least one."""


_MATERIAL = {"material": Kind({"name": 0}, (), ("color", "texture"))}
_SHAPE_KINDS = {
    **{tag: Kind({size: 3 if size == "size" else 1 for size in sizes}, sizes) for tag, sizes in SIZES.items()},
    "mesh": Kind({"filename": 0, "scale": 3}),
}
_LINK_KINDS = {
    "link": Kind({"name": 0}, (), ("inertial", "visual", "collision", "contact"), ("visual", "collision")),
    "inertial": Kind({}, (), ("origin", "mass", "inertia")),
    "mass": Kind({"value": 1}),
    "inertia": Kind(dict.fromkeys((*INERTIA, "iyx", "izx", "izy"), 1)),
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
    "limit": Kind(
        dict.fromkeys(("lower", "upper", "effort", "velocity", "acceleration", "deceleration", "jerk"), 1),
    ),
    "dynamics": Kind({"damping": 1, "friction": 1}, some=("damping", "friction")),
    "mimic": Kind({"joint": 0, "multiplier": 1, "offset": 1}),
    "safety_controller": Kind(
        dict.fromkeys(("soft_lower_limit", "soft_upper_limit", "k_position", "k_velocity"), 1),
        ("k_velocity",),
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
    """Return the elements that URDF knows, in the order of the file, each with what it is a part of.

    What other tools read is left out.
    """
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
