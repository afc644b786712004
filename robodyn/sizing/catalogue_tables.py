"""Catalogues of motors and of gears as CSV: a row each, units in the header, every fault with its line and column."""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, fields
from itertools import pairwise
from math import pi
from typing import Any, NamedTuple

import numpy as np

from robodyn.errors import InputError
from robodyn.scene.scene import Curve
from robodyn.support.floats import LARGEST
from robodyn.support.input_file import beyond, limits, read_input, read_standard_input
from robodyn.support.wording import alternatives, count, listed, shown

UNKNOWN = "-"
"""In the cell of a limit that a data sheet does not tell: it is not judged."""
_MOST_POINTS = 200
"""Points of a curve."""


@dataclass(frozen=True)
class CatalogueMotor:
    """A motor of a catalogue; speeds and torques at its shaft, rad/s and N m; of a linear motor m/s and N.

    Attributes:
        linear: whether it pushes a slide without a gear; `inertia` then is the mass of its moving part [kg].
        continuous, peak: torque for ever and for moments, one for all speeds or a curve; None: not judged.
        max_speed: None: where the curve `peak` ends.
        resistance, torque_constant: R and k, so that a torque T heats the winding with R (T / k)^2 [ohm, N m/A].
        joints: the only ones that it may drive; all without.
    """

    name: str
    inertia: float
    continuous: float | Curve | None
    peak: float | Curve | None
    max_speed: float | None
    mass: float
    linear: bool = False
    price: float | None = None
    resistance: float | None = None
    torque_constant: float | None = None
    joints: tuple[str, ...] = ()

    @property
    def speed_limit(self) -> float | None:
        return self.peak[-1][0] if self.max_speed is None and isinstance(self.peak, tuple) else self.max_speed


@dataclass(frozen=True)
class CatalogueGear:
    """A gear of a catalogue, in one or more ratios; a screw or a rack has `lead` instead, and moves prismatic joints.

    Attributes:
        ratios: turns of the motor per turn of the joint; of a screw 2 pi / lead [rad/m].
        peak, average: what it bears at its output, for moments and as cubic mean [N m, N]; None: not judged.
        max_input_speed: rad/s; inertia: at its input [kg m^2].
    """

    name: str
    ratios: tuple[float, ...]
    efficiency: float
    peak: float | None
    average: float | None
    max_input_speed: float | None
    inertia: float = 0.0
    mass: float = 0.0
    price: float | None = None
    screw: bool = False
    joints: tuple[str, ...] = ()


class CatalogueError(InputError):
    """What is wrong in a catalogue; `faults` has an error for each place, its own words are those of the first."""

    def __init__(self, faults: Sequence[InputError]) -> None:
        first, self.faults = faults[0], tuple(faults)
        more = f"; {count(len(faults) - 1, 'more fault')} below" if faults[1:] else ""
        super().__init__(f"{first.what}{more}", remedy=first.remedy, file=first.file, line=first.line)


class _Column(NamedTuple):
    """A column: the units that its header may name, with what they are in SI, the first without any; whether a row must
    have it; whether a curve may stand there; from where on a number without a unit looks like another unit."""

    units: dict[str, float]
    needed: bool = True
    limit: bool = False
    curve: bool = False
    doubtful: float = math.inf
    zero: bool = False


_TORQUE = {"N m": 1.0, "mN m": 1e-3, "N cm": 1e-2, "kN m": 1e3, "N": 1.0, "kN": 1e3}
_SPEED = {"rad/s": 1.0, "rpm": pi / 30.0, "m/s": 1.0, "mm/s": 1e-3}
_INERTIA = {"kg m^2": 1.0, "kg cm^2": 1e-4, "g cm^2": 1e-7, "kg": 1.0}
_MASS, _LENGTH = {"kg": 1.0, "g": 1e-3}, {"m": 1.0, "mm": 1e-3}
_COMMON = {"price": _Column({}, needed=False, zero=True), "joints": _Column({}, needed=False)}
MOTOR_COLUMNS = {
    "name": _Column({}),
    "inertia": _Column(_INERTIA, doubtful=0.2, zero=True),
    "continuous_torque": _Column(_TORQUE, limit=True, curve=True),
    "peak_torque": _Column(_TORQUE, limit=True, curve=True),
    "max_speed": _Column(_SPEED, limit=True, doubtful=2000.0),
    "mass": _Column(_MASS, doubtful=300.0, zero=True),
    "kind": _Column({}, needed=False),
    "resistance": _Column({"ohm": 1.0, "mohm": 1e-3}, needed=False, doubtful=500.0),
    "torque_constant": _Column({"N m/A": 1.0, "mN m/A": 1e-3, "N/A": 1.0}, needed=False),
    **_COMMON,
}
GEAR_COLUMNS = {
    "name": _Column({}),
    "ratio": _Column({}, needed=False),
    "lead": _Column(_LENGTH, needed=False, doubtful=1.0),
    "efficiency": _Column({"1": 1.0, "%": 1e-2}),
    "peak_torque": _Column(_TORQUE, limit=True),
    "average_torque": _Column(_TORQUE, limit=True),
    "max_input_speed": _Column(_SPEED, limit=True, doubtful=2000.0),
    "inertia": _Column(_INERTIA, doubtful=0.2, zero=True),
    "mass": _Column(_MASS, doubtful=300.0, zero=True),
    **_COMMON,
}
_HEADER = re.compile(r"\s*([^\[\]]*?)\s*(?:\[([^\[\]]*)\])?\s*")
Fault = Callable[[str, str], None]


