"""`identify` and `excite`: parameters that explain a log, and a motion that shows them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from math import floor, inf, log10
from typing import Any

import numpy as np

from robodyn.dynamics.regressor import INERTIAL
from robodyn.identification.excitation.excite import Excitation
from robodyn.identification.excitation.motion import MARGIN
from robodyn.identification.parameters.base import Base
from robodyn.identification.result import BaseFit, Errors, Identified, MotorFit
from robodyn.report import document as doc
from robodyn.report.limits import use
from robodyn.report.measured import error_bars, log_charts, played
from robodyn.report.table import number, printable
from robodyn.support.floats import HALF_UP, Floats, ranked
from robodyn.support.wording import count, figure, listed

_PICTURED = 12
"""Joints that have plots."""
_LABELS = "description", "identified"
_GROUPS = "Base parameters of bodies", "Friction and rotors", "Not determined: 0 is within the interval of 95 %"


def identified_sections(found: Identified) -> Iterator[doc.Section]:
    """Yield errors by joint, friction and rotors, base parameters with their standard errors, and what was assumed."""
    yield doc.paragraphs(_identified_head(found))
    head = ("relative error", "fitted", "held out", "description, fitted", "description, held out")
    parts = (found.train, found.held_out, found.original_train, found.original_held_out)
    rows = [("all joints", *("-" if each is None else _percent(each.relative_error) for each in parts))]
    for name in found.train.joints:
        rows.append((name, *("-" if each is None else _percent(each.joints[name]) for each in parts)))
    yield [doc.Table("", head, rows, "||computed - measured|| / ||measured||, in N m")]
    of_motor = ("motor", "viscous", "Coulomb", "offset", "breakaway", "decays with", "load", "rotor")
    names = ("viscous", "coulomb", "offset", "stribeck", "stribeck_velocity", "load", "rotor")
    rows = []
    for name, motor in found.motors.items():
        values = [getattr(motor, each) for each in names]
        rows.append((name, *("-" if value is None else figure(value) for value in values)))
    units = "N m s/rad, N m, N m, N m, rad/s, part of the torque through the gear, kg m^2; of slides likewise in m."
    note = f"{units} Offset: half of what friction differs by direction, or the sensor's."
    yield [doc.Table("", of_motor, rows, note)]
    note = "Values by least squares without bounds; errors count that residuals of neighbouring rows are alike."
    yield [doc.Table("", ("base parameter", "value", "standard error", "calibrated"), [*_base_rows(found.base)], note)]
    if found.unseen:
        yield doc.paragraphs([f"no torque of the log shows anything of {listed(found.unseen)}: as described"])
    yield doc.remarks("note", found.warnings)


def _base_rows(fit: BaseFit) -> Iterator[list[str]]:
    columns = (fit.values.tolist(), fit.standard_errors.tolist(), fit.consistent.tolist())
    for group, value, error, after in zip(fit.base.short_groups, *columns, strict=True):
        # to a tenth of the first digit of the standard error: further digits tell nothing
        digits = 1 - floor(log10(error)) if error > 0.0 else 0
        cells = [group]
        for each in (value, error, after):
            text = f"{each * HALF_UP:.{max(digits, 0)}f}" if digits < 8 else f"{each * HALF_UP:.2g}"
            text = text if text.strip("-0.") else text.lstrip("-")
            cells.append(text if error > 0.0 else figure(each, 4))
        yield cells


def identified_page(found: Identified, pictures: bool = True) -> doc.Document:
    """Return the verdict, errors of joints, the robot along the logs, plots, parameters beside the description's, and
    the same, with JSON as data."""
    new, old = found.judged
    level: doc.Level = "bad" if found.faults or not found.better else "good" if found.explains else "doubtful"
    reasons = (*found.faults, *_identified_head(found)[1:])
    which = f"||computed - measured|| of ||measured||, {'held out' if found.held_out else 'fitted'}"
    errors = {name: (error, new.joints[name]) for name, error in old.joints.items()}
    first: list[doc.Block] = [doc.Verdict(level, verdict(found), reasons), error_bars(which, _LABELS, errors)]
    if pictures:
        first += [*_along_logs(found), *doc.titled("Parameters", _parameters(found))]
    _, *sections = identified_sections(found)
    files, how = [("identify.json", identified_json(found))], "robodyn identify --format json writes it"
    title = "Parameters that explain logs"
    return doc.page(found.model.name, title, first, sections, "Fit", files, how)


def _along_logs(found: Identified) -> Iterator[doc.Block]:
    """Yield the robot with its measured torques, and plots of the joints that are explained worst."""
    from robodyn.report.charts import Course

    model, course = found.model, Course(found.curves())
    columns, (new, old) = course.frames, found.judged
    theta, words = dict(zip(found.names, found.theta.tolist(), strict=True)), {}
    for body in model.bodies:
        mass, *moments = (theta[f"{body.name}.{kind}"] for kind in INERTIAL[:4])
        if mass > 0.0 and body.name not in found.unseen:
            centre = ", ".join(number(each / mass) for each in moments)
            words[body.name] = f"calibrated {number(mass)} kg, mass centre ({centre}) m"
    yield from played("The robot along the logs, with measured torques", model, columns, "measured", words)
    held = np.flatnonzero(np.diff(np.concatenate(([0.0], course.motion.first[:, 1], [0.0])))).tolist()
    spans = [(course.time[a], course.time[b - 1], "held out") for a, b in zip(held[::2], held[1::2], strict=True)]
    charts: list[doc.Chart] = []
    slides = {joint.rate: joint.kind == "prismatic" for joint in model.independent}
    worst = sorted(ranked([*new.joints], key=new.joints.__getitem__)[:_PICTURED], key=[*new.joints].index)
    for name in worst:
        said = f"within {_percent(new.joints[name])} as identified, {_percent(old.joints[name])} by the description"
        law = _law(found.motors[name], *(columns[f"{kind}_{name}"] for kind in ("speed", "friction")))
        unit = "N" if slides[model.rates.index(name)] else "N m"
        charts += log_charts(course, name, unit, _LABELS, said, lines=law, spans=spans)
    notes = ["Shaded: held out."] if found.held_out else []
    if len(found.hashes) > 1:
        notes.append("Logs stand one after another.")
    if len(worst) < len(new.joints):
        notes.append(f"{len(worst)} of {len(new.joints)} joints, those with the largest errors; the tables have all.")
    yield from doc.titled("Along the logs", [*doc.paragraphs(filter(None, [" ".join(notes)])), *doc.gallery(charts)])


def _law(motor: MotorFit, speed: Floats, friction: Floats) -> dict[str, tuple[Floats, Floats]]:
    """Return the friction that was identified over the speeds of a joint, under the mean load that it had."""
    least, most = min(float(speed.min()), 0.0), max(float(speed.max()), 0.0)
    at = np.concatenate((least * np.linspace(1.0, 1e-3, 100), [np.nan], most * np.linspace(1e-3, 1.0, 100)))
    if not motor.load:
        return {"identified law": (at, motor.friction(at))}
    passed = float(np.abs(friction - motor.friction(speed)).mean()) / motor.load
    return {f"identified law, {number(passed)} N m through the gear": (at, motor.friction(at, passed))}


def _parameters(found: Identified) -> Iterator[doc.Block]:
    """Yield base parameters with intervals beside the description's values, those not told from 0 apart, and what no
    torque shows."""
    fit = found.base
    columns = (fit.values.tolist(), fit.standard_errors.tolist(), fit.described.tolist())
    groups: dict[str, list[Any]] = {title: [] for title in _GROUPS}
    for (name, *cells), k, value, error, before in zip(_base_rows(fit), fit.base.independent, *columns, strict=True):
        low, high = value - 1.96 * error, value + 1.96 * error
        ends = min(low, before, 0.0), max(high, before, 0.0)
        least, mid, most = (100.0 * (x - ends[0]) / ((ends[1] - ends[0]) or 1.0) for x in (low, before, high))
        told, of_body = not low <= 0.0 <= high, fit.base.names[k].rpartition(".")[2] in INERTIAL
        words = f"{cells[0]} +- {cells[1]}, description {figure(before, 4)}"
        stroke = ("", max(mid - 0.4, 0.0), min(mid + 0.4, 100.0), "ink")
        bars = [(words, least, most, "c2" if told else "doubtful"), stroke]
        groups[_GROUPS[2 if not told else 0 if of_body else 1]].append((name, bars, ""))
    note = "Bars: the interval of 95 %, value and standard error beside it; strokes: the description. Each row has its "
    note += "own scale, on which 0 is; SI units: kg, kg m, kg m^2; N m s/rad, N m, kg m^2, of slides likewise in m."
    for title, rows in groups.items():
        if rows:
            yield doc.Bars(title, rows, note)
            note = ""
    yield from doc.paragraphs(_hidden(fit.base))


def _hidden(base: Base) -> list[str]:
    """Return in how many parameters bodies and motors show in no torque."""
    bodies = Counter(base.names[k].rpartition(".")[0] for k in base.invisible)
    some = ", ".join(f"{name} {amount}" for name, amount in bodies.items())
    return [f"{len(base.invisible)} of {len(base.names)} parameters show in no torque: {some}"] if bodies else []


def verdict(found: Identified) -> str:
    """Return the errors of the description and of what was found, held out if something is."""
    new, old = found.judged
    which = "held-out torques" if found.held_out else "torques (none are held out)"
    within, by = _percent(new.relative_error), _percent(old.relative_error)
    return f"{found.model.name}: {which} within {within}; by the description {by}"


def _identified_head(found: Identified) -> list[str]:
    base = found.base.base
    return [
        verdict(found),
        f"fitted within {_percent(found.train.relative_error)}; least squares without physical bounds reach "
        f"{_percent(found.bound_train.relative_error)}"
        + (f", held out {_percent(found.bound_held_out.relative_error)}" if found.bound_held_out else ""),
        f"{count(found.samples, 'sample')} in {found.duration:.6g} s; computed and measured torques through a "
        f"zero-phase filter of {found.cutoff:g} Hz, in which errors are told; {found.rows} rows left",
        f"{base.rank} base parameters, condition {figure(base.condition)}; strength of the prior {found.strength:g}",
        "every body can exist" if found.consistent else "a body cannot exist as found",
    ]


def _percent(part: float) -> str:
    return f"{100.0 * part:.2f}%"


def identified_json(found: Identified) -> str:
    """Return errors, base parameters with standard errors, motors, and every parameter before and after."""
    fit = found.base
    columns = (fit.values.tolist(), fit.standard_errors.tolist(), fit.consistent.tolist())
    base = [
        {"name": group, "parameter": fit.base.names[k], "value": value, "standard_error": error, "calibrated": after}
        for group, k, value, error, after in zip(fit.base.groups, fit.base.independent, *columns, strict=True)
    ]
    return doc.written(
        doc.select(
            found,
            "robot:model.name train held_out original bound consistent better base_parameters rank:base.base.rank "
            "condition:base.base.condition friction coupled discrepancy delays "
            "strength cutoff slip_speed unseen parameters rows samples "
            "duration logs warnings",
            original={**_errors_json(found.judged[1]), **_both_json(found.original_train, found.original_held_out)},
            bound=_both_json(found.bound_train, found.bound_held_out),
            base_parameters=base,
            friction=[{"name": name, **doc.encode(fit)} for name, fit in found.motors.items()],
            coupled=[{"name": name, "unexplained": part} for name, part in found.coupled.items()],
            parameters=[
                {"name": name, "described": before, "calibrated": after}
                for name, before, after in zip(found.names, found.described.tolist(), found.theta.tolist(), strict=True)
            ],
            discrepancy=dict(found.discrepancy),
            delays=dict(found.delays),
            logs=[{"path": path, "sha256": sha256} for path, sha256 in found.hashes.items()],
        )
    )


def _errors_json(errors: Errors) -> dict[str, Any]:
    return {"relative_error": doc.finite(errors.relative_error), "joints": dict(errors.joints)}


def _both_json(train: Errors, held_out: Errors | None) -> dict[str, Any]:
    return {"train": _errors_json(train), "held_out": held_out and _errors_json(held_out)}


def excitation_sections(found: Excitation) -> Iterator[doc.Section]:
    """Yield how telling the motion is, what each joint does, and each base parameter's predicted standard error."""
    series = found.series
    verdict = excitation_verdict(found)
    rate = f"{found.motion.shape[1]} rows at {found.rate:.6g} /s"
    rest = "it begins and ends at rest, at its first and last row"
    length = f"period {series.period:g} s, {series.harmonics} harmonics, {rate}; {rest}"
    apart = "self-collision is not looked at beyond the joints' limits"
    yield doc.paragraphs([verdict.headline, length, *verdict.reasons, apart])
    rows = []
    for joint in found.joints:
        names = ("speed", "acceleration", "effort")
        speed, acceleration, effort = (use(getattr(joint, name), getattr(joint, f"{name}_limit")) for name in names)
        moves = (f"{joint.least:.3f}", f"{joint.largest:.3f}"), (speed, acceleration)
        places, used = moves if joint.moves else ((f"{joint.centre:.3f}", "held"), ("-", "-"))
        unit = "m" if joint.unit == "N" else "rad"
        rows.append((joint.name, *places, unit, *used, effort, f"{joint.noise:.3g} {joint.unit}"))
    head = ("joint", "from", "to", "unit", "speed", "acceleration", "effort", "noise")
    note = f"Largest magnitudes are of limits; positions keep {100 * MARGIN:.0f}% of the range from theirs."
    yield [doc.Table("", head, rows, note)]
    base, parameters = found.base, []
    columns = found.values.tolist(), found.information.standard_errors.tolist()
    for group, value, error in zip(base.short_groups, *columns, strict=True):
        relative = 100.0 * error / abs(value) if value else inf
        share = f"{figure(relative, 2)}%" if relative < 1e3 else "-"
        parameters.append((group, figure(value, 4), figure(error, 2), share))
    title = ("base parameter", "value", "standard error", "relative")
    note = "Values are the description's; errors are those of least squares over all rows of one period, with noise"
    yield [doc.Table("", title, parameters, f"{note} independent from row to row.")]
    yield doc.paragraphs(_hidden(base) or ["every parameter shows in some torque"])
    yield doc.remarks("note", found.notes)


