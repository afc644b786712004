"""`diff`: what differs between two descriptions, and what that does to the torques."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

from robodyn.checks.rule import Excerpt, Finding, Severity
from robodyn.comparison.compare import Comparison
from robodyn.comparison.torques import PARTS, RELATIVE, TorqueDifference
from robodyn.report import document as doc
from robodyn.report.table import number
from robodyn.robot.kinematics import configuration, nearest_to_zero
from robodyn.robot.urdf.view import Subject
from robodyn.support.wording import count, shown_path


def comparison_sections(found: Comparison) -> Iterator[doc.Section]:
    """Yield both robots, the differences with those that move torques most first, the torques, and the verdict."""
    a, b = found.a, found.b
    yield doc.paragraphs([f"A: {shown_path(a.file)}", f"B: {shown_path(b.file)}"])
    differences = [(one.kind, one.name, *one.says, one.cause) for one in found.differences]
    if differences:
        yield [doc.Table("Differences", ("what", "where", "A", "B", "why"), differences)]
    beyond = [one for one in found.torques if one.exceeds(found.tolerance)]
    if beyond:
        rows = []
        for one in beyond:
            share = "-" if one.limit is None else f"{100.0 * one.worst / one.limit:.3g} %"
            guilty = "-" if one.difference is None else f"{one.difference.kind} of {one.difference.name or 'the scene'}"
            parts = (number(one.parts[part], one.worst) for part in PARTS)
            rows.append((one.joint, number(one.worst, one.largest), *parts, share, guilty))
        unit = "N m" if all(one.unit == "N m" for one in beyond) else "N m, N"
        head = ("joint", f"worst [{unit}]", "by gravity", "by inertia", "by speed", "of its limit", "explained by")
        yield [doc.Table("Differences of torque, the largest over motions within the limits", head, rows)]
    if found.worst is not None and found.worst in beyond:
        worst = found.worst
        pose = ", ".join(f"{name} {value:.4g}" for name, value in worst.pose.items())
        sides = f"{worst.a:.5g} {worst.unit} in A, {worst.b:.5g} {worst.unit} in B"
        yield doc.paragraphs([f"{worst.joint} differs most: {sides} at {pose}"])
    yield doc.remarks("note", found.notes)
    yield doc.paragraphs([verdict(found).headline + ".", *verdict(found).reasons])


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
    headline = f"Not the same dynamics: {worst.joint} differs by {worst.worst:.4g} {worst.unit}"
    return doc.Verdict("bad", headline, reasons)


def comparison_page(found: Comparison, pictures: bool = True) -> doc.Document:
    """Return the verdict, both robots laid over each other, how far torques are apart, and what the text says."""
    names = [each.name or shown_path(each.file) for each in (found.a, found.b)]
    what = f"Comparison of two descriptions, A: {shown_path(found.a.file)}, B: {shown_path(found.b.file)}"
    first = (verdict(found), *(_overlay(found) if pictures else ()), *_bars(found))
    sections, data = [*comparison_sections(found)][1:-1], [("comparison.json", comparison_json(found))]
    return doc.page(" and ".join(names), what, first, sections, "", data, "robodyn diff --format json prints it")


def _overlay(found: Comparison) -> Iterator[doc.Block]:
    """Yield A and B, which sliders move together, with what differs; lit are the links that are guilty of torques, of
    all that differ where none is."""
    from robodyn.report import stage

    robots = (found.a, found.b)
    places = [stage.bodies_of(each) for each in robots]
    partner = {pair.a: pair.b for pair in found.pairs}
    guilty = [one.difference for one in found.torques if one.difference and one.exceeds(found.tolerance)]
    said: tuple[dict[str, list[str]], ...] = {}, {}
    lit: tuple[set[str], ...] = set(), set()
    for one in found.differences:
        k_a, k_b = (place.get((one.subject, one.name)) for place in places)
        for side, k in enumerate((k_a, k_b if k_a is None else partner.get(k_a))):
            if k is not None:
                name = robots[side].bodies[k].name
                said[side].setdefault(name, []).append(f"{one.kind} {one.says[0]} in A, {one.says[1]} in B")
                lit[side].update([name] if one in guilty or not guilty else [])
    poses = {"zero pose, or the nearest limits": configuration(found.a, nearest_to_zero(found.a))}
    if found.worst and found.worst.exceeds(found.tolerance):
        poses[f"pose where {found.worst.joint} differs most"] = configuration(found.a, found.worst.pose)
    motions: tuple[list[dict[str, Any]], ...] = [], []
    for name, q in poses.items():
        q_b, sliders = configuration(found.b), []
        for pair in found.pairs:
            own, its = found.a.bodies[pair.a].joint, found.b.bodies[pair.b].joint
            if own.kind == its.kind in ("revolute", "prismatic") and its.mimics is None:
                sign, offset = pair.sign * own.multiplier, pair.sign * own.offset + pair.offset
                q_b[its.coordinate] = sign * q[own.coordinate] + offset
                sliders.append({"q": its.coordinate, "of": own.coordinate, "sign": sign, "offset": offset})
        motions[0].append(stage.pose(found.a, q.tolist()) | {"name": name})
        motions[1].append(stage.pose(found.b, q_b.tolist()) | {"name": name, "sliders": sliders})
    words = [{name: "; ".join(lines) for name, lines in each.items()} for each in said]
    mine = stage.robot(found.a, motions[0], name="A", lit=lit[0], words=words[0])
    theirs = stage.robot(found.b, motions[1], name="B", lit=lit[1], words=words[1], colour="c1", alpha=0.45)
    what = "links guilty of the torques" if guilty else "links that differ"
    caption = f"A, grey, and B, blue and seen through, laid over each other{f'; {what} in red' if any(lit) else ''}"
    alt = "; ".join(f"{name}: {said}" for name, said in words[0].items() if name in lit[0])
    yield stage.stage(caption, [mine, theirs], alt=alt)


def _bars(found: Comparison) -> list[doc.Block]:
    """Return how far each joint's torques are apart, in parts of its limit of effort."""
    rows = []
    for one in found.torques:
        of = "of its limit" if one.limit else "of its largest torque"
        words = f"{number(one.worst, one.largest)} {one.unit}, {100 * one.share:.3g} % {of}"
        colour = "bad" if one.exceeds(found.tolerance) else "good"
        rows.append((one.joint, [(words, 0.0, min(100 * one.share, 100.0), colour)], ""))
    note = "Over random motions within the limits of both, and a search around the worst of them; bars end at 100 %."
    return [doc.Bars("Largest difference of each joint's torque", rows, note)] if rows else []


def comparison_json(found: Comparison) -> str:
    """Return the document of `diff`; docs/reference/schemas has its keys; units are SI."""
    return doc.written(
        doc.select(
            found,
            "a:a.file b:b.file equal tolerance torque joints differences notes",
            torque=found.worst and _torque_json(found.worst),
            joints=[_torque_json(one) for one in found.torques],
            differences=[
                doc.select(one, "kind subject name a b size cause", **dict(zip("ab", one.says, strict=True)))
                for one in found.differences
            ],
        )
    )


def _torque_json(one: TorqueDifference) -> dict[str, Any]:
    keys = f"joint worst share {' '.join(PARTS)} largest a b pose speed acceleration "
    keys += "link:difference.name kind:difference.kind cause:difference.cause explains"
    share = None if one.limit is None else one.worst / one.limit
    return doc.select(one, keys, share=share, **{part: one.parts[part] for part in PARTS})


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
