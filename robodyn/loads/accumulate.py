"""One pass over a trajectory: blocks in, their loads out, figures and self-checks gathered on the way."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import lru_cache
from math import hypot, sqrt
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from robodyn.dynamics.arrays import zero_columns, zero_sources
from robodyn.dynamics.effects.effect import ZeroColumns
from robodyn.dynamics.momenta import COLUMNS, LawResiduals, View, energy, laws, losses, momentum_runner
from robodyn.dynamics.plan import Plan, plan, runner_of, torque_runner
from robodyn.loads.error_bars import ErrorBars
from robodyn.loads.result import Checks, EnergyBalance, History, MomentumReport
from robodyn.loads.statistics import Extremes, Statistics, check_loads, joint_of_rates, position_of_rates
from robodyn.programs.run.runner import Choice, Run, Runner
from robodyn.robot.limits import binding
from robodyn.robot.model import Model
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import Floats, einsum, first_largest
from robodyn.trajectory.columns.signals import COMPONENTS
from robodyn.trajectory.motion import Trajectory
from robodyn.trajectory.read import sources_of

if TYPE_CHECKING:
    from robodyn.loads.constraints import ConstraintPass
    from robodyn.loads.sizing import SizingPass
    from robodyn.loads.uncertainty import UncertaintyPass
    from robodyn.support.courses import Courses

NAMES = (*COLUMNS, "power")
"""Columns of momentum and energy, and the power tau . qd of the actuators and of what moves the base."""
CHECKED_PER_BLOCK = 64  # samples of each block at which the laws are checked, evenly spread
Execute = Callable[[Runner, Mapping[str, Floats], int], Run]
"""Runs a program over sources, which are part of so many samples."""


@lru_cache(maxsize=16)
def _check_runners(a_plan: Plan) -> tuple[Runner, ...]:
    return tuple(runner_of(check(a_plan), a_plan) for check in (losses, laws, energy))


class SelfChecks:
    def __init__(self, model: Model, scene: Scene, borne: bool) -> None:
        """Args: borne: whether the weight balances at least, besides the bodies' momenta."""
        self.model, self.scene, self.ledger = model, scene, EnergyLedger()
        weight = model.total_mass * hypot(*scene.gravity) if borne else 0.0
        self.laws, self._checked = LawResiduals((weight, weight * model.reach)), 0

    def take(
        self,
        block: Trajectory,
        sources: Mapping[str, Floats],
        zero: ZeroColumns,
        tau: Floats,
        base: Floats,
        execute: Execute,
        whole: int,
    ) -> tuple[NDArray[np.int64], Floats]:
        """Take in a block with tau (N, n), base (N, 6), of so many samples as a whole; zero: sources that are zero
        throughout. Return the samples at which energy is computed, and there what `EnergyLedger.update` does."""
        rows = np.linspace(0, len(block) - 1, min(len(block), CHECKED_PER_BLOCK)).astype(int)
        self._checked = self._checked or -(-whole * len(rows) // len(block))
        lost, lawful, stored = _check_runners(plan(self.model, self.scene, zero))
        net = einsum("ij,ij->i", tau, block.qd) - execute(lost, sources, whole).values[:, 0]
        checked = {name: values[rows] for name, values in sources.items()}
        expected = execute(lawful, checked, self._checked).values
        self.laws.update(expected, base[rows], net[rows], tau[rows] * block.qd[rows])
        return rows, self.ledger.update(block.time, net, rows, execute(stored, checked, self._checked).values[:, 0])

    def report(self) -> Checks:
        force, moment = self.laws.largest
        largest = force, max(moment, force * self.model.reach)
        return Checks(self.ledger.balance, *self.laws.relative, self.laws.samples, *largest)


class EnergyLedger:
    """Trapezoidal integrals of the power that goes into stored energy, and how far the energy itself is from them."""

    def __init__(self) -> None:
        self.work = self.turnover = 0.0
        self._quadrature = self._quadrature_most = self._squares = 0.0
        self._energies: list[float] = []
        self._worst = self._stored_most = 0.0
        self._before: tuple[float, float] | None = None

    def update(self, time: Floats, power: Floats, rows: NDArray[np.int64], energy: Floats) -> Floats:
        """Take in a block; return (2, k) work done and energy stored since the start [J]; power: (N,) into stored
        energy [W]. rows: (k,) samples, the first and the last among them, at which `energy` (k,) is given [J]."""
        carried = 0 if self._before is None else 1
        if self._before is not None:
            time, power = np.append(self._before[0], time), np.append(self._before[1], power)
        steps = np.diff(time)
        work = self.work + np.append(0.0, np.cumsum(0.5 * steps * (power[1:] + power[:-1])))
        self.turnover += float(np.sum(0.5 * steps * (np.abs(power[1:]) + np.abs(power[:-1]))))
        self._energies = [*self._energies[:1], *energy.tolist()]
        done, stored = work[rows + carried], energy - self._energies[0]
        residual = done - stored
        found = [self._worst, *residual.tolist()]
        self._worst = found[first_largest(np.abs(found))]
        self._stored_most = max(self._stored_most, float(np.abs(energy).max()))
        parts = quadrature_errors(steps, power)
        self._squares += float(np.sum((3.0 * parts) ** 2))
        errors = self._quadrature + np.cumsum(parts)
        self._quadrature_most = max(self._quadrature_most, float(np.abs(errors).max(initial=0.0)))
        self._quadrature = float(errors[-1]) if len(errors) else self._quadrature
        self.work, self._before = float(work[-1]), (float(time[-1]), float(power[-1]))
        return np.stack((done, stored))

    @property
    def balance(self) -> EnergyBalance:
        change = self._energies[-1] - self._energies[0]
        largest = (self._worst, self._quadrature_most, sqrt(self._squares), self._stored_most)
        return EnergyBalance(self.work, change, self._quadrature, self.turnover, *largest)


def quadrature_errors(steps: Floats, values: Floats) -> Floats:
    """The error of the trapezoidal rule over each pair of steps (N - 1,) with values (N,): (T_h - T_2h) / 3."""
    pairs = len(steps) // 2
    left, right = steps[0 : 2 * pairs : 2], steps[1 : 2 * pairs : 2]
    a, b, c = values[0 : 2 * pairs : 2], values[1 : 2 * pairs : 2], values[2 : 2 * pairs + 1 : 2]
    fine = 0.5 * (left * (a + b) + right * (b + c))
    return (fine - 0.5 * (left + right) * (a + c)) / 3.0


class Options(NamedTuple):
    """What is computed, and by what."""

    reactions: bool
    executor: str
    threads: int | None
    momentum: View | None = None
    sizing: bool = False
    history: bool = False


@lru_cache(maxsize=16)
def _loads(a_plan: Plan, reactions: bool) -> Runner:
    return runner_of(a_plan.wrenches(reactions), a_plan)


class TorqueAccumulator:
    """Figures gathered over the blocks of a trajectory, one after another; zero_columns: what has been zero in every
    block so far, which the program of the loads leaves out; sources: of this, whole sources alone, for programs that
    motions of other joints share; whole: how many samples there are in all, by the largest estimate so far."""

    def __init__(
        self, model: Model, scene: Scene, options: Options, file: str | None, constraints: ConstraintPass | None
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
        self.whole = 0
        self.bars = ErrorBars(model, scene, self.rates, constraints)
        self.checks = SelfChecks(model, scene, borne=constraints is not None)
        self.courses: tuple[Courses, Courses] | None = None
        if options.history:
            from robodyn.support.courses import Courses

            feet = [f"on_{each.name}" for each in constraints.scene.contacts] if constraints else []
            states = [f"q_{name}" for name in model.coordinates]
            states += [f"{what}_{name}" for what in ("qd", "qdd") for name in model.rates]
            curves = [f"{what}_{name}" for what in ("tau", "qd", "power") for name in model.rates[self.rates]]
            curves += self.names[model.n : model.n + 6]
            motion = Courses(("time", *states, *self.names, *scene.columns, *feet), curves)
            self.courses = motion, Courses(("time",), ("work done", "energy stored"))
        self.momenta = Extremes(NAMES)
        if options.momentum is not None:
            options.momentum.check(model, scene)
        self.sizing: SizingPass | None = None
        if options.sizing:
            from robodyn.loads.sizing import SizingPass

            self.sizing = SizingPass(model, scene, self.joints, self.rates, options.history)
        self.uncertain: UncertaintyPass | None = None
        if scene.uncertainty is not None:
            from robodyn.loads.uncertainty import UncertaintyPass

            trains = self.sizing.trains if self.sizing else []
            by = options.executor, options.threads
            self.uncertain = UncertaintyPass(model, scene, self.rates, trains, self.sizing is not None, *by)

    @np.errstate(all="ignore")
    def take(self, block: Trajectory, left: int) -> Floats:
        """Return the output columns of a block, whose statistics are gathered; `left` samples may come, with these."""
        sources = sources_of(block, self.scene)
        found, whole = zero_columns(sources), zero_sources(sources)
        self.sources = whole if self.zero_columns is None else self.sources & whole
        self.zero_columns = found if self.zero_columns is None else self.zero_columns & found
        self.whole = max(self.whole, self.statistics.integrals.samples + left)
        n = self.model.n
        reactions = self.options.reactions or self.sizing is not None or self.courses is not None
        runner = _loads(plan(self.model, self.scene, self.zero_columns), reactions)
        loads, self.choice = self._run(runner, sources, self.whole)
        check_loads(loads, self.names, block.first_row, self.file)
        if self.constraints is not None:
            self.constraints.settle(loads)
        tau, base = loads[:, :n], loads[:, n : n + 6]
        rows, energies = self.checks.take(block, sources, self.sources, tau, base, self._run, self.whole)
        self._gather(block, sources, loads, tau.T[self.rates], base.T)
        if self.courses is not None:
            self._record(self.courses, block, sources["columns"], loads, energies, rows)

        def over_block(runner: Runner) -> Floats:
            return self._run(runner, sources, self.whole).values

        if self.sizing is not None:
            static = self.constraints.static(block) if self.constraints else over_block(self.sizing.static_runner())
            self.sizing.take(block, loads, static)
        columns = loads if self.options.reactions else tau
        if self.options.momentum is None:
            return columns
        # accelerations are not looked at, so that the energy of a rotor counts also in a block without any
        moving = frozenset(pair for pair in self.sources if pair[0] != "qdd")
        values = over_block(momentum_runner(plan(self.model, self.scene, moving), self.options.momentum))
        momenta = np.column_stack((values, einsum("ij,ij->i", tau, block.qd)))
        check_loads(momenta, NAMES, block.first_row, self.file)
        self.momenta.update(block.time, momenta)
        return np.hstack((columns, momenta))

    def momentum(self) -> MomentumReport | None:
        view = self.options.momentum
        return None if view is None else MomentumReport(view.about, view.frame, tuple(self.momenta.ranges()))

    def _record(
        self,
        courses: tuple[Courses, Courses],
        block: Trajectory,
        extra: Floats,
        loads: Floats,
        energies: Floats,
        rows: Any,
    ) -> None:
        motion, energy = courses
        touch = self.constraints.touch if self.constraints else None
        states = block.time, *block.q.T, *block.qd.T, *block.qdd.T
        tau, speed = loads[:, : self.model.n].T[self.rates], block.qd.T[self.rates]
        base = loads[:, self.model.n : self.model.n + 6].T
        motion.update(
            (*states, *loads.T, *extra.T, *(touch[1] if touch else ())), (*tau, *speed, *(tau * speed), *base)
        )
        energy.update((block.time[rows],), energies)

    def history(self) -> History | None:
        if self.courses is None:
            return None
        at_peak, heat = self.statistics.at_peak, self.sizing.heat if self.sizing else None
        return History(*self.courses, tuple(at_peak[k] for k in range(len(at_peak))), heat)

    def _run(self, runner: Runner, sources: Mapping[str, Floats], expected: int) -> Run:
        executor, threads = self.options.executor, self.options.threads
        return runner.run(sources, len(sources["q"]), executor=executor, threads=threads, expected=expected)

    def _gather(
        self, block: Trajectory, sources: Mapping[str, Floats], loads: Floats, tau: Floats, base: Floats
    ) -> None:
        """Take loads into statistics, with what they may be off; tau, base: (joints, N), (6, N) of them."""
        q, qd = (np.ascontiguousarray(x.T) for x in (block.q[:, self.positions], block.qd[:, self.rates]))
        noise, off = self.bars.update(block)
        state = {**sources, "noise": noise, "off": off}
        if self.constraints is not None:
            state["touching"] = self.constraints.touching
        unsure = self.bars.over_block(state)
        other = block.sampling.other if block.sampling else None
        if other is not None and len(other[0]) == len(block) and self.constraints is None:
            by_positions = {**sources, **dict(zip(("qd", "qdd"), other, strict=True))}
            runner = torque_runner(self.model, self.scene)
            unsure = unsure + np.abs(tau - self._run(runner, by_positions, self.whole).values.T[self.rates])
        self.statistics.update(block.time, q, qd, tau, base, state, unsure)
        if self.uncertain is not None:
            self.uncertain.take(block, sources, loads, self.sources, self.whole)


def output_names(model: Model, reactions: bool, momentum: bool = False, scene: Scene = DEFAULT) -> list[str]:
    """Names of the columns of loads: tau, then the base wrench, then joint wrenches, then momentum and energy. In a
    scene with constraints tau of the drives alone, and after it the wrenches of loops and contacts."""
    names = [f"tau_{name}" for name in model.rates]
    if reactions:
        names += [f"base_{part}" for part in COMPONENTS]
        names += [f"{part}_{body.joint.name}" for body in model.bodies[1:] for part in COMPONENTS]
    if momentum:
        names += NAMES
    if not scene.constrained:
        return names
    from robodyn.dynamics.constraints.constraint_jacobian import columns_of
    from robodyn.dynamics.constraints.solve import actuation

    passive = actuation(model, scene).passive.tolist()
    driven = [name for name, free in zip(names, passive, strict=False) if not free]
    wrenches = [column for name in scene.constraint_names for column in columns_of(name)]
    return [*driven, *wrenches, *names[model.n :]]
