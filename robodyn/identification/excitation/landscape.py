"""How much a motion tells and how near it comes to its bounds, with exact slopes, and the search for a telling one."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import partial, reduce
from typing import NamedTuple

import numpy as np

from robodyn.dynamics.plan import Plan, loads, runner_of
from robodyn.dynamics.regressor import regressor_program
from robodyn.errors import InputError
from robodyn.identification.excitation.motion import Bounds, Fourier
from robodyn.programs.derivative import again, jacobian
from robodyn.programs.program import trace
from robodyn.programs.run.runner import Runner
from robodyn.programs.scalar import CONSTANT, Tape
from robodyn.programs.vectors import Scalar
from robodyn.support.floats import Floats, einsum, ranked

_SOURCES = ("q", "qd", "qdd")
_THIN, _EDGE = 2, 0.999
"""The regressor and the torques are computed at every second sample; from this part of a bound on its barrier goes on
as a parabola, so that a search finds back."""
_EARLY, _LATE = (10.0, 1.0), (0.1, 0.03)
"""Pressures of the barrier, stage by stage: those that all starts go through, and those of the best of them."""
_ROUNDS, _STEPS, _SETTLED, _SOFT = 12, 5, 1e-3, 0.3
"""Rounds of a stage and steps of each at most; what a round must gain per base parameter to go on; second derivative of
what is not the bounds'."""
_GRID = 2.0**12
"""After each round positions are rounded to its reciprocal, so that processors whose last digits differ go on alike."""
_POSTURES = 200  # that are tried for some which effort limits allow


class Programs(NamedTuple):
    """What is computed of motions (3, N, n) of q, qd and qdd, for n torques and r columns of the regressor.

    Attributes:
        shown: for each torque, which of the columns are not zero in its row whatever the motion: in a tree, few.
        rows: these entries of the regressor, one torque after another, and the torques; slopes: the derivative of a
            sum of these, each times a weight of its own, by q, qd and qdd.
    """

    n: int
    r: int
    shown: tuple[tuple[int, ...], ...]
    rows: Runner
    slopes: Runner

    def values(self, motion: Floats) -> tuple[list[Floats], Floats]:
        """Return the rows of each torque (N, c) in the columns that are not zero, and the torques (N, n)."""
        sources = dict(zip(_SOURCES, motion, strict=True))
        found = np.ascontiguousarray(self.rows(sources, motion.shape[1], executor="numpy"))
        *rows, tau = np.split(found, np.cumsum([len(columns) for columns in self.shown]), axis=1)
        return rows, tau

    def slope(self, motion: Floats, of_rows: list[Floats], of_torques: Floats) -> Floats:
        """Return the derivative (3, N, n) of sum of_rows rows + sum of_torques tau by the motion."""
        sources = dict(zip(_SOURCES, motion, strict=True))
        sources["weights"] = np.concatenate((*of_rows, of_torques), axis=1)
        found = self.slopes(sources, motion.shape[1], executor="numpy")
        return np.asarray(found.reshape(-1, 3, self.n).transpose(1, 0, 2))


def programs_of(plan: Plan, columns: Sequence[int], count: int) -> Programs:
    """Return the programs of a plan for some columns of the regressor, of `count` that it has."""
    n, whole = plan.model.n, regressor_program(plan)
    zero = [whole.operations[position] == (CONSTANT, 0.0, None) for position in whole.outputs]
    shown = tuple(tuple(k for k, j in enumerate(columns) if not zero[i * count + j]) for i in range(n))

    def entries(tape: Tape) -> list[Scalar]:
        found = again(whole, tape)
        rows = (found[i * count + columns[k]] for i in range(n) for k in shown[i])
        return [*rows, *loads(*plan.terms(tape)).tau]

    def slopes(tape: Tape) -> Iterable[Scalar]:
        terms = (entry * tape.input("weights", k) for k, entry in enumerate(entries(tape)))
        inputs = [tape.input(source, k) for source in _SOURCES for k in range(n)]
        return jacobian([sum(terms, 0.0)], [{each: 1.0} for each in inputs])[0]

    weights = {"weights": sum(map(len, shown)) + n}
    return Programs(n, len(columns), shown, runner_of(trace(entries), plan), runner_of(trace(slopes), plan, weights))


