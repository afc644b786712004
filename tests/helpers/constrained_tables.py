"""Trajectories of closed chains, by their motors alone, and of the quadruped on its feet."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

from mpmath import mpf

from helpers import quadruped_motion
from helpers.jets import Jet
from helpers.parallel_motions import delta_motors, planar_motors
from helpers.quadruped_motion import Gait
from helpers.robot_motions import Motion, fourier, quintic
from helpers.robot_tables import Table, joints, times


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


def quadruped_stand() -> Table:
    return _walked(quadruped_motion.stand, 100)


def quadruped_crouch() -> Table:
    return _walked(quadruped_motion.crouch, 100)


def quadruped_trot() -> Table:
    """Four steps."""
    return _walked(quadruped_motion.trot, 200)


def _walked(gait: Gait, rate: int) -> Table:
    """201 rows."""
    found = [gait(Jet(t, mpf(1))) for t in times(201, rate)]
    return {"time": times(201, rate)} | {name: [mpf(row[name]) for row in found] for name in found[0]}


EVERY: tuple[Callable[[], Table], ...] = (
    crank_slider_turn,
    four_bar_lift,
    five_bar_reach,
    delta_pick,
    planar_3rrr_circle,
    quadruped_stand,
    quadruped_crouch,
    quadruped_trot,
)