def excitation_page(found: Excitation, pictures: bool = True) -> doc.Document:
    """Return the verdict, the robot along the motion, its use of limits, standard errors, the same, and files."""
    summary, *sections = excitation_sections(found)
    reasons = tuple(block.text for block in summary[1:] if isinstance(block, doc.Paragraph))
    blocks: list[doc.Block] = [replace(excitation_verdict(found), reasons=reasons)]
    if pictures:
        blocks += [*_along_motion(found), *doc.titled("Parameters", [_error_bars(found)])]
    motion = doc.csv_text(("time", *found.names), [[t, *row] for t, row in zip(found.time, found.columns, strict=True)])
    files = [("excite.json", excitation_json(found)), ("motion.csv", motion)]
    how, what = "robodyn excite --format json and --out write it to a file", "A motion that shows parameters"
    return doc.page(found.model.name, what, blocks, sections, "Motion", files, how)


def _along_motion(found: Excitation) -> Iterator[doc.Block]:
    """Yield the robot along the motion, and how much of limits of position, speed, acceleration and effort is used."""
    from robodyn.report.charts import COLOURS, Course, time_chart
    from robodyn.support.courses import Courses

    used: dict[str, dict[str, Floats]] = {kind: {} for kind in ("position", "speed", "acceleration", "effort")}
    for joint, q, qd, qdd, tau in zip(found.joints, *(each.T for each in (*found.motion, found.torques)), strict=True):
        if joint.moves and joint.bounds is not None:
            low, high = joint.bounds
            used["position"][joint.name] = (q - (low + high) / 2.0) * (200.0 / (high - low))
            used["speed"][joint.name] = 100.0 * qd / joint.speed_limit
            used["acceleration"][joint.name] = 100.0 * qdd / joint.acceleration_limit
        if joint.effort_limit:
            used["effort"][joint.name] = 100.0 * tau / joint.effort_limit
    names = [f"{kind}_{name}" for kind in ("q", "tau") for name in found.model.joint_names]
    curves = {f"{kind} {name}": values for kind, each in used.items() for name, values in each.items()}
    gathered = Courses(("time", *names), [*curves])
    gathered.update((found.time, *found.motion[0].T, *found.torques.T), [*curves.values()])
    course = Course(gathered)
    yield from played("The motion, again and again", found.model, course.frames, "tau", loop=True)
    charts, levels = [], [(100.0, "limit"), (-100.0, "limit")]
    for kind, shares in used.items():
        of = "range, -100 to 100" if kind == "position" else "limits"
        for first in range(0, len(shares), len(COLOURS)):
            some = [*shares][first : first + len(COLOURS)]
            shown = {printable(name): course.curve(f"{kind} {name}", 0.0) for name in some}
            most = ", ".join(f"{printable(name)} {np.abs(shares[name]).max():.0f} %" for name in some)
            alt = f"{kind.capitalize()} over time in percent of {of}; largest: {most}"
            charts.append(time_chart(f"{kind.capitalize()} [% of {of}]", alt, course.time, shown, "%", levels=levels))
    yield from doc.titled("Within limits", doc.gallery(charts))


