"""Accelerations where friction grows with load: the torque through a gear depends on the accelerations that it makes.

At a joint of load m (with the sign of qd, |m| < 1), rotor A and torque c, less the friction of its own,
`c - A qdd = tau_l + m |tau_l|`, so that with `y = c - A qdd`: `tau_l = (y - m |y|) / (1 - m^2)`. That is monotone in
qdd, so qdd is unique. Without a rotor it is explicit; with one, |y| is found by repetition, each with the rotor
A / (1 - m^2), which contracts by |m|. The last uses the sign of y alone: `tau_l = y / (1 + m sign(y))`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import ceil, log
from typing import NamedTuple

from robodyn.errors import InputError
from robodyn.programs.vectors import Scalar, sign
from robodyn.scene.scene import Scene
from robodyn.support.wording import shown

STEEPEST = 0.5
"""The largest load at a joint with a rotor: 44 repetitions."""
CLOSE = 1e-13
"""What is left of |y|'s error."""
Rotors = Mapping[tuple[int, int], Scalar]
Solve = Callable[[Sequence[Scalar], Rotors], list[Scalar]]


class Loaded(NamedTuple):
    """A joint's coordinate, its load with the sign of qd, and the torque that passes its gear to springs."""

    rate: int
    load: Scalar
    springs: Scalar


def repetitions(scene: Scene, names: Sequence[str]) -> int:
    """Return how often accelerations are found again for joints of these names, which have rotors.

    Raises:
        InputError: the load of one is so large that there would be too many.
    """
    largest = max((scene.friction[name].load for name in names), default=0.0)
    if largest > STEEPEST:
        name = max(names, key=lambda each: scene.friction[each].load)
        what = f"[friction] {shown(name)}: load {largest:g} at a joint with a rotor is too large for forward dynamics"
        raise InputError(what, remedy=f"give {STEEPEST:g} or less, or no rotor")
    return ceil(log(CLOSE) / log(largest)) if largest else 0


def loaded_accelerations(
    solve: Solve, forces: Sequence[Scalar], rotors: Rotors, joints: Sequence[Loaded], passes: int
) -> list[Scalar]:
    """Return qdd.

    Args:
        solve: qdd of an open tree from forces and rotors.
        forces: n scalars, less all friction but that of the load, and less the torque of springs [N m or N].
        rotors: reflected rotor inertias, by coordinates i <= j.
        joints: those with such friction; rotors do not couple them.
        passes: of `repetitions`.
    """
    before = [forces[rate] + springs for rate, _, springs in joints]
    own = [rotors.get((rate, rate), 0.0) for rate, _, _ in joints]
    left = list(before)
    for _ in range(passes):
        torques, scales = [], []
        for (_, m, _), c, y in zip(joints, before, left, strict=True):
            scales.append(1.0 / (1.0 - m * m))
            torques.append((c - m * (y * sign(y))) * scales[-1])
        qdd = _solved(solve, forces, rotors, joints, torques, scales)
        left = [c - A * qdd[rate] for (rate, _, _), c, A in zip(joints, before, own, strict=True)]
    scales = [1.0 / (1.0 + m * sign(y)) for (_, m, _), y in zip(joints, left, strict=True)]
    torques = [c * scale for c, scale in zip(before, scales, strict=True)]
    return _solved(solve, forces, rotors, joints, torques, scales)


def _solved(
    solve: Solve,
    forces: Sequence[Scalar],
    rotors: Rotors,
    joints: Sequence[Loaded],
    torques: Sequence[Scalar],
    scales: Sequence[Scalar],
) -> list[Scalar]:
    """Return qdd with other torques through the gears, and rotors times a scale."""
    through, scaled = list(forces), dict(rotors)
    for (rate, _, springs), torque, scale in zip(joints, torques, scales, strict=True):
        through[rate] = torque - springs
        if (rate, rate) in rotors:
            scaled[rate, rate] = rotors[rate, rate] * scale
    return solve(through, scaled)
