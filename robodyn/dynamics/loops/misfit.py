"""By how much a motion misses closing the loops of its robot."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from robodyn.dynamics.loops.block_equations import BlockEquations
from robodyn.dynamics.loops.branch_start import OFF
from robodyn.errors import TrajectoryError
from robodyn.support.caveats import Caveat
from robodyn.support.floats import Floats
from robodyn.support.sums import einsum

ORDERS = ("positions", "velocities", "accelerations")
RATES = ("", "/s", "/s^2")
SHARE = 0.05
"""Of the largest sum of |J_k qd_k| along the motion, or of |J_k qdd_k| and |J_k qd_k| max |qd|: rates that miss by more
are not those of a closed chain."""

NOTED = 1e-3
"""rad, or of the loops' size, from which on it is said that loops are open."""


class Misfit(NamedTuple):
    """The largest |phi|, or of its first or second derivative.

    Attributes:
        order: of the derivative. size: in `unit`: m or rad, per s or s^2. loop: its name. time: s.
    """

    order: int
    size: float
    unit: str
    loop: str
    time: float


class Misfits:
    """What is left of phi, phi' = J qd and phi'' = J qdd + J' qd along a motion, block after block."""

    def __init__(self, equations: BlockEquations) -> None:
        self._equations = equations
        self._largest: list[Misfit | None] = [None, None, None]
        self._shares = [0.0, 0.0, 0.0]
        self._left, self._sums = np.zeros((2, 2, equations.count))

    @property
    def largest(self) -> tuple[Misfit, ...]:
        """Of each derivative, that which is the largest part of the loops' size or of 1 rad."""
        return tuple(each for each in self._largest if each is not None)

    def refuse(self, phi: Floats, time: Floats, first_row: int, follows: bool) -> None:
        """Raise if loops are open by more than OFF.

        Args:
            phi: (N, equations). follows: whether some coordinates follow.
        """
        if not phi.size:
            return
        shares = np.abs(phi) / self._equations.scale
        k = int(np.argmax(shares.max(axis=1) > OFF))
        worst = int(np.argmax(shares[k]))
        if not shares[k, worst] <= OFF:
            unit, least = self._equations.units[worst], OFF * self._equations.scale[worst]
            raise TrajectoryError(
                f'row {first_row + k}, {time[k]:.6g} s: loop "{self._equations.names[worst]}" is open by '
                f"{abs(phi[k, worst]):.3g} {unit} with these columns, more than {least:.3g} {unit}",
                remedy="correct the columns, or leave some out: what is left out follows from the loops"
                + ("; columns of more joints than needed are given" if follows else ""),
            )

    def update(self, time: Floats, phi: Floats, J: Floats, qd: Floats, qdd: Floats, bias: Floats) -> None:
        """Take in samples.

        Args:
            time: (N,). phi, bias: (N, equations). J: (N, equations, rates). qd, qdd: (N, n).
        """
        if not phi.size:
            return
        rates = list(self._equations.rates)
        rate = einsum("nmk,nk->nm", J, qd[:, rates])
        change = einsum("nmk,nk->nm", J, qdd[:, rates]) + bias
        for order, values in enumerate((phi, rate, change)):
            self._take(order, values, time)
        fast = einsum("nmk,nk->nm", np.abs(J), np.abs(qd[:, rates]))
        turning = fast * np.abs(qd[:, rates]).max(axis=1, keepdims=True, initial=0.0)
        sums = (fast, einsum("nmk,nk->nm", np.abs(J), np.abs(qdd[:, rates])) + turning)
        for k, values in enumerate((rate, change)):
            self._left[k] = np.maximum(self._left[k], np.abs(values).max(axis=0))
            self._sums[k] = np.maximum(self._sums[k], sums[k].max(axis=0))

    def _take(self, order: int, values: Floats, time: Floats) -> None:
        shares = np.abs(values) / self._equations.scale
        k, worst = (int(i) for i in np.unravel_index(int(np.argmax(shares)), shares.shape))
        if self._largest[order] is None or shares[k, worst] > self._shares[order]:
            unit, name = f"{self._equations.units[worst]}{RATES[order]}", self._equations.names[worst]
            self._shares[order] = float(shares[k, worst])
            self._largest[order] = Misfit(order, float(abs(values[k, worst])), unit, name, float(time[k]))

    def notes(self) -> list[str]:
        """Return a note on loops that the positions given leave open."""
        misfit = self._largest[0]
        if misfit is None or self._shares[0] <= NOTED:
            return []
        return [f'loop "{misfit.loop}" is open by up to {misfit.size:.2g} {misfit.unit} ({misfit.time:.4g} s)']

    def caveats(self) -> list[Caveat]:
        """Return the caveat about given rates that the loops do not allow."""
        found = []
        for order in (1, 2):
            misfit, left, sums = self._largest[order], self._left[order - 1], self._sums[order - 1]
            if misfit is not None and (left > SHARE * sums.max(initial=0.0)).any():
                said = (
                    f'the {ORDERS[order]} given open loop "{misfit.loop}" at {misfit.size:.3g} {misfit.unit} '
                    f"({misfit.time:.4g} s); leave columns out that follow from the loops"
                )
                found.append(Caveat(f"by {ORDERS[order]} that the loops do not allow", said))
        return found
