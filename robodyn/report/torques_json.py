"""`torques` as JSON: one motion, its sizing, and many motions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from robodyn.report.document import encode, select, written
from robodyn.report.limits import torques_verdict
from robodyn.robot.limits import Coverage

if TYPE_CHECKING:
    from robodyn.loads.many import Batch, Outcome, Status
    from robodyn.loads.result import BearingLoad, EffectReport, JointLoad, Result, Sizing


def torques_json(result: Result) -> str:
    """Return the document of `torques`, with the keys of docs/reference/schemas; units are SI."""
    checks = result.checks
    balance = select(
        checks.energy_balance,
        "work energy_change residual quadrature_error:quadrature turnover largest_residual:worst consistent",
    )
    document = select(
        result,
        "robot samples duration gravity joints base_wrench effects checks plan derivatives time_origin:origin held "
        "limits_exceeded:exceeded limits within_limits verdict doubts:caveats warnings",
        base_wrench={part.name: select(part, "peak peak_time rms") for part in result.base_wrench},
        effects=[_effect(effect, result.joints) for effect in result.effects],
        checks=select(checks, "energy_balance first_law second_law power samples", energy_balance=balance),
        plan=select(result, "executor operations reason"),
        derivatives=result.derivation.joints if result.derivation else [],
        limits=limits_data(result.limits),
        verdict=torques_verdict(result),
    )
    sizing = result.sizing and sizing_data(result.sizing)
    parts: dict[str, Any] = {"momentum": result.momentum, "accuracy": result.accuracy, "sizing": sizing}
    parts |= {"constraints": result.constraints, "uncertainty": result.uncertainty}
    return written({**document, **{key: part for key, part in parts.items() if part is not None}})


def _effect(effect: EffectReport, joints: Sequence[JointLoad]) -> dict[str, Any]:
    share = {joint.name: joint.shares[effect.name] for joint in joints if effect.name in joint.shares}
    data = select(effect, "name active:verdict.active reason:verdict.reason share operations", share=share)
    return data if effect.saved is None else {**data, "operations_saved_without": effect.saved}


def limits_data(limits: Sequence[Coverage]) -> dict[str, Any]:
    """Return by quantity the joints whose limits were checked, and those without, with what is given instead."""
    return {each.quantity: select(each, "checked unchecked") for each in limits}


def sizing_data(sizing: Sizing) -> dict[str, Any]:
    """Return `joints`, `bearings` and `foundation`, as docs/reference/schemas has them."""
    return {
        "joints": sizing.joints,
        "bearings": list(map(_bearing, sizing.bearings)),
        "foundation": {load.name: _unnamed(load) for load in sizing.foundation},
    }


def _bearing(bearing: BearingLoad) -> dict[str, Any]:
    directions = dict(zip(("u", "v", "axis"), bearing.directions, strict=True))
    parts = {part.name: _unnamed(part) for part in (*bearing.components, bearing.radial, bearing.tilting)}
    return select(bearing, "joint kind directions components", directions=directions, components=parts)


def _unnamed(load: object) -> dict[str, Any]:
    return {key: value for key, value in encode(load).items() if key != "name"}


def batch_json(batch: Batch) -> str:
    """Return `robot`, `files` in the order of the trajectories, the `worst` of each joint, and counts."""
    kinds: tuple[Status, ...] = ("computed", "finished before", "failed")
    counts = {kind.replace(" ", "_"): batch.count(kind) for kind in kinds}
    keys = "robot files worst computed finished_before failed within_limits"
    return written(select(batch, keys, files=list(map(_file, batch.outcomes)), **counts))


def _file(outcome: Outcome) -> dict[str, Any]:
    if outcome.status == "failed":
        return select(outcome, "trajectory status error")
    every = {key: value for key, value in encode(outcome).items() if key not in ("joints", "error")}
    return {**every, "limits": limits_data(outcome.limits), "within_limits": outcome.within_limits}
