"""`retime`: how long a path takes, which limit binds where, and what each joint uses of its limits."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from robodyn.report import document as doc
from robodyn.report.charts import plane_chart, time_chart
from robodyn.report.table import first_names, gravity_text, number, printable
from robodyn.sizing.along import LIMITS
from robodyn.sizing.retime import BINDS, Retimed
from robodyn.support.wording import count

_PLOTTED, _FRAMES = 12, 400
_WORDS = {"optimal": "the shortest time along the path", "trapezoid": "trapezoids of speed", "scurve": "S-curves"}


def retime_sections(found: Retimed) -> Iterator[doc.Section]:
    """Yield what was timed, the verdict, what binds, and the use of limits."""
    yield doc.paragraphs([_subject(found)])
    yield doc.paragraphs([f"{verdict(found).headline}.", *verdict(found).reasons])
    if found.binding:
        rows = [(one.joint, one.limit, f"{100 * one.share_of_time:.3g} %") for one in found.binding]
        rest = 1.0 - sum(one.share_of_time for one in found.binding)
        note = f"No limit binds in {100 * rest:.3g} % of the time." if rest > 5e-4 else ""
        yield [doc.Table("What binds", ("joint", "limit", "share of time"), rows, note)]
    if found.joints:
        shown = [name for name in LIMITS if any(name in joint.use for joint in found.joints)]
        uses = list[tuple[str, ...]]()
        for joint in found.joints:
            cells = (f"{100 * joint.use[name]:.4g} %" if name in joint.use else "-" for name in shown)
            uses.append((joint.name, *cells))
        yield [doc.Table("Largest use of each limit", ("joint", *shown), uses)]
    yield doc.remarks("warning", found.warnings)


def _subject(found: Retimed) -> str:
    places = count(len(found.path.marks), "way-point")
    return f"{found.model.name}: {places}, {_WORDS[found.profile]}, {gravity_text(found.scene.gravity)}"


def verdict(found: Retimed) -> doc.Verdict:
    """Return how long the motion takes, or why there is none."""
    if not found.feasible:
        return doc.Verdict("bad", f"No motion along this path keeps the limits: {found.reason}")
    headline = f"{found.duration or 0.0:.6g} s, {found.samples} rows, within all limits"
    reasons = []
    unlimited = [joint.name for joint in found.joints if "effort" not in joint.use and "motor torque" not in joint.use]
    if unlimited:
        reasons.append(f"Without a limit of torque: {first_names(unlimited, 8)}.")
    return doc.Verdict("doubtful" if unlimited or found.warnings else "good", headline, tuple(reasons))


def retime_page(found: Retimed, pictures: bool = True) -> doc.Document:
    """Return the verdict, the robot along the motion, the path's speed, what binds when, and the use of limits."""
    said = verdict(found)
    blocks: list[doc.Block] = [replace(said, reasons=(*said.reasons, *found.warnings))]
    if found.feasible and pictures:
        blocks.append(_stage(found))
        blocks += doc.titled("Along the path", doc.gallery([_path_chart(found), _use_chart(found)]))
    sections = [*retime_sections(found)][1:]
    data = [("retime.json", retime_json(found))]
    if found.feasible:
        rows = np.column_stack((found.time, found.columns)).tolist()
        data.append(("motion.csv", doc.csv_text(("time", *found.names), rows)))
    title = f"A path of {found.model.name}" if found.model.name else "A path"
    return doc.page(title, _subject(found), blocks, sections, "", data, "robodyn retime --out writes it")


def _stage(found: Retimed) -> doc.Block:
    from robodyn.report import stage

    model, k = found.model, np.unique(np.linspace(0, found.samples - 1, _FRAMES).astype(int))
    most = found.used.max(axis=0)
    uses = [
        (np.ascontiguousarray(most[k, body.joint.rate]), 1.0) if body.joint.kind in ("revolute", "prismatic") else None
        for body in model.bodies
    ]
    q = [np.ascontiguousarray(found.q[k, i]) for i in range(model.nq)]
    tau = {f"tau_{name}": np.ascontiguousarray(found.tau[k, i]) for i, name in enumerate(model.joint_names)}
    arrows = stage.joint_torques(model, tau)
    motion = stage.motion("", found.time[k], q, rows=1.0 + k, use=uses, arrows=arrows)
    words = "The robot along the path; links are coloured by what their joints use of their limits"
    return stage.stage(words, [stage.robot(model, [motion])])


def _path_chart(found: Retimed) -> doc.Chart:
    """Return the speed along the path, and on it in colours where which limit binds."""
    pace, most = np.gradient(found.row, found.time), found.used.max(axis=(0, 2))
    alt = f"Speed along the path over its rows, {number(float(pace.max()))} rows/s at the most; what binds where: "
    lines = {"no limit binds": (found.row, pace)}
    for one in found.binding[:_PLOTTED]:
        used = found.used[LIMITS.index(one.limit), :, found.model.joint_names.index(one.joint)]
        on = (used >= BINDS) & (used >= most * (1.0 - 1e-9))
        lines[f"{printable(one.joint)}: {one.limit}"] = (found.row, np.where(on, pace, np.nan))
    alt += ", ".join([*lines][1:]) or "nothing"
    colours = {"no limit binds": "ink"}
    axes = "row of the path", "speed [rows per second]"
    return plane_chart("What binds where", alt, *axes, lines=lines, colours=colours)


def _use_chart(found: Retimed) -> doc.Chart:
    """Return what joints use of their limits over time, of the one that they use most."""
    used = 100.0 * found.used.max(axis=0)
    curves = {printable(joint): used[:, i] for i, joint in enumerate(found.model.joint_names[:_PLOTTED])}
    most = ", ".join(f"{label} {number(float(each.max()))} %" for label, each in curves.items())
    alt, rows = f"Use of limits over time, at most: {most}", 1.0 + np.arange(float(found.samples))
    return time_chart("Use of limits [%]", alt, found.time, curves, "%", rows=rows, levels=[(100.0, "limit")])


def retime_json(found: Retimed) -> str:
    """Return the document of `retime`; docs/reference/schemas has its keys."""
    keys = "robot:model.name profile feasible reason where duration samples binding joints warnings"
    return doc.written(doc.select(found, keys, reason=found.reason or None, where=dict(found.where) or None))
