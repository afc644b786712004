"""From everything that is gathered over a motion to its result."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import astuple

import numpy as np

from robodyn.dynamics.plan import Plan, plan
from robodyn.loads.accumulate import TorqueAccumulator
from robodyn.loads.caveats import bar_caveats, carried
from robodyn.loads.checks_result import Checks
from robodyn.loads.figures import base_loads, check_figures, effect_reports, joint_load, shares_at_peaks
from robodyn.loads.result import JointLoad, Result
from robodyn.robot.limits import coverage
from robodyn.support.wording import shown
from robodyn.trajectory.motion import Trajectory


@np.errstate(all="ignore")
def gathered_result(run: TorqueAccumulator, last: Trajectory, explain: bool) -> Result:
    """Return everything gathered, with shares and uncertainty at the peaks.

    Args:
        last: its last block. explain: as `torques` has it.
    """
    assert run.choice is not None
    whole = plan(run.model, run.scene, run.zero_columns or frozenset())
    total, checks = run.statistics.integrals, run.checks.report()
    _check(run, checks)
    joints, left = _joints(run, whole)
    base = base_loads(run.statistics)
    constraints = run.constraints.report() if run.constraints else None
    sizing = run.sizing.report(joints, _inertias(run, run.sizing.driven)) if run.sizing else None
    unsure = run.uncertain.report(joints, sizing) if run.uncertain else None
    looped = run.constraints is not None and run.constraints.holds_base
    caveats = (
        *last.caveats,
        *(constraints.caveats if constraints else ()),
        *carried(run.model, run.scene, base, joints, checks.largest_force, checks.largest_moment, looped),
        *run.bars.openness.caveats(joints, left, checks.energy_balance, total.samples, total.duration),
        *bar_caveats(joints, sizing),
        *(unsure.caveats if unsure else ()),
    )
    about = (*(run.uncertain.notes if run.uncertain else ()), *_added(run))
    idle = (
        f"nothing drives {shown(joints[k].name)}, so that its [motor] is judged by its speed alone" for k in _idle(run)
    )
    return Result(
        robot=run.model.name,
        samples=total.samples,
        duration=total.duration,
        gravity=run.scene.gravity,
        joints=joints,
        base_wrench=base,
        effects=effect_reports(whole, explain),
        checks=checks,
        operations=whole.torques().size,
        executor=run.choice.executor,
        reason=run.choice.reason,
        derivation=last.derivation,
        warnings=(*(caveat.text for caveat in caveats), *about, *idle, *run.model.notes, *last.notes),
        momentum=run.momentum.report() if run.momentum else None,
        history=run.history.history(run.statistics.at_peak) if run.history else None,
        sizing=sizing,
        limits=coverage(run.joints),
        caveats=caveats,
        origin=last.origin,
        held=last.held,
        constraints=constraints,
        uncertainty=unsure,
    )


def _added(run: TorqueAccumulator) -> Iterator[str]:
    """Yield which links have several payloads, as of a scene and of the command line, and what these add up to."""
    payloads = run.scene.payloads
    for link in dict.fromkeys(payload.link for payload in payloads):
        masses = [payload.mass for payload in payloads if payload.link == link]
        if len(masses) > 1:
            parts = " + ".join(f"{mass:g}" for mass in masses)
            yield f"{len(masses)} payloads on link {shown(link)} add up: {parts} = {sum(masses):g} kg"


def _check(run: TorqueAccumulator, checks: Checks) -> None:
    """Raise where a square, a power or an integral overflows."""
    peaks = np.concatenate((run.statistics.torque.kept["value"], run.statistics.base.kept["value"]))
    laws = checks.first_law, checks.second_law, checks.power
    more = run.sizing.figures if run.sizing else ()
    totals = run.statistics.integrals.totals.values()
    check_figures((*totals, astuple(checks.energy_balance), laws, *more), peaks, run.file)


def _joints(run: TorqueAccumulator, whole: Plan) -> tuple[tuple[JointLoad, ...], list[float]]:
    """Return the loads of the joints, and what is open of their peaks."""
    gathered = run.statistics
    shares = shares_at_peaks(whole, gathered.at_peak, run.rates.start)
    bars = [_bar(run, k, shares[k]) for k in range(len(run.joints))]
    joints = tuple(
        joint_load(gathered, k, joint, name, run.scene, shares[k], bars[k])
        for k, (joint, name) in enumerate(zip(run.joints, run.model.rates[run.rates], strict=True))
    )
    return joints, [bar or 0.0 for _, bar in bars]


def _bar(run: TorqueAccumulator, k: int, shares: Mapping[str, float]) -> tuple[float, float | None]:
    """Return what noise does to joint k at its peak, and by how much its largest torque may be off."""
    if run.bars.openness.unknown:
        return 0.0, None
    gathered = run.statistics
    noise, guessed = run.bars.at_peak(k, gathered.at_peak.get(k), shares)
    peak = abs(float(gathered.torque.kept["value"][k]))
    bar = max(float(gathered.most[k]) - peak, peak - float(gathered.least[k]))
    return noise, max(bar, guessed) if run.bars.openness.guessed else bar


def _inertias(run: TorqueAccumulator, joints: Sequence[int]) -> dict[int, float | None]:
    """Return what some joints accelerate at their peaks, by their own torque alone [kg m^2 or kg]; None of those that
    nothing drives."""
    rates, idle = {k: run.rates.start + k for k in joints}, _idle(run)
    states = {k: run.statistics.at_peak[k] for k in joints if k not in idle}
    found = {k: float(run.bars.response(state, own=True)[rates[k], rates[k]]) for k, state in states.items()}
    return {k: found.get(k) for k in joints}


def _idle(run: TorqueAccumulator) -> list[int]:
    """Return the joints with motors that nothing drives."""
    if run.sizing is None or run.constraints is None:
        return []
    passive = run.constraints.solver.actuation.passive[run.rates]
    return [k for k in run.sizing.driven if passive[k]]
