"""Reading `[uncertainty]` of scene.toml: standard deviations with their units, or the file of a covariance."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Iterator

from robodyn.scene.toml_table import SceneTable
from robodyn.scene.uncertainty import Deviation, LinkUncertainty, Uncertainty, read_covariance

UNITS = {
    "mass": {"kg": 1.0, "g": 1e-3},
    "com": {"m": 1.0, "cm": 1e-2, "mm": 1e-3},
    "inertia": {"kg m^2": 1.0},
    "friction": {"N m": 1.0, "N": 1.0},
}
"""The units of absolute standard deviations, in SI."""
_AMOUNT = re.compile(r"\s*([0-9.]+(?:[eE][+-]?[0-9]+)?)\s*(.*?)\s*")
_OF_LINKS = ("mass", "com", "inertia")


def uncertainty_of(scene: SceneTable) -> Uncertainty:
    """Return what a scene says of how well its robot is known.

    Raises:
        SceneError: a key or a value is wrong, the covariance cannot be read, or stands beside deviations.
    """
    table = SceneTable(scene.take("uncertainty", ...), "[uncertainty]", scene.file)
    if "covariance" in table.values:
        name = table.text("covariance")
        if table.values:
            what = f'"covariance" is all that is uncertain, and there is {", ".join(table.values)} too'
            raise table.error(what, remedy="leave one of them out")
        return Uncertainty(covariance=read_covariance(os.path.join(os.path.dirname(scene.file), name)))
    links = {name: _link(each) for name, each in _named(table, "link")}
    joints = {name: found for name, each in _named(table, "joint") if (found := _joint(each)) is not None}
    mass, com, inertia, friction = (_deviation(table, key) for key in UNITS)
    table.known.append("covariance")
    table.finish()
    return Uncertainty(mass, com, inertia, friction, links, joints)


def _named(table: SceneTable, key: str) -> Iterator[tuple[str, SceneTable]]:
    for name, values in SceneTable(table.take(key, {}), f"[uncertainty.{key}]", table.file).values.items():
        yield name, SceneTable(values, f"[uncertainty.{key}.{name}]", table.file)


def _link(table: SceneTable) -> LinkUncertainty:
    found = LinkUncertainty(*(_deviation(table, key) for key in _OF_LINKS))
    table.finish()
    return found


def _joint(table: SceneTable) -> Deviation | None:
    found = _deviation(table, "friction")
    table.finish()
    return found


def _deviation(table: SceneTable, key: str) -> Deviation | None:
    given = table.take(key, None)
    if given is None:
        return None
    units = {"%": 0.01, **UNITS[key]}
    found = _AMOUNT.fullmatch(given) if isinstance(given, str) else None
    unit = " ".join(found[2].replace("*", " ").split()) if found else ""
    try:
        value = float(found[1]) * units[unit] if found else math.nan
    except (ValueError, KeyError):
        value = math.nan
    if not math.isfinite(value):
        examples = " or ".join(f'{key} = "5 {each}"' for each in units)
        what = f'"{key}" is {given!r:.60}, not a standard deviation with its unit'
        raise table.error(what, remedy=f"write {examples}")
    return Deviation(value, relative=unit == "%")
