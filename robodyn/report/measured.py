"""Measured against computed torques: a ranked diagnosis in words, each joint in numbers, plots, and JSON."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from robodyn.dynamics.regressor import INERTIAL
from robodyn.identification.faults.compare import Comparison
from robodyn.identification.faults.faults import DELAY, GAIN, OWN, Fault
from robodyn.report import document as doc
from robodyn.report.table import is_noise, number, printable
from robodyn.support.floats import Floats, einsum
from robodyn.support.wording import count

if TYPE_CHECKING:
    from robodyn.report.charts import Course
    from robodyn.robot.model import Model

_GOOD = 0.05
_ROUNDED = 1e-9


def percent(share: float) -> str:
    return f"{100 * share:.0f} %" if share > 0.1 else f"{100 * share:.1f} %"


def fault_words(found: Comparison, fault: Fault) -> str:
    """Return what a fault is, with its standard error, and how much it explains of which residuals."""
    value, error = float(fault.values[0]), float(fault.covariance[0, 0] ** 0.5)
    sure = "explains" if fault.certain else "would explain"
    doubt = "" if fault.certain else " (not told apart from other effects)"
    j, kind = fault.effect.joint, fault.effect.kind
    if j is None:
        order = sorted(range(len(found.joints)), key=lambda j: -fault.shares[j])
        shares = ((printable(found.joints[j].name), fault.shares[j]) for j in order)
        told = ", ".join(f"{percent(share)} at {name}" for name, share in shares if share >= 0.01)
        of = f"of residuals: {told}" if told else "less than 1 % of any residual"
        load = f"A load at {printable(found.load_link)} whose mass cannot be told"
        if 0.0 < 3.0 * error < abs(value):
            centre = fault.values[1:4] / value
            rate = np.column_stack((-centre / value, np.eye(3) / value))
            errors = np.sqrt(einsum("ia,ab,ib->i", rate, fault.covariance[:4, :4], rate))
            each = zip(centre, errors, np.diag(fault.covariance)[1:4] > 0.0, strict=True)
            where = ", ".join(bar(float(x), float(e)) if there else "?" for x, e, there in each)
            load = f"A payload of {bar(value, error)} kg at {printable(found.load_link)}, its centre at ({where}) m,"
        return f"{load} {sure} {of}{doubt}"
    joint = found.joints[j]
    unit, per, inertia = ("N m", "rad", "kg m^2") if joint.unit == "N m" else ("N", "m", "kg")
    if kind == "gain":
        what, where = f"A gain of {bar(1 + value, error)}", " (torque constant or gear)"
    elif kind == "delay":
        what, where = f"A delay of the measured torque of {bar(1e3 * value, 1e3 * error)} ms", ""
    else:
        words = {"offset": ("An offset", unit), "viscous": ("Viscous friction", f"{unit} s/{per}")}
        words |= {"coulomb": ("Coulomb friction", unit), "rotor": ("Rotor inertia", inertia)}
        title, of = words[kind]
        what, where = f"{title} of {bar(value, error, joint.measured)} {of}", ""
    return f"{what} at {printable(joint.name)}{where} {sure} {percent(fault.shares[j])} of its residual{doubt}"


def bar(value: float, error: float, scale: float = 1.0) -> str:
    """Return a value with its standard error, to two digits of the error; 0 for what is noise beside it or `scale`."""
    if is_noise(max(abs(value), error), scale):
        return "0"
    if abs(value) < 0.05 * error:
        value = 0.0
    if max(abs(value), error) < 1e-3:
        return f"{value:.2g} +- {error:.1e}"
    digits = min(max(0, 1 - int(np.floor(np.log10(max(error, 1e-9))))), 4)
    return f"{value:.{digits}f} +- " + (f"{error:.{digits}f}" if error >= 10.0**-digits else f"{error:.0e}")


def measured_sections(found: Comparison) -> Iterator[doc.Section]:
    """Yield the diagnosis, what is told of each joint, its effects with their standard errors, and notes."""
    verdict = verdict_on(found)
    what = f"{count(len(found.joints), 'joint')} with measured torques, {count(found.samples, 'sample')}"
    over = f"compared below {found.cutoff:g} Hz over {found.compared:.4g} s"
    yield doc.paragraphs(
        [f"{found.model.name}: {what}, {found.duration:.6g} s, {over}", f"{verdict.headline}.", *verdict.reasons]
    )
    told = [fault for fault in found.faults if fault.shares.max() >= 0.02]  # others have no line
    lines = [*_gross(found), *(fault_words(found, fault) for fault in told)]
    few = count(len(found.faults) - len(told), "effect")
    rest = [f"{few} that explain less than 2 % left out"] if len(told) < len(found.faults) else []
    numbered = [f"{k}. {line}" for k, line in enumerate(lines, start=1)]
    said = numbered or ["nothing that is more than noise"]
    dark = [
        f"{printable(joint.name)} ({100 * (joint.left / joint.residual) ** 2:.0f} %)"
        for joint in found.joints
        if joint.left > np.sqrt(0.5) * joint.residual and joint.relative_error > _GOOD
    ]
    if dark and found.faults:
        rest.append(f"None of these explains most of the residual of {', '.join(dark)}: noise, or inertias of links.")
    yield doc.paragraphs(["What explains the difference", *said, *rest])
    head = ["joint", "measured RMS", "computed", "residual", "with effects", "relative error", "correlation"]
    rows = []
    for joint in found.joints:
        row = [joint.name, f"{number(joint.measured)} {joint.unit}", number(joint.computed, joint.measured)]
        row += [number(x) if x > _ROUNDED * joint.measured else "0" for x in (joint.residual, joint.left)]
        row.append(f"{100 * joint.relative_error:.3g} %")
        rows.append([*row, "-" if joint.correlation is None else f"{joint.correlation:.3f}"])
    yield [doc.Table("Measured against computed", head, rows)]
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
    yield [doc.Table("Effects, each beside all others", head, rows)]
    yield doc.remarks("note", found.notes)


def measured_page(found: Comparison, pictures: bool = True) -> doc.Document:
    """Return the verdict, how far each joint is explained, plots of torques, residuals and friction, and the same."""
    summary, causes, *numbers = measured_sections(found)
    said = (block.text for block in (summary[0], *causes[1:]) if isinstance(block, doc.Paragraph))
    reasons = tuple(line.removeprefix(f"{k}. ") for k, line in enumerate(said))
    labels, charts = ("computed", "with effects"), list[doc.Chart]()
    errors = {joint.name: (joint.relative_error, joint.left / joint.measured) for joint in found.joints}
    caption = "RMS of measured less computed torque, of that of the measured one"
    first: list[doc.Block] = [replace(verdict_on(found), reasons=reasons), error_bars(caption, labels, errors)]
    if pictures:
        from robodyn.report.charts import Course

        course = Course(found.curves)
        first += played("The robot along the log, with measured torques", found.model, course.frames, "measured")
        for joint in found.joints:
            seen = f"measured {number(joint.measured)} {joint.unit} RMS, computed {number(joint.computed)}, "
            seen += f"residual {number(joint.residual)}, {number(joint.left)} with effects"
            speed, told = (course.frames[f"{kind}_{joint.name}"] for kind in ("speed", "friction"))
            dots = {"friction that is told": (speed, told)} if told.any() else {}
            charts += log_charts(course, joint.name, joint.unit, labels, seen, dots=dots)
        right = ["Measured torques are drawn with exchanged joints and wrong signs corrected."] * bool(
            found.channels.faults
        )
        first += doc.titled("Along the log", [*doc.paragraphs(right), *doc.gallery(charts)])
    what = f"Measured against computed torques of {printable(found.file)}"
    files = [("measured.json", measured_json(found))]
    how = "robodyn torques --measured --format json prints it"
    return doc.page(found.model.name, what, first, numbers, "Joint", files, how)


def played(
    caption: str,
    model: Model,
    columns: Mapping[str, Floats],
    kind: str,
    words: Mapping[str, str] | None = None,
    loop: bool = False,
) -> Iterator[doc.Block]:
    """Yield a robot along columns `time` and q_COORDINATE, with the torques KIND_JOINT; words: of its bodies."""
    from robodyn.report import stage

    efforts = ((columns.get(f"{kind}_{body.joint.name}"), body.joint.effort) for body in model.bodies)
    use = [(tau, limit) if tau is not None and limit else None for tau, limit in efforts]
    q = [columns[f"q_{name}"] for name in model.coordinates]
    along = stage.motion("", columns["time"], q, use=use, arrows=stage.joint_torques(model, columns, kind))
    caption += "; links in the colours of their joints' use of effort: green, red above 100 %" if any(use) else ""
    peaks = {name: np.abs(columns[f"{kind}_{name}"]).max() for name in model.rates if f"{kind}_{name}" in columns}
    alt = f"{caption}; the largest: {', '.join(f'{printable(name)} {number(peak)}' for name, peak in peaks.items())}"
    yield stage.stage(caption, [stage.robot(model, [along], words=words)], alt=alt, loop=loop)


def error_bars(caption: str, labels: Sequence[str], errors: Mapping[str, tuple[float, float]]) -> doc.Bars:
    """Return bars of errors before and after, by joint, as parts of what is measured."""
    rows = []
    for name, both in errors.items():
        each = zip(labels, both, ("soft", "c2"), strict=True)
        bars = [(f"{label} {percent(part)}", 0.0, min(100.0 * part, 100.0), colour) for label, part, colour in each]
        rows.append((name, bars, ""))
    return doc.Bars(caption, rows, "Bars end at 100 %.")


def log_charts(
    course: Course,
    joint: str,
    unit: str,
    labels: tuple[str, str],
    said: str,
    *,
    spans: Sequence[tuple[float, float, str]] = (),
    **friction: Mapping[str, tuple[Floats, Floats]],
) -> Iterator[doc.Chart]:
    """Yield torques of a joint along a log, what is measured beyond computed ones, and friction over speed.

    Args:
        labels: of what is computed, and of what is explained in the end; said: what is to be seen.
        friction: dots or lines, beside what is measured beyond all but friction.
    """
    from robodyn.report.charts import plane_chart, time_chart

    name, what, colours = printable(joint), "force" if unit == "N" else "torque", ("c1", "soft", "c2")
    steps = np.diff(course.time, prepend=course.time[0])
    gap = steps > 3.0 * np.median(steps)
    speed, measured, explained, found = (
        course.frames[f"{kind}_{joint}"] for kind in ("speed", "measured", "explained", "friction")
    )
    for title, kinds in ((what, ("measured", "computed", "explained")), ("residual", ("off", "left"))):
        bands = (course.motion.of(f"{kind}_{joint}") for kind in kinds)
        drawn = ((np.where(gap, np.nan, low), np.where(gap, np.nan, high)) for low, high in bands)
        curves = dict(zip(("measured", *labels)[-len(kinds) :], drawn, strict=True))
        caption, own = f"{name}: {title} [{unit}]", colours[-len(kinds) :]
        alt, wide = f"{caption} over time: {said}", ("measured",)
        yield time_chart(caption, alt, course.time, curves, unit, spans=spans, colours=own, wide=wide)
    caption, least, most = f"{name}: friction over speed", float(found.min()), float(found.max())
    rest, across = "measured less all else", f"speed [{'m/s' if unit == 'N' else 'rad/s'}]"
    chart = plane_chart(
        caption,
        f"{caption}, from {number(least, most)} to {number(most, least)} {unit}",
        across,
        f"{what} [{unit}]",
        dots={rest: (speed, measured - explained + found), **friction.get("dots", {})},
        lines=friction.get("lines"),
        colours={rest: "c1"} | {label: "c2" for each in friction.values() for label in each},
        time=course.frames["time"],
    )
    yield replace(chart, look={**chart.look, "height": 210})


def verdict_on(found: Comparison) -> doc.Verdict:
    """Return how far the model explains the log, and what that rests on."""
    before, after = (
        f"{100 * share:.3g} %" if share > _ROUNDED else "0" for share in (found.relative_error, found.left)
    )
    if not any(joint.moves for joint in found.joints):
        headline = f"No joint moves: of the difference of {before} only offsets and weight can be told"
        return doc.Verdict("neutral", headline)
    reasons = tuple(_gross(found))
    headline = f"The model differs from the log by {before} of the measured torques"
    if not found.faults and not reasons:
        level: doc.Level = "good" if found.relative_error <= _GOOD else "neutral"
        return doc.Verdict(level, f"{headline}; no effect stands out of the noise")
    level = "bad" if reasons else "doubtful" if found.relative_error > _GOOD else "good"
    return doc.Verdict(level, f"{headline}, {after} with what is told below", reasons)


def _gross(found: Comparison) -> Iterator[str]:
    words = found.channels.words([printable(joint.name) for joint in found.joints])
    for line, joints in zip(words, found.channels.faults, strict=True):
        whose = "their residuals" if len(joints) > 1 else "its residual"
        part = percent(min(found.gross[j] for j in joints))
        yield f"{line[0].upper()}{line[1:]}: that explains {part} of {whose}"


def measured_json(found: Comparison) -> str:
    """Return joints, gross faults, and the diagnosis; what cannot be told is null."""
    names, joints, diagnosis = [joint.name for joint in found.joints], [], []
    for joint in found.joints:
        effects: dict[str, Any] = dict.fromkeys(OWN)
        for kind, (value, error) in joint.effects.items():
            effects[kind] = {"value": value + (kind == "gain"), "standard_error": error}
        keys = "name unit measured_rms:measured computed_rms:computed residual_rms:residual residual_rms_left:left"
        joints.append(doc.select(joint, f"{keys} relative_error correlation moves effects", effects=effects))
    for fault in found.faults:
        j, kind = fault.effect.joint, fault.effect.kind
        shift = 1.0 if kind == "gain" else 0.0
        known = zip(INERTIAL if j is None else (kind,), fault.values, np.diag(fault.covariance), strict=True)
        parameters = [
            {"name": name, "value": float(value) + shift, "standard_error": float(np.sqrt(square))}
            for name, value, square in known
            if square > 0.0
        ]
        owner = {"joint": None if j is None else names[j], "link": found.load_link if j is None else None}
        explains = dict(zip(names, map(float, fault.shares), strict=True))
        one = {"kind": kind, **owner, "parameters": parameters, "certain": fault.certain, "explains": explains}
        diagnosis.append({**one, "words": fault_words(found, fault)})
    return doc.written(
        doc.select(
            found,
            "robot:model.name file samples duration cutoff compared relative_error relative_error_left:left joints "
            "exchanged reversed diagnosis warnings:notes",
            joints=joints,
            exchanged=[[names[j] for j in group] for group in found.channels.exchanged],
            reversed=[names[j] for j in found.channels.reversed],
            diagnosis=diagnosis,
        )
    )
