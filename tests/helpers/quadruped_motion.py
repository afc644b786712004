"""Motions of robots/quadruped.urdf on its feet, in closed form: for mpmath's numbers and for arrays of times.

Where the trunk and the feet are is given; the legs follow. Positions, rates and accelerations are exact.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

import numpy as np

from helpers.jets import Jet, Number, Triple, acos, atan2, cos, jet, library, like, pi, rotated, sin, sqrt
from helpers.robot_motions import Motion, quintic

LEGS = {"lf": (1, 1), "rf": (1, -1), "lh": (-1, 1), "rh": (-1, -1)}
HIP, SIDE, FEET, BONE = (0.19, 0.05), 0.06, (0.19, 0.11), 0.18
"""Place of the front left abduction; from there to the thigh, along y; place of the foot that stands; thigh and shank
[m]."""
STANDING = 0.28
"""Height of the trunk that stands [m]."""
PERIOD, DUTY, HEIGHT, BOUNCE, LIFT = 0.5, 0.625, 0.27, 0.006, 0.05
"""Of the trot: time of two steps [s], part of it for which a foot stands; the trunk's mean height, its rise and fall,
and how high feet are lifted [m]."""
TURN, SWAY = 0.4, 0.02
"""Of the trot: mean rate of turning [rad/s], and how far the trunk turns to and fro beside it [rad]."""
Row = dict[str, Number]
Gait = Callable[[Jet], Row]


def stand(t: Jet) -> Row:
    """Stands, leans to the left with a little roll, and comes back, in 2 s."""
    lean = _moved(quintic((0, 0), (0.4, 0), (0.9, 0.03), (1.2, 0.03), (1.8, 0)), t)
    return row((jet(0), lean, jet(like(t.x, STANDING))), (lean * -2, jet(0), jet(0)), _planted(t))


def crouch(t: Jet) -> Row:
    """Sinks by 90 mm while it nods, stays there, and rises, in 2 s."""
    down = _moved(quintic((0, 0), (0.2, 0), (0.8, 0.09), (1.1, 0.09), (1.8, 0)), t)
    return row((down / 5, jet(0), like(t.x, STANDING) - down), (jet(0), down * 3 / 2, jet(0)), _planted(t))


def trot(t: Jet) -> Row:
    """Trots on the spot in steps of PERIOD / 2 and turns to the left; on_<leg> is 1 where a foot stands.

    Turned by 180 degrees about the vertical the motion is itself. Each foot stands still for DUTY of a period, then
    goes to where the trunk's mean turn will have it, at rest with no acceleration where it leaves and lands.
    """
    turns, turning = t / PERIOD, like(t.x, TURN)
    wave = 2 * pi(t.x) * turns
    yaw = turning * t + like(t.x, SWAY) * sin(wave)
    up = like(t.x, HEIGHT) - like(t.x, BOUNCE) * cos(2 * wave - 2 * pi(t.x) * DUTY)
    feet, stands = {}, {}
    for leg, (front, left) in LEGS.items():
        steps = turns if front == left else turns + 0.5
        begun = library(t.x).floor(steps.x)
        gone = (steps - begun - DUTY) / (1 - DUTY)
        lifted = gone.x > 0
        s = Jet(gone.x * lifted, gone.v, gone.a)
        rise = s * s * s * (10 + s * (6 * s - 15))
        bump = s * (1 - s)
        angle = turning * PERIOD * (rise + (begun + DUTY / 2 - (0 if front == left else 0.5)))
        feet[leg] = (*rotated(angle, _below(front, left, t)), like(t.x, LIFT) * 64 * bump * bump * bump)
        stands[f"on_{leg}"] = 1 - lifted * (t.x * 0 + 1)
    return row((jet(0), jet(0), up), (jet(0), jet(0), yaw), feet) | stands


def columns(gait: Gait, count: int, duration: float) -> dict[str, np.ndarray]:
    """Return (count,) columns at equally spaced times; of `trot`, whose path has no branches."""
    time = np.linspace(0, duration, count)
    found = {"time": time} | gait(Jet(time, np.ones(count)))
    return {name: np.array(np.broadcast_to(np.asarray(x, dtype=float), count)) for name, x in found.items()}


def row(trunk: Triple, turn: Triple, feet: Mapping[str, Triple]) -> Row:
    """Return the columns of the joints, level by level, and of the base.

    Args:
        trunk: its place [m].
        turn: its roll, pitch and yaw, `R = R_z(yaw) R_y(pitch) R_x(roll)` [rad].
        feet: their places [m].
    """
    legs = {f"{leg}_{joint}": q for leg in LEGS for joint, q in _leg(leg, _seen(feet[leg], trunk, turn))}
    found = {f"q_{name}": q.x for name, q in legs.items()}
    found |= {f"qd_{name}": q.v for name, q in legs.items()}
    found |= {f"qdd_{name}": q.a for name, q in legs.items()}
    return found | {f"base_{name}": value for name, value in _base(trunk, turn)}


def _moved(motion: Motion, t: Jet) -> Jet:
    return Jet(*motion(t.x))


def _below(front: int, left: int, t: Jet) -> tuple[Number, Number]:
    x, y = (like(t.x, value) for value in FEET)
    return front * x, left * y


def _planted(t: Jet) -> dict[str, Triple]:
    return {leg: (*(jet(x) for x in _below(*place, t)), jet(0)) for leg, place in LEGS.items()}


def _seen(point: Triple, trunk: Triple, turn: Triple) -> Triple:
    """Return R' (point - trunk)."""
    roll, pitch, yaw = turn
    x, y, z = (a - b for a, b in zip(point, trunk, strict=True))
    x, y = rotated(-yaw, (x, y))
    z, x = rotated(-pitch, (z, x))
    y, z = rotated(-roll, (y, z))
    return x, y, z


