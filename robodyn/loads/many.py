"""What becomes of many trajectories: frozen data that reports turn into text and JSON."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from robodyn.errors import Caveat
from robodyn.robot.limits import Coverage, within
from robodyn.support.floats import ranked

Status = Literal["computed", "finished before", "failed"]
_LEVELS = (None, "no limits", "OK", "over continuous", "over temperature", "over peak")


@dataclass(frozen=True)
class JointPeak:
    """What one joint carries along one motion, as `robodyn.loads.result.JointLoad` has it; level: the verdict of
    `robodyn.loads.result.JointSizing`; None where nothing was sized."""

    name: str
    unit: str
    peak: float
    peak_time: float
    peak_row: int
    rms: float
    max_speed: float
    effort_limit: float | None
    velocity_limit: float | None
    level: str | None


@dataclass(frozen=True)
class Outcome:
    """The result of one trajectory of a batch.

    Attributes:
        trajectory: its name as it was given.
        table, document: the files of its torques and of its report, empty if it failed.
        samples, duration: of the motion [s].
        exceeded: joints and what of them is beyond a limit, such as "elbow velocity"; see `loads.result.Result`.
        limits, caveats: what was checked, and what else is not sure, as `loads.result.Result` has it.
        joints: empty if it failed.
        error: one line that says why it failed, else empty.
    """

    trajectory: str
    status: Status
    table: str = ""
    document: str = ""
    samples: int = 0
    duration: float = 0.0
    exceeded: tuple[str, ...] = ()
    limits: tuple[Coverage, ...] = ()
    caveats: tuple[Caveat, ...] = field(default=(), metadata={"json": "doubts"})
    joints: tuple[JointPeak, ...] = ()
    error: str = ""

    @property
    def within_limits(self) -> bool | None:
        """Return whether the motion exceeds no limit; None if that cannot be said, as for a motion that failed."""
        return None if self.status == "failed" else within(bool(self.exceeded), self.limits, self.caveats)


@dataclass(frozen=True)
class Worst(JointPeak):
    """The worst of one joint over all trajectories, each with the trajectory it is from; magnitudes of `max_speed`."""

    peak_in: str
    rms_in: str
    max_speed_in: str
    level_in: str


@dataclass(frozen=True)
class Batch:
    """Many trajectories of one robot, in their order."""

    robot: str
    outcomes: tuple[Outcome, ...]

    def count(self, status: Status) -> int:
        return sum(outcome.status == status for outcome in self.outcomes)

    @property
    def within_limits(self) -> bool | None:
        """Return False if a motion exceeds a limit; None if it cannot be said of one that it does not; else True."""
        found = {outcome.within_limits for outcome in self.outcomes}
        return False if False in found else None if None in found else True

    @property
    def worst(self) -> tuple[Worst, ...]:
        """For every joint the worst over all trajectories; of equal ones the first counts."""
        done, every = [outcome for outcome in self.outcomes if outcome.joints], []
        for joints in zip(*(outcome.joints for outcome in done), strict=True):
            found = list(zip((outcome.trajectory for outcome in done), joints, strict=True))
            peak_in, peak = ranked(found, key=lambda pair: abs(pair[1].peak))[0]
            rms_in, rms = ranked(found, key=lambda pair: pair[1].rms)[0]
            speed_in, speed = ranked(found, key=lambda pair: abs(pair[1].max_speed))[0]
            level_in, level = max(found, key=lambda pair: _LEVELS.index(pair[1].level))
            worst = vars(peak) | {"rms": rms.rms, "max_speed": abs(speed.max_speed), "level": level.level}
            every.append(Worst(**worst, peak_in=peak_in, rms_in=rms_in, max_speed_in=speed_in, level_in=level_in))
        return tuple(every)