class _Row:
    """A row whose cells are taken by column; what is wrong in them is gathered."""

    def __init__(self, table: _Reading, line: int, cells: dict[str, str]) -> None:
        self.table, self.line, self.cells = table, line, cells

    def fault(self, column: str, what: str, remedy: str) -> None:
        self.table.fault(f"column {shown(column)}: {what}", remedy, self.line)

    def text(self, column: str) -> str:
        cell = self.cells.get(column, "")
        return "" if cell == UNKNOWN and not self.table.columns[column].limit else cell

    def number(self, column: str) -> float | None:
        """Return the number of a cell in SI; None, which is told where a row must have it, if there is none."""
        known, cell = self.table.columns[column], self.text(column)
        if known.limit and cell == UNKNOWN:
            return None
        if not cell:
            if known.needed:
                unsaid = ", or - if it is not known, which is then not judged" if known.limit else ""
                self.fault(column, "is empty", f"write the number{unsaid}")
            return None
        value = self._parsed(column, cell)
        if value is None:
            return None
        if value < 0.0 or (value == 0.0 and not known.zero):
            self.fault(column, f"is {cell}", "it is positive or zero" if known.zero else "it is positive")
            return None
        _, factor, said = self.table.units[column]
        if not said and value > known.doubtful:
            units = [unit for unit in known.units if known.units[unit] < 1.0] or ["..."]
            what = f"line {self.line}, {column}: {cell} is taken as {value:g} {next(iter(known.units))}"
            self.table.notes.append(f"{what}; if it is meant in another unit, name it in the header: [{units[0]}]")
        return value * factor

    def torque(self, column: str) -> float | Curve | None:
        """Return a torque, or a curve of `speed:torque` points, in SI."""
        if ":" not in self.text(column):
            return self.number(column)
        points: list[tuple[float, float]] = []
        remedy = "points are speed:torque between blanks, with speeds that increase from 0 on: 0:1.3 300:0.9"
        for word in (words := self.text(column).split()[: _MOST_POINTS + 1]):
            pair = [self._parsed(column, part) for part in word.split(":")] if word.count(":") == 1 else []
            if len(pair) != 2 or None in pair:
                if None not in pair:
                    self.fault(column, f"{shown(word)} is no point of a curve", remedy)
                return None
            points.append((pair[0] or 0.0, pair[1] or 0.0))
        speeds, torques = zip(*points, strict=True)
        if len(words) > _MOST_POINTS:
            self.fault(column, f"the curve has over {_MOST_POINTS} points", "leave out those on straight lines")
        elif speeds[0] < 0.0 or any(b <= a for a, b in pairwise(speeds)):
            self.fault(column, f"the speeds of the curve do not increase from 0 on: {self.text(column):.60}", remedy)
        elif min(torques) < 0.0 or not max(torques):
            self.fault(column, f"the torques of the curve are not positive: {self.text(column):.60}", remedy)
        else:
            speed, torque, _ = self.table.units[column]
            return tuple((x * speed, y * torque) for x, y in points)
        return None

    def _parsed(self, column: str, cell: str) -> float | None:
        try:
            value = math.nan if "_" in cell else float(cell)
        except ValueError:
            value = math.nan
        if abs(value) <= LARGEST:
            return value
        comma = re.fullmatch(r"[-+]?\d+,\d+", cell)
        remedy = "write decimals with a point" if comma else "write a finite number such as 1.5e-3"
        self.fault(column, f"{shown(cell)} is not {'a number' if value != value else 'a finite number'}", remedy)
        return None

    def price(self) -> float | None:
        return self.number("price")

    def joints(self) -> tuple[str, ...]:
        return tuple(self.text("joints").split())