class Landscape:
    """`-log det (sum Y^T W Y / N) + pressure sum barrier(z)` of motions of a series, z being parts of their bounds.
    Positions y (m, size) are combinations x of the shapes of the series, turned joint by joint so that all directions
    lead to the bounds in steps of alike size. The barrier is -log(1 - z^2), from `_EDGE` on its parabola."""

    def __init__(
        self, programs: Programs, bounds: Bounds, series: Fourier, deviations: Floats, samples: int, room: float
    ) -> None:
        """Args: deviations: (n,) of the torques' noise; samples: of a period; room: part of the efforts to be used."""
        self.programs, self.bounds, self.size = programs, bounds, series.size
        self._moving = list(bounds.moving)
        limits = np.array([bounds.half, bounds.speed, bounds.acceleration])[:, None, self._moving]
        self._limits = limits / series.between(samples)
        self._efforts, self._scales = room * bounds.effort, 1.0 / deviations
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

    def largest_share(self, y: Floats) -> float:
        """Return the largest part of a bound that a motion takes; below 1 it keeps them."""
        used = self._used(y)
        torques = self.programs.values(self._motion(used))[1] / self._efforts
        return float(max(np.abs(used).max(), np.abs(torques).max()))

    def stiffness(self, y: Floats, pressure: float) -> Floats:
        """Return the second derivative (m, size, size) by y of what bounds of positions, speeds, accelerations add."""
        bend = self._share(pressure) / _THIN * _barrier(self._used(y))[2]
        return np.asarray(einsum("ktna,ktnb->nab", bend[..., None] * self._parts, self._parts))

    def height(self, y: Floats, pressure: float) -> tuple[float, Floats]:
        """Return the value and its slope (m, size); infinity where a parameter is not shown."""
        used = self._used(y)
        motion = self._motion(used)
        rows, tau = self.programs.values(motion)
        try:
            telling, of_rows = self._telling(rows)
        except np.linalg.LinAlgError:
            return np.inf, np.zeros_like(y)
        share = self._share(pressure)
        (value, slope, _), (of_tau, tau_slope, _) = _barrier(used), _barrier(tau / self._efforts)
        slope *= share / _THIN
        further = self.programs.slope(motion, [-part for part in of_rows], share * tau_slope / self._efforts)
        slope[:, ::_THIN] += further[:, :, self._moving] * self._limits
        height = share * float(value.sum() / _THIN + of_tau.sum()) - telling
        return height, np.asarray(einsum("ktn,ktna->na", slope, self._parts))

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
        """Return log det (sum Y^T W Y / N) and its slope by the rows of each torque; LinAlgError if it is singular."""
        A = np.zeros((self.programs.r, self.programs.r))
        weights = [scale * scale / len(part) for scale, part in zip(self._scales, rows, strict=True)]
        for columns, part, weight in zip(self.programs.shown, rows, weights, strict=True):
            A[np.ix_(columns, columns)] += weight * part.T @ part
        sizes = np.sqrt(np.diagonal(A))
        if not sizes.all():
            raise np.linalg.LinAlgError
        factor = np.linalg.cholesky(A / sizes / sizes[:, None])
        half = np.linalg.inv(factor) / sizes
        inverse = half.T @ half
        parts = zip(self.programs.shown, rows, weights, strict=True)
        slopes = [2.0 * weight * part @ inverse[np.ix_(columns, columns)] for columns, part, weight in parts]
        return 2.0 * float(np.log(np.diagonal(factor) * sizes).sum()), slopes


def _barrier(z: Floats) -> tuple[Floats, Floats, Floats]:
    """Return the barrier of parts of bounds, with its first and second derivative."""
    inner = np.clip(z, -_EDGE, _EDGE)
    room, over = 1.0 - inner * inner, z - inner
    slope, bend = 2.0 * inner / room, 2.0 * (1.0 + inner * inner) / (room * room)
    return -np.log(room) + over * (slope + 0.5 * bend * over), slope + bend * over, bend


def search(landscape: Landscape, starts: int, seed: int) -> Floats:
    """Return the best position that is found from so many motions well within the bounds, about postures that effort
    limits allow; raise InputError if no posture that is tried can be held."""
    rng = np.random.default_rng(seed)
    bounds, k = landscape.bounds, list(landscape.bounds.moving)
    made: list[Floats] = []
    for tried in range(_POSTURES):
        centre = bounds.middle[k] + bounds.half[k] * rng.uniform(-0.5, 0.5, len(k)) * (tried > 0)
        swings = rng.normal(size=(len(k), landscape.size))
        for halvings in range(12):
            y = on_grid(landscape.position(centre, 0.5**halvings * swings))
            if landscape.largest_share(y) < 0.95 and np.isfinite(landscape.height(y, 0.0)[0]):
                made.append(y)
                break
        if len(made) == starts:
            break
    if not made:
        what = f"none of {_POSTURES} postures can be held and moved about within the effort limits"
        raise InputError(what, remedy="check limits and masses, or move fewer joints: --joints")
    lowest = partial(_lowest, landscape)
    ends = [reduce(lowest, _EARLY, start) for start in made]
    return reduce(lowest, _LATE, ranked(ends, lambda end: -landscape.height(end, _EARLY[-1])[0])[0])


def on_grid(y: Floats) -> Floats:
    """Return numbers rounded so that their last digits are gone."""
    return np.asarray(np.round(y * _GRID) / _GRID)


def _lowest(landscape: Landscape, y: Floats, pressure: float) -> Floats:
    """Return where the landscape is low, near where the search starts: by SciPy's L-BFGS-B, some steps at a time, in
    variables in which the bounds' own second derivative is 1."""
    from scipy.optimize import minimize

    least = np.inf
    for _ in range(_ROUNDS):
        bend = landscape.stiffness(y, pressure) + _SOFT * np.eye(landscape.size)
        turn = np.linalg.inv(np.linalg.cholesky(bend)).transpose(0, 2, 1)

        def height(u: Floats, y: Floats = y, turn: Floats = turn) -> tuple[float, Floats]:
            value, slope = landscape.height(y + einsum("nab,nb->na", turn, u.reshape(y.shape)), pressure)
            return min(value, 1e10), np.asarray(einsum("nab,na->nb", turn, slope)).ravel()

        options = {"maxiter": _STEPS, "ftol": 1e-6}
        found = minimize(height, np.zeros(y.size), jac=True, method="L-BFGS-B", options=options)
        y = on_grid(y + einsum("nab,nb->na", turn, found.x.reshape(y.shape)))
        if least - found.fun < _SETTLED * landscape.programs.r:
            break
        least = found.fun
    return y
