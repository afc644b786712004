"""Monte Carlo: the motion run again with drawn parameters, as a comparison for error bars."""

from __future__ import annotations

from collections import defaultdict

import numpy as np
from scipy.integrate import trapezoid

from robodyn.dynamics.plan import plan, runner_of
from robodyn.dynamics.regressor import _loads, summed
from robodyn.loads.sizing import train_of
from robodyn.loads.uncertainty import UncertaintyPass
from robodyn.programs.program import trace
from robodyn.trajectory.read import sources_of

SEED = 1905
TOGETHER = 200
"""Draws that are run together."""


def varied_runner(plan, found, rows):
    """Return sums of loads for a given `x`, by which parameters are off."""

    def outputs(tape):
        x = [tape.input("x", k) for k, _ in enumerate(found.each)]
        return summed(rows, _loads(plan, tape, x, found))

    return runner_of(trace(outputs), plan, {"x": len(found.each)})


def run_again(model, motion, scene, count, bearings=True):
    """Return magnitudes (count,) of every figure of a motion with drawn parameters, by joint, quantity and kind."""
    rates, samples = slice(6 if model.floating else 0, model.n), len(motion)
    joints = [joint for joint in model.independent if joint.kind != "floating"]
    trains = [(k, train) for k, joint in enumerate(joints) if (train := train_of(joint, scene)) is not None]
    beside = UncertaintyPass(model, scene, rates, trains, bearings)
    of, found, runner = beside.of, beside.found, varied_runner(plan(model, scene), beside.found, beside.of.rows)
    z = np.random.default_rng(SEED).standard_normal((count, len(found.each)))
    every, result = z if found.factor is None else z @ found.factor.T, defaultdict(list)
    for x in np.split(every, range(TOGETHER, count, TOGETHER)):
        draws = len(x)
        given = {key: np.tile(each, (draws, *[1] * (each.ndim - 1))) for key, each in sources_of(motion, scene).items()}
        sums = runner.run(given | {"x": np.repeat(x, samples, axis=0)}, draws * samples, executor="auto").values
        qd, qdd = (np.ascontiguousarray(np.tile(each[:, rates].T, draws)) for each in (motion.qd, motion.qdd))
        values = of.with_motors(np.ascontiguousarray(sums.T), qd, qdd).reshape(of.columns, draws, samples)
        pace = iter(np.abs(qd[[joint for joint, _ in of.trains]]).reshape(-1, draws, samples))
        for figure in of.figures:
            size, own = figure.size(values[figure.columns]), (figure.owner, figure.name)
            result[(*own, "peak")].append(size.max(axis=-1))
            result[(*own, "rms")].append(np.sqrt(trapezoid(size**2, motion.time) / np.ptp(motion.time)))
            if figure.name == "gear":
                speed = next(pace)
                travel = trapezoid(speed, motion.time)
                wear = trapezoid(size**3 * speed, motion.time) / np.where(travel == 0.0, 1.0, travel)
                result[(*own, "cubic")].append(np.cbrt(wear))
    return {key: np.concatenate(parts) for key, parts in result.items()}