class _Reading:
    """The header and the rows of a catalogue; faults and doubts of it."""

    def __init__(self, file: str, what: str, columns: dict[str, _Column]) -> None:
        self.file, self.what, self.columns = file, what, columns
        self.faults: list[InputError] = []
        self.notes: list[str] = []
        self.units: dict[str, tuple[float, float, bool]] = {}

    def fault(self, what: str, remedy: str, line: int | None = None) -> None:
        self.faults.append(InputError(what, remedy=remedy, file=self.file, line=line))

    def rows(self, data: bytes) -> Iterator[_Row]:
        """Yield the rows; what is no row of as many cells as the header has is a fault."""
        if len(data) > limits().catalogue_bytes:
            raise beyond("catalogue_bytes", "too many bytes", InputError, file=self.file)
        try:
            text = data.decode("utf-8-sig")
        except UnicodeDecodeError as error:
            line = data.count(b"\n", 0, error.start) + 1
            self.fault("is not UTF-8 text", "save the table as CSV in UTF-8", line)
            return
        lines = text.splitlines() if "\0" not in text else []
        first = next((k for k, each in enumerate(lines) if each.strip() and not each.lstrip().startswith("#")), None)
        if first is None:
            self.fault("has no table", f"the header names columns: {', '.join(self.columns)}", None)
            return
        delimiter = next((mark for mark in ",;\t" if mark in lines[first]), ",")
        names = self._header([cell.strip() for cell in lines[first].split(delimiter)], first + 1)
        seen: dict[str, int] = {}
        for line, each in enumerate(lines[first + 1 :], start=first + 2):
            if not each.strip() or each.lstrip().startswith("#"):
                continue
            try:
                cells = [cell.strip() for cell in next(csv.reader(io.StringIO(each), delimiter=delimiter, strict=True))]
            except csv.Error as error:
                self.fault(f"cannot be read: {error}", "close the quotes", line)
                continue
            if len(cells) != len(names):
                what = f"{count(len(cells), 'cell')} where the header names {count(len(names), 'column')}"
                self.fault(what, "a cell for each column; points of a curve stand between blanks", line)
                continue
            row = _Row(self, line, dict(zip(names, cells, strict=True)))
            name = row.text("name")
            if not name:
                row.fault("name", "is empty", f"name the {self.what}")
            elif name in seen:
                row.fault("name", f"{shown(name)} is in line {seen[name]} too", "give each a name of its own")
            seen.setdefault(name, line)
            yield row
        if not seen and not self.faults:
            self.fault(f"has no {self.what}", "write a row for each below the header", None)

    def _header(self, cells: Sequence[str], line: int) -> list[str]:
        names = []
        for cell in cells:
            match = _HEADER.fullmatch(cell.strip('"'))
            name, unit = (match[1], match[2]) if match else (cell, None)
            known = self.columns.get(name)
            names.append(name)
            if known is None:
                self.fault(f"unknown column {shown(name)}", alternatives(name, self.columns, "columns"), line)
            elif names.count(name) > 1:
                self.fault(f"column {shown(name)} stands twice", "leave one of them out", line)
            else:
                self.units[name] = self._unit(name, known, unit, line)
        missing = [name for name, known in self.columns.items() if known.needed and name not in names]
        if "ratio" in self.columns and not {"ratio", "lead"} & {*names}:
            missing.append("ratio")
        if missing:
            self.fault(f"no column {listed(missing)}", "add it; robodyn size --init writes a whole table", line)
        return names

    def _unit(self, name: str, known: _Column, text: str | None, line: int) -> tuple[float, float, bool]:
        """Return the factors to SI of the speeds of a curve and of the numbers, and whether the header says them."""
        parts = [] if text is None else [part.strip() for part in text.split(":")]
        speeds = _SPEED if known.curve and len(parts) == 2 else {}
        if text is None:
            return 1.0, 1.0, False
        if parts[-1] in known.units and (len(parts) == 1 or (len(parts) == 2 and parts[0] in speeds)):
            return speeds.get(parts[0], 1.0), known.units[parts[-1]], True
        valid = ", ".join(known.units) or "none"
        remedy = f"units: {valid}" + ("; of curves such as [rpm:N m]" if known.curve else "")
        self.fault(f"column {shown(name)}: unknown unit {shown(text)}", remedy, line)
        return 1.0, 1.0, True


