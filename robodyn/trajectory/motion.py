"""The frozen data of a motion; stretches of it cut out, joined, and with their neighbours."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from robodyn.errors import Caveat
from robodyn.support.floats import Floats

NOISE = 2.0  # standard deviations of noise in an error bar
_ROWS = ("time", "q", "qd", "qdd")
FEW = 24  # rows of a table below which they are taken for way-points: what lies between them is anyone's guess


@dataclass(frozen=True)
class JointDerivation:
    """What was derived for one joint (or part of a floating joint) and how far it can be trusted.

    Args:
        velocity, acceleration: "given" or the method; source: "q" or "qd", which was differentiated.
        quantum: step of the grid on which the source lies (encoder step, rounded decimals), 0 if there is none.
        noise: standard deviation of the noise in the source, 0 if none was found.
        std: standard deviation that noise typically leaves in the highest derivative of it.
    """

    name: str
    velocity: str
    acceleration: str
    source: str
    quantum: float
    noise: float
    std: float


@dataclass(frozen=True)
class Derivation:
    """How missing velocities and accelerations were derived, joint by joint."""

    joints: tuple[JointDerivation, ...]


@dataclass(frozen=True)
class Sampling:
    """How far derived accelerations can be trusted.

    Args:
        off: (N, n) by how much each may be off in 19 of 20 cases; 0 where it is given.
        noise: (N, n) standard deviation of each that comes of noise.
        off_squares, squares: (n,) sums of the squares of `off`, where that is for want of samples, and of qdd.
        guessed: whether velocities are derived from so few rows that they may as well be 0.
        unknown: whether accelerations are given that nothing was compared with.
        other: (N, n) of qd and qdd by the positions, where these contradict what is given.
    """

    off: Floats
    noise: Floats
    off_squares: Floats
    squares: Floats
    guessed: bool = False
    unknown: bool = False
    other: tuple[Floats, Floats] | None = None


@dataclass(frozen=True)
class Trajectory:
    """Consecutive samples of a motion.

    Args:
        time: (N,) s, increasing.
        q: (N, nq) rad, m; of a floating joint position (parent axes) and unit quaternion x y z w.
        qd, qdd: (N, n); of a floating joint w, v and wd, a: w in body axes, v the rate of the position in parent axes.
        extra: (N,) columns that the scene named, and measured torques `tau_<joint>` [N m] where those were asked for.
        first_row: row of the data, from 1, of sample 0.
        derivation: how qd and qdd were derived; None if all was given.
        notes: assumptions that were made.
        stamps: (N,) the time as the table gives it; None if that is `time`.
        origin: what `time` counts from [s], in the table's count.
        held: position [rad or m] of each coordinate without a column that is held.
        followed: joints without columns, which loops tell; zero until they are filled in, see `loads.constraints`.
        caveats: what makes the table's units doubtful, by all samples up to the last of these.
        sampling: how far derived accelerations can be trusted; None if that is not known.
        slowest: (n,) speeds below which a joint cannot be told from one that stands still [rad/s, m/s]; speeds are 0
            where it does. None if that is not known.
    """

    time: Floats
    q: Floats
    qd: Floats
    qdd: Floats
    extra: Mapping[str, Floats] = field(default_factory=dict)
    first_row: int = 1
    derivation: Derivation | None = None
    notes: tuple[str, ...] = ()
    stamps: Floats | None = None
    origin: float = 0.0
    held: Mapping[str, float] = field(default_factory=dict)
    followed: tuple[str, ...] = ()
    caveats: tuple[Caveat, ...] = ()
    sampling: Sampling | None = None
    slowest: Floats | None = None

    def __len__(self) -> int:
        return len(self.time)

    @property
    def given_time(self) -> Floats:
        """(N,) the time as the table gives it."""
        return self.time if self.stamps is None else self.stamps


def join(parts: list[Trajectory]) -> Trajectory:
    """Consecutive samples as one trajectory."""
    if len(parts) == 1:
        return parts[0]
    known = [part.sampling for part in parts if part.sampling is not None]
    sampling = None
    if len(known) == len(parts):
        others = [each.other for each in known if each.other is not None]
        sampling = Sampling(
            off=np.concatenate([each.off for each in known]),
            noise=np.concatenate([each.noise for each in known]),
            off_squares=np.sum([each.off_squares for each in known], axis=0),
            squares=np.sum([each.squares for each in known], axis=0),
            guessed=any(each.guessed for each in known),
            unknown=any(each.unknown for each in known),
            other=(np.concatenate([qd for qd, _ in others]), np.concatenate([qdd for _, qdd in others]))
            if len(others) == len(known)
            else None,
        )
    columns: dict[str, Any] = {name: np.concatenate([getattr(part, name) for part in parts]) for name in _ROWS}
    return replace(
        parts[-1],
        **columns,
        extra={name: np.concatenate([part.extra[name] for part in parts]) for name in parts[0].extra},
        first_row=parts[0].first_row,
        notes=tuple(dict.fromkeys(note for part in parts for note in part.notes)),
        stamps=None if parts[0].stamps is None else np.concatenate([part.given_time for part in parts]),
        sampling=sampling,
    )


def cut(samples: Trajectory, start: int, stop: int) -> Trajectory:
    rows = slice(start, stop)
    columns: dict[str, Any] = {name: getattr(samples, name)[rows] for name in _ROWS}
    return replace(
        samples,
        **columns,
        extra={name: values[rows] for name, values in samples.extra.items()},
        first_row=samples.first_row + start,
        stamps=None if samples.stamps is None else samples.stamps[rows],
        sampling=None,
    )


def with_neighbours(parts: Iterator[Trajectory], halo: int) -> Iterator[tuple[Trajectory, int, int]]:
    """Each part with up to `halo` samples before and after it, and where the part begins and ends in that."""
    before: list[Trajectory] = []
    waiting: list[Trajectory] = []

    def emit() -> tuple[Trajectory, int, int]:
        nonlocal before
        part = waiting.pop(0)
        past = join([*before, part])
        start = len(past) - len(part)
        before = [cut(past, max(0, len(past) - halo), len(past))] if halo else []
        if not waiting or not halo:
            return past, start, len(past)
        future = join(waiting)
        return join([past, cut(future, 0, min(halo, len(future)))]), start, len(past)

    for part in parts:
        waiting.append(part)
        while waiting and sum(map(len, waiting[1:])) >= halo:
            yield emit()
    while waiting:
        yield emit()
