"""Simulated motions and measured times as JSON: `simulate`, `accuracy` and `bench`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from robodyn.report.json.encode import encode, select, written
from robodyn.report.json.loads import limits_data
from robodyn.report.limits import limits_verdict

if TYPE_CHECKING:
    from robodyn.measure.accuracy.ladder import Accuracy, Ladder, Rung
    from robodyn.measure.speed.result import Bench, EffectBench
    from robodyn.simulation.loop_figures import LoopFigures
    from robodyn.simulation.result import Simulation


def simulation_json(result: Simulation) -> str:
    """Return the document of `simulate`; docs/reference/schemas has its keys."""
    from robodyn.simulation.joint_use import held

    energy, accuracy = result.figures.energy, select(result, "target expected:expected_error")
    stopped = held(result.model, result.scene, result.time, result.qd)
    drift = dict(zip(("linear", "angular"), result.momentum_drift, strict=True)) if result.free else None
    return written(
        {
            "robot": result.model.name,
            "duration": float(result.time[-1]),
            "gravity": result.scene.gravity,
            "method": {**select(result.method, "name order"), **select(result, "step rtol")},
            **select(result, "steps evaluations executor ended", ended=result.ended or None),
            **({"accuracy": accuracy} if result.target else {}),
            "start": _state(result, 0),
            "final": _state(result, -1),
            "energy": {"start": energy[0], "end": energy[-1], "work": result.work[-1], "drift": result.energy_drift},
            "momentum_drift": drift,
            "loops": _loops(result.loops) if result.loops else None,
            "held": [select(each, "joint:joint.name time creep speed") for each in stopped],
            "limit_spring": _limit(result) if result.scene.limit_spring else None,
            "effects": [{"name": effect.name, **select(why, "active reason")} for effect, why in result.effects],
            **select(
                result,
                "joints limits_exceeded:exceeded limits within_limits verdict doubts:caveats warnings notes",
                limits=limits_data(result.limits),
                verdict=limits_verdict(result),
                warnings=[caveat.text for caveat in result.caveats],
            ),
        }
    )


def _state(result: Simulation, row: int) -> dict[str, dict[str, float]]:
    """Return the positions and speeds of a row, by name."""
    return {
        "q": dict(zip(result.model.coordinates, result.q[row].tolist(), strict=True)),
        "qd": dict(zip(result.model.rates, result.qd[row].tolist(), strict=True)),
    }


def _limit(result: Simulation) -> dict[str, Any] | None:
    from robodyn.simulation.joint_use import deepest

    found = deepest(result.model, result.time, result.q, result.qd)
    return found and select(found, "joint:stop.joint.name side:stop.word value:stop.value depth time limits")


def _loops(loops: LoopFigures) -> dict[str, Any]:
    from robodyn.simulation.loop_figures import PARTS

    rows = zip(loops.names, loops.wrenches[-1].tolist(), loops.gap.tolist(), loops.slip.tolist(), strict=True)
    return select(
        loops,
        "equations dropped rank freedoms usual_freedoms:usual singular stabilised closures",
        singular=[each._asdict() for each in loops.singular],
        closures=[
            {"name": name, "final": dict(zip(PARTS, wrench, strict=True)), "gap": gap, "slip": slip}
            for name, wrench, gap, slip in rows
        ],
    )


def accuracy_json(accuracy: Accuracy, target: float | None = None) -> str:
    """Return the document of `accuracy`; times [s] are the median, the quartiles `low` and `high`, and the `runs`."""
    ladders = [_ladder(ladder, target) for ladder in accuracy.ladders]
    return written(select(accuracy, "name target ladders prices effects notes", target=target, ladders=ladders))


def _ladder(ladder: Ladder, target: float | None) -> dict[str, Any]:
    cheapest = None if target is None else ladder.cheapest(target)
    return select(
        ladder,
        "title reference per methods front cheapest",
        methods=[_rung(ladder, rung) for rung in ladder.rungs],
        front=[rung.name for rung in ladder.front],
        cheapest=cheapest and cheapest.name,
    )


def _rung(ladder: Ladder, rung: Rung) -> dict[str, Any]:
    other = ladder.dominator(rung)
    errors = dict(zip(ladder.measures, rung.errors, strict=True))
    return {
        **select(rung, "name errors error time operations", errors=errors),
        **({} if rung.drift is None else select(rung, "evaluations drift")),
        "dominated_by": other and other.name,
    }


def bench_json(bench: Bench) -> str:
    """Return the document of `bench`; times [s], of samples for one, are the `least`, `median` and `runs`."""
    return written({**encode(bench), "effects": list(map(_effect, bench.effects))})


def _effect(effect: EffectBench) -> dict[str, Any]:
    keys = "name reason:verdict.reason operations operations_saved_without:saved without"
    return select(effect.report, keys, without=effect.without)
