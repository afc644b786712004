"""Reading `[motor]` of scene.toml: what data sheets of motors and gears say, in their words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from math import pi
from typing import Any

import numpy as np

from robodyn.scene.parts import Curve, Motor, Rotor
from robodyn.scene.toml_table import SceneTable

SPEEDS = {"rad/s": 1.0, "rpm": pi / 30.0}
"""Units of speed that a data sheet may have, in rad/s."""
_POINTS = "points are [speed, torque], such as [[0, 1.3], [300, 0.9]]"


def motors_of(scene: SceneTable, rotors: Mapping[str, Rotor]) -> dict[str, Any]:
    """Return the scene's `motor`, and its `rotor` with those that stand in the tables of motors.

    Args:
        rotors: of the table `[rotor]`.

    Raises:
        SceneError: a key or a value is wrong, or a rotor or gear is said twice.
    """
    motors, all_rotors = {}, dict(rotors)
    for name, table in scene.tables("motor"):
        motors[name] = _motor(table)
        rotor = Rotor(table.nonnegative("inertia", None), table.number("gear", None))
        table.finish()
        for key, value in (("inertia", rotor.inertia), ("gear", rotor.gear)):
            if value is not None and name in rotors:
                raise table.error(f'"{key}" and [rotor] {name} say the same', remedy="leave [rotor] out")
        if rotor.gear == 0:
            raise table.error('"gear" is 0', remedy="turns of the motor per turn of the joint")
        if rotor != Rotor(None):
            all_rotors[name] = rotor
    return {"motor": motors, "rotor": all_rotors}


def _motor(table: SceneTable) -> Motor:
    unit = SPEEDS[table.text("speed_unit", "rad/s", tuple(SPEEDS))]
    most = _positive(table, "max_speed")
    motor = Motor(
        _efficiency(table),
        _curve(table, "continuous", unit),
        _curve(table, "peak", unit),
        None if most is None else most * unit,
        _positive(table, "gear_average"),
        _positive(table, "gear_peak"),
    )
    _check_order(table, motor)
    return motor


def _efficiency(table: SceneTable) -> float:
    efficiency: float = table.number("efficiency", 1.0)
    if not 0.0 < efficiency <= 1.0:
        share = f"{efficiency:g} % is {efficiency / 100:g}" if 1 < efficiency <= 100 else "such as 0.85"
        raise table.error(f'"efficiency" is {efficiency:g}', remedy=f"a share above 0 and up to 1: {share}")
    return efficiency


def _positive(table: SceneTable, key: str) -> float | None:
    value: float | None = table.number(key, None)
    if value is not None and value <= 0:
        raise table.error(f'"{key}" is {value:g}', remedy="it is positive; leave it out if it is not known")
    return value


def _curve(table: SceneTable, key: str, unit: float) -> float | Curve | None:
    if not isinstance(table.values.get(key), list):
        return _positive(table, key)
    entries = table.take(key, ())
    if not entries or not all(isinstance(entry, Sequence) and len(entry) == 2 for entry in entries):
        raise table.error(f'"{key}" is {entries!r:.60}, neither a torque nor a curve', remedy=_POINTS)
    points = [SceneTable({key: entry}, table.what, table.file).numbers(key, 2) for entry in entries]
    speeds, torques = zip(*points, strict=True)
    if speeds[0] < 0 or any(b <= a for a, b in pairwise(speeds)):
        raise table.error(f'the speeds of "{key}" do not increase from 0 on: {_listed(speeds)}', remedy=_POINTS)
    if min(torques) < 0 or not max(torques):
        raise table.error(f'the torques of "{key}" are not positive: {_listed(torques)}', remedy=_POINTS)
    return tuple((speed * unit, torque) for speed, torque in points)


def _listed(values: Sequence[float]) -> str:
    return ", ".join(f"{value:g}" for value in values)


def _check_order(table: SceneTable, motor: Motor) -> None:
    """Raise where more is allowed for ever than for moments."""
    if motor.continuous is None or motor.peak is None:
        return
    (speeds, torques), (places, limits) = (
        np.transpose(((0.0, of),) if isinstance(of, float) else of) for of in (motor.continuous, motor.peak)
    )
    for speed, torque, most in zip(speeds, torques, np.interp(speeds, places, limits), strict=True):
        if torque > most:
            what = f'"continuous" allows {torque:g} at {speed:g} rad/s and "peak" {most:g}'
            raise table.error(what, remedy=f"are they swapped? {_POINTS}")
