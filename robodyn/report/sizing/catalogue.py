"""`size`: motors and gears of a catalogue that suffice for each joint, and what rules out the others."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from robodyn.loads.sizing import allowed
from robodyn.report import document as doc
from robodyn.report.charts import plane_chart
from robodyn.report.sizes import speed_unit
from robodyn.report.table import filled, first_names, number
from robodyn.scene.scene import Curve
from robodyn.sizing.catalogue import Catalogue, Choice, JointChoices
from robodyn.support.floats import Floats
from robodyn.support.wording import count

SHOWN = 3
"""Choices of each joint in text."""
_CURVES, _STEPS, _POINTS = 6, 49, 1500
"""Candidates that suffice, and that do not, whose curves are drawn; points of each, and of the load."""
_SHARES = ("speed", "input", "peak", "RMS", "gear peak", "gear mean", "of the ratio")
"""As heads of columns, what `LIMITS` are."""
_FIRST = {"mass": "lightest", "price": "cheapest", "loss": "least loss"}
_UNITS = {"mass": "kg", "price": "in price", "loss": "W lost"}


def size_sections(found: Catalogue) -> Iterator[doc.Section]:
    """Yield the best choices of each joint, what rules out the others, notes and the verdict."""
    rows = []
    for joint in found.joints:
        for k, each in enumerate(joint.choices[: min(SHOWN, joint.feasible)]):
            rows.append(["" if k else joint.name, *_row(each)])
    head = ("joint", "motor", "gear", "ratio", "mass [kg]", "price", "loss [W]", *_SHARES, "inertia ratio")
    title = f"Motors and gears that suffice, {_FIRST[found.by]} first; shares of their limits in %"
    yield [doc.Table(title, *filled(head, rows))] if rows else []
    rows = []
    for joint in found.joints:
        fails, nearest = ", ".join(f"{amount} by {name}" for name, amount in joint.ruled_out.items()), "-"
        for miss in joint.choices[joint.feasible :][:1]:
            nearest = f"{_named(miss)}: {-100.0 * (miss.margins[miss.binding] or 0.0):.3g} % over its {miss.binding}"
        rows.append([joint.name, f"{joint.feasible} of {len(joint.choices)}", fails or "-", nearest])
    yield [doc.Table("What rules out the others", ("joint", "suffice", "fail most", "nearest miss"), rows)]
    yield doc.remarks("note", found.notes)
    said = verdict(found)
    yield doc.paragraphs([f"{said.headline}.", *said.reasons])


def _row(each: Choice) -> list[str]:
    shares = ("" if x is None else "0" if x > 1.0 - 1e-6 else f"{100.0 * (1.0 - x):.3g}" for x in each.margins.values())
    known = ("" if x is None else number(x, 1.0) for x in (each.price, each.loss))
    row = [each.motor.name, each.gear.name or "-", f"{each.ratio:.6g}", f"{each.mass:.4g}", *known, *shares]
    return [*row, "" if each.inertia_ratio is None else f"{each.inertia_ratio:.3g}"]


def _named(each: Choice) -> str:
    name = each.motor.name
    return f"{name}, {each.gear.name} {each.ratio:.6g}" if each.gear.name else f"{name}, ratio {each.ratio:.6g}"


def verdict(found: Catalogue) -> doc.Verdict:
    """Return whether every joint has a motor, what all weigh, cost and lose, and how the choice was made."""
    if not found.converged:
        return doc.Verdict("doubtful", "The choice does not settle", found.notes[-1:])
    lacking = [joint.name for joint in found.joints if joint.best is None]
    sweeps = count(found.sweeps, "sweep")
    reasons = (f"{sweeps} from the tips to the base, the last of which changed nothing",)
    if lacking:
        return doc.Verdict("bad", f"Nothing in the catalogue suffices for {first_names(lacking, 6)}", reasons)
    sums = [(found.total(name), unit) for name, unit in _UNITS.items()]
    totals = ", ".join(f"{number(value)} {unit}" for value, unit in sums if value is not None)
    return doc.Verdict("good", f"Every joint has a motor that suffices: {totals} in all", reasons)


def size_page(found: Catalogue, pictures: bool = True) -> doc.Document:
    """Return the verdict, torque over speed of each joint with the candidates' curves, and what the text says."""
    what = f"Motors and gears of a catalogue for {count(len(found.joints), 'joint')}, by {found.by}"
    charts = [_plane(joint) for joint in found.joints if joint.choices] if pictures else []
    sections = [*size_sections(found)]
    blocks = [verdict(found), *doc.gallery(charts)]
    data = [("catalogue.json", size_json(found))]
    return doc.page(found.robot, what, blocks, sections[:-1], "", data, "robodyn size --format json prints it")


