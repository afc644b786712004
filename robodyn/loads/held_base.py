"""Whether a base that is taken as held is one that in truth stands on legs or wheels, or flies."""

from __future__ import annotations

from collections.abc import Sequence
from math import hypot

from robodyn.loads.result import ComponentLoad, JointLoad
from robodyn.robot.model import Model
from robodyn.robot.standing import untouched
from robodyn.scene.scene import Scene
from robodyn.support.doubts import Doubt
from robodyn.support.wording import figure, shown

VANISHING = 0.01
"""Of the weight, or of the largest force that balances: a base wrench below it is rounding or noise."""


def carried(
    model: Model,
    scene: Scene,
    base: Sequence[ComponentLoad],
    joints: Sequence[JointLoad],
    largest_force: float,
    largest_moment: float,
) -> tuple[Doubt, ...]:
    """Return what is in doubt about what carries the base, and what carries the robot at floating joints.

    Nothing where the scene says that the base is held, where no wrench is left, and where a base that does not move may
    well be bolted down.

    Args:
        base, joints: their loads.
        largest_force, largest_moment: that balance along the motion [N, N m].
    """
    weight = model.total_mass * hypot(*scene.gravity)
    least = VANISHING * max(weight, largest_force), VANISHING * max(weight * model.reach, largest_moment)
    parts = {part.name: part.rms for part in base}
    wrench = [hypot(*(parts[f"{kind}{axis}"] for axis in "xyz")) for kind in "fm"]
    found = [_base_doubt(model, scene, *wrench)] if _left(wrench, least) else []
    loads = {joint.name: joint.rms for joint in joints}
    for name in (body.joint.name for body in model.bodies[1:] if body.joint.kind == "floating"):
        wrench = [hypot(*(loads[f"{name}_{kind}{axis}"] for axis in "xyz")) for kind in "vw"]
        if _left(wrench, least):
            what = f"nothing drives the floating joint {shown(name)}, whose motion takes {_wrench(*wrench)}"
            found.append(Doubt("as long as what floats is carried (assumed)", f"{what}; give it as [[wrench]]"))
    return tuple(doubt for doubt in found if doubt is not None)


def _left(wrench: Sequence[float], least: Sequence[float]) -> bool:
    return any(size > most for size, most in zip(wrench, least, strict=True))


def _wrench(force: float, moment: float) -> str:
    return f"{figure(force)} N and {figure(moment)} N m (RMS)"


def _base_doubt(model: Model, scene: Scene, force: float, moment: float) -> Doubt | None:
    alone = "the wrenches of the scene do not carry it" if scene.wrenches else "there is no contact that carries it"
    why = alone if model.floating else untouched(model)
    if scene.held or not why:
        return None
    loads = "which a robot that floats cannot have" if model.floating else "loads of a robot that hangs by its base"
    free = "" if model.floating else 'let the base move ([base] motion = "moving", base_ columns) and '
    said = (
        f"the ground holds the base with {_wrench(force, moment)}, {loads}: {why}; "
        f"if something carries the base, such as bolts or a vehicle, say so (--base-held, or [base] held = true), "
        f"otherwise {free}give the contact forces as [[wrench]]"
    )
    return Doubt("as long as the base is held (assumed)", said)
