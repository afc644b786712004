"""What became of many trajectories as one JSON document."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from robodyn.loads.many import Batch, Outcome
from robodyn.report.json_torques import limits_data


def batch_json(batch: Batch) -> str:
    """The document: `robot`, `files` in the order of the trajectories, the `worst` of each joint, and counts."""
    import json

    document = {
        "robot": batch.robot,
        "files": [_file(outcome) for outcome in batch.outcomes],
        "worst": [asdict(worst) for worst in batch.worst],
        "computed": batch.count("computed"),
        "finished_before": batch.count("finished before"),
        "failed": batch.count("failed"),
        "within_limits": batch.within_limits,
    }
    return json.dumps(document, indent=2, allow_nan=False) + "\n"


def _file(outcome: Outcome) -> dict[str, Any]:
    fields = asdict(outcome)
    fields.pop("joints")
    if outcome.status == "failed":
        return {key: fields[key] for key in ("trajectory", "status", "error")}
    fields.pop("error")
    fields["limits"] = limits_data(outcome.limits)
    return {**fields, "within_limits": outcome.within_limits}
