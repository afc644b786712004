"""The closed chains of robots/ in closed form: every joint and every energy from as many coordinates as they have.

Lengths, masses and frames are those in the heads of the descriptions.
"""

from __future__ import annotations

from collections.abc import Sequence

from helpers.jets import Jet, Triple, acos, atan2, cos, dot, jet, rotated, sin, sqrt
from helpers.virtual_work import Moving, Place

G = 9.81
REST = 0.9272952180016122
"""acos((0.32 - 0.08) / 0.4)"""
TILTED = 4.905
"""Of gravity, down the tilted table of the 3-RRR [m/s^2]."""
HALF_PI, TURN = 1.5707963267948966, 2.0943951023931953
LEAN, ARM, ELBOW, FOLD = 0.6435011087932844, 2.214297435588181, 1.2870022175865687, 1.8545904360032246
"""atan2(3, 4), atan2(4, -3), its difference from atan2(4, 3), and what twice it lacks to a full turn."""


def crank_slider(u: Sequence[Jet]) -> Place:
    """From the crank's angle: x = r cos th + sqrt(l^2 - r^2 sin^2 th)."""
    (th,) = u
    r, l, m = 0.1, 0.3, 0.6
    pin = (r * cos(th), r * sin(th))
    level = sqrt(l * l - pin[1] * pin[1])
    tilt = atan2(-pin[1], level)
    middle = (pin[0] + level / 2, pin[1] / 2)
    x = pin[0] + level
    moving = [Moving(0.0216, (th,)), Moving(m, middle), Moving(_rod(m, l, 0.012), (tilt,)), Moving(1.2, (x,))]
    return Place({"main": th, "pin": tilt - th, "rail": x}, ("main",), moving, m * G * middle[1])


def four_bar(u: Sequence[Jet]) -> Place:
    """From how far the cranks lean: the table shifts along a circle."""
    (th,) = u
    r, crank, table = 0.3, 1.5, 4.0
    I = _rod(crank, r, 0.02) + crank * r * r / 4
    moving = [Moving(2 * I, (th,)), Moving(table, (r * sin(th), r * cos(th)))]
    joints = {"left": th, "right": th, "top": -th}
    return Place(joints, ("left",), moving, (crank + table) * G * r * cos(th))


def five_bar(u: Sequence[Jet]) -> Place:
    """From the motors: m and d being half the sum and the difference of the elbows, the tool is at
    m + sqrt(l^2 / d^2 - 1) (d_z, -d_x).
    """
    home = (ARM, ARM - ELBOW)
    angles = [q - rest for q, rest in zip(u, home, strict=True)]
    elbows = [(x + 0.2 * cos(a), 0.2 * sin(a)) for x, a in zip((-0.06, 0.06), angles, strict=True)]
    (x1, z1), (x2, z2) = elbows
    d = ((x2 - x1) / 2, (z2 - z1) / 2)
    rise = sqrt(0.09 / dot(d, d) - 1)
    tool = ((x1 + x2) / 2 + rise * d[1], (z1 + z2) / 2 - rise * d[0])
    joints, moving, V = {}, [Moving(0.4, tool)], 0.4 * G * tool[1]
    for side, q, a, elbow, rest in zip(("left", "right"), u, angles, elbows, (ELBOW, -ELBOW), strict=True):
        along = (tool[0] - elbow[0], tool[1] - elbow[1])
        rod = atan2(*rotated(-a - rest, along)[::-1])
        joints |= {side: q, f"{side}_elbow": rod}
        middle = (elbow[0] + along[0] / 2, elbow[1] + along[1] / 2)
        moving += [Moving(_rod(0.5, 0.2, 0.015) + 0.5 * 0.01, (a,)), Moving(0.3, middle)]
        ball = 0.4 * 0.4 * 0.025**2 if side == "left" else 0.0
        moving.append(Moving(_rod(0.3, 0.3, 0.01) + ball, (rod + a,)))
        V = V + G * (0.25 * elbow[1] + 0.3 * middle[1])
    return Place(joints, ("left", "right"), moving, V)


