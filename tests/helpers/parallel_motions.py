"""Motors of the parallel robots of robots/ from the place of their platforms, with exact rates."""

from __future__ import annotations

from helpers.jets import Jet, Pair, Triple, acos, atan2, dot, jet, like, pi, rotated, sqrt

SHIFT, ARM, ROD = 0.1, 0.2, 0.5
"""Of the delta robot: radius of the motors less that of the platform's balls; arm; rod [m]."""
MOTORS, PINS, LINK = 0.32, 0.08, 0.2
"""Of the 3-RRR: radii of the motors and of the platform's pins; arms and rods [m]."""


def delta_motors(place: Triple) -> list[Jet]:
    """Return how far each arm is lowered where the platform's centre is at `place`.

    In the axes of the leg, with x less f - e, `|(x - r cos th, y, z + r sin th)| = l` is
    `x cos th - z sin th = (x^2 + y^2 + z^2 + r^2 - l^2) / (2 r)`.
    """
    x, y, z = place
    shift, arm, rod = (like(x.x, value) for value in (SHIFT, ARM, ROD))
    found = []
    for k in range(3):
        out, across = rotated(-2 * k * pi(x.x) / 3, (x, y))
        out = out - shift
        reach = dot((out, across, z), (out, across, z)) + (arm * arm - rod * rod)
        share = reach / (2 * arm) / sqrt(out * out + z * z)
        found.append(atan2(-z, out) - acos(share))
    return found


def planar_motors(place: Pair, turn: Jet) -> list[Jet]:
    """Return the angles of the 3-RRR's arms, from where they stand at rest, for a platform that is shifted and turned.

    Arm and rod are equally long, so the arm stands off the line from motor to pin by acos(d / (2 l)).
    """
    motors, pins, link = (like(turn.x, value) for value in (MOTORS, PINS, LINK))
    rest = acos(jet((motors - pins) / (2 * link)))
    found = []
    for k in range(3):
        leg = pi(turn.x) / 2 + 2 * k * pi(turn.x) / 3
        pin = rotated(turn, rotated(leg, (pins, 0 * pins)))
        x, y = rotated(-leg, (pin[0] + place[0], pin[1] + place[1]))
        x = x - motors
        found.append(atan2(-y, -x) - acos(sqrt(x * x + y * y) / (2 * link)) + rest)
    return found