def _error_bars(found: Excitation) -> doc.Bars:
    """Return each base parameter's relative standard error, and that by plain waves, on a logarithmic scale."""
    rows, known = [], found.plain.rank == found.base.rank
    plain = found.plain.standard_errors.tolist() if known else [inf] * found.base.rank
    columns = (found.values.tolist(), found.information.standard_errors.tolist(), plain)
    for group, value, *errors in zip(found.base.short_groups, *columns, strict=True):
        part, beside = (100.0 * error / abs(value) if value else inf for error in errors)
        said = f"{figure(value, 4)} +- {figure(errors[0], 2)}" + (f", {figure(part, 2)} %" if part < inf else "")
        colour = "good" if part < 10.0 else "doubtful" if part < 100.0 else "bad"
        bars = [(said, part, colour) if part < inf else (said, 0.0, "raised")]
        bars += [(f"plain waves {figure(beside, 2)} %", beside, "soft")] if beside < inf else []
        places = [25.0 * (float(np.log10(max(size, 1e-2)).clip(-2.0, 2.0)) + 2.0) for _, size, _ in bars]
        rows.append(
            (group, [(label, 0.0, to, colour) for (label, _, colour), to in zip(bars, places, strict=True)], "")
        )
    note = "Bars are on a logarithmic scale from 0.01 % to 100 % of the value. Values in SI units."
    return doc.Bars("Standard errors of base parameters", rows, note)


