"""Measured against computed torques as JSON."""

from __future__ import annotations

from typing import Any

import numpy as np

from robodyn.dynamics.regressor import INERTIAL
from robodyn.identification.compare import Comparison, JointComparison
from robodyn.identification.fault_columns import OWN
from robodyn.identification.faults import Fault
from robodyn.report.json.encode import select, written
from robodyn.report.measured_words import fault_words


def measured_json(found: Comparison) -> str:
    """Return joints, gross faults, and the diagnosis; what cannot be told is null."""
    names = [joint.name for joint in found.joints]
    return written(
        select(
            found,
            "robot file samples duration cutoff compared relative_error relative_error_left:left joints exchanged "
            "reversed diagnosis warnings:notes",
            joints=[_joint(joint) for joint in found.joints],
            exchanged=[[names[j] for j in group] for group in found.channels.exchanged],
            reversed=[names[j] for j in found.channels.reversed],
            diagnosis=[_fault(found, fault) for fault in found.faults],
        )
    )


def _joint(joint: JointComparison) -> dict[str, Any]:
    effects = {
        kind: None
        if kind not in joint.effects
        else {"value": joint.effects[kind][0] + (kind == "gain"), "standard_error": joint.effects[kind][1]}
        for kind in OWN
    }
    keys = "name unit measured_rms:measured computed_rms:computed residual_rms:residual residual_rms_left:left"
    return select(joint, f"{keys} relative_error correlation moves effects", effects=effects)


def _fault(found: Comparison, fault: Fault) -> dict[str, Any]:
    j, kind = fault.effect.joint, fault.effect.kind
    names = INERTIAL if j is None else (kind,)
    shift = 1.0 if kind == "gain" else 0.0
    errors = np.sqrt(np.diag(fault.covariance))
    parameters = [
        {"name": name, "value": float(value) + shift, "standard_error": float(error)}
        for name, value, error in zip(names, fault.values, errors, strict=True)
        if error > 0.0
    ]
    return {
        "kind": kind,
        "joint": None if j is None else found.joints[j].name,
        "link": found.load_link if j is None else None,
        "parameters": parameters,
        "certain": fault.certain,
        "explains": {joint.name: float(share) for joint, share in zip(found.joints, fault.shares, strict=True)},
        "words": fault_words(found, fault),
    }
