"""The result of `simulate` as one JSON document with stable keys and full precision."""

from __future__ import annotations

from typing import Any

from robodyn.simulation.loop_figures import PARTS, LoopFigures
from robodyn.simulation.remarks import deepest, held
from robodyn.simulation.result import Simulation


def simulation_json(result: Simulation) -> str:
    """The document; see README for its keys. Units are SI."""
    import json

    energy = result.figures.energy
    document: dict[str, Any] = {
        "robot": result.model.name,
        "duration": float(result.time[-1]),
        "gravity": result.scene.gravity,
        "method": {"name": result.method.name, "order": result.method.order, "step": result.step, "rtol": result.rtol},
        "steps": result.steps,
        "evaluations": result.evaluations,
        "executor": result.executor,
        "ended": result.ended or None,
        **({"accuracy": {"target": result.target, "expected": result.expected_error}} if result.target else {}),
        "final": {
            "q": dict(zip(result.model.coordinates, result.q[-1].tolist(), strict=True)),
            "qd": dict(zip(result.model.rates, result.qd[-1].tolist(), strict=True)),
        },
        "energy": {
            "start": float(energy[0]),
            "end": float(energy[-1]),
            "work": float(result.work[-1]),
            "drift": result.energy_drift,
        },
        "momentum_drift": dict(zip(("linear", "angular"), result.momentum_drift, strict=True)) if result.free else None,
        "loops": _loops(result.loops) if result.loops else None,
        "held": [
            {"joint": each.joint.name, "time": each.time, "creep": each.creep, "speed": each.speed}
            for each in held(result.model, result.scene, result.time, result.qd)
        ],
        "limit_spring": _limit(result) if result.scene.limit_spring else None,
        "effects": [
            {"name": effect.name, "active": why.active, "reason": why.reason} for effect, why in result.effects
        ],
        "notes": list(result.notes),
    }
    return json.dumps(document, indent=2) + "\n"


def _limit(result: Simulation) -> dict[str, Any] | None:
    found = deepest(result.model, result.time, result.q, result.qd)
    return found and {**found._asdict(), "joint": found.joint.name}


def _loops(loops: LoopFigures) -> dict[str, Any]:
    final = loops.wrenches[-1].tolist()
    rows = zip(loops.names, final, loops.gap.tolist(), loops.slip.tolist(), strict=True)
    return {
        "equations": loops.equations,
        "dropped": list(loops.dropped),
        "rank": loops.rank,
        "freedoms": loops.freedoms,
        "stabilised": loops.stabilised,
        "closures": [
            {"name": name, "final": dict(zip(PARTS, wrench, strict=True)), "gap": gap, "slip": slip}
            for name, wrench, gap, slip in rows
        ],
    }
