"""<transmission>: reduction and rotor inertia of the motors that drive one joint each."""

from __future__ import annotations

from collections.abc import Collection

from robodyn.robot.urdf.elements import Element
from robodyn.robot.urdf.fields import Fields
from robodyn.robot.urdf.numbers import NumbersError, parse_numbers
from robodyn.robot.urdf.parts import Transmission
from robodyn.support.wording import shown

_REDUCTIONS = ("mechanicalReduction", "mechanical_reduction", "drake:gear_ratio")
_ROTOR_INERTIAS = ("rotorInertia", "rotor_inertia", "motorInertia", "motor_inertia", "drake:rotor_inertia")


def read_transmission(element: Element, joints: Collection[str], fields: Fields) -> Transmission | None:
    """Return a transmission; None, with a warning, where no single joint of the robot is driven."""
    name = element.get("name") or ""
    owner = f"transmission {shown(name)}"
    driven = element.findall("joint")
    actuators = element.findall("actuator")
    if len(driven) != 1 or len(actuators) > 1:
        counts = f"{len(driven)} <joint> and {len(actuators)} <actuator>"
        fields.warn(element.line, f"{owner} has {counts} and is left out: only one motor on one joint is understood")
        return None
    joint = driven[0].get("name")
    if joint is None or joint not in joints:
        fields.warn(driven[0].line, f"{owner} names no joint of the robot and is left out: {shown(joint or '')}")
        return None
    places = (*actuators, *driven, element)
    reduction = _value(places, _REDUCTIONS, owner, fields)
    if reduction == 0:
        fields.warn(element.line, f"{owner} has the reduction 0: the rotor does not turn with the joint")
    if reduction is None:
        fields.default(element.line, f"{owner} has no <mechanicalReduction>: 1")
    rotor_inertia = _value(places, _ROTOR_INERTIAS, owner, fields)
    return Transmission(name, joint, 1.0 if reduction is None else reduction, rotor_inertia, element.line)


def _value(places: Collection[Element], tags: Collection[str], owner: str, fields: Fields) -> float | None:
    """Return the one value that the actuator, the joint or the transmission gives."""
    found = [child for place in places for child in place.children if child.tag in tags]
    if not found:
        return None
    values = [_number(element, owner, fields) for element in found]
    for element, value in zip(found, values, strict=True):
        if value != values[0]:
            what = f"{owner} contradicts itself: <{found[0].tag}> {values[0]:g} in line {found[0].line}, then {value:g}"
            raise fields.error(element.line, what, "keep one of them")
    return values[0]


def _number(element: Element, owner: str, fields: Fields) -> float:
    """Return the number in the element's text, or in its attribute `value`, as Drake writes it."""
    if element.get("value") is not None:
        return fields.needed_number(element, "value", owner)
    try:
        return parse_numbers(element.text, 1)[0]
    except NumbersError as error:
        raise fields.error(element.line, f"<{element.tag}> of {owner} {error}", error.remedy) from None
