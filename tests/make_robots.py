"""Write every trajectory of robots/: `python tests/make_robots.py [FOLDER]`, by default into robots/ itself.

Everything is computed to 30 digits and rounded once, so the files come out the same, bit for bit, on every machine.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

from helpers import constrained_tables
from helpers.free_motions import attitudes, tumble
from helpers.robot_motions import Motion, State, exact, fourier, quintic
from helpers.robot_tables import Table, base, joints, times
from helpers.satellite_motion import Satellite
from mpmath import mp, mpf

ENCODER_STEPS = 2**17
ZERO = 1e-20


def scara_pick_and_place() -> Table:
    """Down, hold, up, across, down, hold, up, in one second."""
    return joints(
        times(1000, 1000),
        {
            "shoulder": quintic((0, 0.45), (0.28, 0.45), (0.68, -0.45)),
            "elbow": quintic((0, 0.7), (0.3, 0.7), (0.66, -0.8)),
            "quill": quintic(
                (0, 0.02),
                (0.04, 0.02),
                (0.17, 0.12),
                (0.22, 0.12),
                (0.35, 0.02),
                (0.6, 0.02),
                (0.73, 0.14),
                (0.78, 0.14),
                (0.92, 0.02),
            ),
        },
    )


def puma_reach() -> Table:
    """Out from rest to the side, dwell, and back by another way."""
    return joints(
        times(401, 100),
        {
            "waist": quintic((0, 0), (1.5, 1.2), (2, 1.2), (3.6, -0.3)),
            "shoulder": quintic((0, -0.6), (1.3, 0.4), (2.1, 0.4), (3.7, -0.6)),
            "elbow": quintic((0, 0.5), (1.4, -0.9), (2, -0.9), (3.5, 0.5)),
        },
    )


def _puma_waves() -> dict[str, Motion]:
    return {
        "waist": fourier(0.2, 2, (0.25, 0), (0, 0.1), (0.05, 0)),
        "shoulder": fourier(-0.3, 2, (0, 0.2), (0.1, 0), (0, 0.03)),
        "elbow": fourier(-0.4, 2, (0.3, 0.1), (0, -0.12), (0.04, 0)),
    }


def puma_waves() -> Table:
    """Positions only, in the bare column names of a log: clean numbers, so derivatives can be had from a spline."""
    clock = times(401, 200)
    return {"t": clock} | {joint: [motion(t)[0] for t in clock] for joint, motion in _puma_waves().items()}


def puma_encoder() -> Table:
    """The motion of `puma_waves` as a 17-bit encoder sees it at 1 kHz: whole steps of 2 pi / 2^17."""
    clock, step = times(1000, 1000), 2 * mp.pi / ENCODER_STEPS
    return {"t": clock} | {
        joint: [step * mp.nint(motion(t)[0] / step) for t in clock] for joint, motion in _puma_waves().items()
    }


def puma_polish() -> Table:
    """A stroke to and fro, with the contact force and friction moment that puma_polish.toml puts on the tool."""
    table = joints(
        times(301, 100),
        {
            "waist": fourier(0.1, 3, (0.3, 0)),
            "shoulder": fourier(0.25, 3, (0, 0.08), (0.05, 0)),
            "elbow": fourier(-0.5, 3, (0, -0.1), (-0.06, 0)),
        },
    )
    press = quintic((0, 0), (0.4, -40), (2.6, -40), (3, 0))
    drag = fourier(0, 3, (0, -12))
    return table | {
        "press": [press(t)[0] for t in table["time"]],
        "drag": [drag(t)[0] for t in table["time"]],
        "twist": [drag(t)[0] / 20 for t in table["time"]],
    }


def puma560_sweep() -> Table:
    """A periodic motion of all six joints, as an identification of parameters would use it."""
    return joints(
        times(401, 100),
        {
            "waist": fourier(0.1, 4, (0.45, 0), (0, 0.15), (0.05, 0.05)),
            "shoulder": fourier(0.7, 4, (0, 0.4), (0.15, 0), (0, 0.05)),
            "elbow": fourier(-1.2, 4, (0.4, 0.2), (0, -0.2), (0.1, 0)),
            "wrist_roll": fourier(0.4, 4, (0.6, 0), (0.3, 0.2), (0, 0.1)),
            "wrist_pitch": fourier(0.1, 4, (0, 0.7), (0.3, 0), (0.1, 0.1)),
            "flange_roll": fourier(0, 4, (1, 0), (0, 0.4), (0.2, 0)),
        },
    )


def cylindrical_transfer() -> Table:
    """Lift, swing while the boom extends, lower the gripper, dwell."""
    return joints(
        times(401, 100),
        {
            "swing": quintic((0, -1), (0.5, -1), (2.4, 1.3)),
            "lift": quintic((0, -0.2), (0.9, 0.25), (2.2, 0.25), (3.2, -0.1)),
            "reach": quintic((0, 0.05), (0.8, 0.05), (2.6, 0.35), (3, 0.35), (3.8, 0.2)),
            "plunge": quintic((0, 0), (0.4, 0.05), (2.5, 0.05), (3.4, 0.22)),
        },
    )


def two_link_planar_swing() -> Table:
    return joints(
        times(301, 100),
        {
            "shoulder": fourier(-0.9, 3, (0.5, 0), (0, 0.2)),
            "elbow": fourier(0.6, 3, (0, 0.7), (-0.3, 0)),
        },
    )


def two_link_spatial_slew() -> Table:
    return joints(
        times(301, 100),
        {
            "azimuth": quintic((0, -1.2), (1.6, 1.4), (2, 1.4), (2.9, 0.4)),
            "elevation": quintic((0, -0.3), (1.2, 1), (1.7, 1), (2.8, 0.1)),
        },
    )


def gripper_pick() -> Table:
    """Lower, close, lift and turn by one and a half turns, open. The jaw that follows by mimicry has no column."""
    return joints(
        times(401, 100),
        {
            "lift": quintic((0, 0.3), (0.2, 0.3), (1.1, 0.02), (1.6, 0.02), (2.6, 0.25)),
            "wrist": quintic((0, -0.5), (0.9, 0.8), (1.8, 0.8), (3.7, 10.2)),
            "jaw": quintic((0, 0.03), (1.1, 0.03), (1.5, 0.008), (3.7, 0.008), (3.95, 0.03)),
        },
    )


def satellite_slew() -> Table:
    """The arrays turn from rest to rest, by different angles; the bus answers so that no momentum arises."""
    arrays = {
        "left_array": quintic((0, 0), (1, 0), (13, 2.8), (15, 2.8), (19, 2.2)),
        "right_array": quintic((0, 0.4), (3, 0.4), (17, 2.9)),
    }
    bus = [exact(6.8, -0.5, 0.4), exact(-0.5, 5, -0.3), exact(0.4, -0.3, 8.2)]
    satellite = Satellite(mpf(60), exact(0.05, -0.02, 0.1), bus, mpf(20), exact(8, 0.5, 8.4), arm=mpf("1.5"))
    clock = times(401, 20)

    def motion(t: mpf) -> list[State]:
        return [array(t) for array in arrays.values()]

    turning = attitudes(lambda t: satellite.rates(motion(t))[0], clock)
    states = [satellite.state(attitude, motion(t)) for attitude, t in zip(turning, clock, strict=True)]
    return joints(clock, arrays) | base(states)


def rigid_body_flip() -> Table:
    """The Dzhanibekov flip: turned about the middle axis, a little disturbed, over one period of 55.06 s."""
    clock = times(443, 8)
    return {"time": clock} | base(tumble(exact(1, 2, 3), exact(0.001, 1, 0.001), clock[1], len(clock)))


TRAJECTORIES: dict[str, Callable[[], Table]] = {
    f"{make.__name__}.csv": make
    for make in (
        scara_pick_and_place,
        puma_reach,
        puma_waves,
        puma_encoder,
        puma_polish,
        puma560_sweep,
        cylindrical_transfer,
        two_link_planar_swing,
        two_link_spatial_slew,
        gripper_pick,
        satellite_slew,
        rigid_body_flip,
        *constrained_tables.EVERY,
    )
}


def text(make: Callable[[], Table]) -> str:
    """The table as CSV, every number the shortest that reads back as the same double."""
    with mp.workdps(30):
        table = make()
        rows = [[_cell(value) for value in row] for row in zip(*table.values(), strict=True)]
    return "\n".join(",".join(row) for row in [list(table), *rows]) + "\n"


def _cell(value: mpf) -> str:
    """A zero that cancellation left at 1e-30 is written as zero: the sign of a speed decides Coulomb friction."""
    return repr(float(value)) if abs(value) > ZERO else "0.0"


def main(folder: Path) -> None:
    for name, make in TRAJECTORIES.items():
        (folder / name).write_text(text(make), encoding="ascii", newline="\n")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent.parent / "robots")
