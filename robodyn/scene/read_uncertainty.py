"""Reading `[uncertainty]` of scene.toml: standard deviations with their units, or the file of a covariance."""

from __future__ import annotations

import json
import math
import os
import re
from collections.abc import Iterator, Sequence
from typing import Any

from robodyn.errors import SceneError, unreadable
from robodyn.scene.toml_table import SceneTable
from robodyn.scene.uncertainty import Covariance, Deviation, LinkUncertainty, Uncertainty
from robodyn.support.input_file import read_input

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
        return Uncertainty(covariance=_covariance(os.path.join(os.path.dirname(scene.file), name)))
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


def _covariance(file: str) -> Covariance:
    """Return the covariance of a file {"parameters": [...], "values": [...], "covariance": [[...]]}."""
    try:
        data = json.loads(read_input(file))
    except OSError as error:
        raise unreadable(error, file) from None
    except ValueError as error:
        raise SceneError(f"is not JSON: {error}", file=file) from None
    keys = ("parameters", "values", "covariance")
    if not isinstance(data, dict) or any(not isinstance(data.get(key), list) for key in keys):
        what = f"has no lists {', '.join(keys)}"
        raise SceneError(what, remedy="take the covariance file that robodyn identify writes", file=file)
    names, values, rows = (data[key] for key in keys)
    count = len(names)
    if not all(isinstance(name, str) for name in names) or len(set(names)) < count:
        raise SceneError("parameters are not different names", file=file)
    if not all(_numbers(row, count) for row in (values, *rows)) or len(rows) != count:
        what = f"{count} parameters need {count} values and a covariance of {count} x {count} finite numbers"
        raise SceneError(what, file=file)
    _check_covariance(rows, names, file)
    return Covariance(tuple(names), tuple(values), tuple(map(tuple, rows)), file)


def _numbers(row: Any, count: int) -> bool:
    """Return whether these are so many finite numbers."""
    numbers = isinstance(row, list) and all(isinstance(x, (int, float)) and not isinstance(x, bool) for x in row)
    return numbers and len(row) == count and all(map(math.isfinite, row))


def _check_covariance(rows: Sequence[Sequence[float]], names: Sequence[str], file: str) -> None:
    """Raise where two parameters cannot vary in this way; whether many can together is asked when they are drawn."""
    for i, name in enumerate(names):
        if rows[i][i] < 0.0:
            raise SceneError(f"the variance of {name} is {rows[i][i]:g}", remedy="it is positive or zero", file=file)
        for k in range(i):
            most = math.sqrt(rows[i][i] * rows[k][k])
            if abs(rows[i][k] - rows[k][i]) > 1e-9 * most or abs(rows[i][k]) > most * (1.0 + 1e-9):
                what = f"the covariance of {name} and {names[k]} is {rows[i][k]:g} and {rows[k][i]:g}"
                remedy = f"it is symmetric, and at most {most:g}, the product of their standard deviations"
                raise SceneError(what, remedy=remedy, file=file)
