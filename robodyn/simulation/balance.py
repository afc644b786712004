"""The balance of energy and work along a motion, by which steps that are too long are told where nothing else tells."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from robodyn.simulation.fixed import Motion
from robodyn.simulation.methods import MethodOptions
from robodyn.simulation.result import Figures
from robodyn.simulation.stiffness import rounded
from robodyn.support.caveats import Caveat

KEPT = 1e-3
"""Of the energy that a motion turns over: by more than this its balance may not be off."""
ROUNDING = 1e-10
"""Of the stored energy, whose zero is arbitrary: what is less is rounding."""
DRIFTS = "by steps that do not keep the energy (ENERGY DRIFTS)"
"""The kind of caveat about motions whose balance is off."""


class Balanced(NamedTuple):
    """A motion with its figures, which say how well it keeps the balance E - E_0 = work."""

    motion: Motion
    figures: Figures

    @property
    def off(self) -> float:
        """max |E - E_0 - work| [J]."""
        energy, work = self.figures.energy, self.motion.states[:, -2]
        return float(np.abs(energy - energy[0] - (work - work[0])).max())

    @property
    def share(self) -> float:
        """`off` as a share of what is turned over: kinetic and stored energy, work, what drives give and take."""
        figures, motion = self.figures, self.motion
        n = figures.tau.shape[1]
        power = np.abs(figures.tau * motion.states[:, -2 - n : -2]).sum(axis=1)
        driven = float((0.5 * (power[1:] + power[:-1]) * np.diff(motion.time)).sum())
        energy = figures.energy
        largest = max(figures.kinetic.max(), np.ptp(energy), np.ptp(motion.states[:, -2]), driven)
        return self.off / max(float(largest), ROUNDING * float(np.abs(energy).max()), 1e-300)

    def finer(self, step: float) -> float:
        """Return a step whose balance should be kept."""
        return rounded(0.25 * step)

    def caveat(self, options: MethodOptions) -> Caveat:
        """Return what is said of a balance that is off."""
        shorter = f"give --step {self.finer(options.step):g}, or --method radau"
        remedy = "give a smaller --rtol" if options.method.adaptive else shorter
        return Caveat(
            DRIFTS,
            f"ENERGY DRIFTS: stored energy and work part by {self.off:.3g} J, {100 * self.share:.2g} % of what the "
            f"motion turns over, and more than {100 * KEPT:g} % ({remedy})",
        )
