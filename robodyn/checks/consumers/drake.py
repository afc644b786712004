"""What Drake 1.51 refuses of joints, sizes, materials and transmissions; each was learnt by running it."""

from __future__ import annotations

from collections.abc import Iterator
from math import hypot

from robodyn.checks.consumers.found import Found, joints, named, part
from robodyn.checks.context import Context
from robodyn.robot.urdf.elements import Element
from robodyn.robot.urdf.numbers import numbers
from robodyn.robot.urdf.parts import WITH_AXIS
from robodyn.robot.urdf.view import JointView

_FREEDOM = {"fixed": 0, "planar": 3, "floating": 6}
_LEAST_AXIS, _LEAST_SCALE = 1e-8, 1e-8
_LIMITED = ("revolute", "continuous", "prismatic")


def _upside_down(joint: JointView) -> bool:
    limit = joint.limit if joint.type in _LIMITED else None
    lower, upper = (None, None) if limit is None else (limit.lower.value, limit.upper.value)
    return lower is not None and upper is not None and lower > upper


def _backwards(joint: JointView) -> bool:
    limit = joint.limit if joint.type in _LIMITED else None
    return limit is not None and (limit.velocity.value or 0.0) < 0


no_axis = joints(lambda joint: joint.type in WITH_AXIS and hypot(*(joint.axis.values or (1.0,))) < _LEAST_AXIS)
upside_down = joints(_upside_down)
backwards = joints(_backwards)
negative_damping = joints(lambda joint: joint.type in _LIMITED and (joint.damping.value or 0.0) < 0)
single_damping = joints(lambda joint: joint.type == "planar" and joint.damping.values)


def mimic_leader(context: Context) -> Iterator[Found]:
    """Yield mimic joints whose leader is not there, is the joint itself, or has other degrees of freedom."""
    for joint in context.view.joints:
        if joint.mimic is None:
            continue
        leader = context.view.joint.get(joint.mimic.joint)
        if leader is None or leader is joint or _FREEDOM.get(leader.type, 1) != _FREEDOM.get(joint.type, 1):
            yield part(joint, joint.mimic.element)


def sizeless(context: Context) -> Iterator[Found]:
    """Yield primitives with a size that is not positive, but for spheres of no radius, and meshes scaled to nothing."""
    for link in context.view.links:
        for shape in link.geometries:
            least = min((value for size in shape.sizes for value in size.values or ()), default=1.0)
            scale = min(map(abs, shape.scale.values or (1.0,)))
            sphere = shape.shape is not None and shape.shape.tag == "sphere"
            if least < 0 or (least == 0 and not sphere) or (not shape.sizes and scale < _LEAST_SCALE):
                yield Found(shape.element.span, f"the {shape.kind} of {named(link)}")


def materials(context: Context) -> Iterator[Found]:
    """Yield materials that are not defined before they are used, that are defined anew, or of colours not in [0, 1].

    Those of the robot come first, wherever they stand. One colour without name is each one's own.
    """
    known: dict[str, tuple[float, ...] | None] = {}
    for element in context.view.root.findall("material"):
        yield from _defined(element, known, " in the robot")
        if element.get("name") is None:
            yield Found(element.span, "a <material> without a name in the robot")
    for link in context.view.links:
        for shape in link.geometries:
            element_or_none = shape.element.find("material") if shape.kind == "visual" else None
            if element_or_none is not None:
                where = f" in {named(link)}"
                yield from _defined(element_or_none, known, where)
                colour = _colour(element_or_none) or known.get(element_or_none.get("name") or "")
                if colour and not 0 <= min(colour) <= max(colour) <= 1:
                    yield Found(element_or_none.span, f"a colour beyond 0 to 1{where}")


def _defined(element: Element, known: dict[str, tuple[float, ...] | None], where: str) -> Iterator[Found]:
    """Take note of a material; yield it where it is not defined, or not as it was."""
    name, colour, texture = element.get("name") or "", _colour(element), element.find("texture")
    if not name:
        return
    if colour is None and (texture is None or not texture.get("filename")):
        if name not in known:
            yield Found(element.span, f"'{name}', not defined,{where}")
    elif name in known and colour and known[name] and colour != known[name]:
        yield Found(element.span, f"'{name}', of another colour,{where}")
    else:
        known.setdefault(name, colour)


def _colour(element: Element) -> tuple[float, ...] | None:
    return numbers(element.find("color"), "rgba", 4).values


def transmissions(context: Context) -> Iterator[Found]:
    """Yield simple transmissions without joint or actuator, of a joint that cannot have one, or of a known name."""
    actuators: set[str] = set()
    for element in context.view.root.findall("transmission"):
        problem = _transmission(context, element, actuators)
        if problem:
            yield Found(element.span, f"transmission '{element.get('name') or ''}' {problem}")


def _transmission(context: Context, element: Element, actuators: set[str]) -> str:
    """Return what is wrong with one, in words; take note of its actuator."""
    inner = element.find("type")
    text = element.get("type") if inner is None else inner.text
    if not text:
        return "has no type"
    if "SimpleTransmission" not in text:
        return ""
    joint, actuator = ((child and child.get("name")) or "" for child in map(element.find, ("joint", "actuator")))
    found = context.view.joint.get(joint)
    kind = "floating" if found is None else found.type
    effort = 0.0 if found is None or found.limit is None else found.limit.effort.value or 0.0
    problems = {
        "has no named actuator": not actuator,
        "has no joint to act on": kind == "floating",
        "acts on a planar joint": kind == "planar",
        f"acts on joint '{joint}' of negative effort": effort < 0 and kind != "fixed",
        f"has an actuator '{actuator}' that another has": actuator in actuators and kind != "fixed",
    }
    if kind != "fixed":
        actuators.add(actuator)
    return next((words for words, holds in problems.items() if holds), "")


def missing_textures(context: Context) -> Iterator[Found]:
    """Yield textures of visuals whose file is not there."""
    for link in context.view.links:
        for shape in link.geometries:
            material = shape.element.find("material") if shape.kind == "visual" else None
            texture = None if material is None else material.find("texture")
            name = "" if texture is None else texture.get("filename") or ""
            if texture is not None and name and context.search.find(name) is None:
                yield Found(texture.span, f"{name} in {named(link)}")