def _leg(leg: str, foot: Triple) -> Iterator[tuple[str, Jet]]:
    """Yield the joints of a leg whose foot is there in the trunk's frame; front knees bend backward, hind ones forward.

    Across: `(y, z) = R (d, -h)`, h the length of the leg in its plane. In the plane the bones are equal, so half the
    knee's angle lies on either side of the line from hip to foot.
    """
    front, left = LEGS[leg]
    z = foot[2]
    x, y, d, bone = (like(z.x, value) for value in (*HIP, SIDE, BONE))
    x, y, d = foot[0] - front * x, foot[1] - left * y, left * d
    h = sqrt(y * y + z * z - d * d)
    half = acos(sqrt(x * x + h * h) / (2 * bone))
    yield "abduction", atan2(y * h + z * d, y * d - z * h)
    yield "flexion", atan2(-x, h) + front * half
    yield "knee", -2 * front * half


def _base(trunk: Triple, turn: Triple) -> Iterator[tuple[str, Number]]:
    """Yield the base_ columns: place, attitude, then rates and accelerations, w in the trunk's axes."""
    yield from zip(("x", "y", "z"), (u.x for u in trunk), strict=True)
    yield from _attitude(turn)
    roll, pitch, _ = turn
    roll_rate, pitch_rate, yaw_rate = (Jet(u.v, u.a) for u in turn)
    up = cos(pitch) * yaw_rate
    w = (
        roll_rate - sin(pitch) * yaw_rate,
        cos(roll) * pitch_rate + sin(roll) * up,
        cos(roll) * up - sin(roll) * pitch_rate,
    )
    for stem, values in (
        ("v", [u.v for u in trunk]),
        ("w", [u.x for u in w]),
        ("a", [u.a for u in trunk]),
        ("wd", [u.v for u in w]),
    ):
        yield from ((stem + axis, value) for axis, value in zip("xyz", values, strict=True))


def _attitude(turn: Triple) -> Iterator[tuple[str, Number]]:
    """Yield the quaternion of R_z R_y R_x, from sine and cosine of half the angles."""
    halves = [u / 2 for u in turn]
    a, b, c = (sin(u).x for u in halves)
    r, p, y = (cos(u).x for u in halves)
    yield "qx", a * p * y - r * b * c
    yield "qy", r * b * y + a * p * c
    yield "qz", r * p * c - a * b * y
    yield "qw", r * p * y + a * b * c
