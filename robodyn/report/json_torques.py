"""The result of `torques` as one JSON document with stable keys and full precision."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from robodyn.loads.result import Checks, JointLoad, Result
from robodyn.report.limits_words import limits_verdict
from robodyn.robot.limits import Coverage


def torques_json(result: Result) -> str:
    """The document; see README for its keys. Units are SI: N m or N, W, J, s, rad or m."""
    import json

    document: dict[str, Any] = {
        "robot": result.robot,
        "samples": result.samples,
        "duration": result.duration,
        "gravity": result.gravity,
        "joints": [_joint(joint) for joint in result.joints],
        "base_wrench": {
            part.name: {"peak": part.peak, "peak_time": part.peak_time, "rms": part.rms} for part in result.base_wrench
        },
        "effects": [
            {
                "name": effect.name,
                "active": effect.verdict.active,
                "reason": effect.verdict.reason,
                "share": {
                    joint.name: joint.shares[effect.name] for joint in result.joints if effect.name in joint.shares
                },
                "operations": effect.operations,
                **({} if effect.saved is None else {"operations_saved_without": effect.saved}),
            }
            for effect in result.effects
        ],
        "checks": _checks(result.checks),
        "plan": {"executor": result.executor, "operations": result.operations, "reason": result.reason},
        "derivatives": [asdict(joint) for joint in result.derivation.joints] if result.derivation else [],
        "time_origin": result.origin,
        "held": dict(result.held),
        "limits_exceeded": [asdict(excess) for excess in result.exceeded],
        "limits": limits_data(result.limits),
        "within_limits": result.within_limits,
        "verdict": asdict(limits_verdict(result)),
        "doubts": [asdict(doubt) for doubt in result.doubts],
        "warnings": list(result.warnings),
    }
    if result.momentum is not None:
        document["momentum"] = asdict(result.momentum)
    if result.accuracy is not None:
        document["accuracy"] = asdict(result.accuracy)
    if result.sizing is not None:
        from robodyn.report.json_sizing import sizing_data

        document["sizing"] = sizing_data(result.sizing)
    return json.dumps(document, indent=2, allow_nan=False) + "\n"


def _checks(checks: Checks) -> dict[str, Any]:
    balance = checks.energy_balance
    return {
        "energy_balance": {
            "work": balance.work,
            "energy_change": balance.energy_change,
            "residual": balance.residual,
            "quadrature_error": balance.quadrature,
            "turnover": balance.turnover,
            "largest_residual": balance.worst,
            "consistent": balance.consistent,
        },
        "first_law": checks.first_law,
        "second_law": checks.second_law,
        "power": checks.power,
        "samples": checks.samples,
    }


def limits_data(limits: Sequence[Coverage]) -> dict[str, Any]:
    """Return by quantity the joints whose limits were checked, and those without, with what is given instead."""
    return {
        each.quantity: {"checked": list(each.checked), "unchecked": [asdict(one) for one in each.unchecked]}
        for each in limits
    }


def _joint(joint: JointLoad) -> dict[str, Any]:
    fields = asdict(joint)
    shares = fields.pop("shares")
    return {**fields, "effort_margin": joint.effort_margin, "velocity_margin": joint.velocity_margin, "shares": shares}