def read_motors(path: str) -> tuple[tuple[CatalogueMotor, ...], tuple[str, ...]]:
    """Return the motors of a CSV table, and doubts about its units; `-` is standard input.

    Raises:
        CatalogueError: all that is wrong in the table, place by place.
    """
    reading, found = _Reading(_named(path), "motor", MOTOR_COLUMNS), []
    for row in reading.rows(_bytes(path)):
        before = len(reading.faults)
        kind = row.text("kind") or "rotary"
        if kind not in ("rotary", "linear"):
            row.fault("kind", f"is {shown(kind)}", "rotary or linear")
        inertia, mass, fastest = row.number("inertia"), row.number("mass"), row.number("max_speed")
        continuous, peak = row.torque("continuous_torque"), row.torque("peak_torque")
        resistance, constant = row.number("resistance"), row.number("torque_constant")
        price = row.price()
        if (resistance is None) != (constant is None) and len(reading.faults) == before:
            empty = "resistance" if resistance is None else "torque_constant"
            row.fault(empty, "is empty", "copper loss R (T / k)^2 needs resistance and torque_constant, or neither")
        if len(reading.faults) == before:
            _check_motor(row, continuous, peak, fastest)
        if len(reading.faults) == before and inertia is not None and mass is not None:
            each = (row.text("name"), inertia, continuous, peak, fastest, mass, kind == "linear", price)
            found.append(CatalogueMotor(*each, resistance, constant, row.joints()))
    return _checked(reading, found)


def _check_motor(row: _Row, continuous: float | Curve | None, peak: float | Curve | None, fast: float | None) -> None:
    if fast is None and not isinstance(peak, tuple):
        row.fault("max_speed", "is not known", "write it, or give peak_torque as a curve that ends there")
    if isinstance(peak, tuple) and fast is not None and peak[-1][0] < fast * (1.0 - 1e-9):
        what = f"is {fast:g} rad/s, and the curve of peak_torque ends at {peak[-1][0]:g} rad/s"
        row.fault("max_speed", what, "write the curve to its end, or a unit of speeds: peak_torque [rpm:N m]")
    for name, curve in (("continuous_torque", continuous), ("peak_torque", peak)):
        if isinstance(curve, tuple) and fast is not None and curve[-1][0] > 5.0 * fast:
            what = f"the curve goes to {curve[-1][0]:g} rad/s, max_speed is {fast:g} rad/s"
            row.fault(name, what, f"name the unit of its speeds in the header: {name} [rpm:N m]")
    if continuous is None or peak is None:
        return
    (speeds, torques), (places, most) = (
        np.transpose(((0.0, of),) if isinstance(of, float) else of) for of in (continuous, peak)
    )
    for speed, torque, limit in zip(speeds, torques, np.interp(speeds, places, most), strict=True):
        if torque > limit * (1.0 + 1e-9):
            what = f"allows {torque:g} N m at {speed:g} rad/s and peak_torque {limit:g}"
            row.fault("continuous_torque", what, "are they swapped, or in different units?")
            return


def read_gears(path: str) -> tuple[tuple[CatalogueGear, ...], tuple[str, ...]]:
    """Return the gears of a CSV table, and doubts about its units; `-` is standard input.

    Raises:
        CatalogueError: all that is wrong in the table, place by place.
    """
    reading, found = _Reading(_named(path), "gear", GEAR_COLUMNS), []
    for row in reading.rows(_bytes(path)):
        before = len(reading.faults)
        lead, words = row.number("lead"), row.text("ratio").split()
        ratios = [row._parsed("ratio", word) for word in words]
        if (lead is None) == (not words) and len(reading.faults) == before:
            row.fault("ratio", "and lead are both empty" if not words else "and lead are both given", "give one")
        for ratio in ratios:
            if ratio is not None and (ratio <= 0.0 or ratios.count(ratio) > 1):
                row.fault("ratio", f"is {row.text('ratio'):.60}", "positive numbers, each once: 50 80 100")
                break
        given = [row.number(name) for name in ("efficiency", "peak_torque", "average_torque", "max_input_speed")]
        efficiency, peak, average, fastest = given
        inertia, mass, price = row.number("inertia"), row.number("mass"), row.price()
        if efficiency is not None and efficiency > 1.0:
            row.fault("efficiency", f"is {efficiency:g}", "a share above 0 and up to 1, or efficiency [%]")
        if average is not None and peak is not None and average > peak:
            row.fault("average_torque", f"is {average:g} N m, and peak_torque {peak:g}", "are they swapped?")
        if len(reading.faults) == before:
            assert efficiency is not None and inertia is not None and mass is not None
            turns = (2.0 * pi / lead,) if lead else tuple(each for each in ratios if each is not None)
            each = (row.text("name"), turns, efficiency, peak, average, fastest, inertia, mass, price)
            found.append(CatalogueGear(*each, lead is not None, row.joints()))
    return _checked(reading, found)


