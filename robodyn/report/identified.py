"""The result of `identify`: how well the log is explained, by which parameters, and how well those are known."""

from __future__ import annotations

from collections.abc import Iterator
from math import floor, log10

from robodyn.identification.identified import Errors, Identified, MotorFit
from robodyn.report.document import Block, Document, Section, Table, Verdict, data_blocks, on_page, paragraphs, remarks
from robodyn.report.json.identified import identified_json
from robodyn.support.floats import HALF_UP
from robodyn.support.wording import count, figure, listed

_DECIMALS = 8
"""From so many on, numbers are written with an exponent."""


def identified_sections(found: Identified) -> Iterator[Section]:
    """Yield errors by joint, friction and rotors, base parameters with their standard errors, and what was assumed."""
    yield paragraphs(_head(found))
    yield [_errors(found)]
    yield [_motors(found)]
    yield [_base(found)]
    if found.unseen:
        yield paragraphs([f"no torque of the log shows anything of {listed(found.unseen)}: as described"])
    yield remarks("note", found.warnings)


def identified_page(found: Identified) -> Document:
    """Return the same as a page, with JSON as data."""
    blocks: list[Block] = [Verdict("good" if found.better else "bad", verdict(found), tuple(_head(found)))]
    blocks += on_page(identified_sections(found), "In numbers")
    blocks += data_blocks([("identify.json", identified_json(found))], "robodyn identify --format json writes it")
    return Document(found.model.name, "Parameters that explain logs", tuple(blocks))


def verdict(found: Identified) -> str:
    """Return the errors of the description and of what was found, held out if something is."""
    new, old = found.held_out or found.train, found.original_held_out or found.original_train
    which = "held-out torques" if found.held_out else "torques (none are held out)"
    return (
        f"{found.model.name}: {which} within {_percent(new.relative_error)}; "
        f"by the description {_percent(old.relative_error)}"
    )


def _head(found: Identified) -> list[str]:
    base = found.base.base
    lines = [
        verdict(found),
        f"fitted within {_percent(found.train.relative_error)}; least squares without physical bounds reach "
        f"{_percent(found.bound_train.relative_error)}"
        + (f", held out {_percent(found.bound_held_out.relative_error)}" if found.bound_held_out else ""),
        f"{count(found.samples, 'sample')} in {found.duration:.6g} s; computed and measured torques through a "
        f"zero-phase filter of {found.cutoff:g} Hz, in which errors are told; {found.rows} rows left",
        f"{base.rank} base parameters, condition {figure(base.condition)}; strength of the prior {found.strength:g}",
    ]
    lines.append("every body can exist" if found.consistent else "a body cannot exist as found")
    return lines


def _percent(part: float) -> str:
    return f"{100.0 * part:.2f}%"


def _errors(found: Identified) -> Table:
    head = ("relative error", "fitted", "held out", "description, fitted", "description, held out")
    parts = (found.train, found.held_out, found.original_train, found.original_held_out)
    rows = [("all joints", *(_of(each, None) for each in parts))]
    rows += [(name, *(_of(each, name) for each in parts)) for name in found.train.joints]
    return Table("", head, rows, "||computed - measured|| / ||measured||, in N m")


def _of(errors: Errors | None, joint: str | None) -> str:
    if errors is None:
        return "-"
    return _percent(errors.relative_error if joint is None else errors.joints[joint])


def _motors(found: Identified) -> Table:
    head = ("motor", "viscous", "Coulomb", "offset", "breakaway", "decays with", "load", "rotor")
    units = "N m s/rad, N m, N m, N m, rad/s, part of the torque through the gear, kg m^2; of slides likewise in m."
    offset = "Offset: half of what friction differs by direction, or the sensor's."
    return Table("", head, [_motor(*pair) for pair in found.motors.items()], f"{units} {offset}")


def _motor(name: str, fit: MotorFit) -> tuple[str, ...]:
    values = (fit.viscous, fit.coulomb, fit.offset, fit.stribeck, fit.stribeck_velocity, fit.load, fit.rotor)
    return (name, *("-" if value is None else figure(value) for value in values))


def _base(found: Identified) -> Table:
    fit = found.base
    columns = (fit.values.tolist(), fit.standard_errors.tolist(), fit.consistent.tolist())
    rows = [
        (group, *(_known(each, error) for each in (value, error, after)))
        for group, value, error, after in zip(fit.base.short_groups, *columns, strict=True)
    ]
    note = "Values by least squares without bounds; errors count that residuals of neighbouring rows are alike."
    return Table("", ("base parameter", "value", "standard error", "calibrated"), rows, note)


def _known(value: float, error: float) -> str:
    """Return a value to a tenth of the first digit of its standard error: further digits tell nothing."""
    if not error > 0.0:
        return figure(value, 4)
    digits = 1 - floor(log10(error))
    text = f"{value * HALF_UP:.{max(digits, 0)}f}" if digits < _DECIMALS else f"{value * HALF_UP:.2g}"
    return text if text.strip("-0.") else text.lstrip("-")
