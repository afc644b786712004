"""Write the trajectories of robots/ that joints or feet lead: `python tests/make_robots.py [FOLDER]`, by default into
robots/ itself.

Everything is computed to 30 digits and rounded once, so the files come out the same, bit for bit, on every machine.
satellite_slew.csv and rigid_body_flip.csv are solutions of the equations of motion, to rounding:
tests/robots/test_robots_free_motion.py holds them to the conservation laws and to elliptic functions.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from functools import cache, partial
from pathlib import Path

from helpers import quadruped_motion
from helpers.jets import Jet
from helpers.parallel_motions import delta_motors, planar_motors
from helpers.quadruped_motion import Gait
from helpers.robot_motions import Motion, fourier, quintic
from mpmath import mp, mpf

ENCODER_STEPS = 2**17
ZERO = 1e-20
Table = dict[str, list[mpf]]


def times(count: int, rate: int) -> list[mpf]:
    return [mpf(k) / rate for k in range(count)]


def joints(clock: list[mpf], motions: Mapping[str, Motion]) -> Table:
    """time, then q_, qd_ and qdd_ of every joint."""
    table = {"time": clock}
    for level, name in enumerate(("q", "qd", "qdd")):
        for joint, motion in motions.items():
            table[f"{name}_{joint}"] = [motion(t)[level] for t in clock]
    return table


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


def crank_slider_turn() -> Table:
    """Two turns of the crank in 2 s, from rest to rest."""
    return joints(times(401, 200), {"main": quintic((0, 0), (2, 12.566370614359172))})


def four_bar_lift() -> Table:
    """From upright over to the right, rest, and to the left, within 60 degrees of upright."""
    return joints(
        times(301, 100),
        {"left": quintic((0, 0), (0.9, 1), (1.2, 1), (2.4, -0.9), (2.5, -0.9), (2.9, -0.6))},
    )


def five_bar_reach() -> Table:
    """In between the motors, out to the right and home, with stops."""
    return joints(
        times(301, 200),
        {
            "left": quintic((0, 0), (0.3, 0.5), (0.5, 0.5), (0.9, -0.3), (1.1, -0.3), (1.4, 0)),
            "right": quintic((0, 0), (0.35, 0.3), (0.5, 0.3), (0.95, -0.5), (1.1, -0.5), (1.4, 0)),
        },
    )


def delta_pick() -> Table:
    """Down, hold, up and across, down, hold, up and home, in 1.2 s."""
    x = quintic((0, 0), (0.25, 0.11), (0.5, 0.11), (0.8, -0.1), (1, -0.1), (1.2, 0))
    y = quintic((0, 0), (0.25, -0.04), (0.5, -0.04), (0.8, 0.07), (1, 0.07), (1.2, 0))
    z = quintic(
        *((0, -0.4), (0.2, -0.44), (0.3, -0.44), (0.45, -0.39), (0.7, -0.39)),
        *((0.85, -0.44), (0.95, -0.44), (1.15, -0.4)),
    )

    @cache
    def motors(t: mpf) -> list[Jet]:
        return delta_motors((Jet(*x(t)), Jet(*y(t)), Jet(*z(t))))

    return joints(times(301, 250), {f"motor_{k + 1}": _one(motors, k) for k in range(3)})


def planar_3rrr_circle() -> Table:
    """The platform goes round in 1 s, and turns to and fro."""
    x, y = fourier(0, 1, (0.05, 0)), fourier(0.01, 1, (0, 0.05))
    turn = fourier(0, 1, (0.15, 0), (0, 0.1))

    @cache
    def motors(t: mpf) -> list[Jet]:
        return planar_motors((Jet(*x(t)), Jet(*y(t))), Jet(*turn(t)))

    return joints(times(251, 250), {f"motor_{k + 1}": _one(motors, k) for k in range(3)})


def _one(motors: Callable[[mpf], list[Jet]], k: int) -> Motion:
    def motion(t: mpf) -> tuple[mpf, mpf, mpf]:
        q = motors(t)[k]
        return q.x, q.v, q.a

    return motion


def _walked(gait: Gait, rate: int) -> Table:
    """201 rows."""
    found = [gait(Jet(t, mpf(1))) for t in times(201, rate)]
    return {"time": times(201, rate)} | {name: [mpf(row[name]) for row in found] for name in found[0]}


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
        crank_slider_turn,
        four_bar_lift,
        five_bar_reach,
        delta_pick,
        planar_3rrr_circle,
    )
} | {
    f"quadruped_{gait.__name__}.csv": partial(_walked, gait, rate)
    for gait, rate in ((quadruped_motion.stand, 100), (quadruped_motion.crouch, 100), (quadruped_motion.trot, 200))
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
