"""Which limits a motion exceeds, and how near it comes to others, in plain words."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from robodyn.report.document import Verdict
from robodyn.report.table import number, printable
from robodyn.result import JointLoad, Result

_LINES = 15
"""So many limits are named at the top of a page."""


def limits_verdict(result: Result) -> Verdict:
    """Whether the motion keeps to the limits of the description."""
    joints = result.joints
    over = [joint for joint in joints if joint.exceeded]
    if over:
        count = f"{len(over)} of {len(joints)} joints" if len(joints) > 1 else "The joint"
        verb = "exceeds its limits" if len(over) == 1 else "exceed their limits"
        lines = [line for joint in over for line in exceeded_words(joint)]
        return Verdict("bad", f"{count} {verb}", _shortened(lines))
    if not any(joint.effort_limit is not None or joint.velocity_limit is not None for joint in joints):
        what = "There are no limits of effort and speed to hold this motion against"
        return Verdict("neutral", what, _unlimited(joints))
    of = "" if result.within_limits else " of the description"
    return Verdict("good", f"No limit{of} is exceeded", (*_nearest(joints), *_unlimited(joints)))


def _shortened(lines: list[str]) -> tuple[str, ...]:
    """The first of many lines; the tables have all."""
    if len(lines) <= _LINES + 1:
        return tuple(lines)
    return (*lines[:_LINES], f"{len(lines) - _LINES} more limits are exceeded: see the table of the joints.")


def exceeded_words(joint: JointLoad) -> Iterator[str]:
    """A sentence for each limit that a joint exceeds."""
    name, what = printable(joint.name), "force" if joint.unit == "N" else "torque"
    speed, place = ("m/s", "m") if joint.unit == "N" else ("rad/s", "rad")
    for excess in joint.exceeded:
        if excess.quantity == "position":
            side = "below its lower" if excess.limit == joint.lower else "above its upper"
            yield f"{name} goes to {excess.value:.6g} {place}, {side} limit of {excess.limit:.6g} {place}."
        elif excess.quantity == "effort":
            yield (
                f"{name} needs a {what} of {number(excess.value)} {joint.unit} at {joint.peak_time:.6g} s, "
                f"{_percent(excess.value, excess.limit)} its limit of {excess.limit:g} {joint.unit}; "
                f"it is beyond the limit for {joint.seconds_over_effort:.3g} s."
            )
        else:
            yield (
                f"{name} moves at {number(excess.value)} {speed}, {_percent(excess.value, excess.limit)} its limit of "
                f"{excess.limit:g} {speed}; it is beyond the limit for {joint.seconds_over_velocity:.3g} s."
            )


def worst_joint(result: Result) -> int | None:
    """The joint that uses most of its effort limit; the one with the largest peak where there are none."""
    joints = result.joints
    if not joints:
        return None
    limited = [k for k, joint in enumerate(joints) if joint.effort_limit]
    return max(limited or range(len(joints)), key=lambda k: effort_use(joints[k]) if limited else abs(joints[k].peak))


def effort_use(joint: JointLoad) -> float:
    """|peak| / limit; 0 without a limit."""
    return abs(joint.peak) / joint.effort_limit if joint.effort_limit else 0.0


def speed_use(joint: JointLoad) -> float:
    """|speed| / limit; 0 without a limit."""
    return abs(joint.max_speed) / joint.velocity_limit if joint.velocity_limit else 0.0


def _percent(value: float, limit: float) -> str:
    return f"{100 * value / limit:.0f} % of" if limit > 0 else "beyond"


def _nearest(joints: Sequence[JointLoad]) -> Iterator[str]:
    for use, what in ((effort_use, "effort"), (speed_use, "speed")):
        joint = max(joints, key=use)
        if use(joint):
            yield f"Nearest to its limit of {what} is {printable(joint.name)}, at {100 * use(joint):.0f} % of it."


def _unlimited(joints: Sequence[JointLoad]) -> tuple[str, ...]:
    free = [printable(joint.name) for joint in joints if joint.effort_limit is None]
    if not free:
        return ()
    some = ", ".join(free[:4]) + (f" and {len(free) - 4} more" if len(free) > 4 else "")
    return (f"Without a limit of effort in the description: {some}.",)
