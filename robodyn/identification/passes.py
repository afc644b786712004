"""Passes over the logs that are fitted and those that are held out; and how they were taken, by raw samples: torques
that are late, gravity that leans, positions that are misread."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from itertools import combinations
from typing import NamedTuple

import numpy as np

from robodyn.dynamics.effects.motors import spins
from robodyn.dynamics.regressor import INERTIAL
from robodyn.errors import InputError, WrongUnits
from robodyn.identification.faults.compare import magnitudes, told
from robodyn.identification.faults.faults import range_basis
from robodyn.identification.log.curves import add, curves_of
from robodyn.identification.log.log import Log, Samples, joined
from robodyn.identification.log.rows import PERIODS, POSITIONS, filtered, kernel, rates, states
from robodyn.identification.model_selection import (
    ROUNDED,
    SPEEDS,
    Structure,
    counts,
    coupled,
    coupled_motors,
    fitted,
    joint_motors,
    least_squares,
    system,
    whole_system,
)
from robodyn.identification.parameters.base import base_of
from robodyn.identification.parameters.regressor_columns import (
    PLAIN,
    Gathered,
    Guess,
    Moments,
    Motor,
    RegressorColumns,
    gather,
)
from robodyn.programs.vectors import product
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene
from robodyn.support.courses import Courses
from robodyn.support.floats import Floats, einsum

FOLDS = 5  # parts of what is fitted, for cross-validation; what is held out is another one
RESTS = 1e-6  # rad/s (m/s): a joint that is never faster rests
_NOISE = 4.0
_SLOW = 1e-5  # of the largest speed: below it, derived speeds do not tell the sign of friction
_JOINTS, _LEAST, _FILLED = 30, 2, 2
"""At most; rows for each base parameter; folds with rows in them, so that what one leaves out is told by another."""


@dataclass(frozen=True, eq=False)
class Run:
    """Logs that are fitted, then those that are held out, and how they are gone through."""

    logs: tuple[Log, ...]
    edges: tuple[tuple[float, ...], ...]
    measured: tuple[int, ...]
    scene: Scene
    cutoff: float
    slip_speed: float
    directions: dict[str, Motor]
    holds: bool

    @property
    def model(self) -> Model:
        return self.logs[0].model

    def delayed(self, delays: Floats) -> Run:
        """Return the run through logs whose torques are (n,) late [s]."""
        return replace(self, logs=tuple(replace(log, delays=delays) for log in self.logs))

    def gathered(self, regressor: RegressorColumns, guess: Guess | None = None) -> tuple[Gathered, Gathered]:
        """Return the factors of one pass over all logs, and the weighted ones."""
        plain, weighted = Gathered(FOLDS + 1, regressor), Gathered(FOLDS + 1, regressor)
        for log, edges in zip(self.logs, self.edges, strict=True):
            gather(log, self.cutoff, edges, plain, weighted, guess)
        return plain, weighted


def begun(logs: Sequence[Log], validate: Sequence[Log], scene: Scene, split: float, cutoff: float | None) -> Run:
    """Go through the logs once for the largest speeds; raise InputError if a log is given twice, of which standard
    errors would know nothing, or the filter passes everything or nothing."""
    every = (*logs, *validate)
    model = every[0].model
    check_size(model)
    for spin in spins(model, scene):
        what = f"[rotor] {spin.joint.name} has an axis, and identify knows only rotors that turn in place"
        raise InputError(what, remedy="leave axis and on out")
    measured = tuple(j for j in every[0].measured if all(j in log.measured for log in every))
    if not measured:
        raise InputError("the logs have no measured joint in common", remedy="identify them one by one")
    cutoff = min(log.cutoff for log in every) if cutoff is None else cutoff
    seen: dict[str, str] = {}
    for log in every:
        if log.sha256 in seen:
            what = f"has the same content as {seen[log.sha256]}"
            raise InputError(what, remedy="give each log once, and validate by another", file=log.path)
        seen[log.sha256] = log.path
        if log.noisy and POSITIONS * cutoff * (log.stop - log.start) < 2.0 * PERIODS:
            what = f"a filter of {cutoff:g} Hz leaves 0 rows of {log.stop - log.start:.4g} s"
            raise InputError(what, remedy="choose a higher --cutoff", file=log.path)
        if cutoff >= 0.5 / log.step:
            what = f"a cutoff of {cutoff:g} Hz is above half the sampling rate, {0.5 / log.step:.4g} Hz"
            raise InputError(what, remedy="choose a lower --cutoff", file=log.path)
    turns = {motor.name: [motor.joints.get(name, 0.0) for name in model.rates] for motor in scene.coupled}
    known = [Motor(name, np.array(direction), 0.0) for name, direction in turns.items()]
    candidates = [*joint_motors(model), *known, *coupled_motors(model, measured, known)]
    largest, slip = np.zeros(len(candidates)), scene.slip_speed
    directions = np.stack([motor.direction for motor in candidates])
    for log in every:
        top = np.zeros(len(candidates))
        for samples in states(log, cutoff):
            speeds = einsum("kj,mj->km", samples.qd, directions)
            top = np.maximum(top, np.abs(speeds).max(axis=0, initial=0.0))
        if log.derived and not scene.slip_speed:
            _, first, _ = rates(kernel(min(POSITIONS * cutoff, 0.4 / log.step), log.step), log.step)
            noise = log.noise * float(np.sqrt((first**2).sum()))  # of the speeds of smoothed positions
            slip = max(slip, _SLOW * float(top[: model.n].max()), _NOISE * noise)
        largest = np.maximum(largest, top)
    if largest[: model.n].max() <= max(RESTS, 2.0 * slip if slip != scene.slip_speed else 0.0):
        why = ["no joint moves: the log shows nothing of masses and friction", *(c.text for c in every[0].caveats)]
        raise InputError("; ".join(why), remedy="log an exciting motion, see robodyn excite", file=every[0].path)
    motors = {}
    for each, most in zip(candidates, largest.tolist(), strict=True):
        # breakaway decays over more than a sign does that is rounded off
        speeds = tuple(part * most for part in SPEEDS if part * most > ROUNDED * slip)
        motors[each.name] = replace(each, scale=most, stribeck=speeds)
    ends = [log.start + (log.stop - log.start) * split * np.arange(1, FOLDS + 1) / FOLDS for log in logs]
    edges = (*(tuple(each.tolist()) for each in ends), *((-np.inf,) * FOLDS for _ in validate))
    holds = bool(validate) or split < 1.0
    return Run(every, edges, measured, scene, cutoff, float(f"{slip:.3g}"), motors, holds)


class First(NamedTuple):
    """What a first fit tells: motors that count, what coupled ones leave of the squares, values by column, sigma
    (joints,) of residuals [N m], faults of the logs, for which nothing is written, and caveats about gravity."""

    run: Run
    motors: list[Motor]
    coupled: dict[str, float]
    values: dict[str, float]
    sigma: Floats
    faults: list[str]
    caveats: list[str]


def first_fit(run: Run) -> First:
    names = run.model.rates
    given = {*names, *(motor.name for motor in run.scene.coupled)}
    slow = max(RESTS, 2.0 * run.slip_speed)
    motors = [
        each
        for name, each in run.directions.items()
        if (names.index(name) in run.measured if name in names else name in given or each.scale > slow)
    ]
    bare = [replace(motor, stribeck=()) for motor in motors]
    regressor = RegressorColumns(run.model, run.scene, run.measured, bare, run.slip_speed)
    fitted_logs = [log for log, edges in zip(run.logs, run.edges, strict=True) if edges[-1] > log.start]
    raw = Raw(fitted_logs, run.cutoff, regressor, [edges[-1] for edges in run.edges if np.isfinite(edges[-1])])
    plain, _ = run.gathered(regressor)
    joints = [k for k, motor in enumerate(motors) if motor.name in given]
    first = Structure(regressor, dict.fromkeys(joints, PLAIN))
    rows = int(counts(plain, range(FOLDS)).sum())
    R, _ = system(plain, range(FOLDS), first, np.ones(len(run.measured)))
    rank = base_of(R, first.names).rank if rows else len(first.names)
    filled = sum(bool(counts(plain, [fold]).any()) for fold in range(FOLDS))
    if rows < _LEAST * rank or filled < _FILLED:
        what = f"a filter of {run.cutoff:.3g} Hz leaves {rows} rows to fit {rank} parameters to"
        remedy = "give a longer log, a higher --cutoff or a larger --split"
        raise InputError(what, remedy=remedy, file=run.logs[0].path)
    if run.holds and not counts(plain, [FOLDS]).all():
        what = f"a filter of {run.cutoff:.3g} Hz leaves nothing of what is held out"
        remedy = "give a longer log, a higher --cutoff, or --split 1"
        raise InputError(what, remedy=remedy, file=run.logs[-1].path)
    late = raw.delays()
    if late.any():  # a delay counts if it leaves much less of its joint's torque also where all joints are fitted
        _, before = fitted(plain, range(FOLDS), first)
        _, after = fitted(run.delayed(late).gathered(regressor)[0], range(FOLDS), first)
        late[list(run.measured)] *= after**2 < LATE * before**2
        run = run.delayed(late)
        plain, _ = run.gathered(regressor)
    channels, measured = [triangle.R for triangle in plain.channels], [names[j] for j in run.measured]
    faults = told(channels).words(measured)
    ratios = {motor.name: part for motor, part in coupled(plain, range(FOLDS), first)}
    chosen = [k for k, motor in enumerate(motors) if k in joints or motor.name in ratios]
    second = Structure(regressor, dict.fromkeys(chosen, PLAIN))
    theta, sigma = fitted(plain, range(FOLDS), second)
    faults = faults or raw.misread(second, sigma)
    caveats = [] if faults else raw.leaning(second, theta, sigma, run.scene)
    values = dict(zip(regressor.names, (second.shape @ theta).tolist(), strict=True))
    units = [
        caveat.text if len(run.logs) == 1 else f"{log.path}: {caveat.text}"
        for log in run.logs
        for caveat in log.caveats
        if isinstance(caveat, WrongUnits)
    ]
    faults = [*units, *faults, *magnitudes(channels, measured)]
    return First(run, [motors[k] for k in chosen], ratios, values, sigma, faults, caveats)


def weighted_rows(run: Run, first: First) -> tuple[Gathered, Gathered, Moments]:
    """Return factors of all columns, plain and with outliers weighing less, and what tells how rows are correlated."""
    motors, values, rates = first.motors, first.values, run.model.rates
    several = [motor.direction for motor in motors if np.count_nonzero(motor.direction) > 1]
    shared = {rates[j] for direction in several for j in np.flatnonzero(direction)}
    motors = [replace(motor, loaded=motor.name in rates and motor.name not in shared) for motor in motors]
    bodies = np.array([value for name, value in values.items() if name.rpartition(".")[2] in INERTIAL])
    regressor = RegressorColumns(run.model, run.scene, run.measured, motors, run.slip_speed, bodies)
    guess = Guess(np.array([values.get(name, 0.0) for name in regressor.names]), first.sigma, Moments(regressor))
    return *run.gathered(regressor, guess), guess.moments


def repeated(
    run: Run, structure: Structure, theta: Floats, sigma: Floats
) -> tuple[Structure, Gathered, Gathered, Moments]:
    """Return the structure and what `weighted_rows` returns, linear near theta (p,): see `RegressorColumns.near`."""
    regressor = structure.regressor.near(theta[: len(structure.regressor.bodies)], structure.loads(theta))
    guess = Guess(structure.shape @ theta, sigma, Moments(regressor))
    return replace(structure, regressor=regressor), *run.gathered(regressor, guess), guess.moments


def curves_along(run: Run, structure: Structure, theta: Floats) -> Courses:
    """Return `curves_of` all logs, one after another, in one more pass: computed by the description, explained by theta
    (p,), friction of each joint's own motor; besides whether rows are `held` out, and every q_COORDINATE."""
    regressor, values, nq = structure.regressor, structure.shape @ theta, run.model.nq
    joints = [run.model.rates[j] for j in run.measured]
    owners = [(motor.name, column != "rotor") for motor in regressor.motors for column in motor.column_names]
    rubs = [("", False)] * len(regressor.bodies) + owners
    found = curves_of(joints, ("held", *(f"q_{name}" for name in run.model.coordinates)))

    def compute(samples: Samples) -> Floats:
        return np.concatenate((regressor.compute(samples), samples.q), axis=1)

    begin = 0.0
    for log, edges in zip(run.logs, run.edges, strict=True):
        for rows in filtered(log, run.cutoff, compute):
            curves = []
            parts = regressor.by_joint(rows.values[:, :-nq])
            for j, name, used, part in zip(run.measured, joints, regressor.used, parts, strict=True):
                own = [k for k, each in enumerate(used) if rubs[each] == (name, True)]
                known, described = part.T[-2:]
                friction = part[:, own] @ values[used[own]]
                curves.append(
                    (part[:, own[0]], rows.tau[:, j], described, part[:, :-2] @ values[used] + known, friction)
                )
            columns = [np.stack(each, axis=1) for each in zip(*curves, strict=True)]
            held = (rows.time >= edges[-1]).astype(float)
            add(found, rows.time - log.start + begin, columns, (held, *rows.values[:, -nq:].T))
        begin += log.stop - log.start
    return found


