"""Torques as accurate as asked: the arithmetic by its error on the motion itself, and what noise in the data leaves."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from robodyn.dynamics.plan import plan, runner_of
from robodyn.errors import InputError
from robodyn.loads.result import Promise, Result
from robodyn.programs.run.multiprecision import Multiprecision
from robodyn.programs.run.numpy_blocks import NumpyBlocks
from robodyn.programs.run.runner import PAIRS
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene
from robodyn.support.extras import need
from robodyn.trajectory.motion import Trajectory
from robodyn.trajectory.read import sources_of

SAMPLES = 64
"""Of the motion, evenly spaced, on which errors are measured."""
DIGITS = 40
MARGIN = 4.0
"""Of what the largest error elsewhere may be, of that among the samples."""
ROUNDING = 2.0**-53
"""Of a result to a float."""


@dataclass(frozen=True)
class Arithmetic:
    """The cheapest arithmetic for a target.

    Attributes:
        executor: that it needs, None for any.
        expected: error, relative to the largest torque.
    """

    target: float
    executor: str | None
    expected: float

    def fulfilled(self, result: Result) -> Result:
        """The result with what it promises: the error of the arithmetic, and of noise in derived accelerations."""
        largest = max((abs(joint.peak) for joint in result.joints), default=0.0)
        derived = result.derivation is not None and largest > 0.0
        noise = max((joint.error_bar or 0.0 for joint in result.joints), default=0.0) / largest if derived else 0.0
        name = "pairs of doubles" if self.executor else "doubles"
        said = f"{self.target:g} asked: {name} are within {self.expected:.0e} of the largest torque"
        met = noise <= self.target
        if noise:
            said += f", and noise in derived accelerations is within {noise:.0e} of it (95 %)"
            said += "" if met else "; no arithmetic helps: give accelerations, or quieter positions"
        return replace(result, accuracy=Promise(self.target, max(self.expected, noise), met, said))


def arithmetic_within(model: Model, samples: Trajectory, scene: Scene, target: float) -> Arithmetic:
    """Doubles if their error is within the target, else pairs of doubles, whose sums are rounded at last.

    The error of doubles is four times the largest among 64 samples of the motion, against 40 digits.

    Raises:
        InputError: mpmath is not installed, or no result in doubles can be that accurate.

    Accuracy: covers the error of every sample in 95 of 100 random motions.
    """
    if target < ROUNDING:
        what = f"an accuracy of {target:g} cannot be promised: results are doubles, which are rounded to {ROUNDING:.1e}"
        raise InputError(what, remedy=f"ask for {ROUNDING:.1e} or more")
    need("accuracies that are promised", "mpmath")
    a_plan = plan(model, scene)
    program, sources = a_plan.torques(), sources_of(samples, scene)
    rows = np.unique(np.linspace(0, len(samples) - 1, SAMPLES).astype(int))
    few = {name: values[rows] for name, values in sources.items()}
    exact = Multiprecision(program, digits=DIGITS)(few, len(rows))
    found = NumpyBlocks(program, runner_of(program, a_plan).widths)(few, len(rows))
    largest = abs(exact).max() if exact.size else 0
    error = float(abs(exact - found.astype(object)).max() / largest) if largest else 0.0
    expected = MARGIN * max(error, ROUNDING)
    return Arithmetic(target, None, expected) if expected <= target else Arithmetic(target, PAIRS, ROUNDING)
