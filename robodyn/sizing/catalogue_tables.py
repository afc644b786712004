"""Catalogues of motors and of gears as CSV: a row each, units in the header; every row at fault is told."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import pi
from typing import Annotated, Any, Literal, NamedTuple, TypeVar, get_type_hints

import numpy as np

from robodyn.errors import InputError, unreadable
from robodyn.loads.sizing import points
from robodyn.scene.scene import Curve
from robodyn.support.floats import BEYOND
from robodyn.support.input_file import beyond, limits, read_input, read_standard_input
from robodyn.support.wording import alternatives, count, listed, shown

UNKNOWN = "-"
"""In the cell of a limit that a data sheet does not tell: it is not judged."""
_MOST_POINTS, _MOST_FAULTS = 200, 100
"""Points of a curve, and faults of a table that are told."""
_ROUNDED = 1.01
"""Times this, a curve may end before the largest speed, which data sheets round."""
_LEAST, _MOST = 1e-15, 1e15
"""Numbers beyond these would overflow in powers and quotients of each other."""


class _Column(NamedTuple):
    """A column: what its cells are, the units that its header may name with what they are in SI (the first without
    any), whether a row must have it (a limit may be `UNKNOWN`), and above which number the header must name a unit."""

    cells: Literal["number", "curve", "numbers", "text"]
    units: dict[str, float] = {}  # noqa: RUF012
    needed: bool = True
    limit: bool = False
    doubtful: float = math.inf


_SPEED = {"rad/s": 1.0, "rpm": pi / 30.0}
_TORQUE = {"N m": 1.0, "mN m": 1e-3, "N cm": 1e-2}
_INERTIA = _Column("number", {"kg m^2": 1.0, "kg cm^2": 1e-4, "g cm^2": 1e-7}, doubtful=0.2)
_FASTEST = _Column("number", _SPEED, limit=True, doubtful=2000.0)
_CURVE, _LOAD = _Column("curve", _TORQUE, limit=True), _Column("number", {"N m": 1.0, "N": 1.0}, limit=True)
_MASS = _Column("number", {"kg": 1.0, "g": 1e-3}, doubtful=300.0)
_NAME, _PRICE = _Column("text"), _Column("number", needed=False)
_R = _Column("number", {"ohm": 1.0, "mohm": 1e-3}, needed=False)
_K = _Column("number", {"N m/A": 1.0, "mN m/A": 1e-3}, needed=False)


def _fault(column: str, what: str, remedy: str) -> InputError:
    return InputError(f"column {shown(column)}: {what}", remedy=remedy)


@dataclass(frozen=True)
class CatalogueMotor:
    """A motor of a catalogue; speeds and torques at its shaft, rad/s and N m.

    Attributes:
        inertia: of the rotor [kg m^2].
        continuous_torque, peak_torque: for ever and for moments, one for all speeds or a curve; None: not judged.
        max_speed: None: where the curve of `peak_torque` ends.
        resistance, torque_constant: R and k, so that a torque T heats the winding with R (T / k)^2 [ohm, N m/A].
    """

    name: Annotated[str, _NAME]
    inertia: Annotated[float, _INERTIA]
    continuous_torque: Annotated[float | Curve | None, _CURVE]
    peak_torque: Annotated[float | Curve | None, _CURVE]
    max_speed: Annotated[float | None, _FASTEST]
    mass: Annotated[float, _MASS]
    price: Annotated[float | None, _PRICE] = None
    resistance: Annotated[float | None, _R] = None
    torque_constant: Annotated[float | None, _K] = None

    @property
    def speed_limit(self) -> float | None:
        curve = self.peak_torque
        return curve[-1][0] if self.max_speed is None and isinstance(curve, tuple) else self.max_speed

    def check(self) -> None:
        """Refuse a row that contradicts itself."""
        fast, continuous, peak = self.max_speed, self.continuous_torque, self.peak_torque
        if (self.resistance is None) != (self.torque_constant is None):
            empty = "resistance" if self.resistance is None else "torque_constant"
            raise _fault(empty, "is empty", "the loss R (T / k)^2 takes resistance and torque_constant, or neither")
        if fast is None and not isinstance(peak, tuple):
            raise _fault("max_speed", "is not known", "write it, or peak_torque as a curve that ends there")
        for name, curve in (("continuous_torque", continuous), ("peak_torque", peak)):
            if isinstance(curve, tuple) and fast is not None:
                end = curve[-1][0]
                if end > 5.0 * fast or (name == "peak_torque" and end * _ROUNDED < fast):
                    what = f"the curve ends at {end:g} rad/s, max_speed is {fast:g} rad/s"
                    raise _fault(name, what, f"write it to its end, or name the unit of its speeds: {name} [rpm:N m]")
        if continuous is not None and peak is not None:
            (x, lasting), (places, most) = np.transpose(points(continuous)), np.transpose(points(peak))
            speeds = np.union1d(x, places[places <= x[-1]])
            torques, allowed = np.interp(speeds, x, lasting), np.interp(speeds, places, most)
            for k in np.flatnonzero(torques > allowed * BEYOND)[:1]:
                what = f"allows {torques[k]:g} at {speeds[k]:g} rad/s, and peak_torque {allowed[k]:g}"
                raise _fault("continuous_torque", what, "are they swapped, or in different units?")


@dataclass(frozen=True)
class CatalogueGear:
    """A gear of a catalogue, in one or more ratios: turns of the motor per turn of the joint; or a screw or a rack,
    which moves a prismatic joint by its `lead` [m] per turn of the motor.

    Attributes:
        peak_torque, average_torque: what it bears at its output, for moments and as cubic mean [N m, N].
        max_input_speed: rad/s; inertia: at its input [kg m^2]. None of these limits: not judged.
    """

    name: Annotated[str, _NAME]
    ratio: Annotated[tuple[float, ...], _Column("numbers", needed=False)] = ()
    lead: Annotated[float | None, _Column("number", {"m": 1.0, "mm": 1e-3}, needed=False, doubtful=1.0)] = None
    efficiency: Annotated[float, _Column("number", {"1": 1.0, "%": 1e-2})] = 1.0
    peak_torque: Annotated[float | None, _LOAD] = None
    average_torque: Annotated[float | None, _LOAD] = None
    max_input_speed: Annotated[float | None, _FASTEST] = None
    inertia: Annotated[float, _INERTIA] = 0.0
    mass: Annotated[float, _MASS] = 0.0
    price: Annotated[float | None, _PRICE] = None

    @property
    def ratios(self) -> tuple[float, ...]:
        """Turns of the motor per turn of the joint; of a screw 2 pi / lead [rad/m]."""
        return (2.0 * pi / self.lead,) if self.lead else self.ratio

    def check(self) -> None:
        """Refuse a row that contradicts itself."""
        average, peak = self.average_torque, self.peak_torque
        if bool(self.ratio) == bool(self.lead):
            raise _fault("ratio", f"and lead are both {'given' if self.lead else 'empty'}", "give one")
        if self.efficiency > 1.0:
            raise _fault("efficiency", f"is {self.efficiency:g}", "a share above 0 and up to 1, or efficiency [%]")
        if average is not None and peak is not None and average > peak:
            raise _fault("average_torque", f"is {average:g}, and peak_torque {peak:g}", "are they swapped?")


class CatalogueError(InputError):
    """Rows of a catalogue are wrong; `faults` has an error for each, its own words are those of the first."""

    def __init__(self, faults: Sequence[InputError]) -> None:
        first, self.faults = faults[0], tuple(faults)
        more = f"; and {count(len(faults) - 1, 'more fault')}" if faults[1:] else ""
        super().__init__(f"{first.what}{more}", remedy=first.remedy, file=first.file, line=first.line)


_ZERO = ("inertia", "mass", "price")
_HEADER = re.compile(r"([^\[\]]*?)\s*(?:\[([^\[\]]*)\])?")
_POINTS = f"points speed:torque between blanks, at most {_MOST_POINTS}, of increasing speed, not all 0: 0:1.3 300:0.9"
_Row = TypeVar("_Row", CatalogueMotor, CatalogueGear)


def read_rows(path: str, kind: type[_Row]) -> tuple[tuple[_Row, ...], list[str]]:
    """Return the rows of a CSV table, and notes on what is not judged; `-` is standard input.

    Raises:
        CatalogueError: all rows at fault.
    """
    columns = {name: hint.__metadata__[0] for name, hint in get_type_hints(kind, include_extras=True).items()}
    file = "<stdin>" if path == "-" else path
    numbered = enumerate(_text(path, file).split("\n"), 1)
    lines = [(k, line) for k, line in numbered if line.strip() and not line.lstrip().startswith("#")]
    delimiter = next((mark for mark in ",;\t" if lines and mark in lines[0][1]), ",")
    found: dict[str, tuple[_Row, int]] = {}
    faults, units = list[InputError](), dict[str, str]()
    for line, text in lines:
        try:
            if "\ufffd" in text:
                raise InputError("is not UTF-8 text", remedy="save the table as CSV in UTF-8")
            cells = [cell.strip() for cell in next(csv.reader([text], delimiter=delimiter, strict=True))]
            if not units:
                units = _header(cells, columns)
                continue
            if len(cells) != len(units):
                wrong = f"{count(len(cells), 'cell')} where the header names {count(len(units), 'column')}"
                raise InputError(wrong, remedy="a cell for each column; points of a curve stand between blanks")
            words = dict(zip(units, cells, strict=True))
            said = [each for each in units if columns[each].needed or words[each] not in ("", UNKNOWN)]
            values = {each: _value(each, columns[each], words[each], units[each]) for each in said}
            name, row = values["name"], kind(**values)
            if name in found:
                raise _fault("name", f"{shown(name)} is in line {found[name][1]} too", "a name of its own for each")
            row.check()
            found[name] = row, line
        except (InputError, csv.Error) as error:
            remedy = "see that quotes are closed and cells short"
            fault = error if isinstance(error, InputError) else InputError(f"cannot be read: {error}", remedy=remedy)
            fault.file, fault.line = file, line
            faults.append(fault)
            if not units or len(faults) == _MOST_FAULTS:
                break
    if faults:
        raise CatalogueError(faults)
    if not found:
        remedy = f"a header of {listed(columns)}, and a row for each below"
        raise CatalogueError([InputError("has no rows", remedy=remedy, file=file)])
    rows = tuple(each for each, _ in found.values())
    judged = [name for name, known in columns.items() if known.limit and name != "max_speed"]
    silent = {name: [each.name for each in rows if getattr(each, name) is None] for name in judged}
    unjudged = "; ".join(f"{name} of {listed(own)}" for name, own in silent.items() if own)
    return rows, [f"{file}: not known, and not judged: {unjudged}"] if unjudged else []


def _text(path: str, file: str) -> str:
    most = limits().catalogue_bytes
    try:
        data = read_standard_input() if path == "-" else read_input(path, most + 1, typed=True)
    except (OSError, ValueError) as error:
        raise unreadable(error, file) from None
    if len(data) > most:
        raise beyond("catalogue_bytes", "too many bytes", InputError, file=file)
    return data.decode("utf-8-sig", errors="replace")


def _header(cells: Sequence[str], columns: dict[str, _Column]) -> dict[str, str]:
    """Return the names of columns, and their units, "" where there is none."""
    units: dict[str, str] = {}
    for cell in cells:
        match = _HEADER.fullmatch(cell)
        name, unit = (match[1], match[2]) if match else (cell, None)
        known = columns.get(name)
        if known is None:
            raise InputError(f"unknown column {shown(name)}", remedy=alternatives(name, columns, "columns"))
        if name in units:
            raise InputError(f"column {shown(name)} stands twice", remedy="leave one of them out")
        speed, colon, own = (unit or "").rpartition(":")
        fits = own in known.units and (not colon or (known.cells == "curve" and speed in _SPEED))
        if unit is not None and name != "price" and not fits:
            of_curves = "; of curves such as [rpm:N m]" if known.cells == "curve" else ""
            raise _fault(name, f"unknown unit {shown(unit)}", f"units: {listed(known.units) or 'none'}{of_curves}")
        units[name] = unit or ""
    missing = [name for name, known in columns.items() if known.needed and name not in units]
    if missing:
        raise InputError(f"no column {listed(missing)}", remedy="add it; robodyn size --init writes a whole table")
    return units


def _value(name: str, known: _Column, cell: str, unit: str) -> Any:
    """Return what a cell says in SI, None of a limit that is not known."""
    if cell == UNKNOWN and known.limit:
        return None
    if cell in ("", UNKNOWN):
        unsaid = ", or - if it is not known, which then is not judged" if known.limit else ""
        raise _fault(name, "is not known" if cell else "is empty", f"write it{unsaid}")
    if known.cells == "text":
        return cell
    if known.cells == "numbers":
        return tuple(_number(name, word) for word in cell.split())
    speed, _, own = unit.rpartition(":")
    pace, factor = _SPEED.get(speed, 1.0), known.units.get(own, 1.0)
    if known.cells == "number" or ":" not in cell:
        value = _number(name, cell)
        if value > known.doubtful and not unit:
            raise _fault(name, f"is {cell} in {next(iter(known.units))}", "if it is, name the unit in the header too")
        return value * factor
    pairs = [word.split(":") for word in cell.split()]
    if any(len(pair) != 2 for pair in pairs) or len(pairs) > _MOST_POINTS:
        raise _fault(name, f"{shown(cell)} is no curve", _POINTS)
    curve = tuple((_number(name, x, True) * pace, _number(name, y, True) * factor) for x, y in pairs)
    if any(b[0] <= a[0] for a, b in pairwise(curve)) or not max(y for _, y in curve):
        raise _fault(name, f"{shown(cell)} is no curve", _POINTS)
    return curve


def _number(name: str, cell: str, zero: bool = False) -> float:
    """Return a number that is positive, or 0 where that may be."""
    try:
        value = math.nan if "_" in cell else float(cell)
    except ValueError:
        value = math.nan
    if math.isnan(value):
        raise _fault(name, f"{shown(cell)} is not a number", "write it as 1.5e-3, decimals with a point")
    zero = zero or name in _ZERO
    if not (_LEAST <= value <= _MOST or (value == 0.0 and zero)):
        raise _fault(name, f"is {cell}", f"it is {'0 or ' if zero else ''}between {_LEAST:g} and {_MOST:g}")
    return value


MOTORS_TEMPLATE = """\
# Motors, one a row; numbers are invented. Units stand in the header, SI without: inertia [kg m^2, kg cm^2, g cm^2],
# torques [N m, mN m], max_speed [rad/s, rpm]. A torque is one for all speeds, or a curve of speed:torque points between
# blanks, [rpm:N m]. - in place of a torque or a max_speed: not known, not judged (max_speed: the curve's end). Optional:
# price, resistance and torque_constant for copper loss R (T / k)^2.
name,inertia [kg cm^2],continuous_torque [rpm:N m],peak_torque [rpm:N m],max_speed [rpm],mass,price,resistance,torque_constant
M 200,0.21,0:0.67 3000:0.64 5000:0.48,0:2.0 3500:2.0 5000:1.2,5000,0.82,190,0.95,0.10
M 400,0.39,0:1.35 3000:1.27 5000:0.90,0:4.0 3500:4.0 5000:2.2,5000,1.2,240,0.62,0.14
M 1500,3.9,0:5.2 3000:4.77 4000:3.9,0:15 2800:15 4000:9.0,4000,4.4,520,0.21,0.29
"""  # noqa: E501
GEARS_TEMPLATE = """\
# Gears, one a row; numbers are invented. ratio: turns of the motor per turn of the joint, several between blanks; or
# lead [m, mm]: way of a screw per turn, of prismatic joints. peak_torque and average_torque (cubic mean) at the output
# [N m; N of a screw], inertia at the input. - for a limit: not known, not judged. A motor without gear: a ratio of 1.
name,ratio,lead [mm],efficiency [%],peak_torque,average_torque,max_input_speed [rpm],inertia [kg cm^2],mass,price
W 20,50 80 100 120 160,-,75,92,49,6500,0.19,0.52,700
W 32,50 80 100 120 160,-,75,333,216,4800,1.7,1.8,1250
S 50,-,50,92,5000,2500,4000,0.25,1.2,290
direct,1,-,100,-,-,-,0,0,0
"""