def check_size(model: Model) -> None:
    """Raise if a robot has so many joints that fits would take longer than minutes."""
    if model.n > _JOINTS:
        what = f"{model.name} has {model.n} joints, and identify fits at most {_JOINTS} together"
        raise InputError(f"{what}: time grows as their cube", remedy="describe and log its limbs one by one")


_SAMPLES, _ROWS, _VALUES = 1 << 17, 3000, 2_000_000
"""Samples that are read, and instants that are compared, of at most so many numbers."""
_MOST, _SHIFTS = 0.15, 60
"""s: delays are looked for up to here, and up to a tenth of a log; so many are compared in either direction."""
LATE = 0.6  # what a delay leaves of the squares at most
_BENDS = (0.003, 0.01, 0.03)
"""Of a joint's usual speed times 1 s: displacements over which dry friction may turn its sign, which looks late."""
_LEAN, _ALIKE, _LEANS, _SMALL = 1.0, 0.45, 2, 1e-3
"""Degrees that are told, if both halves of a log tell them alike but for a part; rounds; rad of differences."""
_INSTANTS, _WORST, _FEWEST, _WHOLE, _CLEAR = 400, 8, 100, 1e-6, 1.0 / 16.0
"""Instants and joints at which other readings of positions are tried; what of a torque that is left out an instant may
hold; and what the right reading leaves at most of the squares of the one at hand, as a product over the joints."""


