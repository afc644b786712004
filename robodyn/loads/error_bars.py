"""By how much torques may be off that come of derived accelerations."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from robodyn.dynamics.effects.friction import joints_with_friction
from robodyn.dynamics.mass import mass_matrix
from robodyn.loads.caveats import Openness
from robodyn.programs.vectors import length
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene
from robodyn.support.floats import Floats
from robodyn.trajectory.motion import NOISE

if TYPE_CHECKING:
    from robodyn.loads.constraints import ConstraintPass


class ErrorBars:
    """Error bars of joint torques, by the derivatives of torques by accelerations.

    Attributes:
        openness: what is open of the accelerations.
    """

    def __init__(self, model: Model, scene: Scene, rates: slice, constraints: ConstraintPass | None) -> None:
        """Args: rates: the entries of tau that are joints; constraints: of the motion, if there are any."""
        self.model, self.scene, self.rates, self.constraints = model, scene, rates, constraints
        self.openness = Openness(model.n)
        self._first: Floats | None = None

    def over_block(self, state: Mapping[str, Floats]) -> Floats | float:
        """Return (joints, N) by how much torques may be off; 0 for guesses.

        Noise s of accelerations adds up as sqrt(sum_j (M_kj s_j)^2), what is in doubt besides as sum_j |M_kj d_j|:
        joints that move together have their corners together. Where constraints bear a part, M is that of the first
        pose.

        Args:
            state: q (N, nq) and so on; noise, off: (N, n) of accelerations.
        """
        noise, off = NOISE * state["noise"], state["off"]
        if self.openness.guessed or not off.any():
            return 0.0
        if self.constraints is None:
            M = self._inertia(state["q"])[:, self.rates]
        else:
            if self._first is None:
                self._first = self.response({name: values[0] for name, values in state.items()})[self.rates]
            M = self._first[None]
        M = np.abs(M.transpose(1, 0, 2))
        doubt = (M * np.maximum(off - noise, 0.0)).sum(axis=2)
        return np.asarray(doubt + np.sqrt(((M * np.minimum(noise, off)) ** 2).sum(axis=2)))

    def _inertia(self, q: Floats) -> Floats:
        """Return (N, n, n) by how much torques of poses (N, nq) change with accelerations, load's friction included."""
        M = mass_matrix(self.model, np.ascontiguousarray(q), scene=self.scene)
        for _, joint, friction in joints_with_friction(self.model, self.scene):
            if friction.load:
                M[..., joint.rate, :] *= 1.0 + friction.load
        return M

    def at_peak(self, k: int, state: Mapping[str, Floats] | None, shares: Mapping[str, float]) -> tuple[float, float]:
        """Return sqrt(sum (M_kj s_j)^2) of joint k at its peak, what noise of accelerations does there; and its bar.

        Args:
            state: of the peak; None without one. shares: of the torque, by effect.
        """
        if state is None or not state["off"].any():
            return 0.0, 0.0
        M = self.response(state)[k + self.rates.start]
        return length(M * state["noise"]), self.openness.bar(M, state["off"], shares)

    def response(self, state: Mapping[str, Floats], own: bool = False) -> Floats:
        """Return (n, n) by how much torques change with accelerations: M, but where constraints take part of it.

        Friction that grows with load adds at most its share, which is taken.

        Args:
            state: q (nq,) and so on of one sample; own: as `ConstraintPass.response` has it.
        """
        if self.constraints is not None:
            return self.constraints.response(state, own)
        return self._inertia(state["q"])
