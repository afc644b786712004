"""`diff`: what differs between two descriptions, and what that does to the torques."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

from robodyn.checks.rule import Excerpt, Finding, Severity
from robodyn.comparison.compare import Comparison
from robodyn.comparison.differences import Difference
from robodyn.comparison.torques import PARTS, RELATIVE, TorqueDifference
from robodyn.report import document as doc
from robodyn.report.table import number
from robodyn.robot.urdf.view import Subject
from robodyn.support.wording import count, shown_path


def comparison_sections(found: Comparison) -> Iterator[doc.Section]:
    """Yield both robots, the differences with those that move torques most first, the torques, and the verdict."""
    a, b = found.a, found.b
    yield doc.paragraphs([f"A: {shown_path(a.file)}", f"B: {shown_path(b.file)}"])
    rows = [(one.kind, one.name, *one.says, one.cause) for one in found.differences]
    if rows:
        yield [doc.Table("Differences", ("what", "where", "A", "B", "why"), rows)]
    beyond = [one for one in found.torques if one.exceeds(found.tolerance)]
    if beyond:
        yield [_torques(found, beyond)]
    if found.worst is not None and found.worst in beyond:
        yield doc.paragraphs([_where(found.worst)])
    yield doc.remarks("note", found.notes)
    yield doc.paragraphs([verdict(found).headline + ".", *verdict(found).reasons])


def _torques(found: Comparison, beyond: list[TorqueDifference]) -> doc.Table:
    rows = []
    for one in beyond:
        share = "-" if one.limit is None else f"{100.0 * one.worst / one.limit:.3g} %"
        guilty = "-" if one.difference is None else f"{one.difference.kind} of {one.difference.name or 'the scene'}"
        parts = [number(one.parts[part], one.worst) for part in PARTS]
        rows.append((one.joint, number(one.worst, one.largest), *parts, share, guilty))
    unit = "N m" if all(one.unit == "N m" for one in beyond) else "N m, N"
    head = ("joint", f"worst [{unit}]", "by gravity", "by inertia", "by speed", "of its limit", "explained by")
    return doc.Table("Differences of torque, the largest over motions within the limits", head, rows)


def _where(one: TorqueDifference) -> str:
    pose = ", ".join(f"{name} {value:.4g}" for name, value in one.pose.items())
    return f"{one.joint} differs most: {one.a:.5g} {one.unit} in A, {one.b:.5g} {one.unit} in B at {pose}"


def verdict(found: Comparison) -> doc.Verdict:
    """Return whether both are the same robot and, if not, why."""
    worst, what = found.worst, count(len(found.differences), "difference")
    within = f"{RELATIVE:g} of the largest of each joint" if found.tolerance is None else f"{found.tolerance:g} N m"
    if found.equal:
        same = f"torques agree within {within}, {what}" if found.differences else "no difference found"
        return doc.Verdict("good", f"The same robot: {same}")
    if worst is None or not worst.exceeds(found.tolerance):
        return doc.Verdict("doubtful", f"The same torques within {within}, and {what}")
    guilty = worst.difference
    reasons = () if guilty is None else (f"{100.0 * worst.explains:.3g} % of it: {guilty.words}",)
    return doc.Verdict(
        "bad", f"Not the same dynamics: {worst.joint} differs by {worst.worst:.4g} {worst.unit}", reasons
    )


def comparison_page(found: Comparison) -> doc.Document:
    """Return the page: the verdict, and what stands behind it."""
    names = [each.name or shown_path(each.file) for each in (found.a, found.b)]
    blocks = [block for section in [*comparison_sections(found)][:-1] for block in section]
    return doc.Document(" and ".join(names), "comparison of two descriptions", (verdict(found), *blocks))


def comparison_json(found: Comparison) -> str:
    """Return the document of `diff`; docs/reference/schemas has its keys; units are SI."""
    worst = found.worst
    keys: dict[str, Any] = {
        "a": found.a.file,
        "b": found.b.file,
        "equal": found.equal,
        "tolerance": found.tolerance,
        "torque": None if worst is None else _torque_json(worst),
        "joints": [_torque_json(one) for one in found.torques],
        "differences": [_difference_json(one) for one in found.differences],
        "notes": list(found.notes),
    }
    return doc.written(keys)


def _torque_json(one: TorqueDifference) -> dict[str, Any]:
    link = one.difference
    return {
        "joint": one.joint,
        "worst": one.worst,
        "share": None if one.limit is None else one.worst / one.limit,
        **{part: one.parts[part] for part in PARTS},
        "largest": one.largest,
        "a": one.a,
        "b": one.b,
        "pose": dict(one.pose),
        "speed": dict(one.speed),
        "acceleration": dict(one.acceleration),
        "link": None if link is None else link.name,
        "kind": None if link is None else link.kind,
        "cause": None if link is None else link.cause,
        "explains": one.explains,
    }


def _difference_json(one: Difference) -> dict[str, Any]:
    says = dict(zip("ab", one.says, strict=True))
    return {"kind": one.kind, "subject": one.subject, "name": one.name, **says, "size": one.size, "cause": one.cause}


def findings(found: Comparison) -> tuple[Finding, ...]:
    """Return the differences as findings in B, at the line of the link or joint, for programs that show such."""
    described = found.b.description
    parts = () if described is None else (("link", described.links), ("joint", described.joints))
    lines = {(kind, part.name): part.line for kind, some in parts for part in some}
    remedy, nothing = "see that the difference is meant", Excerpt("", 0, 1)
    out = []
    for one in found.differences:
        subject, line = Subject(one.subject, one.name), lines.get((one.subject, one.name), 1)
        finding = partial(Finding, "RD902", "regression", Severity.ERROR, found.b.file, line, 1, 0, 0, subject)
        out.append(finding(one.words, remedy, one.size, None, None, None, nothing))
    return tuple(out)
