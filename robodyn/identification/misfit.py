"""What fits leave of torques beyond their noise: how far off predictions are of another motion."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from robodyn.identification.filters import kernel
from robodyn.identification.gather import Gathered
from robodyn.identification.run import FOLDS, Run
from robodyn.identification.structure import Structure, counts, least_squares, squares, without_one
from robodyn.support.floats import Floats

_ABSORBED = 3.0
"""Times what is left: a fit hides a part of what the model has not in its parameters, where it comes back on another
motion. Chosen on one half of the logs of which the documentation has the other."""
_CHANCE = 1.0
"""Standard deviations by which noise alone is larger in one part of a log than in another."""
_LEAST = 1e-3
"""Of a joint's torque: no model is nearer to a robot."""
_LOUD = 2.0
"""Times the noise: what is told."""


class Misfit(NamedTuple):
    """What is left of each measured joint's torque in parts of the logs that were not fitted.

    Attributes:
        left: (joints,) its RMS in the worst part; noise: that of the noise of torques, filtered [N m].
        deviation: (joints,) standard error of predicted torques beside that of the parameters [N m].
    """

    left: Floats
    noise: Floats
    deviation: Floats

    def words(self, names: list[str]) -> list[str]:
        """Return a line if something is missing in the model."""
        rows = zip(names, self.left.tolist(), self.noise.tolist(), self.deviation.tolist(), strict=True)
        loud = [f"{name} +- {more:.2g} N m" for name, left, noise, more in rows if left > _LOUD * noise]
        if not loud:
            return []
        what = "the model lacks something (friction that changes or sticks, joints that bend, a load)"
        return [f"more than noise is left of some torques: {what}; intervals are wider by {', '.join(loud)}"]


def misfit(run: Run, structure: Structure, plain: Gathered, weighted: Gathered, theta: Floats, sigma: Floats) -> Misfit:
    """Return how far off torques are in each part of the logs where the other parts were fitted, and what is held out.

    Blocks of the log stand for other motions: their errors have in them how residuals go along with the motion, and how
    they differ between the parts of a log.

    Args:
        theta: (p,) fitted to all parts; sigma: (joints,) by which joints weigh [N m].
    """
    folds, parts = range(FOLDS), []
    for fold, (R, z) in enumerate(without_one(weighted, folds, structure, sigma)):
        parts.append((fold, least_squares(R, z)))
    off, least = [], np.zeros(len(sigma))
    noise = _noise(run)
    for fold, values in (*parts, (FOLDS, theta)):
        rows = counts(plain, [fold])
        if rows.all():
            off.append(squares(plain, fold, structure, values) / rows)
            least = np.maximum(least, noise * (1.0 + _CHANCE / np.sqrt(2.0 * rows)))
    left = np.sqrt(np.max(off, axis=0))
    size = np.sqrt(plain.squares.sum(axis=0) / np.maximum(counts(plain, range(FOLDS + 1)), 1.0))
    deviation = np.hypot(_ABSORBED * np.sqrt(np.maximum(left**2 - least**2, 0.0)), _LEAST * size)
    return Misfit(left, noise, deviation)


def _noise(run: Run) -> Floats:
    """Return (joints,) the standard deviation of filtered noise, of the log with least."""
    passed = [np.linalg.norm(kernel(run.cutoff, log.step)) * log.loud for log in run.logs]
    return np.asarray(np.min(passed, axis=0)[list(run.measured)])