class Raw:
    """Some instants of logs that are fitted, each until a time `stop` [s]; `late` (n,) is how late torques are [s]."""

    def __init__(self, logs: Sequence[Log], cutoff: float, regressor: RegressorColumns, stop: Sequence[float]) -> None:
        self.regressor, self.logs, self.cutoff = regressor, logs, cutoff
        self.whole = []
        for log, end in zip(logs, stop, strict=True):
            parts: list[Samples] = []
            for part in states(log, cutoff):
                parts.append(part.cut(slice(0, int(np.searchsorted(part.time, end))), part.begins))
                if part.time[-1] >= end or sum(len(each.time) for each in parts) > _SAMPLES:
                    break
            self.whole.append(reduce(joined, parts))
        count = min(_ROWS, _VALUES // sum(regressor.widths)) // len(logs)
        self.some = [slice(None, None, 1 + len(each.time) // max(count, 1)) for each in self.whole]
        few = reduce(joined, (each.cut(own, True) for each, own in zip(self.whole, self.some, strict=True)))
        self.few = few._replace(tau=np.zeros_like(few.tau))  # torques that are left out may be there some time later
        self.late = np.zeros(regressor.model.n)

    def delays(self) -> Floats:
        """Return (n,) the delay of each torque [s] that leaves least of it, fitted by all columns of its joint, free of
        other joints, and by dry friction that turns its sign over a displacement; 0 unless it is clear."""
        step = self.logs[0].step
        reach = min(_MOST, 0.1 * min(log.stop - log.start for log in self.logs))
        step *= max(1, round(reach / (_SHIFTS * step)))
        shifts = np.asarray(step * np.arange(-int(reach / step), int(reach / step) + 1), dtype=float)
        pairs = zip(self.whole, self.some, self.logs, strict=True)
        slow = np.concatenate([_presliding(whole, log.step)[own] for whole, own, log in pairs])
        parts = self.regressor.by_joint(self.regressor.compute(self.few))
        for j, columns in zip(self.regressor.measured, parts, strict=True):
            late = self._later(shifts, j)
            there = np.isfinite(late).all(axis=1)
            if there.sum() > 2 * columns.shape[1]:
                Q = range_basis(np.concatenate([columns[:, :-2], slow[:, j]], axis=1)[there])
                targets = late[there] - columns[there, -2:-1]
                rest = targets - Q @ (Q.T @ targets)
                left = einsum("ks,ks->s", rest, rest)
                k = int(np.argmin(left))
                if 0 < k < len(shifts) - 1 and left[k] <= LATE * left[len(left) // 2]:
                    before, least, after = left[k - 1 : k + 2]  # a parabola between the shifts
                    bend = before - 2.0 * least + after
                    place = 0.5 * (before - after) / bend if bend > 0.0 else 0.0
                    self.late[j] = float(f"{shifts[k] + place * (shifts[1] - shifts[0]):.3g}")
        return self.late

    def leaning(self, structure: Structure, theta: Floats, sigma: Floats, scene: Scene) -> list[str]:
        """Return in words how gravity leans, if both halves of the instants tell it alike. Two angles about axes across
        gravity are fitted with all parameters, to first order, and anew near the fit."""
        g = np.array(scene.gravity, dtype=float)
        if not g.any():
            return []
        across = np.linalg.svd(g[None])[2][1:] * np.linalg.norm(g)
        angles, halves = np.zeros(2), np.zeros((2, 2))
        for _ in range(_LEANS):
            here = g + angles @ across
            Y, z = self._weighted(structure, sigma, here)
            leans = [self._weighted(structure, sigma, here + _SMALL * way)[0] - Y for way in across]
            rows = np.column_stack((Y, *(each @ theta / _SMALL for each in leans), z))
            names, half = (*structure.names, "lean.first", "lean.second"), len(rows) // 2
            parts = rows[:half], rows[half:]
            halves = angles + [least_squares(*whole_system([part], names))[-2:] for part in parts]
            found = least_squares(*whole_system([rows], names))
            theta, angles = found[:-2], angles + found[-2:]
        size = float(np.linalg.norm(angles))
        differ = float(np.linalg.norm(halves - angles, axis=1).max())
        if not _LEAN < np.degrees(size) < 90.0 or differ > _ALIKE * size:
            return []
        way = g + angles @ across
        said = ",".join(f"{x:.3g}" for x in way * np.linalg.norm(g) / np.linalg.norm(way))
        what = f"torques fit gravity that leans by {np.degrees(np.arctan(size)):.2g} degrees"
        return [f"{what}: does the base stand tilted? then --gravity {said}"]

    def misread(self, structure: Structure, sigma: Floats) -> list[str]:
        """Return in words how positions are misread, if the torques tell: of the joints explained worst, each position
        with the other sign and every two exchanged, with and without torques, are fitted anew. The best counts if its
        squares, multiplied over the joints, are less than `_CLEAR` of those as they are."""
        model, measured = self.regressor.model, self.regressor.measured
        if model.nq != model.n:
            return []

        def motion(samples: Samples) -> Floats:
            lost = np.repeat(np.isnan(samples.tau).any(axis=1, keepdims=True), samples.q.shape[1], axis=1)
            return np.stack((samples.q, samples.qd, samples.qdd, lost), axis=1)

        logs = (replace(log, delays=self.late) for log in self.logs)
        parts = [part for log in logs for part in filtered(log, self.cutoff, motion)]
        time, motions, tau = (np.concatenate([getattr(part, name) for part in parts]) for name in parts[0]._fields)
        whole = np.flatnonzero(np.abs(motions[:, 3]).max(axis=1) < _WHOLE)  # around which no torque is left out
        some = whole[:: 1 + len(whole) // _INSTANTS]
        q, qd, qdd, _ = motions[some].swapaxes(0, 1)
        rows = Samples(time[some], q, qd, qdd, tau[some], True)
        if len(some) < _FEWEST:
            return []
        before = _left_by_joint(rows, structure, sigma)
        size = np.array([np.sum(rows.tau[:, j] ** 2) for j in measured]) / sigma**2
        worst = sorted(np.argsort(-before / np.maximum(size, 1e-300), kind="stable")[:_WORST].tolist())
        best, words = np.log(_CLEAR), []
        for order, sign, torques, said in _readings(model.rates, [measured[place] for place in worst]):
            q, qd, qdd = (each[:, order] * sign for each in (rows.q, rows.qd, rows.qdd))
            along = rows.tau[:, order] * sign if torques else rows.tau
            after = _left_by_joint(Samples(rows.time, q, qd, qdd, along, True), structure, sigma)
            ratio = float(np.log(after / before).sum())
            if ratio < best:
                best, words = ratio, [said]
        return words

    def _weighted(self, structure: Structure, sigma: Floats, gravity: Floats) -> tuple[Floats, Floats]:
        """Return columns of the parameters (k, p) and torques (k,) of all instants, joint by joint in each."""
        regressor, shape = structure.regressor.under(tuple(gravity.tolist())), structure.shape
        parts = regressor.by_joint(regressor.compute(self.few))
        Y, z = [], []
        for j, used, columns, scale in zip(regressor.measured, regressor.used, parts, sigma, strict=True):
            late = self._later(self.late[j : j + 1], j)
            there = np.isfinite(late)
            Y.append(np.where(there, columns[:, :-2] @ shape[used], 0.0) / scale)
            z.append(np.where(there, late - columns[:, -2:-1], 0.0)[:, 0] / scale)
        return np.stack(Y, axis=1).reshape(-1, len(structure.names)), np.stack(z, axis=1).ravel()

    def _later(self, shifts: Floats, j: int) -> Floats:
        """Return (k, shifts) the torque of a joint later than at the instants, NaN outside of the log."""
        found = []
        for each, own in zip(self.whole, self.some, strict=True):
            found.append(np.interp(each.time[own, None] + shifts, each.time, each.tau[:, j], np.nan, np.nan))
        return np.concatenate(found)


def _presliding(whole: Samples, step: float) -> Floats:
    """Return (k, n, `_BENDS`) the sign of dry friction that turns over a displacement s: dz/dq = (sign(qd) - z) / s."""
    size = np.sqrt(np.mean(whole.qd**2, axis=0))
    s = np.multiply.outer(np.where(size > 0.0, size, 1.0), _BENDS)
    stay = np.exp(-step * np.abs(whole.qd)[..., None] / s)
    z, found = np.zeros(s.shape), np.empty(stay.shape)
    for k, sign in enumerate(np.sign(whole.qd)[..., None]):
        z = sign + (z - sign) * stay[k]
        found[k] = z
    return found


def _readings(names: Sequence[str], joints: Sequence[int]) -> Iterator[tuple[list[int], Floats, bool, str]]:
    """Yield which rate's columns are read as each rate's, with which sign, whether torques go along, and the words."""
    as_is, ahead = list(range(len(names))), np.ones(len(names))
    for torques, what, has in ((False, "the measured position", "has"), (True, "position and torque", "have")):
        for j in joints:
            sign = np.where(np.arange(len(names)) == j, -1.0, 1.0)
            yield as_is, sign, torques, f"{what} of {names[j]} {has} the wrong sign"
        for i, j in combinations(joints, 2):
            order = as_is.copy()
            order[i], order[j] = j, i
            yield order, ahead, torques, f"{what if torques else what + 's'} of {names[i]} and {names[j]} are exchanged"


def _left_by_joint(rows: Samples, structure: Structure, sigma: Floats) -> Floats:
    """Return (joints,) the squares that least squares leave, not less than rounding."""
    regressor, shape = structure.regressor, structure.shape
    parts, pairs = regressor.by_joint(regressor.compute(rows)), []
    for j, used, columns, scale in zip(regressor.measured, regressor.used, parts, sigma, strict=True):
        pairs.append((product(columns[:, :-2], shape[used]) / scale, (rows.tau[:, j] - columns[:, -2]) / scale))
    R, z = whole_system([np.column_stack(pair) for pair in pairs], structure.names)
    theta = least_squares(R, z, structure.driving)
    return np.array([np.sum((product(Y, theta) - z) ** 2) + 1e-20 * np.sum(z * z) + 1e-300 for Y, z in pairs])
