"""One pass over a trajectory: blocks in, their loads out, figures gathered on the way."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple
from functools import lru_cache
from math import hypot
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from robodyn.dynamics.arrays import zero_columns, zero_sources
from robodyn.dynamics.balance import LawResiduals, energy, laws, losses
from robodyn.dynamics.effects.effect import ZeroColumns
from robodyn.dynamics.plan import Plan, plan
from robodyn.dynamics.runners import runner_of
from robodyn.loads.checks_result import Checks
from robodyn.loads.columns import output_names
from robodyn.loads.constraint_result import constraint_doubts
from robodyn.loads.doubts import carried
from robodyn.loads.energy import EnergyLedger
from robodyn.loads.error_bars import ErrorBars
from robodyn.loads.figures import (
    base_loads,
    check_figures,
    check_loads,
    effect_reports,
    joint_load,
    joint_of_rates,
    position_of_rates,
    shares_at_peaks,
)
from robodyn.loads.result import Result
from robodyn.loads.statistics import Statistics
from robodyn.programs.run.choice import Choice
from robodyn.programs.run.runner import Run, Runner
from robodyn.robot.limits import binding, coverage
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene
from robodyn.support.floats import Floats
from robodyn.support.wording import shown
from robodyn.trajectory.columns import COMPONENTS
from robodyn.trajectory.motion import Trajectory
from robodyn.trajectory.robot_motion import sources_of

if TYPE_CHECKING:
    from robodyn.dynamics.momenta import View
    from robodyn.loads.constraints import ConstraintPass
    from robodyn.loads.history import Recorder
    from robodyn.loads.momenta import MomentumPass
    from robodyn.loads.sizing import SizingPass
    from robodyn.loads.uncertain import UncertainLoads

CHECKED_PER_BLOCK = 64
"""Samples of each block at which the laws are checked, evenly spread."""


class Options(NamedTuple):
    """What is computed, and by what."""

    reactions: bool
    executor: str
    threads: int | None
    momentum: View | None = None
    sizing: bool = False
    history: bool = False
    samples: int = 0


class _Checks(NamedTuple):
    """What runs beside the loads."""

    losses: Runner
    energy: Runner
    laws: Runner


@lru_cache(maxsize=16)
def _loads(a_plan: Plan, reactions: bool) -> Runner:
    return runner_of(a_plan.wrenches(reactions), a_plan)


@lru_cache(maxsize=16)
def _checks(a_plan: Plan) -> _Checks:
    return _Checks(*(runner_of(check(a_plan), a_plan) for check in (losses, energy, laws)))


class TorqueAccumulator:
    """Figures gathered over the blocks of a trajectory, one after another.

    Attributes:
        zero_columns: what has been zero in every block so far, which the program of the loads leaves out.
        sources: of this, whole sources alone, for programs beside it, which motions of other joints share.
        whole, checked: how many samples there are in all, by the largest estimate so far, and those of the laws.
    """

    def __init__(
        self,
        model: Model,
        scene: Scene,
        options: Options,
        file: str | None,
        constraints: ConstraintPass | None = None,
    ) -> None:
        self.model, self.scene, self.options, self.file = model, scene, options, file
        self.constraints = constraints
        self.names = output_names(model, reactions=True)
        self.rates = slice(6 if model.floating else 0, model.n)
        self.joints = joint_of_rates(model)[self.rates]
        self.positions = position_of_rates(model)[self.rates]
        self.statistics = Statistics(
            np.array([binding(joint.effort) or np.inf for joint in self.joints]),
            np.array([binding(joint.velocity) or np.inf for joint in self.joints]),
        )
        self.zero_columns: ZeroColumns | None = None
        self.sources: ZeroColumns = frozenset()
        self.choice: Choice | None = None
        self.whole = self.checked = 0
        self.ledger = EnergyLedger()
        self.bars = ErrorBars(model, scene, self.rates, constraints)
        weight = model.total_mass * hypot(*scene.gravity) if constraints else 0.0
        self.laws = LawResiduals((weight, weight * model.reach))
        self.history: Recorder | None = None
        if options.history:
            from robodyn.loads.history import Recorder

            feet = tuple(each.name for each in constraints.scene.contacts) if constraints else ()
            self.history = Recorder(model.rates[self.rates], COMPONENTS, feet)
        self.momentum: MomentumPass | None = None
        if options.momentum is not None:
            from robodyn.loads.momenta import MomentumPass

            self.momentum = MomentumPass(model, scene, options.momentum, file)
        self.sizing: SizingPass | None = None
        if options.sizing:
            from robodyn.loads.sizing import SizingPass

            self.sizing = SizingPass(model, scene, self.joints, self.rates)
        self.uncertain: UncertainLoads | None = None
        if scene.uncertainty is not None:
            from robodyn.loads.uncertain import UncertainLoads

            self.uncertain = UncertainLoads(model, scene, self.rates, self.sizing, options.samples, options[1:3])

    @np.errstate(all="ignore")
    def take(self, block: Trajectory, left: int) -> Floats:
        """The output columns of one block, whose statistics are gathered; `left` samples may come, with these."""
        sources = sources_of(block, self.scene)
        found, whole = zero_columns(sources), zero_sources(sources)
        self.sources = whole if self.zero_columns is None else self.sources & whole
        self.zero_columns = found if self.zero_columns is None else self.zero_columns & found
        reactions = self.options.reactions or self.sizing is not None
        checks = _checks(plan(self.model, self.scene, self.sources))
        samples, n = len(block), self.model.n

        rows = np.linspace(0, samples - 1, min(samples, CHECKED_PER_BLOCK)).astype(int)
        self.whole = max(self.whole, self.statistics.integrals.samples + left)
        self.checked = self.checked or -(-self.whole * len(rows) // samples)

        def run(runner: Runner, given: dict[str, Floats], expected: int) -> Run:
            how = self.options
            return runner.run(given, len(given["q"]), executor=how.executor, threads=how.threads, expected=expected)

        def over_block(runner: Runner) -> Floats:
            return run(runner, sources, self.whole).values

        loads, self.choice = run(
            _loads(plan(self.model, self.scene, self.zero_columns), reactions), sources, self.whole
        )
        check_loads(loads, self.names, block.first_row, self.file)
        if self.constraints is not None:
            self.constraints.settle(loads)
        tau, base = loads[:, :n], loads[:, n : n + 6]
        net = np.einsum("ij,ij->i", tau, block.qd) - over_block(checks.losses)[:, 0]
        checked = {name: values[rows] for name, values in sources.items()}
        expected = run(checks.laws, checked, self.checked).values
        self.laws.update(expected, base[rows], net[rows], tau[rows] * block.qd[rows])
        energies = self.ledger.update(block.time, net, rows, run(checks.energy, checked, self.checked).values[:, 0])
        q, qd = (np.ascontiguousarray(x.T) for x in (block.q[:, self.positions], block.qd[:, self.rates]))
        noise, off = self.bars.openness.update(block)
        state = {**sources, "noise": noise, "off": off}
        if self.constraints is not None:
            state["touching"] = self.constraints.touching
        unsure = self.bars.over_block(state, off)
        self.statistics.update(block.time, q, qd, tau.T[self.rates], base.T, state, unsure)
        if self.uncertain is not None:
            self.uncertain.take(block, sources, loads, unsure, self.sources, self.whole)
        if self.history is not None:
            motion, more = (qd, block.qdd[:, self.rates].T), left / samples
            touch = self.constraints.touch if self.constraints else None
            self.history.update(block.time, *motion, tau.T[self.rates], base.T, energies, rows, more, touch)
        if self.sizing is not None:
            static = self.constraints.static(block) if self.constraints else over_block(self.sizing.static_runner())
            self.sizing.take(block, loads, static)
        columns = loads if self.options.reactions else tau
        if self.momentum is None:
            return columns
        return np.hstack(
            (
                columns,
                self.momentum.take(block, tau, self.sources, over_block),
            )
        )

    @np.errstate(all="ignore")
    def result(self, last: Trajectory, explain: bool) -> Result:
        """Return everything gathered, with shares and uncertainty at the peaks."""
        assert self.choice is not None
        whole = plan(self.model, self.scene, self.zero_columns or frozenset())
        gathered, total = self.statistics, self.statistics.integrals
        peaks = np.concatenate((gathered.torque.kept["value"], gathered.base.kept["value"]))
        more = self.sizing.figures if self.sizing else ()
        check_figures(
            (*total.totals.values(), astuple(self.ledger.balance), self.laws.relative, *more),
            peaks,
            self.file,
        )
        shares = shares_at_peaks(whole, gathered.at_peak, self.rates.start)
        bars = [self.bars.at_peak(k, gathered.at_peak.get(k), shares[k]) for k in range(len(self.joints))]
        joints = tuple(
            joint_load(gathered, k, joint, name, self.scene, shares[k], bars[k])
            for k, (joint, name) in enumerate(zip(self.joints, self.model.rates[self.rates], strict=True))
        )
        balance, (force, moment) = self.ledger.balance, self.laws.largest
        moment = max(moment, force * self.model.reach)
        base = base_loads(gathered)
        left = np.maximum([bar for _, bar in bars], gathered.most - np.abs(gathered.torque.kept["value"])).tolist()
        constraints = self.constraints.report() if self.constraints else None
        sizing = self.sizing.report(joints, self._inertias(self.sizing.driven)) if self.sizing else None
        unsure = self.uncertain.report(joints, sizing) if self.uncertain else None
        looped = self.constraints is not None and self.constraints.holds_base
        doubts = (
            *last.doubts,
            *(constraint_doubts(constraints) if constraints else ()),
            *carried(self.model, self.scene, base, joints, force, moment, looped),
            *self.bars.openness.doubts(joints, left, balance, total.samples, total.duration),
            *(unsure.doubts if unsure else ()),
        )
        about = self.uncertain.notes if self.uncertain else ()
        warnings = [*(doubt.said for doubt in doubts), *about, *self._idle_notes(), *self.model.notes, *last.notes]
        return Result(
            robot=self.model.name,
            samples=total.samples,
            duration=total.duration,
            gravity=self.scene.gravity,
            joints=joints,
            base_wrench=base,
            effects=effect_reports(whole, explain),
            checks=Checks(balance, *self.laws.relative, self.laws.samples, force, moment),
            operations=whole.torques().size,
            executor=self.choice.executor,
            reason=self.choice.reason,
            derivation=last.derivation,
            warnings=tuple(warnings),
            momentum=self.momentum.report() if self.momentum else None,
            history=self.history.history(gathered.at_peak) if self.history else None,
            sizing=sizing,
            limits=coverage(self.joints),
            doubts=doubts,
            origin=last.origin,
            held=last.held,
            constraints=constraints,
            uncertainty=unsure,
        )

    def _idle_notes(self) -> list[str]:
        """Return notes on motors at joints that nothing drives."""
        names = [self.model.rates[self.rates][k] for k in self._idle]
        return [f"nothing drives {shown(name)}, so that its [motor] is judged by its speed alone" for name in names]

    def _inertias(self, joints: Sequence[int]) -> dict[int, float | None]:
        """Return what some joints accelerate at their peaks, by their own torque alone [kg m^2 or kg]; None of those
        that nothing drives."""
        rates, idle = {k: self.rates.start + k for k in joints}, self._idle
        states = {k: self.statistics.at_peak[k] for k in joints if k not in idle}
        found = {k: float(self.bars.response(state, own=True)[rates[k], rates[k]]) for k, state in states.items()}
        return {k: found.get(k) for k in joints}

    @property
    def _idle(self) -> list[int]:
        """Joints with motors that nothing drives."""
        if self.sizing is None or self.constraints is None:
            return []
        passive = self.constraints.solver.actuation.passive[self.rates]
        return [k for k in self.sizing.driven if passive[k]]
