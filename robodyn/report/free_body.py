"""Free bodies: the joint table, and a table of forces and moments for each body."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from robodyn.equations.free_body.types import Action, FreeBodies, FreeBody, JointRow
from robodyn.report.bodies import point_text
from robodyn.report.document import Paragraph, Section, Table, remarks
from robodyn.report.sizes import Sizes, free_body_sizes
from robodyn.report.table import Content, axis_text, gravity_text, number, printable, relative_text
from robodyn.support.floats import Floats


def free_body_sections(found: FreeBodies, state: str) -> Iterator[Section]:
    """Yield the report of one state."""
    size = free_body_sizes(found)
    yield [Paragraph(f"{found.robot}: {len(found.bodies)} bodies, {state}, {gravity_text(found.gravity)}")]
    yield [Table("Joints", *_joints(found, size)), Paragraph(_count(found.joints))]
    yield from (_body(body, size) for body in found.bodies)
    yield [
        Paragraph(
            "Balance: forces, and moments about each body's origin, add up to zero within "
            f"{relative_text(found.residual_force)} and {relative_text(found.residual_moment)} of the largest"
        )
    ]
    yield remarks("warning", found.warnings)


def _joints(found: FreeBodies, size: Sizes) -> Content:
    rows = []
    for row in found.joints:
        along = "" if row.drive is None else _amount(row, size)
        rows.append(
            (
                f"{row.number} {row.name}",
                f"{row.parent} - {row.child}",
                row.kind,
                _axis(row),
                str(row.freedom),
                str(row.reactions),
                *_components(row, size),
                along,
            )
        )
    head = ("joint", "between", "type", "axis", "f", "6 - f", "fx [N]", "fy", "fz", "mx [N m]", "my", "mz", "drive")
    return head, rows


def _axis(row: JointRow) -> str:
    if row.kind not in ("revolute", "prismatic"):
        return "-"
    return axis_text(row.axis)


def _amount(row: JointRow, size: Sizes) -> str:
    unit = "N m" if row.kind == "revolute" else "N"
    return f"{number(row.drive or 0.0, size[unit])} {unit}"


def _components(row: JointRow, size: Sizes) -> list[str]:
    """Return the six components that a joint transmits; a dash where it is free."""
    cells = [number(x, size["N"]) for x in row.force] + [number(x, size["N m"]) for x in row.moment]
    if row.kind == "floating":
        return ["-"] * 6
    for k in range(3):
        if row.kind in ("revolute", "prismatic") and abs(row.axis[k]) == 1.0:
            cells[k + (3 if row.kind == "revolute" else 0)] = "-"
    return cells


def _count(joints: Sequence[JointRow]) -> str:
    freedom, reactions = sum(row.freedom for row in joints), sum(row.reactions for row in joints)
    return (
        f"in the axes of the body that the joint carries; {len(joints)} bodies x 6 equations = {6 * len(joints)} "
        f"= {reactions} reactions + {freedom} along the degrees of freedom"
    )


def _body(body: FreeBody, size: Sizes) -> Section:
    others = [name for name in body.links if name != body.name]
    fixed = f" with {', '.join(map(printable, others))}" if others else ""
    mass = f"{number(body.mass)} kg, mass centre {point_text(body.com, 1.0)} m" if body.mass else "no mass"
    title = f"Body {body.number}, {printable(body.name)}{fixed}: {mass}"
    where = f"its origin at {point_text(body.pose.p, 1.0)} m in the ground's frame; components in its own axes"
    return [Paragraph(title), Table(where, *action_table(body, size))]


def action_table(body: FreeBody, size: Sizes) -> Content:
    """Return every force and moment on a body, and their sums."""
    rows = [_row(action, size) for action in body.actions]
    rows.append(("sum", "", "", *_vector(body.force, size["N"]), *_vector(body.moment, size["N m"])))
    return ("", "by", "at [m]", "fx [N]", "fy", "fz", "mx [N m]", "my", "mz"), rows


def _row(action: Action, size: Sizes) -> tuple[str, ...]:
    vectors = (*_vector(action.force, size["N"]), *_vector(action.moment, size["N m"]))
    return (action.what, action.by, point_text(action.point, 1.0), *vectors)


def _vector(vector: Floats, scale: float) -> list[str]:
    return [number(x, scale) for x in vector]
