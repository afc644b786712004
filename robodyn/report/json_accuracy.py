"""What accuracy costs, as one JSON document with stable keys and full precision."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from robodyn.measure.accuracy.ladder import Accuracy, Ladder, Rung


def accuracy_json(accuracy: Accuracy, target: float | None = None) -> str:
    """The document; times are in seconds: the median, the quartiles `low` and `high`, and how many `runs`."""
    import json

    document = {
        "name": accuracy.name,
        "target": target,
        "ladders": [_ladder(ladder, target) for ladder in accuracy.ladders],
        "prices": [asdict(price) for price in accuracy.prices],
        "effects": [asdict(effect) for effect in accuracy.effects],
        "notes": list(accuracy.notes),
    }
    return json.dumps(document, indent=2, allow_nan=False) + "\n"


def _ladder(ladder: Ladder, target: float | None) -> dict[str, Any]:
    cheapest = None if target is None else ladder.cheapest(target)
    return {
        "title": ladder.title,
        "reference": ladder.reference,
        "per": ladder.per,
        "methods": [_rung(ladder, rung) for rung in ladder.rungs],
        "front": [rung.name for rung in ladder.front],
        "cheapest": cheapest and cheapest.name,
    }


def _rung(ladder: Ladder, rung: Rung) -> dict[str, Any]:
    other = ladder.dominator(rung)
    return {
        "name": rung.name,
        "errors": dict(zip(ladder.measures, rung.errors, strict=True)),
        "error": rung.error,
        "time": asdict(rung.time),
        "operations": rung.operations,
        **({} if rung.drift is None else {"evaluations": rung.evaluations, "drift": rung.drift}),
        "dominated_by": other and other.name,
    }
