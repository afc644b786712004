"""<joint>: what moves against what, how, and within which limits."""

from __future__ import annotations

from math import hypot

from robodyn.robot.urdf.elements import Element
from robodyn.robot.urdf.fields import Fields
from robodyn.robot.urdf.parts import JOINT_TYPES, WITH_AXIS, WITH_RANGE, Joint, Limit, Mimic, Vector
from robodyn.support.wording import alternatives, shown

_DEFAULT_AXIS: Vector = (1.0, 0.0, 0.0)
_UNIT_TOLERANCE = 1e-6


def read_joint(element: Element, fields: Fields) -> Joint:
    name = fields.name(element, "name", "<joint>")
    owner = f"joint {shown(name)}"
    kind = _type(element, owner, fields)
    parent = fields.name(fields.needed_child(element, "parent", owner), "link", owner)
    child = fields.name(fields.needed_child(element, "child", owner), "link", owner)
    damping, friction = _dynamics(element, owner, fields)
    return Joint(
        name=name,
        type=kind,
        parent=parent,
        child=child,
        origin=fields.origin(element, owner),
        axis=_axis(element, kind, owner, fields),
        limit=_limit(element, kind, owner, fields),
        damping=damping,
        friction=friction,
        mimic=_mimic(element, owner, fields),
        line=element.line,
    )


def _type(element: Element, owner: str, fields: Fields) -> str:
    kind = fields.name(element, "type", owner)
    if kind not in JOINT_TYPES:
        remedy = alternatives(kind.lower(), JOINT_TYPES, "types")
        raise fields.error(element.line, f"{owner} has the unknown type {shown(kind)}", remedy)
    return kind


def _axis(element: Element, kind: str, owner: str, fields: Fields) -> Vector:
    """Return the axis as written. Only the types that move along or about it need it to be a direction."""
    written = fields.child(element, "axis", owner)
    if written is None:
        if kind in WITH_AXIS:
            fields.default(element.line, f"{owner} has no <axis>: 1 0 0")
        return _DEFAULT_AXIS
    axis = fields.vector(written, "xyz", owner)
    if axis is None:
        raise fields.missing(written, "xyz", owner)
    length = hypot(*axis)
    if kind not in WITH_AXIS or abs(length - 1) <= _UNIT_TOLERANCE:
        return axis
    if length == 0:
        what = f"the axis of {owner} has the length 0, which gives no direction"
        raise fields.error(written.line, what, 'write a direction, for example xyz="0 0 1"')
    fields.warn(written.line, f"the axis of {owner} has the length {length:.9g}, not 1")
    return axis


def _limit(element: Element, kind: str, owner: str, fields: Fields) -> Limit | None:
    written = fields.child(element, "limit", owner)
    if written is None:
        if kind in WITH_RANGE:
            fields.default(element.line, f"{owner} has no <limit>: unlimited")
        return None
    values = {name: fields.number(written, name, owner) for name in ("lower", "upper", "effort", "velocity")}
    limit = Limit(**values)
    absent = [
        name for name in values if values[name] is None and (kind in WITH_RANGE or name in ("effort", "velocity"))
    ]
    if absent:
        fields.default(written.line, f"<limit> of {owner} has no {', '.join(absent)}: unlimited")
    if limit.lower is not None and limit.upper is not None and limit.lower > limit.upper:
        fields.warn(written.line, f"<limit> of {owner} is empty: lower {limit.lower:g} > upper {limit.upper:g}")
    for name in ("effort", "velocity"):
        value = values[name]
        if value is not None and value < 0:
            fields.warn(written.line, f"<limit> of {owner} has a negative {name}: {value:g}")
    return limit


def _dynamics(element: Element, owner: str, fields: Fields) -> tuple[float, float]:
    written = fields.child(element, "dynamics", owner)
    if written is None:
        return 0.0, 0.0
    damping = fields.number_or(0.0, written, "damping", owner)
    friction = fields.number_or(0.0, written, "friction", owner)
    for name, value in (("damping", damping), ("friction", friction)):
        if value < 0:
            fields.warn(written.line, f"<dynamics> of {owner} has a negative {name}: {value:g}, which feeds energy in")
    return damping, friction


def _mimic(element: Element, owner: str, fields: Fields) -> Mimic | None:
    written = fields.child(element, "mimic", owner)
    if written is None:
        return None
    return Mimic(
        fields.name(written, "joint", owner),
        fields.number_or(1.0, written, "multiplier", owner),
        fields.number_or(0.0, written, "offset", owner),
    )
