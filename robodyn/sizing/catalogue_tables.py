"""Catalogues of motors and of gears as CSV: a row each, units in the header, every fault with its line and column."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import pi
from typing import Any, Literal, NamedTuple

import numpy as np

from robodyn.errors import InputError
from robodyn.scene.scene import Curve
from robodyn.support.floats import BEYOND, LARGEST
from robodyn.support.input_file import beyond, limits, read_input, read_standard_input
from robodyn.support.wording import alternatives, count, listed, shown

UNKNOWN = "-"
"""In the cell of a limit that a data sheet does not tell: it is not judged."""
_MOST_POINTS, _MOST_FAULTS = 200, 100
"""Points of a curve, and faults of a table."""


@dataclass(frozen=True)
class CatalogueMotor:
    """A motor of a catalogue; speeds and torques at its shaft, rad/s and N m; of a linear motor m/s and N.

    Attributes:
        inertia: of the rotor; of a linear motor the mass of what it moves beside the link [kg m^2, kg].
        continuous_torque, peak_torque: for ever and for moments, one for all speeds or a curve; None: not judged.
        max_speed: None: where the curve of `peak_torque` ends.
        kind: "rotary", or "linear": it pushes a slide without a gear.
        resistance, torque_constant: R and k, so that a torque T heats the winding with R (T / k)^2 [ohm, N m/A].
        joints: the only ones that it may drive; all without.
    """

    name: str
    inertia: float
    continuous_torque: float | Curve | None
    peak_torque: float | Curve | None
    max_speed: float | None
    mass: float
    kind: str = "rotary"
    price: float | None = None
    resistance: float | None = None
    torque_constant: float | None = None
    joints: tuple[str, ...] = ()

    @property
    def speed_limit(self) -> float | None:
        curve = self.peak_torque
        return curve[-1][0] if self.max_speed is None and isinstance(curve, tuple) else self.max_speed


@dataclass(frozen=True)
class CatalogueGear:
    """A gear of a catalogue, in one or more ratios: turns of the motor per turn of the joint; or a screw or a rack,
    which moves a prismatic joint by its `lead` [m] per turn of the motor.

    Attributes:
        peak_torque, average_torque: what it bears at its output, for moments and as cubic mean [N m, N].
        max_input_speed: rad/s; inertia: at its input [kg m^2]. None of these limits: not judged.
    """

    name: str
    ratio: tuple[float, ...]
    lead: float | None
    efficiency: float
    peak_torque: float | None = None
    average_torque: float | None = None
    max_input_speed: float | None = None
    inertia: float = 0.0
    mass: float = 0.0
    price: float | None = None

    @property
    def ratios(self) -> tuple[float, ...]:
        """Turns of the motor per turn of the joint; of a screw 2 pi / lead [rad/m]."""
        return (2.0 * pi / self.lead,) if self.lead else self.ratio


class CatalogueError(InputError):
    """What is wrong in a catalogue; `faults` has an error for each place, its own words are those of the first."""

    def __init__(self, faults: Sequence[InputError]) -> None:
        first, self.faults = faults[0], tuple(faults)
        more = f"; and {count(len(faults) - 1, 'more fault')}" if faults[1:] else ""
        super().__init__(f"{first.what}{more}", remedy=first.remedy, file=first.file, line=first.line)


class _Column(NamedTuple):
    """A column: what its cells are, the units that its header may name with what they are in SI (the first without
    any), whether a row must have it (a limit may be `UNKNOWN`), and from where on a number looks like another unit."""

    cells: Literal["number", "curve", "numbers", "names", "text"]
    units: dict[str, float] = {}  # noqa: RUF012
    needed: bool = True
    limit: bool = False
    doubtful: float = math.inf


_TORQUE = {"N m": 1.0, "mN m": 1e-3, "N cm": 1e-2, "N": 1.0, "kN": 1e3}
_SPEED = {"rad/s": 1.0, "rpm": pi / 30.0, "m/s": 1.0, "mm/s": 1e-3}
_INERTIA = {"kg m^2": 1.0, "kg cm^2": 1e-4, "g cm^2": 1e-7, "kg": 1.0}
_MASS = _Column("number", {"kg": 1.0, "g": 1e-3}, doubtful=300.0)
_OPTIONAL, _NAME = _Column("number", needed=False), _Column("text")
_FASTEST, _ROTOR = _Column("number", _SPEED, limit=True, doubtful=2000.0), _Column("number", _INERTIA, doubtful=0.2)
MOTOR_COLUMNS = {
    "name": _NAME,
    "inertia": _ROTOR,
    "continuous_torque": _Column("curve", _TORQUE, limit=True),
    "peak_torque": _Column("curve", _TORQUE, limit=True),
    "max_speed": _FASTEST,
    "mass": _MASS,
    "kind": _Column("text", needed=False),
    "price": _OPTIONAL,
    "resistance": _Column("number", {"ohm": 1.0, "mohm": 1e-3}, needed=False),
    "torque_constant": _Column("number", {"N m/A": 1.0, "mN m/A": 1e-3, "N/A": 1.0}, needed=False),
    "joints": _Column("names", needed=False),
}
GEAR_COLUMNS = {
    "name": _NAME,
    "ratio": _Column("numbers", needed=False),
    "lead": _Column("number", {"m": 1.0, "mm": 1e-3}, needed=False, doubtful=1.0),
    "efficiency": _Column("number", {"1": 1.0, "%": 1e-2}),
    "peak_torque": _Column("number", _TORQUE, limit=True),
    "average_torque": _Column("number", _TORQUE, limit=True),
    "max_input_speed": _FASTEST,
    "inertia": _ROTOR,
    "mass": _MASS,
    "price": _OPTIONAL,
}
_ZERO = ("inertia", "mass", "price")
_HEADER = re.compile(r"([^\[\]]*?)\s*(?:\[([^\[\]]*)\])?")
_POINTS = "points are speed:torque between blanks, with speeds that increase from 0 on: 0:1.3 300:0.9"


class _Table:
    """A catalogue that is read row by row; what is wrong is gathered with its line and column."""

    def __init__(self, path: str, what: str, columns: dict[str, _Column]) -> None:
        self.file, self.what, self.columns = "<stdin>" if path == "-" else path, what, columns
        self.faults: list[InputError] = []
        self.notes: list[str] = []
        self.line: int | None = None
        self.cells: dict[str, str] = {}
        self.units: dict[str, tuple[float, float] | None] = {}
        most = limits().catalogue_bytes
        try:
            self.data = read_standard_input() if path == "-" else read_input(path, most + 1, typed=True)
        except (OSError, ValueError) as error:
            why = (getattr(error, "strerror", None) or str(error)).lower()
            raise InputError(f"cannot be read: {why}", remedy="check the name; --init writes one", file=path) from None
        if len(self.data) > most:
            raise beyond("catalogue_bytes", "too many bytes", InputError, file=self.file)

    def fault(self, what: str, remedy: str, column: str = "") -> None:
        where = f"column {shown(column)}: " if column else ""
        self.faults.append(InputError(f"{where}{what}", remedy=remedy, file=self.file, line=self.line))
        if len(self.faults) == _MOST_FAULTS:
            more = InputError(
                "the rest is not read", remedy="put these faults right first", file=self.file, line=self.line
            )
            raise CatalogueError([*self.faults, more])

    def rows(self) -> Iterator[dict[str, Any]]:
        """Yield the values of each row by column, in SI, None where there is none; those with faults are left out."""
        try:
            lines = self.data.decode("utf-8-sig").split("\n")
        except UnicodeDecodeError as error:
            self.line = self.data.count(b"\n", 0, error.start) + 1
            return self.fault("is not UTF-8 text", "save the table as CSV in UTF-8")
        numbered = [(k, text) for k, text in enumerate(lines, 1) if text.strip() and not text.lstrip().startswith("#")]
        delimiter = next((mark for mark in ",;\t" if numbered and mark in numbered[0][1]), ",")
        seen: dict[str, int] = {}
        names, missing = list[str](), list[str]()
        for k, (self.line, text) in enumerate(numbered):
            try:
                cells = [cell.strip() for cell in next(csv.reader([text], delimiter=delimiter, strict=True))]
            except csv.Error as error:
                self.fault(f"cannot be read: {error}", "see that quotes are closed and cells short")
                continue
            if k == 0:
                names, missing = self._header(cells)
                if not self.units:
                    return  # it is no catalogue
            elif len(cells) != len(names):
                what = f"{count(len(cells), 'cell')} where the header names {count(len(names), 'column')}"
                self.fault(what, "a cell for each column; points of a curve stand between blanks")
            else:
                self.cells, before = dict(zip(names, cells, strict=True)), len(self.faults)
                values = {name: self._value(name, self.columns[name]) for name in self.units}
                first = seen.setdefault(name := values.get("name") or "", self.line)
                if first != self.line and name:
                    self.fault(f"{shown(name)} is in line {first} too", "a name of its own for each", "name")
                if len(self.faults) == before and self.units.keys() == {*names} and not missing:
                    yield values
        if not seen and not self.faults:
            self.fault(f"has no {self.what}", f"a header of {listed(self.columns)}, and a row for each below")

    def _header(self, cells: Sequence[str]) -> tuple[list[str], list[str]]:
        """Return the names of columns, with units of those that are known, and those that are missing."""
        names = []
        for cell in cells:
            match = _HEADER.fullmatch(cell)
            name, unit = (match[1], match[2]) if match else (cell, None)
            known, parts = self.columns.get(name), [] if unit is None else [part.strip() for part in unit.split(":")]
            names.append(name)
            if known is None:
                self.fault(f"unknown column {shown(name)}", alternatives(name, self.columns, "columns"))
            elif names.count(name) > 1:
                self.fault(f"column {shown(name)} stands twice", "leave one of them out")
            elif unit is None or name == "price":
                self.units[name] = None
            elif parts[-1] in known.units and (parts[:-1] == [] or (known.cells == "curve" and parts[0] in _SPEED)):
                self.units[name] = (_SPEED[parts[0]] if parts[:-1] else 1.0), known.units[parts[-1]]
            else:
                of_curves = "; of curves such as [rpm:N m]" if known.cells == "curve" else ""
                self.fault(f"unknown unit {shown(unit)}", f"units: {listed(known.units) or 'none'}{of_curves}", name)
        missing = [name for name, known in self.columns.items() if known.needed and name not in names]
        if "lead" in self.columns and not {"ratio", "lead"} & {*names}:
            missing.append("ratio")
        if missing:
            self.fault(f"no column {listed(missing)}", "add it; robodyn size --init writes a whole table")
        return names, missing

    def _value(self, name: str, known: _Column) -> Any:
        """Return what a cell says, None if nothing or nothing that can be: this is a fault."""
        cell = self.cells[name]
        if known.cells == "names":
            return () if cell == UNKNOWN else tuple(cell.split())
        if not cell or (cell == UNKNOWN and not known.limit):
            if known.needed:
                unsaid = ", or - if it is not known, which then is not judged" if known.limit else ""
                self.fault("is empty" if not cell else "is not known", f"write it{unsaid}", name)
            return () if known.cells == "numbers" else None
        if known.cells == "text" or cell == UNKNOWN:
            return cell if known.cells == "text" else None
        if known.cells == "numbers":
            ratios = [self._number(name, word) for word in cell.split()]
            if len(set(ratios)) < len(ratios):
                self.fault(f"{shown(cell)} has a number twice", "each once: 50 80 100", name)
            return tuple(ratios)
        speed, factor = self.units[name] or (1.0, 1.0)
        if known.cells == "curve" and ":" in cell:
            return self._curve(name, cell, speed, factor)
        value = self._number(name, cell)
        if value is not None and self.units[name] is None and value > known.doubtful:
            unit, other, *_ = known.units
            doubt = f"line {self.line}: {name} {cell} is taken in {unit}; if it is not, name the unit in the header"
            self.notes.append(f"{doubt}: {name} [{other}]")
        return None if value is None else value * factor

    def _curve(self, name: str, cell: str, speed: float, torque: float) -> Curve | None:
        words = cell.split()
        pairs = [word.split(":") for word in words[: _MOST_POINTS + 1]]
        wrong = next((word for word, pair in zip(words, pairs, strict=False) if len(pair) != 2), None)
        points = [] if wrong else [(self._number(name, x, True), self._number(name, y, True)) for x, y in pairs]
        known = tuple((x * speed, y * torque) for x, y in points if x is not None and y is not None)
        if wrong:
            self.fault(f"{shown(wrong)} is no point of a curve", _POINTS, name)
        elif len(known) == len(points):
            if len(words) > _MOST_POINTS:
                self.fault(f"a curve of {len(words)} points", f"at most {_MOST_POINTS}: leave out those on lines", name)
            elif any(b[0] <= a[0] for a, b in pairwise(known)):
                self.fault(f"the speeds of {shown(cell)} do not increase", _POINTS, name)
            elif not max(y for _, y in known):
                self.fault(f"the torques of {shown(cell)} are all 0", _POINTS, name)
        return known

    def _number(self, name: str, cell: str, zero: bool = False) -> float | None:
        """Return a finite number that is positive, or 0 where that may be."""
        try:
            value = math.nan if "_" in cell else float(cell)
        except ValueError:
            value = math.nan
        if not abs(value) <= LARGEST:
            comma = re.fullmatch(r"[-+]?\d+,\d+", cell)
            remedy = "write decimals with a point" if comma else "write a finite number such as 1.5e-3"
            self.fault(f"{shown(cell)} is not a number", remedy, name)
        elif value < 0.0 or (value == 0.0 and not zero and name not in _ZERO):
            self.fault(f"is {cell}", "it is positive" if name not in _ZERO else "it is positive or zero", name)
        else:
            return value
        return None

    def finished(self, found: list[Any]) -> tuple[tuple[Any, ...], tuple[str, ...]]:
        """Return the rows, and what is doubtful or not judged; raise if something is wrong."""
        if self.faults:
            raise CatalogueError(self.faults)
        silent: dict[str, list[str]] = {}
        for name in (name for name, known in self.columns.items() if known.limit and name != "max_speed"):
            for each in found:
                if getattr(each, name) is None:
                    silent.setdefault(each.name, []).append(name)
        for names in dict.fromkeys(map(tuple, silent.values())):
            rows = [name for name, own in silent.items() if tuple(own) == names]
            self.notes.append(f"{' and '.join(names)} of {listed(rows)} not known, and not judged")
        return tuple(found), tuple(f"{self.file}: {note}" for note in self.notes)


def read_motors(path: str, joints: Collection[str]) -> tuple[tuple[CatalogueMotor, ...], tuple[str, ...]]:
    """Return the motors of a CSV table for a robot with these joints, and notes on it; `-` is standard input.

    Raises:
        CatalogueError: all that is wrong in the table, place by place.
    """
    table, found = _Table(path, "motor", MOTOR_COLUMNS), []
    for row in table.rows():
        motor = CatalogueMotor(**row | {"kind": row.get("kind") or "rotary"})
        _check_motor(table, motor)
        for name in motor.joints:
            if name not in joints:
                table.fault(f"there is no joint {shown(name)}", alternatives(name, joints, "joints"), "joints")
        found.append(motor)
    return table.finished(found)


def _check_motor(table: _Table, motor: CatalogueMotor) -> None:
    """Find what contradicts itself in a row."""
    fast, continuous, peak = motor.max_speed, motor.continuous_torque, motor.peak_torque
    if motor.kind not in ("rotary", "linear"):
        table.fault(f"is {shown(motor.kind)}", "rotary or linear", "kind")
    if (motor.resistance is None) != (motor.torque_constant is None):
        empty = "resistance" if motor.resistance is None else "torque_constant"
        table.fault("is empty", "the loss R (T / k)^2 takes resistance and torque_constant, or neither", empty)
    if fast is None and not isinstance(peak, tuple):
        table.fault("is not known", "write it, or peak_torque as a curve that ends there", "max_speed")
    for name, curve in (("continuous_torque", continuous), ("peak_torque", peak)):
        if isinstance(curve, tuple) and fast is not None:
            end, says = curve[-1][0], f"the curve ends at {curve[-1][0]:g} rad/s, max_speed is {fast:g} rad/s"
            if end * BEYOND < fast and name == "peak_torque":
                table.fault(says, f"write the curve to its end, or the unit of its speeds: {name} [rpm:N m]", name)
            elif end > 5.0 * fast:
                table.fault(says, f"name the unit of its speeds in the header: {name} [rpm:N m]", name)
    if continuous is None or peak is None:
        return
    (speeds, torques), (places, most) = (
        np.transpose(((0.0, of),) if isinstance(of, float) else of) for of in (continuous, peak)
    )
    for speed, torque, limit in zip(speeds, torques, np.interp(speeds, places, most), strict=True):
        if torque > limit * BEYOND:
            what = f"allows {torque:g} at {speed:g} rad/s, and peak_torque {limit:g}"
            return table.fault(what, "are they swapped, or in different units?", "continuous_torque")


def read_gears(path: str) -> tuple[tuple[CatalogueGear, ...], tuple[str, ...]]:
    """Return the gears of a CSV table, and notes on it; `-` is standard input.

    Raises:
        CatalogueError: all that is wrong in the table, place by place.
    """
    table, found = _Table(path, "gear", GEAR_COLUMNS), []
    for row in table.rows():
        gear = CatalogueGear(**{"ratio": (), "lead": None} | row)
        if bool(gear.ratio) == bool(gear.lead):
            table.fault("and lead are both given" if gear.lead else "and lead are both empty", "give one", "ratio")
        if gear.efficiency > 1.0:
            table.fault(f"is {gear.efficiency:g}", "a share above 0 and up to 1, or efficiency [%]", "efficiency")
        if (gear.average_torque or 0.0) > (gear.peak_torque or math.inf):
            what = f"is {gear.average_torque:g} N m, and peak_torque {gear.peak_torque:g}"
            table.fault(what, "are they swapped?", "average_torque")
        found.append(gear)
    return table.finished(found)


MOTORS_TEMPLATE = """\
# Motors, one a row; invented numbers, in the range of servo motors for robots. Lines that begin with # are comments.
# Units stand in the header, SI without: inertia [kg m^2, kg cm^2, g cm^2], torques [N m, mN m], max_speed [rad/s, rpm].
# A torque is one for all speeds, or a curve of speed:torque points between blanks, straight between them; [rpm:N m]
# names the units of both. - in place of a torque or a max_speed: not known, not judged (max_speed: the curve's end).
# Optional: kind (rotary or linear: then N, m/s, and kg of the moving part for the inertia), price, resistance [ohm] and
# torque_constant [N m/A] for copper loss R (T / k)^2, joints (names between blanks; all without).
name,inertia [kg cm^2],continuous_torque [rpm:N m],peak_torque [rpm:N m],max_speed [rpm],mass,price,resistance,torque_constant
M 20,0.012,0:0.080 4000:0.060 6000:0.045,0:0.25 4000:0.25 6000:0.12,6000,0.16,95,1.9,0.038
M 50,0.033,0:0.17 4000:0.15 6000:0.11,0:0.55 4000:0.55 6000:0.30,6000,0.29,120,1.1,0.045
M 100,0.06,0:0.34 3000:0.32 5000:0.25,0:1.05 3500:1.05 5000:0.60,5000,0.46,150,1.3,0.071
M 200,0.21,0:0.67 3000:0.64 5000:0.48,0:2.0 3500:2.0 5000:1.2,5000,0.82,190,0.95,0.10
M 400,0.39,0:1.35 3000:1.27 5000:0.90,0:4.0 3500:4.0 5000:2.2,5000,1.2,240,0.62,0.14
M 750,1.4,0:2.55 3000:2.39 4500:1.7,0:7.6 3200:7.6 4500:4.4,4500,2.3,330,0.38,0.20
M 1500,3.9,0:5.2 3000:4.77 4000:3.9,0:15 2800:15 4000:9.0,4000,4.4,520,0.21,0.29
"""  # noqa: E501
GEARS_TEMPLATE = """\
# Gears, one a row, in one or several ratios; invented numbers, in the range of strain wave gears, planets and screws.
# ratio: turns of the motor per turn of the joint, several between blanks; or lead [m, mm]: way of a screw per turn, of
# prismatic joints. peak_torque and average_torque (cubic mean) at the output [N m; N of a screw], inertia at the input.
# - in place of a limit: not known, not judged. Optional: price, joints. A motor without gear is a row of ratio 1.
name,ratio,lead [mm],efficiency [%],peak_torque,average_torque,max_input_speed [rpm],inertia [kg cm^2],mass,price
W 8,30 50 80 100,-,70,4.8,3.3,8500,0.003,0.11,410
W 14,50 80 100,-,75,28,11,8500,0.033,0.24,520
W 17,50 80 100 120,-,75,54,27,7300,0.079,0.36,610
W 20,50 80 100 120 160,-,75,92,49,6500,0.19,0.52,700
W 25,50 80 100 120 160,-,75,176,108,5600,0.41,0.86,880
W 32,50 80 100 120 160,-,75,333,216,4800,1.7,1.8,1250
P 60,5 10 25,-,94,40,16,6000,0.06,0.9,260
S 10,-,10,90,3000,1500,4000,0.10,0.6,180
S 20,-,20,90,4000,2000,4000,0.13,0.8,210
S 50,-,50,92,5000,2500,4000,0.25,1.2,290
direct,1,-,100,-,-,-,0,0,0
"""