def excitation_verdict(found: Excitation) -> doc.Verdict:
    """Return how many parameters the motion shows, and how well beside plain waves."""
    moving = count(sum(joint.moves for joint in found.joints), "joint")
    own, plain = (
        f"condition {each.condition:.3g}, log-determinant {each.log_determinant:.1f}"
        for each in (found.information, found.plain)
    )
    beside = f"{own}; plain waves of this period and these limits"
    if found.plain.rank < found.base.rank:
        beside += f" show {found.plain.rank} of them"
    else:
        beside += f": {plain}; standard errors are {figure(found.gain)} times smaller, in the geometric mean"
    shown = f"{found.model.name}: a motion of {moving} that shows {found.base.rank} base parameters"
    return doc.Verdict("good", shown, (beside,))


def excitation_json(found: Excitation) -> str:
    """Return joints with their series, base parameters with predicted standard errors, and what plain waves show."""
    base = found.base
    columns = (found.values.tolist(), found.information.standard_errors.tolist())
    parameters = [
        {"name": group, "parameter": base.names[k], "value": value, "standard_error": error}
        for group, k, value, error in zip(base.groups, base.independent, *columns, strict=True)
    ]
    return doc.written(
        doc.select(
            found,
            "robot:model.name period:series.period harmonics:series.harmonics rate rows joints base_parameters "
            "rank:information.rank condition:information.condition? log_determinant:information.log_determinant? "
            "plain[rank condition? log_determinant?] gain? invisible warnings:notes",
            rows=found.motion.shape[1],
            base_parameters=parameters,
            invisible=[base.names[k] for k in base.invisible],
        )
    )
