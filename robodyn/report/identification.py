"""`identify` and `excite`: parameters that explain a log, and a motion that shows them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from math import floor, inf, log10
from typing import Any

from robodyn.identification.excitation.excite import Excitation
from robodyn.identification.excitation.motion import MARGIN
from robodyn.identification.result import Errors, Identified
from robodyn.report import document as doc
from robodyn.report.limits import use
from robodyn.support.floats import HALF_UP
from robodyn.support.wording import count, figure, listed

_PICTURED = 12


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
    fit, known = found.base, []
    columns = (fit.values.tolist(), fit.standard_errors.tolist(), fit.consistent.tolist())
    for group, value, error, after in zip(fit.base.short_groups, *columns, strict=True):
        # to a tenth of the first digit of the standard error: further digits tell nothing
        digits = 1 - floor(log10(error)) if error > 0.0 else 0
        cells = [group]
        for each in (value, error, after):
            text = f"{each * HALF_UP:.{max(digits, 0)}f}" if digits < 8 else f"{each * HALF_UP:.2g}"
            text = text if text.strip("-0.") else text.lstrip("-")
            cells.append(text if error > 0.0 else figure(each, 4))
        known.append(cells)
    note = "Values by least squares without bounds; errors count that residuals of neighbouring rows are alike."
    yield [doc.Table("", ("base parameter", "value", "standard error", "calibrated"), known, note)]
    if found.unseen:
        yield doc.paragraphs([f"no torque of the log shows anything of {listed(found.unseen)}: as described"])
    yield doc.remarks("note", found.warnings)


def identified_page(found: Identified) -> doc.Document:
    """Return the same as a page, with JSON as data."""
    first = [doc.Verdict("good" if found.better else "bad", verdict(found), tuple(_identified_head(found)))]
    files, how = [("identify.json", identified_json(found))], "robodyn identify --format json writes it"
    return doc.page(
        found.model.name, "Parameters that explain logs", first, identified_sections(found), "Fit", files, how
    )


def verdict(found: Identified) -> str:
    """Return the errors of the description and of what was found, held out if something is."""
    new, old = found.held_out or found.train, found.original_held_out or found.original_train
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
    held = found.original_held_out or found.original_train
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
            original={**_errors_json(held), **_both_json(found.original_train, found.original_held_out)},
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
    bodies = Counter(base.names[k].rpartition(".")[0] for k in base.invisible)
    some = ", ".join(f"{name} {amount}" for name, amount in bodies.items())
    hidden = f"{len(base.invisible)} of {len(base.names)} parameters show in no torque: {some}"
    yield [doc.Paragraph(hidden if bodies else "every parameter shows in some torque")]
    yield doc.remarks("note", found.notes)


def excitation_page(found: Excitation, pictures: bool = True) -> doc.Document:
    """Return the same as a page, with plots of the joints, and the motion as data."""
    blocks: list[doc.Block] = [excitation_verdict(found)]
    if pictures:
        from robodyn.report.pictures.figures import joint_figure

        joints = [(k, joint) for k, joint in enumerate(found.joints) if joint.moves]
        shown = [
            joint_figure(joint.name, joint.unit == "N", found.time, (*found.motion[:2, :, k], found.torques[:, k]))
            for k, joint in joints[:_PICTURED]
        ]
        some = [doc.Paragraph(f"The first {_PICTURED} of {len(joints)} joints.")] if len(joints) > _PICTURED else []
        blocks += [doc.Heading("Along the motion"), *some, doc.Gallery(tuple(shown))]
    motion = doc.csv_text(("time", *found.names), [[t, *row] for t, row in zip(found.time, found.columns, strict=True)])
    files = [("excite.json", excitation_json(found)), ("motion.csv", motion)]
    how, what = "robodyn excite --format json and --out write it to a file", "A motion that shows parameters"
    return doc.page(found.model.name, what, blocks, excitation_sections(found), "Motion", files, how)


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
