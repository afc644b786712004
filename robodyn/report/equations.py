"""The equations of motion: the ODE form in numbers, and the closed form."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from robodyn.equations.closed import STATES, Closed, decimal
from robodyn.equations.ode import Ode
from robodyn.report.document import Paragraph, Section, Table, paragraphs, remarks
from robodyn.report.table import Content, gravity_text, number, relative_text
from robodyn.support.wording import count

DIGITS = 15


def ode_sections(ode: Ode) -> Iterator[Section]:
    """Yield configuration, mass matrix and the parts of the bias."""
    largest = float(abs(ode.M).max())
    rows = [(name, *(number(x, largest) for x in row)) for name, row in zip(ode.rates, ode.M.tolist(), strict=True)]
    yield paragraphs(
        [_head(ode.robot, len(ode.rates), ode.gravity, "base_qx" in ode.coordinates), _equation(ode.shares)]
    )
    yield [Table("Configuration", *_configuration(ode))]
    mass = Table("Mass matrix M(q) [kg m^2, kg m or kg]", ("", *ode.rates), rows)
    yield [mass, Paragraph(_condition(ode.cond))]
    yield [Table("What tau must supply where nothing accelerates", *_bias(ode))]
    yield remarks("warning", ode.warnings)


def closed_sections(closed: Closed) -> Iterator[Section]:
    """Yield every entry on a line, in a syntax that Python reads, constants with up to 15 digits."""
    n = len(closed.joints)
    joints = enumerate(zip(closed.joints, closed.kinds, closed.q, closed.qd, strict=True), 1)
    yield paragraphs([_head(closed.robot, n, closed.gravity), _equation(closed.bias)])
    units = {"prismatic": "m"}
    names = [f"{i}  {name}: {kind}, {q} [{units.get(kind, 'rad')}], {qd}" for i, (name, kind, q, qd) in joints]
    yield paragraphs(["Coordinates", *names])
    mass = [f"M[{i + 1},{j + 1}] = {_written(closed.M[i][j])}" for i in range(n) for j in range(i, n)]
    yield paragraphs(["Mass matrix, symmetric", *mass])
    for effect, entries in closed.bias.items():
        name = effect.replace(" ", "_")
        lines = [f"{name}[{i}] = {_written(entry)}" for i, entry in enumerate(entries, 1)]
        yield paragraphs([effect.capitalize(), *lines])
    yield [Paragraph(checked(closed))]


def checked(closed: Closed) -> str:
    """Return how far the closed form was found to be from the recursion."""
    plain = f"; {closed.plain} entries are not simplified" if closed.plain else ""
    return (
        f"Checked against the recursion in numbers at {STATES} random states: "
        f"largest difference {relative_text(closed.error)} of the largest entry of its unit{plain}."
    )


def _head(robot: str, n: int, gravity: tuple[float, float, float], moving: bool = False) -> str:
    return f"{robot}: {count(n, 'coordinate')}, {base_text(moving)}, {gravity_text(gravity)}"


def base_text(moving: bool) -> str:
    """Return whether the base is held, which a description does not say."""
    return "the base moves" if moving else "the base is bolted down"


def _equation(effects: Any) -> str:
    return " + ".join(["M(q) qdd", *effects]) + " = tau"


def _configuration(ode: Ode) -> Content:
    if len(ode.q) == len(ode.qd):
        rows = zip(ode.coordinates, ode.q.tolist(), ode.qd.tolist(), strict=True)
        return ("joint", "q", "qd"), [(name, f"{x:.6g}", f"{speed:.6g}") for name, x, speed in rows]
    pairs = [*zip(ode.coordinates, ode.q.tolist(), strict=True)]
    pairs += [(f"{name} per s", speed) for name, speed in zip(ode.rates, ode.qd.tolist(), strict=True) if speed]
    return ("coordinate", "value"), [(name, f"{x:.6g}") for name, x in pairs]


def _condition(cond: float) -> str:
    if cond == float("inf"):
        return "M is singular to working precision: nothing resists some motion"
    return f"Condition number {cond:.4g}"


def _bias(ode: Ode) -> Content:
    columns: Sequence[Any] = [*ode.shares.values(), ode.bias]
    scale = max(float(abs(column).max()) for column in columns)
    rows = [
        (name, *(number(float(column[i]), scale) for column in columns), ode.units[i])
        for i, name in enumerate(ode.rates)
    ]
    return ("joint", *ode.shares, "together", "unit"), rows


def _written(expression: Any) -> str:
    from sympy.printing.str import StrPrinter

    class Written(StrPrinter):  # type: ignore[misc,unused-ignore]
        def _print_Float(self, value: Any) -> str:
            return f"{float(value):.{DIGITS}g}"

    return str(Written().doprint(decimal(expression)))
