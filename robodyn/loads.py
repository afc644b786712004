"""The main job: what every joint carries along a motion."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from dataclasses import astuple
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robodyn.effects.effect import Still
from robodyn.energy_ledger import EnergyLedger
from robodyn.errors import InputError
from robodyn.execute.runner import Runner
from robodyn.inverse import mass_matrix, runner_of, still
from robodyn.model import Model
from robodyn.motion_input import read_motion, sources_of
from robodyn.overflow import check_figures, check_loads
from robodyn.overlap import ahead
from robodyn.plan import Plan, plan
from robodyn.result import Checks, Result
from robodyn.scene import DEFAULT, Scene
from robodyn.self_checks import LawResiduals, energy, laws, losses
from robodyn.sizing import base_loads, effect_reports, joint_load, joint_of_rates, position_of_rates, shares_at_peaks
from robodyn.statistics import COMPONENTS, Statistics
from robodyn.trajectory.motion import Trajectory
from robodyn.trajectory.reader import TrajectoryReader

Floats = NDArray[np.float64]
Sink = Callable[[Floats, Floats], None]

CHECKED_PER_BLOCK = 64
"""Samples of each block at which the laws are checked, evenly spread."""


def output_names(model: Model, reactions: bool) -> list[str]:
    """Names of the columns that `torques` gives its sinks: tau, then the base wrench, then joint wrenches."""
    names = [f"tau_{name}" for name in model.rates]
    if reactions:
        names += [f"base_{part}" for part in COMPONENTS]
        names += [f"{part}_{body.joint.name}" for body in model.bodies[1:] for part in COMPONENTS]
    return names


def torques(
    model: Model,
    trajectory: Trajectory | TrajectoryReader | str | os.PathLike[str],
    scene: Scene = DEFAULT,
    *,
    reactions: bool = False,
    explain: bool = False,
    sinks: Iterable[Sink] = (),
) -> Result:
    """What every joint of a robot carries along a motion, with self-checks.

    Blocks of the trajectory go through the traced recursion one after another, in memory that does not depend on their
    number. Integrals over time use the trapezoidal rule.

    Args:
        model: of `robodyn.load`.
        trajectory: of `robodyn.motion`, or a file, or a reader of `robodyn.read_motion`, which is read to its end.
        scene: what surrounds the robot.
        reactions: compute the six components of every joint's wrench for the sinks.
        explain: count the operations that the absence of each effect would save.
        sinks: each is called after every block with time (N,) [s] and the columns of `output_names` (N, k).

    Raises:
        InputError: the scene does not fit the robot, or the trajectory is wrong.

    Accuracy: torques as `inverse_dynamics`; shares add up to the peak within 1e-12 of the largest torque.
    """
    if isinstance(trajectory, (str, os.PathLike)):
        with read_motion(trajectory, model, scene) as reader:
            return torques(model, reader, scene, reactions=reactions, explain=explain, sinks=sinks)
    run = _Run(model, scene, reactions, trajectory.file if isinstance(trajectory, TrajectoryReader) else None)
    last: Trajectory | None = None
    for block in (trajectory,) if isinstance(trajectory, Trajectory) else ahead(trajectory.blocks()):
        if len(block):
            columns, last = run.take(block), block
            for sink in sinks:
                sink(block.time, columns)
    if last is None:
        raise InputError("the trajectory has no samples")
    return run.result(last, explain)


class _Programs(NamedTuple):
    """What runs for one pattern of zero columns."""

    wrenches: Runner
    losses: Runner
    energy: Runner
    laws: Runner


@lru_cache(maxsize=16)
def _programs(a_plan: Plan, reactions: bool) -> _Programs:
    programs = (a_plan.wrenches(reactions), *(check(a_plan) for check in (losses, energy, laws)))
    return _Programs(*(runner_of(program, a_plan) for program in programs))


class _Run:
    """One pass over a trajectory.

    Attributes:
        still: what has been zero in every block so far.
    """

    def __init__(self, model: Model, scene: Scene, reactions: bool, file: str | None) -> None:
        self.model, self.scene, self.reactions, self.file = model, scene, reactions, file
        self.names = output_names(model, reactions=True)
        self.rates = slice(6 if model.floating else 0, model.n)
        self.joints = joint_of_rates(model)[self.rates]
        self.positions = position_of_rates(model)[self.rates]
        self.statistics = Statistics(
            np.array([np.inf if joint.effort is None else joint.effort for joint in self.joints]),
            np.array([np.inf if joint.velocity is None else joint.velocity for joint in self.joints]),
        )
        self.still: Still | None = None
        self.ledger = EnergyLedger()
        self.laws = LawResiduals()

    @np.errstate(all="ignore")
    def take(self, block: Trajectory) -> Floats:
        """The output columns of one block, whose statistics are gathered."""
        sources = sources_of(block, self.scene)
        pattern = still(sources)
        self.still = pattern if self.still is None else self.still & pattern
        programs = _programs(plan(self.model, self.scene, pattern), self.reactions)
        samples, n = len(block), self.model.n
        loads = programs.wrenches(sources, samples)
        check_loads(loads, self.names, block.first_row, self.file)
        tau, base = loads[:, :n], loads[:, n : n + 6]
        net = np.einsum("ij,ij->i", tau, block.qd) - programs.losses(sources, samples)[:, 0]
        rows = np.linspace(0, samples - 1, min(samples, CHECKED_PER_BLOCK)).astype(int)
        checked = {name: values[rows] for name, values in sources.items()}
        expected = programs.laws(checked, len(rows))
        self.laws.update(expected, base[rows], net[rows], tau[rows] * block.qd[rows])
        self.ledger.update(block.time, net, rows, programs.energy(checked, len(rows))[:, 0])
        q, qd = (np.ascontiguousarray(x.T) for x in (block.q[:, self.positions], block.qd[:, self.rates]))
        self.statistics.update(block.time, q, qd, tau.T[self.rates], base.T, sources)
        return loads if self.reactions else tau

    @np.errstate(all="ignore")
    def result(self, last: Trajectory, explain: bool) -> Result:
        """Everything gathered, with shares and uncertainty at the peaks."""
        whole = plan(self.model, self.scene, self.still or frozenset())
        gathered = self.statistics
        peaks = np.concatenate((gathered.torque.value, gathered.base.value))
        check_figures(
            (*gathered.integrals.totals.values(), astuple(self.ledger.balance), self.laws.relative), peaks, self.file
        )
        shares = shares_at_peaks(whole, gathered.at_peak, self.rates.start)
        joints = tuple(
            joint_load(gathered, k, joint, name, self.scene, shares[k], self._uncertainty(k, last))
            for k, (joint, name) in enumerate(zip(self.joints, self.model.rates[self.rates], strict=True))
        )
        balance = self.ledger.balance
        warnings = [*self.model.notes, *last.notes]
        if not balance.consistent:
            warnings.append(
                f"energy balance is off by {balance.worst:.3g} J of {balance.turnover:.3g} J: "
                "velocities or accelerations are not the rates of the positions"
            )
        return Result(
            robot=self.model.name,
            samples=gathered.samples,
            duration=gathered.duration,
            gravity=self.scene.gravity,
            joints=joints,
            base_wrench=base_loads(gathered),
            effects=effect_reports(whole, explain),
            checks=Checks(balance, *self.laws.relative, self.laws.samples, *self.laws.largest),
            operations=whole.torques().size,
            executor="numpy",
            reason="starts at once, without compiling",
            derivation=last.derivation,
            warnings=tuple(warnings),
        )

    def _uncertainty(self, k: int, last: Trajectory) -> float:
        """sqrt(sum (M_kj s_j)^2) at the joint's peak: what noisy accelerations do to its torque."""
        if last.derivation is None or k not in self.statistics.at_peak:
            return 0.0
        peak = int(self.statistics.torque.index[k])
        from_end = min(peak, self.statistics.samples - 1 - peak)
        spread = {joint.name: joint.std_acceleration_near(from_end) for joint in last.derivation.joints}
        std = np.array([spread.get(name, 0.0) for name in self.model.rates])
        M = mass_matrix(self.model, self.statistics.at_peak[k][1]["q"], scene=self.scene)
        return float(np.linalg.norm(M[k + self.rates.start] * std))