def _checked(reading: _Reading, found: list[Any]) -> tuple[tuple[Any, ...], tuple[str, ...]]:
    if reading.faults:
        raise CatalogueError(reading.faults)
    for each in fields(found[0]):
        if each.name in ("continuous", "peak", "average", "max_input_speed"):
            silent = [one.name for one in found if getattr(one, each.name) is None]
            if silent:
                what = f"{each.name.replace('_', ' ')} of {reading.what} {listed(silent)} is not known, and not judged"
                reading.notes.append(what)
    return tuple(found), tuple(f"{reading.file}: {note}" for note in reading.notes)


def check_joints(rows: Collection[CatalogueMotor | CatalogueGear], known: Collection[str], file: str) -> None:
    """Raise CatalogueError if a catalogue names joints that a robot does not have."""
    faults = [
        InputError(f"{shown(row.name)}: there is no joint {shown(name)}", remedy=remedy, file=file)
        for row in rows
        for name in row.joints
        if name not in known
        for remedy in [alternatives(name, known, "joints")]
    ]
    if faults:
        raise CatalogueError(faults)


def _named(path: str) -> str:
    return "<stdin>" if path == "-" else path


def _bytes(path: str) -> bytes:
    try:
        return read_standard_input() if path == "-" else read_input(path, limits().catalogue_bytes + 1, typed=True)
    except (OSError, ValueError) as error:
        why = (getattr(error, "strerror", None) or str(error)).lower()
        raise InputError(f"cannot be read: {why}", remedy="check the name, or write one by --init", file=path) from None


MOTORS_TEMPLATE = """\
# Motors, one a row; invented numbers, in the range of servo motors for robots. Lines that begin with # are comments.
# Units stand in the header, SI without: inertia [kg m^2, kg cm^2, g cm^2], torques [N m, mN m], max_speed [rad/s, rpm].
# A torque is one for all speeds, or a curve of speed:torque points between blanks, straight between them; [rpm:N m]
# names the units of both. - in place of a torque or a max_speed: not known, not judged (max_speed: the curve's end).
# Optional: kind (rotary or linear: then N, m/s, and kg of the moving part for the inertia), price, resistance [ohm] and
# torque_constant [N m/A] for copper loss R (T / k)^2, joints (names between blanks; all without).
name,inertia [kg cm^2],continuous_torque [rpm:N m],peak_torque [rpm:N m],max_speed [rpm],mass,price,resistance,torque_constant [N m/A]
M 20,0.012,0:0.080 4000:0.060 6000:0.045,0:0.25 4000:0.25 6000:0.12,6000,0.16,95,1.9,0.038
M 50,0.033,0:0.17 4000:0.15 6000:0.11,0:0.55 4000:0.55 6000:0.30,6000,0.29,120,1.1,0.045
M 100,0.06,0:0.34 3000:0.32 5000:0.25,0:1.05 3500:1.05 5000:0.60,5000,0.46,150,1.3,0.071
M 200,0.21,0:0.67 3000:0.64 5000:0.48,0:2.0 3500:2.0 5000:1.2,5000,0.82,190,0.95,0.10
M 400,0.39,0:1.35 3000:1.27 5000:0.90,0:4.0 3500:4.0 5000:2.2,5000,1.2,240,0.62,0.14
M 750,1.4,0:2.55 3000:2.39 4500:1.7,0:7.6 3200:7.6 4500:4.4,4500,2.3,330,0.38,0.20
M 1500,3.9,0:5.2 3000:4.77 4000:3.9,0:15 2800:15 4000:9.0,4000,4.4,520,0.21,0.29
"""
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