def _plane(joint: JointChoices) -> doc.Chart:
    """Return torque over speed at a joint, up to three times its speed: its load, that of the best motor with its
    rotor, and the curves of candidates, torques times and speeds over the ratio."""
    course, best = joint.course, joint.choices[0]
    rows = slice(None, None, -(-len(course.load) // _POINTS))
    at_motor = np.abs(best.ratio**2 * best.inertia * course.qdd + course.geared(best.gear.efficiency)[0])[rows]
    pace, with_rotor = course.speed[rows], f"with the rotor of the {'best' if joint.best else 'nearest miss'}"
    dots = {"load": (pace, np.abs(course.load[rows])), with_rotor: (pace, at_motor)}
    colours, lines = {"load": "soft", with_rotor: "ink"}, dict[str, tuple[Floats, Floats]]()
    reach, top = 3.0 * course.max_speed, 3.0 * max(course.peak, float(at_motor.max()))
    for name, colour in (("peak", "c1"), ("continuous", "c2")):
        label = f"{name} of {_named(best)}"
        lines[label], colours[label] = _curve(best, getattr(best.motor, f"{name}_torque"), reach, np.inf), colour
    others = joint.choices[1 : joint.feasible][:_CURVES], joint.choices[max(joint.feasible, 1) :][:_CURVES]
    for some, colour, suffix in zip(others, ("good", "bad"), ("", ": fails"), strict=True):
        for each in some:
            label = f"{_named(each)}{suffix}"
            lines[label], colours[label] = _curve(each, each.motor.peak_torque, reach, top), colour
    words = f"{joint.name}: {_named(best)}" if joint.best else f"{joint.name}: nothing suffices"
    alt = f"Torque over speed at {joint.name} and curves of motors times the ratio; {joint.feasible} suffice"
    axes = f"speed [{speed_unit(joint.unit)}]", f"torque [{joint.unit}]"
    return plane_chart(words, alt, *axes, dots=dots, lines=lines, colours=colours)


def _curve(each: Choice, torque: float | Curve | None, reach: float, top: float) -> tuple[Floats, Floats]:
    """Return speed and torque at the joint of a motor's curve, up to a speed; nan above a torque."""
    G = abs(each.ratio)
    speeds = np.linspace(0.0, min(each.motor.speed_limit or np.inf, reach * G), _STEPS)
    torques = G * allowed(torque, speeds)
    return speeds / G, np.where(torques <= top, torques, np.nan)


def size_json(found: Catalogue) -> str:
    """Return the document of `size`; docs/reference/schemas has its keys; units are SI."""
    keys = "motor:motor.name gear:gear.name ratio feasible margins binding inertia_ratio mass price loss"
    load = "peak:course.peak rms:course.rms max_speed:course.max_speed"
    joint = f"name unit {load} feasible ruled_out best[{keys}] choices[{keys}]"
    totals = {name: found.total(name) for name in _UNITS}
    return doc.written(
        doc.select(found, f"robot by feasible mass price loss sweeps converged notes joints[{joint}]", **totals)
    )
