"""The result of `simulate` as one JSON document with stable keys and full precision."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from robodyn.report.json_torques import limits_data
from robodyn.report.limits_words import simulation_limits
from robodyn.simulation.joint_use import deepest, held
from robodyn.simulation.loop_figures import PARTS, LoopFigures
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
        "start": _state(result, 0),
        "final": _state(result, -1),
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
        "joints": [asdict(joint) for joint in result.joints],
        "limits_exceeded": [asdict(excess) for excess in result.exceeded],
        "limits": limits_data(result.limits),
        "within_limits": result.within_limits,
        "verdict": asdict(simulation_limits(result)),
        "doubts": [asdict(doubt) for doubt in result.doubts],
        "warnings": [doubt.said for doubt in result.doubts],
        "notes": list(result.notes),
    }
    return json.dumps(document, indent=2) + "\n"


def _state(result: Simulation, row: int) -> dict[str, dict[str, float]]:
    """The positions and speeds of a row, by name."""
    return {
        "q": dict(zip(result.model.coordinates, result.q[row].tolist(), strict=True)),
        "qd": dict(zip(result.model.rates, result.qd[row].tolist(), strict=True)),
    }


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
        "usual_freedoms": loops.usual,
        "singular": [each._asdict() for each in loops.singular],
        "stabilised": loops.stabilised,
        "closures": [
            {"name": name, "final": dict(zip(PARTS, wrench, strict=True)), "gap": gap, "slip": slip}
            for name, wrench, gap, slip in rows
        ],
    }
