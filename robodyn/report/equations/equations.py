"""Equations of motion: the ODE form in numbers, the closed form, and free bodies with what acts on them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from robodyn.equations.closed import STATES, Closed
from robodyn.equations.free_body.bodies import Action, FreeBodies, FreeBody, JointRow
from robodyn.equations.ode import Ode
from robodyn.programs.vectors import product
from robodyn.report.document import Paragraph, Section, Table, finite, paragraphs, remarks, select, written
from robodyn.report.renderers.letters import text_of
from robodyn.report.sizes import Sizes, free_body_sizes
from robodyn.report.table import Content, axis_text, gravity_text, number, point_text, printable, relative_text
from robodyn.support.wording import count

_COMPONENTS = ("fx [N]", "fy", "fz", "mx [N m]", "my", "mz")


def ode_sections(ode: Ode) -> Iterator[Section]:
    """Yield configuration, mass matrix and the parts of the bias."""
    largest = float(abs(ode.M).max())
    rows = [(name, *(number(x, largest) for x in row)) for name, row in zip(ode.rates, ode.M.tolist(), strict=True)]
    yield paragraphs(
        [_head(ode.robot, len(ode.rates), ode.gravity, "base_qx" in ode.coordinates), _equation(ode.shares)]
    )
    cells = [(name, f"{x:.6g}") for name, x in zip(ode.coordinates, ode.q.tolist(), strict=True)]
    cells += [(f"{name} per s", f"{x:.6g}") for name, x in zip(ode.rates, ode.qd.tolist(), strict=True) if x]
    yield [Table("Configuration", ("coordinate", "value"), cells)]
    mass = Table("Mass matrix M(q) [kg m^2, kg m or kg]", ("", *ode.rates), rows)
    singular = "M is singular to working precision: nothing resists some motion"
    yield [mass, Paragraph(singular if ode.cond == float("inf") else f"Condition number {ode.cond:.4g}")]
    columns = [each.tolist() for each in (*ode.shares.values(), ode.bias)]
    scale = max(abs(x) for column in columns for x in column)
    rows = [(name, *(number(x[i], scale) for x in columns), ode.units[i]) for i, name in enumerate(ode.rates)]
    head = ("joint", *ode.shares, "together", "unit")
    yield [Table("What tau must supply where nothing accelerates", head, rows)]
    yield remarks("warning", ode.warnings)


def closed_sections(closed: Closed) -> Iterator[Section]:
    """Yield coordinates, letters, constants and every entry on a line."""
    n = len(closed.rates)
    yield paragraphs([_head(closed.robot, n, closed.gravity, "floating" in closed.kinds), _equation(closed.bias)])
    yield paragraphs(["Coordinates", *(f"{k}  {text}" for k, text in enumerate(coordinate_lines(closed), 1))])
    if closed.symbols:
        rows = [(letter.name, f"{letter.value:.15g}", printable(letter.meaning)) for letter in closed.symbols]
        yield [Table("Symbols", ("", "value", "meaning"), rows), Paragraph(NOTATION)]
    if closed.constants:
        yield paragraphs(["Constants", *(f"{name} = {text_of(x)}" for name, x in closed.constants.items())])
    entries: dict[str, list[str]] = {}
    for (name, i, j), entry in closed.entries.items():
        place = f"{i + 1}" if j < 0 else f"{i + 1},{j + 1}"
        entries.setdefault(name, []).append(f"{name.replace(' ', '_')}[{place}] = {text_of(entry)}")
    for name, lines in entries.items():
        yield paragraphs(["Mass matrix, symmetric" if name == "M" else name.capitalize(), *lines])
    yield [Paragraph(checked(closed))]


NOTATION = "c_2 is cos(q_2), s_23 sin(q_2 + q_3), c_223 cos(2 q_2 + q_3), and c_2^2 the square of c_2."
_UNITS = {"prismatic": "m", "revolute": "rad"}


def coordinate_lines(closed: Closed) -> Iterator[str]:
    """Yield name, kind and symbols of every coordinate."""
    for i, (name, kind, q, qd) in enumerate(zip(closed.rates, closed.kinds, closed.q, closed.qd, strict=True)):
        if q is None:
            what = "angular velocity of the base" if i < 3 else "velocity of the base's origin"
            unit, qdd = "rad/s" if i < 3 else "m/s", closed.qdd[i]
            yield f"{name}: {what} in its axes, {qd} [{unit}], {qdd} its acceleration"
        else:
            yield f"{name}: {kind}, {q} [{_UNITS[kind]}], {qd}"


def checked(closed: Closed) -> str:
    """Return how far the closed form was found to be from the recursion."""
    values = ", half of them at random values of the symbols" if closed.symbols else ""
    return (
        f"Checked against the recursion in numbers at {STATES} random states{values}: "
        f"largest difference {relative_text(closed.error)} of the largest entry of its unit."
    )


def _head(robot: str, n: int, gravity: tuple[float, float, float], moving: bool = False) -> str:
    return f"{robot}: {count(n, 'coordinate')}, {base_text(moving)}, {gravity_text(gravity)}"


def base_text(moving: bool) -> str:
    """Return whether the base is held, which a description does not say."""
    return "the base moves" if moving else "the base is bolted down"


def _equation(effects: Any) -> str:
    return " + ".join(["M(q) qdd", *effects]) + " = tau"


def free_body_sections(found: FreeBodies, state: str) -> Iterator[Section]:
    size = free_body_sizes(found)
    yield [Paragraph(f"{found.robot}: {len(found.bodies)} bodies, {state}, {gravity_text(found.gravity)}")]
    freedom, reactions = (sum(getattr(row, name) for row in found.joints) for name in ("freedom", "reactions"))
    many = len(found.joints)
    balanced = (
        f"{many} bodies x 6 equations = {6 * many} = {reactions} reactions + {freedom} along the degrees of freedom"
    )
    where = Paragraph(f"in the axes of the body that the joint carries; {balanced}")
    rows = []
    for row in found.joints:
        turns = row.kind == "revolute"
        along = "" if row.drive is None else size.amount(row.drive, "N m" if turns else "N")
        axis = axis_text(row.axis) if row.kind in ("revolute", "prismatic") else "-"
        cells = _cells(row, size)
        for k in range(6):  # a dash where the joint is free
            free = turns == (k >= 3) and axis != "-" and abs(row.axis[k % 3]) == 1.0
            cells[k] = "-" if free or row.kind == "floating" else cells[k]
        joint = (f"{row.number} {row.name}", f"{row.parent} - {row.child}", row.kind, axis)
        rows.append((*joint, str(row.freedom), str(row.reactions), *cells, along))
    yield [Table("Joints", ("joint", "between", "type", "axis", "f", "6 - f", *_COMPONENTS, "drive"), rows), where]
    for body in found.bodies:
        others = [name for name in body.links if name != body.name]
        fixed = f" with {', '.join(map(printable, others))}" if others else ""
        mass = f"{number(body.mass)} kg, mass centre {point_text(body.com, 1.0)} m" if body.mass else "no mass"
        title = f"Body {body.number}, {printable(body.name)}{fixed}: {mass}"
        place = f"its origin at {point_text(body.pose.p, 1.0)} m in the ground's frame; components in its own axes"
        yield [Paragraph(title), Table(place, *action_table(body, size))]
    off = f"{relative_text(found.residual_force)} and {relative_text(found.residual_moment)} of the largest"
    yield [Paragraph(f"Balance: forces, and moments about each body's origin, add up to zero within {off}")]
    yield remarks("warning", found.warnings)


def _cells(acting: Action | FreeBody | JointRow, size: Sizes) -> list[str]:
    return [size.number(x, "N") for x in acting.force] + [size.number(x, "N m") for x in acting.moment]


def action_table(body: FreeBody, size: Sizes) -> Content:
    """Return every force and moment on a body, and their sums."""
    rows = [(action.what, action.by, point_text(action.point, 1.0), *_cells(action, size)) for action in body.actions]
    rows.append(("sum", "", "", *_cells(body, size)))
    return ("", "by", "at [m]", *_COMPONENTS), rows


def free_bodies_json(found: FreeBodies, state: str) -> str:
    """Return vectors in each body's own axes, and forces and moments in the ground's too."""
    keys, joints, bodies = "number name parent child kind axis freedom reactions frame:child force moment drive", [], []
    for row in found.joints:
        joints.append(select(row, keys, axis=row.axis if row.kind in ("revolute", "prismatic") else None))
    for body in found.bodies:
        (R, p), actions = body.pose, []
        for action in body.actions:
            ground = {"point": p + product(R, action.point)}
            ground |= {name: product(R, getattr(action, name)) for name in ("force", "moment")}
            actions.append(select(action, "kind what by point force moment ground", ground=ground))
        given: dict[str, Any] = {"frame": select(body.pose, "rotation:R origin:p"), "actions": actions}
        given["sum"] = select(body, "force moment_about_origin:moment")
        bodies.append(select(body, "number name links mass com frame actions sum", **given))
    residual = {"force": found.residual_force, "moment": found.residual_moment}
    keys = "robot file state q qd qdd gravity tau joints bodies residual warnings"
    return written(select(found, keys, state=state, joints=joints, bodies=bodies, residual=residual))


def ode_json(ode: Ode) -> str:
    """Return the ODE form; a singular M has the condition null."""
    keys = "robot form gravity coordinates rates units q qd M condition bias shares warnings"
    return written(select(ode, keys, form="ode", condition=finite(ode.cond)))


def closed_json(closed: Closed) -> str:
    """Return the closed form; expressions are SymPy's, fractions exact."""
    names = [[None if x is None else str(x) for x in source] for source in (closed.q, closed.qd)]
    joints = zip(closed.rates, closed.kinds, *names, strict=True)
    return written(
        select(
            closed,
            "robot form gravity joints symbols constants M shares check",
            form="closed",
            joints=[dict(zip(("name", "kind", "q", "qd"), each, strict=True)) for each in joints],
            symbols=[select(letter, "name value meaning") for letter in closed.symbols],
            constants={str(name): str(whole) for name, whole in closed.constants.items()},
            M=[[str(entry) for entry in row] for row in closed.M],
            shares={name: list(map(str, entries)) for name, entries in closed.bias.items()},
            check={"states": STATES, "largest_difference": closed.error},
        )
    )
