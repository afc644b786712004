"""How often the largest torque of a motion is within the bar that is printed with it, and how often verdicts mislead.

Random motions that are known exactly, on robots of `robots/` and a UR5, are read in every way that tables come to be.
The truth is inverse dynamics along the exact motion: the largest |torque| of each joint at the instants of the samples,
on both sides of a jump that lies on one, which is what a peak claims; and the largest between first and last sample, on
a grid 20 times finer and on both sides of every jump. Two halves of the seeds share nothing: one to tune on, one to
publish, `cd tests && python -m benchmarks.peak_bar_coverage`; tests draw a third.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import deepcopy
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from helpers.exact_motions import MOTIONS, Array, Course, course
from helpers.example_robots import PATHS
from helpers.markdown_tables import main
from helpers.markdown_tables import table as markdown
from helpers.oracles import ROBOTS
from helpers.read_motions import GIVEN, READINGS, Table, read

import robodyn

HALVES = {"tune": 0, "publish": 1, "test": 2}
HERTZ = (100, 250, 500, 1000)
FINER = 20
SHARES = (0.4, 0.1, 0.12, 0.1, 0.16, 0.12)
"""How often each of `GIVEN` is drawn."""
ROBOT_FILES = [ROBOTS / f"{name}.urdf" for name in ("two_link_planar", "scara", "cylindrical", "puma560")]
ROBOT_FILES += [path for path in PATHS if path.name == "ur5_robot.urdf"][:1]
PITCH = 0.01
"""Metres that a prismatic joint moves while its motor turns by a radian."""
BELOW, ABOVE = 0.985, 1.05
"""Effort limits, of the true largest torque: one that is exceeded, one that is kept."""
JUDGED = 3
"""So many joints of each motion get such limits, one at a time."""
NARROW = 0.02
"""Bars below this share of the peak are to tell a limit 5 % above it from one that is exceeded."""
MOST = {"effort": 900.0, "velocity": 90.0}
"""Limits of joints that are not judged: beyond every motion here."""
ENOUGH, GREEN = 0.93, 0.02


@dataclass(frozen=True)
class Load:
    """What is printed of one joint's largest torque, and what it is.

    Attributes:
        true, between: largest |torque| at the samples, and of the motion [N m or N].
        peak, bar: as printed; the bar is infinite where there is none.
        scale: largest torque of the robot, of which 1e-9 is rounding.
    """

    joint: str
    true: float
    between: float
    peak: float
    bar: float
    scale: float

    def holds(self, true: float) -> bool:
        """Whether the bar covers it, or the four digits of the peak that are printed."""
        digits = 0.5 * 10.0 ** (np.floor(np.log10(max(self.peak, 1e-300))) - 3)
        return bool(abs(self.peak - true) <= self.bar + digits + 1e-9 * self.scale)


@dataclass(frozen=True)
class Case:
    """One motion, read once, and what came of it.

    Attributes:
        loads: of each joint.
        verdicts: of joints that had a limit, one at a time: the limit's share of the true largest torque, and
            `within_limits`.
        refused: why the table was refused, which leaves nothing to judge.
    """

    labels: tuple[str, ...]
    robot: str
    draw: int
    loads: tuple[Load, ...] = ()
    verdicts: tuple[tuple[Load, float, bool | None], ...] = ()
    refused: str = ""

    def told(self, *shares: float) -> list[bool | None]:
        """The verdicts on limits of these shares, by default on the random ones."""
        of = shares or tuple({share for _, share, _ in self.verdicts} - {BELOW, ABOVE})
        return [verdict for _, share, verdict in self.verdicts if share in of]


@cache
def description(file: Path) -> ElementTree.Element:
    """The XML of a file."""
    return ElementTree.parse(file).getroot()


def robot_of(file: Path, joint: str | None = None, effort: float = MOST["effort"]) -> robodyn.Model:
    """The robot with this limit of effort of one joint, all other limits but those of position out of reach."""
    root = deepcopy(description(file))
    for each in root.iter("joint"):
        for limit in each.iter("limit"):
            own = {**MOST, "effort": effort} if each.get("name") == joint else MOST
            limit.attrib.update({key: repr(float(most)) for key, most in own.items()})
    return robodyn.load(ElementTree.tostring(root))


def largest(model: robodyn.Model, rates: Sequence[Array]) -> Array:
    """(joints,) largest |torque| along these samples."""
    return np.asarray(np.abs(robodyn.inverse_dynamics(model, *rates)).max(axis=0))


def case(kind: str, draw: int, half: str, judged: int = JUDGED) -> Case:
    """One draw of a class of motions, everything else random."""
    rng = np.random.default_rng([HALVES[half], list(MOTIONS).index(kind), draw])
    file = ROBOT_FILES[rng.integers(len(ROBOT_FILES))]
    hz = HERTZ[rng.integers(len(HERTZ))]
    reading, given = READINGS[draw % len(READINGS)], GIVEN[rng.choice(len(GIVEN), p=SHARES)]
    model = robot_of(file)
    joints = [body.joint for body in model.bodies if body.joint.kind in ("revolute", "continuous", "prismatic")]
    path = course(kind, rng, [range_of(joint) for joint in joints], 1 / hz)
    units = np.array([PITCH if joint.kind == "prismatic" else 1.0 for joint in joints])
    table = read(path, rng, hz, reading, given, units)
    true, between = truths(model, path, table, exact=given == "both")
    labels = (kind, reading, given, f"{hz} Hz")
    try:
        motion = robodyn.motion(model, table.time, table.q, table.qd, table.qdd, encoder_error=table.declared or 0.0)
        printed = robodyn.torques(model, motion).joints
    except robodyn.RobodynError as error:
        return Case(labels, file.stem, draw, refused=str(error))
    scale = float(true.max())
    loads = tuple(
        Load(found.name, float(a), float(b), abs(found.peak), bar_of(found), scale)
        for found, a, b in zip(printed, true, between, strict=True)
    )
    heavy = [load for load in loads if load.true > 1e-3 * scale]
    limits = (BELOW, float(rng.uniform(0.9, 0.99)), ABOVE)[:: 1 if judged == JUDGED else 2]
    verdicts = tuple(
        (load, share, robodyn.torques(robot_of(file, load.joint, share * load.true), motion).within_limits)
        for load in (heavy[k] for k in rng.permutation(len(heavy))[:judged])
        for share in limits
    )
    return Case(labels, file.stem, draw, loads, verdicts)


def range_of(joint: Any) -> tuple[float, float]:
    """Positions within a joint's limits [rad or m]."""
    lower, upper = joint.lower, joint.upper
    return (-3.0, 3.0) if lower is None or upper is None or upper - lower > 6.0 else (lower, upper)


