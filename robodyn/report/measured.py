"""Measured against computed torques: a ranked diagnosis in words, each joint in numbers, plots."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from robodyn.identification.compare import Comparison
from robodyn.identification.fault_columns import DELAY, GAIN, OWN
from robodyn.report.document import (
    Block,
    Document,
    Gallery,
    Heading,
    Level,
    Paragraph,
    Section,
    Table,
    Verdict,
    data_blocks,
    on_page,
    paragraphs,
    remarks,
)
from robodyn.report.json.measured import measured_json
from robodyn.report.measured_words import bar, fault_words, percent
from robodyn.report.table import number, printable
from robodyn.support.wording import count

_LEAST = 0.02
"""Of the residual of a joint: an effect that explains less has no line."""
_GOOD = 0.05
_MUCH = 0.5
_ROUNDED = 1e-9


def measured_sections(found: Comparison) -> Iterator[Section]:
    """Yield the diagnosis, what is told of each joint, its effects with their standard errors, and notes."""
    verdict = verdict_on(found)
    yield paragraphs([_head(found), f"{verdict.headline}.", *verdict.reasons])
    told = [fault for fault in found.faults if fault.shares.max() >= _LEAST]
    lines = [*_gross(found), *(fault_words(found, fault) for fault in told)]
    few = count(len(found.faults) - len(told), "effect")
    rest = [f"{few} that explain less than 2 % left out"] if len(told) < len(found.faults) else []
    numbered = [f"{k}. {line}" for k, line in enumerate(lines, start=1)]
    said = numbered or ["nothing that is more than noise"]
    yield paragraphs(["What explains the difference", *said, *rest, *_left(found)])
    yield [Table("Measured against computed", *_joints(found))]
    yield [Table("Effects, each beside all others", *_effects(found))]
    yield remarks("note", found.notes)


def measured_page(found: Comparison, pictures: bool = True) -> Document:
    """Return the same as a page, with plots of torques, residuals and friction."""
    blocks: list[Block] = [verdict_on(found), *(_pictures(found) if pictures else [])]
    blocks += [Heading("In numbers"), *on_page(measured_sections(found), "Joint")]
    blocks += data_blocks(
        [("measured.json", measured_json(found))], "robodyn torques --measured --format json prints it"
    )
    return Document(found.robot, f"Measured against computed torques of {printable(found.file)}", tuple(blocks))


def _pictures(found: Comparison) -> list[Block]:
    from robodyn.report.pictures.measured import friction_figure, torque_figure

    places = range(len(found.joints))
    return [
        Heading("Measured over computed"),
        Gallery(tuple(torque_figure(found, j) for j in places)),
        Heading("Friction"),
        Paragraph("What is measured beyond the computed torque and all told effects but friction, over speed."),
        Gallery(tuple(friction_figure(found, j) for j in places)),
    ]


def _head(found: Comparison) -> str:
    what = f"{count(len(found.joints), 'joint')} with measured torques, {count(found.samples, 'sample')}"
    return (
        f"{found.robot}: {what}, {found.duration:.6g} s, compared below {found.cutoff:g} Hz over {found.compared:.4g} s"
    )


def verdict_on(found: Comparison) -> Verdict:
    """Return how far the model explains the log, and what that rests on."""
    before, after = (
        f"{100 * share:.3g} %" if share > _ROUNDED else "0" for share in (found.relative_error, found.left)
    )
    if not any(joint.moves for joint in found.joints):
        return Verdict("neutral", f"No joint moves: of the difference of {before} only offsets and weight can be told")
    reasons = [*_gross(found)]
    if not found.faults and not reasons:
        return Verdict(
            "good" if found.relative_error <= _GOOD else "neutral",
            f"The model differs from the log by {before} of the measured torques; no effect stands out of the noise",
        )
    level: Level = "bad" if reasons else "doubtful" if found.relative_error > _GOOD else "good"
    return Verdict(
        level,
        f"The model differs from the log by {before} of the measured torques, {after} with what is told below",
        tuple(reasons),
    )


def _left(found: Comparison) -> Iterator[str]:
    """Yield which joints' residuals none of the effects explains."""
    dark = [
        f"{printable(joint.name)} ({100 * (joint.left / joint.residual) ** 2:.0f} %)"
        for joint in found.joints
        if joint.left > np.sqrt(_MUCH) * joint.residual and joint.relative_error > _GOOD
    ]
    if dark and found.faults:
        yield f"None of these explains most of the residual of {', '.join(dark)}: noise, or inertias of links."


def _gross(found: Comparison) -> Iterator[str]:
    words = found.channels.words([printable(joint.name) for joint in found.joints])
    for line, joints in zip(words, found.channels.faults, strict=True):
        whose = "their residuals" if len(joints) > 1 else "its residual"
        part = percent(min(found.gross[j] for j in joints))
        yield f"{line[0].upper()}{line[1:]}: that explains {part} of {whose}"


def _joints(found: Comparison) -> tuple[list[str], list[list[str]]]:
    head = ["joint", "measured RMS", "computed", "residual", "with effects", "relative error", "correlation"]
    rows = [
        [
            joint.name,
            f"{number(joint.measured)} {joint.unit}",
            number(joint.computed, joint.measured),
            number(joint.residual) if joint.residual > _ROUNDED * joint.measured else "0",
            number(joint.left) if joint.left > _ROUNDED * joint.measured else "0",
            f"{100 * joint.relative_error:.3g} %",
            "-" if joint.correlation is None else f"{joint.correlation:.3f}",
        ]
        for joint in found.joints
    ]
    return head, rows


def _effects(found: Comparison) -> tuple[list[str], list[list[str]]]:
    head = ["joint", "gain", "offset", "viscous", "Coulomb", "rotor", "delay [ms]"]
    rows = []
    for joint in found.joints:
        row = [joint.name]
        for kind in OWN:
            size = 1.0 if kind in (OWN[GAIN], OWN[DELAY]) else joint.measured
            value, error = joint.effects.get(kind, (0.0, 0.0))
            scale, shift = (1e3 if kind == OWN[DELAY] else 1.0), (1.0 if kind == OWN[GAIN] else 0.0)
            row.append(bar(scale * value + shift, scale * error, size) if kind in joint.effects else "cannot be told")
        rows.append(row)
    return head, rows
