"""The result of `excite`: how telling the motion is, what joints do, and how well parameters will be known."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from math import inf

from robodyn.identification.excitation.bounds import MARGIN
from robodyn.identification.excitation.result import Excitation, Information, JointSwing
from robodyn.report.document import (
    Block,
    Document,
    Gallery,
    Heading,
    Paragraph,
    Section,
    Table,
    Verdict,
    csv_text,
    data_blocks,
    on_page,
    paragraphs,
    remarks,
)
from robodyn.report.json.excitation import excitation_json
from robodyn.report.limits import use
from robodyn.support.wording import count, figure

_PICTURED = 12


def excitation_sections(found: Excitation) -> Iterator[Section]:
    """Yield how telling the motion is, what each joint does, and each base parameter's predicted standard error."""
    yield paragraphs(_head(found))
    head = ("joint", "from", "to", "unit", "speed", "acceleration", "effort", "noise")
    note = f"Largest magnitudes are of limits; positions keep {100 * MARGIN:.0f}% of the range from theirs."
    yield [Table("", head, [_joint(joint) for joint in found.joints], note)]
    rows = zip(found.base.short_groups, found.values.tolist(), found.information.standard_errors.tolist(), strict=True)
    title = ("base parameter", "value", "standard error", "relative")
    note = "Values are the description's; errors are those of least squares over all rows of one period, with noise"
    yield [Table("", title, [_parameter(*row) for row in rows], f"{note} independent from row to row.")]
    yield paragraphs([_invisible(found)])
    yield remarks("note", found.notes)


def excitation_page(found: Excitation, pictures: bool = True) -> Document:
    """Return the same as a page, with plots of the joints, and the motion as data."""
    blocks: list[Block] = [Verdict("good", _shown(found), (_compared(found),))]
    if pictures:
        blocks += _plots(found)
    blocks += [Heading("In numbers"), *on_page(excitation_sections(found), "Motion")]
    motion = csv_text(("time", *found.names), [[t, *row] for t, row in zip(found.time, found.columns, strict=True)])
    files = [("excite.json", excitation_json(found)), ("motion.csv", motion)]
    blocks += data_blocks(files, "robodyn excite --format json and --out write it to a file")
    return Document(found.model.name, "A motion that shows parameters", tuple(blocks))


def _plots(found: Excitation) -> list[Block]:
    from robodyn.report.pictures.simulation import joint_figure

    joints = [(k, joint) for k, joint in enumerate(found.joints) if joint.moves]
    shown = [
        joint_figure(joint.name, joint.unit == "N", found.time, (*found.motion[:2, :, k], found.torques[:, k]))
        for k, joint in joints[:_PICTURED]
    ]
    some = [Paragraph(f"The first {_PICTURED} of {len(joints)} joints.")] if len(joints) > _PICTURED else []
    return [Heading("Along the motion"), *some, Gallery(tuple(shown))]


def _head(found: Excitation) -> list[str]:
    series, rows = found.series, found.motion.shape[1]
    return [
        _shown(found),
        f"period {series.period:g} s, {series.harmonics} harmonics, {rows} rows at {found.rate:.6g} /s; "
        "it begins and ends at rest, at its first and last row",
        _compared(found),
        "self-collision is not looked at beyond the joints' limits",
    ]


def _shown(found: Excitation) -> str:
    moving = sum(joint.moves for joint in found.joints)
    return f"{found.model.name}: a motion of {count(moving, 'joint')} that shows {found.base.rank} base parameters"


def _compared(found: Excitation) -> str:
    own, plain = _words(found.information), _words(found.plain)
    if found.plain.rank < found.base.rank:
        return f"{own}; plain waves of this period and these limits show {found.plain.rank} of them"
    gain = f"standard errors are {figure(found.gain)} times smaller, in the geometric mean"
    return f"{own}; plain waves of this period and these limits: {plain}; {gain}"


def _words(information: Information) -> str:
    return f"condition {information.condition:.3g}, log-determinant {information.log_determinant:.1f}"


def _joint(joint: JointSwing) -> tuple[str, ...]:
    unit = "m" if joint.unit == "N" else "rad"
    used = (
        use(joint.speed, joint.speed_limit),
        use(joint.acceleration, joint.acceleration_limit),
        use(joint.effort, joint.effort_limit),
    )
    noise = f"{joint.noise:.3g} {joint.unit}"
    if not joint.moves:
        return (joint.name, f"{joint.centre:.3f}", "held", unit, "-", "-", used[2], noise)
    return (joint.name, f"{joint.least:.3f}", f"{joint.largest:.3f}", unit, *used, noise)


def _parameter(group: str, value: float, error: float) -> tuple[str, ...]:
    relative = 100.0 * error / abs(value) if value else inf
    return (group, figure(value, 4), figure(error, 2), f"{figure(relative, 2)}%" if relative < 1e3 else "-")


def _invisible(found: Excitation) -> str:
    base = found.base
    bodies = Counter(base.names[k].rpartition(".")[0] for k in base.invisible)
    if not bodies:
        return "every parameter shows in some torque"
    some = ", ".join(f"{name} {amount}" for name, amount in bodies.items())
    return f"{len(base.invisible)} of {len(base.names)} parameters show in no torque: {some}"