def bar_of(found: Any) -> float:
    """The bar printed with a peak; none is infinite."""
    return np.inf if found.error_bar is None else float(found.error_bar)


def truths(model: robodyn.Model, path: Course, table: Table, exact: bool) -> tuple[Array, Array]:
    """(joints,) largest |torque| at the samples, and between; of exact rates in the table, what these say of a jump."""
    at = largest(model, path.at(table.instants) if exact else path.sides(table.instants))
    return at, np.maximum(at, largest(model, path.within(table.instants, FINER)))


HEAD = ("joints", "refused", "holds", "between", "bar / error", "bar / peak")
HEAD += ("green -1.5 %", "green -1..10 %", "red", "unsure")


def row(name: str, cases: Sequence[Case]) -> tuple[str, ...]:
    """The cells of a class: shares of joints and of verdicts; medians of bars over errors and over peaks."""
    judged = [each for each in cases if not each.refused]
    refused = f"{100 - 100 * len(judged) / len(cases):.1f} %"
    if not judged:
        return (name, "0", refused, *("-" for _ in HEAD[2:]))
    loads = [load for each in judged for load in each.loads]
    errors = [max(abs(load.peak - load.true), 1e-12 * load.scale) for load in loads]
    told = [one for each in judged for one in each.verdicts]
    narrow = [verdict for load, share, verdict in told if share == ABOVE and load.bar <= NARROW * load.true]
    verdicts = (
        [verdict is True for each in judged for verdict in each.told(BELOW)],
        [verdict is True for each in judged for verdict in each.told()],
        [verdict is False for verdict in narrow],
        [verdict is None for verdict in narrow],
    )
    held = ([load.holds(load.true) for load in loads], [load.holds(load.between) for load in loads])
    return (
        name,
        str(len(loads)),
        refused,
        *(f"{100 * np.mean(each):.1f} %" for each in held),
        f"{np.median([load.bar / error for load, error in zip(loads, errors, strict=True)]):.2g}",
        f"{100 * np.median([load.bar / max(load.true, 1e-300) for load in loads]):.2g} %",
        *(f"{100 * np.mean(each):.1f} %" if each else "-" for each in verdicts),
    )


def tables(cases: Sequence[Case]) -> str:
    """A table each by motion, by reading, by given rates and by rate of the samples; the last row is of all."""
    parts = []
    for k, names in enumerate((list(MOTIONS), READINGS, GIVEN, [f"{hz} Hz" for hz in HERTZ])):
        head = (("motion", "positions", "rates in the table", "samples")[k], *HEAD)
        of = {name: [each for each in cases if each.labels[k] == name] for name in names}
        rows = [row(name, own) for name, own in of.items() if own]
        parts.append(markdown(head, [*rows, *([row("all", cases)] if k == 3 else [])]))
    return "\n".join(parts)


def report(draws: int, tune: int) -> str:
    """Args: draws: motions of each class; tune: 1 for the half of the seeds that is not published."""
    return tables([case(kind, draw, "tune" if tune else "publish") for kind in MOTIONS for draw in range(draws)])


if __name__ == "__main__":
    main(report, __doc__, draws=30, tune=0)