def delta(u: Sequence[Jet]) -> Place:
    """From the place of the platform's centre."""
    x, y, z = u
    across, spin, cross = 0.06 * (3 * 0.004**2 + 0.25) / 12, 0.06 * 0.004**2 / 2, 0.4 * 0.01 * 0.008**2
    joints, moving = {}, [Moving(0.5 + 2 * 0.01, (x, y, z))]
    V = 0.52 * G * z
    for k, th in enumerate(delta_motors((x, y, z))):
        out, side = rotated(-k * TURN, (x, y))
        elbow = (0.1 + 0.2 * cos(th), jet(0.0), -0.2 * sin(th))
        rod = tuple((a - b) / 0.5 for a, b in zip((out, side, z), elbow, strict=True))
        swing, sway = atan2(-rod[0], -rod[2]), atan2(rod[1], sqrt(rod[0] * rod[0] + rod[2] * rod[2]))
        joints[f"motor_{k + 1}"] = th
        for twin in "ab":
            joints |= {f"swing_{k + 1}{twin}": swing - th - LEAN, f"sway_{k + 1}{twin}": sway}
        if k == 0:
            joints |= {"roll": -sway, "pitch": LEAN - swing, "yaw": 0 * th}
        middle = tuple(a + 0.25 * b for a, b in zip(elbow, rod, strict=True))
        moving += [
            Moving(0.4 * (0.2**2 + 0.02**2) / 12 + 0.4 * 0.01, (th,)),
            Moving(2 * 0.01, elbow),
            Moving((3 if k == 0 else 2) * cross, (swing,)),
            Moving(2 * 0.06, middle),
            Moving(2 * across, rod),
            Moving(2 * spin * sin(sway) * sin(sway), (swing,)),
        ]
        V = V + G * (0.4 * 0.5 * elbow[2] + 0.02 * elbow[2] + 0.12 * middle[2])
    return Place(joints, ("motor_1", "motor_2", "motor_3"), moving, V)


def delta_motors(place: Triple) -> list[Jet]:
    """Return how far each arm is lowered where the platform's centre is at `place`.

    In the axes of the leg, with x less the motors' radius and plus the platform's, `|(x - r cos th, y, z + r sin th)| =
    l` is `x cos th - z sin th = (x^2 + y^2 + z^2 + r^2 - l^2) / (2 r)`.
    """
    x, y, z = place
    found = []
    for k in range(3):
        out, across = rotated(-k * TURN, (x, y))
        out = out - 0.1
        reach = dot((out, across, z), (out, across, z)) + (0.2**2 - 0.5**2)
        found.append(atan2(-z, out) - acos(reach / 0.4 / sqrt(out * out + z * z)))
    return found


def planar_3rrr(u: Sequence[Jet]) -> Place:
    """From the platform's shift and turn."""
    x, y, turn = u
    joints, moving = {}, [Moving(0.8, (x, y)), Moving(0.8 * 0.1**2 / 2, (turn,))]
    V = 0.8 * TILTED * y
    for k in range(3):
        leg = HALF_PI + k * TURN
        base, pin = rotated(leg, (0.32, 0.0)), rotated(turn + leg, (0.08, 0.0))
        # arm and rod are equally long, so the arm stands off the line from motor to pin by acos(d / (2 l))
        to_pin = rotated(-leg, (pin[0] + x, pin[1] + y))
        across, d = to_pin[1], to_pin[0] - 0.32
        q = atan2(-across, -d) - acos(sqrt(d * d + across * across) / 0.4) + REST
        a = q + (leg + ARM)
        elbow = (base[0] + 0.2 * cos(a), base[1] + 0.2 * sin(a))
        along = (pin[0] + x - elbow[0], pin[1] + y - elbow[1])
        rod = atan2(*rotated(-a - FOLD, along)[::-1])
        middle = (elbow[0] + along[0] / 2, elbow[1] + along[1] / 2)
        joints |= {f"motor_{k + 1}": q, f"elbow_{k + 1}": rod}
        if k == 0:
            joints["wrist"] = turn - q - rod
        moving += [Moving(_rod(0.5, 0.2, 0.015) + 0.5 * 0.01, (q,)), Moving(0.3, middle)]
        moving.append(Moving(_rod(0.3, 0.2, 0.01), (q + rod,)))
        V = V + TILTED * (0.5 * (base[1] + elbow[1]) / 2 + 0.3 * middle[1])
    return Place(joints, ("motor_1", "motor_2", "motor_3"), moving, V)


def _rod(m: float, length: float, radius: float) -> float:
    """Moment of inertia of a cylinder about its middle, across it [kg m^2]."""
    return m * (3 * radius**2 + length**2) / 12
