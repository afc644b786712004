"""The result of `bench` as one JSON document with stable keys and full precision."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from robodyn.measure.speed.result import Bench, EffectBench


def bench_json(bench: Bench) -> str:
    """The document; times are in seconds, those of samples for one: the `least`, the `median` and how many `runs`."""
    import json

    document = asdict(bench)
    document["effects"] = [_effect(effect) for effect in bench.effects]
    return json.dumps(document, indent=2, allow_nan=False) + "\n"


def _effect(effect: EffectBench) -> dict[str, Any]:
    report = effect.report
    return {
        "name": report.name,
        "reason": report.verdict.reason,
        "operations": report.operations,
        "operations_saved_without": report.saved,
        "without": None if effect.without is None else asdict(effect.without),
    }
