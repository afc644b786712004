"""The frozen data of a motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from robodyn.doubts import Doubt
from robodyn.trajectory.table import FloatArray

INNER, END = 4.0, 10.0
"""Bars in standard deviations of the noise: in the middle of the data, and where neighbours are on one side only."""


@dataclass(frozen=True)
class JointDerivation:
    """What was derived for one joint (or part of a floating joint) and how far it can be trusted.

    Args:
        name: the joint; velocity, acceleration: "given" or the method.
        source: "q" or "qd", the column that was differentiated.
        quantum: step of the grid on which the source lies (encoder step, rounded decimals), 0 if there is none.
        noise: standard deviation of the noise in the source, 0 if none was found.
        gain_velocity, gain_acceleration: standard deviation of the result per standard deviation of the source
            [1/s, 1/s^2]; 0 where the quantity was given.
        end_gains: `gain_acceleration` of the samples nearest to an end of the table, outermost first, where the method
            sees neighbours on one side only.
    """

    name: str
    velocity: str
    acceleration: str
    source: str
    quantum: float
    noise: float
    gain_velocity: float
    gain_acceleration: float
    end_gains: tuple[float, ...] = field(default=(), repr=False)

    @property
    def std_velocity(self) -> float:
        """Implied standard deviation of qd, `noise * gain_velocity`."""
        return self.noise * self.gain_velocity

    @property
    def std_acceleration(self) -> float:
        """Implied standard deviation of qdd, `noise * gain_acceleration`."""
        return self.noise * self.gain_acceleration

    def std_acceleration_near(self, from_end: int) -> float:
        """Implied standard deviation of qdd at the sample that has `from_end` samples between it and an end."""
        gain = self.end_gains[from_end] if from_end < len(self.end_gains) else self.gain_acceleration
        return self.noise * gain

    def bar_acceleration_near(self, from_end: int) -> float:
        """What qdd is off by in 19 of 20 cases: 4 standard deviations of the noise, 10 where an end is near.

        A window is as wide as makes what smoothing takes away no larger than the noise that it leaves, and both add up;
        near an end a polynomial smooths less well. The factors are those of random motions (`test_bars_cover`).
        """
        return (END if from_end < len(self.end_gains) else INNER) * self.std_acceleration_near(from_end)


@dataclass(frozen=True)
class Derivation:
    """How missing velocities and accelerations were derived, joint by joint."""

    joints: tuple[JointDerivation, ...]

    @property
    def velocity(self) -> str:
        """The method, or the methods with the joints that each served."""
        return _summary([(joint.velocity, joint.name) for joint in self.joints])

    @property
    def acceleration(self) -> str:
        """The method, or the methods with the joints that each served."""
        return _summary([(joint.acceleration, joint.name) for joint in self.joints])


@dataclass(frozen=True)
class Sampling:
    """What the number of samples leaves open about derived accelerations.

    Args:
        off: (N, n) by how much each may be off; 0 where it is given, NaN where that was not looked at.
        off_squares, squares: (n,) sums of the squares of `off` and of qdd where that was looked at.
        guessed: whether velocities are derived from so few rows that they may as well be 0.
    """

    off: FloatArray
    off_squares: FloatArray
    squares: FloatArray
    guessed: bool = False


@dataclass(frozen=True)
class Trajectory:
    """Consecutive samples of a motion.

    Args:
        time: (N,) s, increasing.
        q: (N, nq) rad, m; of a floating joint position (parent axes) and unit quaternion x y z w.
        qd, qdd: (N, n); of a floating joint w, v and wd, a: w in body axes, v the rate of the position in parent axes.
        extra: (N,) columns that the scene named.
        first_row: row of the data, from 1, of sample 0.
        derivation: how qd and qdd were derived; None if all was given.
        notes: assumptions that were made.
        stamps: (N,) the time as the table gives it; None if that is `time`.
        origin: what `time` counts from [s], in the table's count.
        held: position [rad or m] of each coordinate without a column that is held.
        doubts: what makes the table's units doubtful, by all samples up to the last of these.
        sampling: how far the derived accelerations of these samples can be trusted; None if that is not known.
    """

    time: FloatArray
    q: FloatArray
    qd: FloatArray
    qdd: FloatArray
    extra: Mapping[str, FloatArray] = field(default_factory=dict)
    first_row: int = 1
    derivation: Derivation | None = None
    notes: tuple[str, ...] = ()
    stamps: FloatArray | None = None
    origin: float = 0.0
    held: Mapping[str, float] = field(default_factory=dict)
    doubts: tuple[Doubt, ...] = ()
    sampling: Sampling | None = None

    def __len__(self) -> int:
        return len(self.time)

    @property
    def given_time(self) -> FloatArray:
        """(N,) the time as the table gives it."""
        return self.time if self.stamps is None else self.stamps


def _summary(methods: list[tuple[str, str]]) -> str:
    joints: dict[str, list[str]] = {}
    for method, name in methods:
        joints.setdefault(method, []).append(name)
    if len(joints) == 1:
        return methods[0][0]
    return "; ".join(f"{method} ({', '.join(names)})" for method, names in joints.items())
