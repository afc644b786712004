"""`torques` as JSON: one motion, its sizing, and many motions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from typing import TYPE_CHECKING, Any

from robodyn.loads.constraint_result import Peak
from robodyn.report.document import encode, select, written
from robodyn.report.limits import torques_verdict
from robodyn.robot.limits import Coverage

if TYPE_CHECKING:
    from robodyn.loads.checks_result import Checks
    from robodyn.loads.constraint_result import Constraints
    from robodyn.loads.many import Batch, Outcome
    from robodyn.loads.result import EffectReport, JointLoad, Result
    from robodyn.loads.sizing_result import BearingLoad, JointSizing, Sizing


def torques_json(result: Result) -> str:
    """Return the document of `torques`, with the keys of docs/reference/schemas; units are SI."""
    document = select(
        result,
        "robot samples duration gravity joints base_wrench effects checks plan derivatives time_origin:origin held "
        "limits_exceeded:exceeded limits within_limits verdict doubts:caveats warnings",
        joints=list(map(_joint, result.joints)),
        base_wrench={part.name: select(part, "peak peak_time rms") for part in result.base_wrench},
        effects=[_effect(effect, result.joints) for effect in result.effects],
        checks=_checks(result.checks),
        plan=select(result, "executor operations reason"),
        derivatives=result.derivation.joints if result.derivation else [],
        limits=limits_data(result.limits),
        verdict=torques_verdict(result),
    )
    sizing = result.sizing and sizing_data(result.sizing)
    constraints = result.constraints and constraint_data(result.constraints)
    parts: dict[str, Any] = {"momentum": result.momentum, "accuracy": result.accuracy, "sizing": sizing}
    parts |= {"constraints": constraints, "uncertainty": result.uncertainty}
    return written({**document, **{key: part for key, part in parts.items() if part is not None}})


def constraint_data(found: Constraints) -> dict[str, Any]:
    """Return what loops and contacts bear, peaks as objects of value, time and row."""
    return {
        **encode(found),
        "loops": [_peaks(loop) for loop in found.loops],
        "contacts": [_peaks(contact) for contact in found.contacts],
        "unbalanced": [_peaks(each) for each in found.unbalanced],
        "missing": [_peaks(each) for each in found.missing],
    }


def _peaks(load: object) -> dict[str, Any]:
    """Return the fields of a load, its peaks as objects."""
    values = {field.name: getattr(load, field.name) for field in fields(load)}  # type: ignore[arg-type]
    return {name: value._asdict() if isinstance(value, Peak) else encode(value) for name, value in values.items()}


def _joint(joint: JointLoad) -> dict[str, Any]:
    every = encode(joint)
    shares = every.pop("shares")
    return {**every, **select(joint, "effort_margin velocity_margin"), "shares": shares}


def _effect(effect: EffectReport, joints: Sequence[JointLoad]) -> dict[str, Any]:
    share = {joint.name: joint.shares[effect.name] for joint in joints if effect.name in joint.shares}
    data = select(effect, "name active:verdict.active reason:verdict.reason share operations", share=share)
    return data if effect.saved is None else {**data, "operations_saved_without": effect.saved}


def _checks(checks: Checks) -> dict[str, Any]:
    balance = select(
        checks.energy_balance,
        "work energy_change residual quadrature_error:quadrature turnover largest_residual:worst consistent",
    )
    return select(checks, "energy_balance first_law second_law power samples", energy_balance=balance)


def limits_data(limits: Sequence[Coverage]) -> dict[str, Any]:
    """Return by quantity the joints whose limits were checked, and those without, with what is given instead."""
    return {each.quantity: select(each, "checked unchecked") for each in limits}


def sizing_data(sizing: Sizing) -> dict[str, Any]:
    """Return `joints`, `bearings` and `foundation`, as docs/reference/schemas has them."""
    return {
        "joints": list(map(_sized, sizing.joints)),
        "bearings": list(map(_bearing, sizing.bearings)),
        "foundation": {load.name: _unnamed(load) for load in sizing.foundation},
    }


def _sized(joint: JointSizing) -> dict[str, Any]:
    motor = joint.motor and {**encode(joint.motor), **select(joint.motor, "continuous_margin peak_margin")}
    exceeded = [{**encode(each), **select(each, "excess level")} for each in joint.exceeded]
    return {**encode(joint), "motor": motor, "exceeded": exceeded}


def _bearing(bearing: BearingLoad) -> dict[str, Any]:
    return select(
        bearing,
        "joint kind directions components",
        directions=dict(zip(("u", "v", "axis"), bearing.directions, strict=True)),
        components={part.name: _unnamed(part) for part in (*bearing.components, bearing.radial, bearing.tilting)},
    )


def _unnamed(load: object) -> dict[str, Any]:
    return {key: value for key, value in encode(load).items() if key != "name"}


def batch_json(batch: Batch) -> str:
    """Return `robot`, `files` in the order of the trajectories, the `worst` of each joint, and counts."""
    return written(
        select(
            batch,
            "robot files worst computed finished_before failed within_limits",
            files=list(map(_file, batch.outcomes)),
            computed=batch.count("computed"),
            finished_before=batch.count("finished before"),
            failed=batch.count("failed"),
        )
    )


def _file(outcome: Outcome) -> dict[str, Any]:
    if outcome.status == "failed":
        return select(outcome, "trajectory status error")
    every = {key: value for key, value in encode(outcome).items() if key not in ("joints", "error")}
    return {**every, "limits": limits_data(outcome.limits), "within_limits": outcome.within_limits}
