"""Monte Carlo: the motion run again with drawn parameters, as a comparison for error bars."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from robodyn.dynamics.plan import plan, runner_of
from robodyn.dynamics.regressor import _loads, summed
from robodyn.loads.sizing import train_of
from robodyn.loads.statistics import Integrals
from robodyn.loads.uncertainty import Quantities, UncertaintyPass
from robodyn.programs.program import trace
from robodyn.support.floats import Floats
from robodyn.trajectory.read import sources_of

SEED = 1905
TOGETHER = 200
"""Draws that are run together."""
ROOM = 4_000_000
"""Numbers of loads that are held at a time."""


def varied_runner(plan, found, rows):
    """Return sums of loads for a given `x`, by which parameters are off."""

    def outputs(tape):
        x = [tape.input("x", k) for k, _ in enumerate(found.each)]
        return summed(rows, _loads(plan, tape, x, found))

    return runner_of(trace(outputs), plan, {"x": len(found.each)})


class SamplePass:
    """Runs every block with every draw of the parameters.

    Attributes:
        peaks: (figures, draws) of magnitudes.
    """

    def __init__(self, beside: UncertaintyPass, count: int) -> None:
        """Args: beside: whose parameters and quantities are taken; count: draws."""
        self.of: Quantities = beside.of
        self.runner = varied_runner(plan(beside.model, beside.scene), beside.found, beside.of.rows)
        found = beside.found
        z = np.random.default_rng(SEED).standard_normal((count, len(found.each)))
        self.x = z if found.factor is None else z @ found.factor.T
        self.peaks = np.zeros((len(self.of.figures), count))
        self._integrals = [(slice(k, k + TOGETHER), Integrals()) for k in range(0, count, TOGETHER)]
        self._gears = [figure.a for figure in self.of.figures if figure.name == "gear"]

    def take(
        self,
        time: Floats,
        sources: Mapping[str, Floats],
        motion: tuple[Floats, Floats],
        executor: str,
        threads: int | None,
    ) -> None:
        """Take in a block; motion: qd and qdd (joints, N)."""
        step = max(2, ROOM // (TOGETHER * (self.of.columns + self.x.shape[1])))
        for start in range(0, len(time), step):
            part = slice(start, start + step)
            given, of = {name: values[part] for name, values in sources.items()}, time[part]
            qd, qdd = (each[:, part] for each in motion)
            for draws, integrals in self._integrals:
                x = self.x[draws]
                many = {name: np.tile(values, (len(x), *[1] * (values.ndim - 1))) for name, values in given.items()}
                many["x"] = np.repeat(x, len(of), axis=0)
                count, expected = len(x) * len(of), len(self.x) * len(of)
                sums = self.runner.run(many, count, executor=executor, threads=threads, expected=expected).values
                rates = (np.tile(each, len(x)) for each in (qd, qdd))
                values = self.of.with_motors(np.ascontiguousarray(sums.T), *rates)
                self._gather(draws, integrals, of, values.reshape(len(values), len(x), len(of)), qd)

    def _gather(self, draws: slice, integrals: Integrals, time: Floats, values: Floats, qd: Floats) -> None:
        """Take in the columns (columns, draws, N) of a block for some draws."""
        sizes = np.stack([figure.size(values[figure.columns]) for figure in self.of.figures])
        self.peaks[:, draws] = np.maximum(self.peaks[:, draws], sizes.max(axis=-1))
        quantities = {"square": sizes * sizes}
        if self._gears:
            load, pace = np.abs(values[self._gears]), np.abs(qd[[joint for joint, _ in self.of.trains]])
            quantities |= {"wear": load * load * load * pace[:, None], "travel": pace}
        integrals.update(time, quantities)

    def rms(self, figure: int) -> Floats:
        """Return (draws,) the RMS of a figure; its magnitude in a motion without duration."""
        each = [some for _, some in self._integrals]
        if each[0].duration <= 0.0:
            return np.array(self.peaks[figure])
        return np.sqrt(np.concatenate([some.totals["square"][figure] for some in each]) / each[0].duration)

    def cubic(self, i: int) -> Floats:
        """Return (draws,) the cubic mean of what gear i bears."""
        totals = [each.totals for _, each in self._integrals]
        travel = float(totals[0]["travel"][i])
        return np.cbrt(np.concatenate([each["wear"][i] for each in totals]) / (travel or 1.0))


def run_again(model, blocks, scene, count, bearings=True):
    """Return magnitudes (count,) of every figure of a motion with drawn parameters, by joint, quantity and kind."""
    rates = slice(6 if model.floating else 0, model.n)
    joints = [joint for joint in model.independent if joint.kind != "floating"]
    trains = [(k, train) for k, joint in enumerate(joints) if (train := train_of(joint, scene)) is not None]
    again = SamplePass(UncertaintyPass(model, scene, rates, trains, bearings), count)
    for block in blocks:
        motion = tuple(np.ascontiguousarray(each[:, rates].T) for each in (block.qd, block.qdd))
        again.take(block.time, sources_of(block, scene), motion, "auto", None)
    found, gears = {}, 0
    for k, figure in enumerate(again.of.figures):
        found[figure.owner, figure.name, "peak"] = again.peaks[k]
        found[figure.owner, figure.name, "rms"] = again.rms(k)
        if figure.name == "gear":
            found[figure.owner, "gear", "cubic"], gears = again.cubic(gears), gears + 1
    return found
