"""What motors, gears, bearings and the foundation bear, as data for JSON."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from robodyn.loads.sizing_result import BearingLoad, JointSizing, Sizing


def sizing_data(sizing: Sizing) -> dict[str, Any]:
    """`joints`, `bearings` and `foundation`, with stable keys; see README."""
    return {
        "joints": [_joint(joint) for joint in sizing.joints],
        "bearings": [_bearing(bearing) for bearing in sizing.bearings],
        "foundation": {load.name: _without(asdict(load), "name") for load in sizing.foundation},
    }


def _joint(joint: JointSizing) -> dict[str, Any]:
    fields = asdict(joint)
    if joint.motor is not None:
        margins = {"continuous_margin": joint.motor.continuous_margin, "peak_margin": joint.motor.peak_margin}
        fields["motor"] = {**fields["motor"], **margins}
    fields["exceeded"] = [
        {**asdict(exceeded), "excess": exceeded.excess, "level": exceeded.level} for exceeded in joint.exceeded
    ]
    return fields


def _bearing(bearing: BearingLoad) -> dict[str, Any]:
    components = (*bearing.components, bearing.radial, bearing.tilting)
    return {
        "joint": bearing.joint,
        "kind": bearing.kind,
        "directions": dict(zip(("u", "v", "axis"), bearing.directions, strict=True)),
        "components": {part.name: _without(asdict(part), "name") for part in components},
    }


def _without(fields: dict[str, Any], key: str) -> dict[str, Any]:
    fields.pop(key)
    return fields
