"""How much a motion tells and how near it comes to its bounds, with exact slopes."""

from __future__ import annotations

import numpy as np

from robodyn.identification.excitation.bounds import Bounds
from robodyn.identification.excitation.fourier import Fourier
from robodyn.identification.excitation.programs import Programs
from robodyn.programs.vectors import product
from robodyn.support.floats import Floats
from robodyn.support.sums import einsum

_THIN = 2
"""The regressor and the torques are computed at every second sample, where positions, speeds, accelerations are."""


class Landscape:
    """`-log det (sum Y^T W Y / N) - pressure sum log(1 - z^2)` of motions of a series, z being parts of their bounds.

    Positions y (m, size) are combinations x of the shapes of the series, turned joint by joint so that all directions
    lead to the bounds in steps of alike size.
    """

    def __init__(
        self, programs: Programs, bounds: Bounds, series: Fourier, deviations: Floats, samples: int, room: float
    ) -> None:
        """Args: deviations: (n,) of the torques' noise. samples: of a period. room: part of the efforts to be used."""
        self.programs, self.bounds, self.size = programs, bounds, series.size
        self._moving = list(bounds.moving)
        limits = np.array([bounds.half, bounds.speed, bounds.acceleration])[:, None, self._moving]
        self._limits = limits / series.between(samples)
        self._efforts = room * bounds.effort
        self._scales = 1.0 / deviations
        self._zero = bounds.middle[self._moving] / self._limits[0]
        shapes = series.shapes(series.even(samples))
        squares = einsum("kti,ktj,kln->nij", shapes, shapes, self._limits**-2.0) / samples
        self._turn = np.linalg.inv(np.linalg.cholesky(squares)).transpose(0, 2, 1)
        self._parts = einsum("kti,nij->ktnj", shapes, self._turn) / self._limits[..., None]

    def combinations(self, y: Floats) -> Floats:
        """Return x (m, size) of positions y."""
        return np.asarray(einsum("nij,nj->ni", self._turn, y))

    def position(self, centre: Floats, swings: Floats) -> Floats:
        """Return the y of motions about a centre (m,), with y of `swings` but for that."""
        x = self.combinations(swings)
        x[:, 0] = centre
        return np.asarray(np.linalg.solve(self._turn, x[..., None])[..., 0])

    def reach(self, y: Floats, step: Floats) -> float:
        """Return how many steps lead to the first bound of position, speed or acceleration."""
        used, more = self._used(y), einsum("ktna,na->ktn", self._parts, step)
        with np.errstate(divide="ignore"):
            return float(((1.0 - np.sign(more) * used) / np.abs(more)).min())

    def most(self, y: Floats) -> float:
        """Return the largest part of a bound that a motion takes; below 1 it keeps them."""
        used = self._used(y)
        torques = self.programs.values(self._motion(used))[1] / self._efforts
        return float(max(np.abs(used).max(), np.abs(torques).max()))

    def stiffness(self, y: Floats, pressure: float) -> Floats:
        """Return the second derivative (m, size, size) by y of what bounds of positions, speeds, accelerations add."""
        used = self._used(y)
        bend = 2.0 * self._share(pressure) / _THIN * (1.0 + used * used) / (1.0 - used * used) ** 2
        return np.asarray(einsum("ktna,ktnb->nab", bend[..., None] * self._parts, self._parts))

    def height(self, y: Floats, pressure: float) -> tuple[float, Floats]:
        """Return the value and its slope (m, size); infinity beyond a bound, and where a parameter is not shown."""
        used = self._used(y)
        if np.abs(used).max() >= 1.0:
            return np.inf, y
        motion = self._motion(used)
        rows, tau = self.programs.values(motion)
        torques = tau / self._efforts
        if np.abs(torques).max() >= 1.0:
            return np.inf, y
        try:
            telling, of_rows = self._telling(rows)
        except np.linalg.LinAlgError:
            return np.inf, y
        share = self._share(pressure)
        barrier = -share * float(np.log1p(-used * used).sum() / _THIN + np.log1p(-torques * torques).sum())
        of_torques = 2.0 * share * torques / (1.0 - torques * torques) / self._efforts
        further = self.programs.slope(motion, [-part for part in of_rows], of_torques)
        slope = 2.0 * share / _THIN * used / (1.0 - used * used)
        slope[:, ::_THIN] += further[:, :, self._moving] * self._limits
        return barrier - telling, einsum("ktn,ktna->na", slope, self._parts)

    def _used(self, y: Floats) -> Floats:
        """Return which parts of their bounds positions, speeds and accelerations (3, N, m) are."""
        used = np.asarray(einsum("ktna,na->ktn", self._parts, y))
        used[0] -= self._zero
        return used

    def _motion(self, used: Floats) -> Floats:
        """Return q, qd and qdd (3, N, n) at every `_THIN`-th sample."""
        few = used[:, ::_THIN] * self._limits
        motion = np.zeros((3, few.shape[1], len(self.bounds.home)))
        motion[0] = self.bounds.home
        motion[:, :, self._moving] = few
        motion[0][:, self._moving] += self.bounds.middle[self._moving]
        return motion

    def _share(self, pressure: float) -> float:
        """Return the weight of one sample of one torque: all bounds together weigh as the parameters at pressure 1."""
        kinds, samples, m, _ = self._parts.shape
        return float(pressure * self.programs.r / (kinds * m + len(self._efforts)) / (samples // _THIN))

    def _telling(self, rows: list[Floats]) -> tuple[float, list[Floats]]:
        """Return log det (sum Y^T W Y / N) and its derivative by the rows of each torque.

        Raises:
            numpy.linalg.LinAlgError: it is singular.
        """
        A = np.zeros((self.programs.r, self.programs.r))
        for columns, part, scale in zip(self.programs.shown, rows, self._scales, strict=True):
            A[np.ix_(columns, columns)] += scale * scale / len(part) * product(part.T, part)
        sizes = np.sqrt(einsum("ii->i", A))
        if not sizes.all():
            raise np.linalg.LinAlgError
        factor = np.linalg.cholesky(A / sizes / sizes[:, None])
        half = np.linalg.inv(factor) / sizes
        inverse = product(half.T, half)
        slopes = [
            2.0 * scale * scale / len(part) * product(part, inverse[np.ix_(columns, columns)])
            for columns, part, scale in zip(self.programs.shown, rows, self._scales, strict=True)
        ]
        return 2.0 * float(np.log(einsum("ii->i", factor)).sum() + np.log(sizes).sum()), slopes
