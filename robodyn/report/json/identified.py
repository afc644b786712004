"""What identification found, as JSON."""

from __future__ import annotations

from typing import Any

from robodyn.identification.identified import Errors, Identified
from robodyn.report.json.encode import encode, finite, select, written


def identified_json(found: Identified) -> str:
    """Return errors, base parameters with standard errors, motors, and every parameter before and after."""
    held = found.original_held_out or found.original_train
    return written(
        select(
            found,
            "robot:model.name train held_out original bound consistent better base_parameters rank:base.base.rank "
            "condition:base.base.condition friction coupled discrepancy delays "
            "strength cutoff slip_speed unseen parameters rows samples "
            "duration logs warnings",
            original={**_errors(held), **_both(found.original_train, found.original_held_out)},
            bound=_both(found.bound_train, found.bound_held_out),
            base_parameters=_base(found),
            friction=[{"name": name, **encode(fit)} for name, fit in found.motors.items()],
            coupled=[{"name": name, "unexplained": part} for name, part in found.coupled.items()],
            parameters=_parameters(found),
            discrepancy=dict(found.discrepancy),
            delays=dict(found.delays),
            logs=[{"path": path, "sha256": sha256} for path, sha256 in found.hashes.items()],
        )
    )


def _errors(errors: Errors) -> dict[str, Any]:
    return {"relative_error": finite(errors.relative_error), "joints": dict(errors.joints)}


def _both(train: Errors, held_out: Errors | None) -> dict[str, Any]:
    return {"train": _errors(train), "held_out": held_out and _errors(held_out)}


def _base(found: Identified) -> list[dict[str, Any]]:
    fit = found.base
    columns = (fit.values.tolist(), fit.standard_errors.tolist(), fit.consistent.tolist())
    return [
        {"name": group, "parameter": fit.base.names[k], "value": value, "standard_error": error, "calibrated": after}
        for group, k, value, error, after in zip(fit.base.groups, fit.base.independent, *columns, strict=True)
    ]


def _parameters(found: Identified) -> list[dict[str, Any]]:
    pairs = zip(found.names, found.described.tolist(), found.theta.tolist(), strict=True)
    return [{"name": name, "described": before, "calibrated": after} for name, before, after in pairs]
