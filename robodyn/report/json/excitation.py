"""Exciting motions as JSON."""

from __future__ import annotations

from typing import Any

from robodyn.identification.excitation.result import Excitation, Information
from robodyn.report.json.encode import finite, select, written


def excitation_json(found: Excitation) -> str:
    """Return joints with their series, base parameters with predicted standard errors, and what plain waves show."""
    base = found.base
    parameters = [
        {"name": group, "parameter": base.names[k], "value": value, "standard_error": error}
        for group, k, value, error in zip(
            base.groups,
            base.independent,
            found.values.tolist(),
            found.information.standard_errors.tolist(),
            strict=True,
        )
    ]
    return written(
        select(
            found,
            "robot:model.name period:series.period harmonics:series.harmonics rate rows joints base_parameters rank "
            "condition log_determinant plain gain invisible warnings:notes",
            rows=found.motion.shape[1],
            base_parameters=parameters,
            **_told(found.information),
            plain=_told(found.plain),
            gain=finite(found.gain),
            invisible=[base.names[k] for k in base.invisible],
        )
    )


def _told(information: Information) -> dict[str, Any]:
    """Return numbers, null where not all parameters are shown."""
    return {
        "rank": information.rank,
        "condition": finite(information.condition),
        "log_determinant": finite(information.log_determinant),
    }
