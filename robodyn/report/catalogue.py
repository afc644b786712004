"""`size`: motors and gears of a catalogue that suffice for each joint, and what rules out the others."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from robodyn.report import document as doc
from robodyn.report.charts import plane_chart
from robodyn.report.sizes import speed_unit
from robodyn.report.table import filled, first_names, number
from robodyn.sizing.catalogue import LIMITS, Catalogue, Choice, JointChoices
from robodyn.support.floats import Floats
from robodyn.support.wording import count

SHOWN = 3
"""Choices of each joint in text."""
_CURVES, _STEPS = 10, 24
"""Candidates that suffice, and that do not, whose curves are drawn; and points of each."""
_FIRST = {"mass": "lightest", "price": "cheapest", "loss": "least loss"}
_UNITS = {"mass": "kg", "price": "in price", "loss": "W lost"}


def size_sections(found: Catalogue) -> Iterator[doc.Section]:
    """Yield the best choices of each joint, what rules out the others, notes and the verdict."""
    rows = []
    for joint in found.joints:
        for k, each in enumerate(joint.choices[: min(SHOWN, joint.feasible)]):
            rows.append(["" if k else joint.name, *_row(each)])
    head = ("joint", "motor", "gear", "ratio", "mass [kg]", "price", "loss [W]", *(f"{name} %" for name in LIMITS))
    title = f"Motors and gears that suffice, {_FIRST[found.by]} first; shares of their limits"
    yield [doc.Table(title, *filled((*head, "load / rotor inertia"), rows))] if rows else []
    rows = []
    for joint in found.joints:
        fails = ", ".join(f"{amount} by {name}" for name, amount in joint.ruled_out.items())
        rows.append([joint.name, f"{joint.feasible} of {len(joint.choices)}", fails or "-", _miss(joint)])
    yield [doc.Table("What rules out the others", ("joint", "suffice", "fail most", "nearest miss"), rows)]
    yield doc.remarks("note", found.notes)
    said = verdict(found)
    yield doc.paragraphs([f"{said.headline}.", *said.reasons])


def _row(each: Choice) -> list[str]:
    shares = ("" if x is None else f"{100.0 * (1.0 - x):.3g}" for x in each.margins.values())
    price, loss = ("" if x is None else number(x) for x in (each.price, each.loss))
    ratio = "" if each.inertia_ratio is None else f"{each.inertia_ratio:.3g}"
    return [each.motor, each.gear or "-", f"{each.ratio:.6g}", f"{each.mass:.4g}", price, loss, *shares, ratio]


def _miss(joint: JointChoices) -> str:
    miss = joint.nearest
    if miss is None:
        return "-"
    excess = -100.0 * (miss.margins[miss.binding] or 0.0)
    return f"{_named(miss)}: {excess:.3g} % over its {miss.binding}"


def _named(each: Choice) -> str:
    return f"{each.motor} with {each.gear} {each.ratio:.6g}" if each.gear else f"{each.motor} at {each.ratio:.6g}"


def verdict(found: Catalogue) -> doc.Verdict:
    """Return whether every joint has a motor, what all weigh, cost and lose, and how the choice was made."""
    lacking = [joint.name for joint in found.joints if joint.best is None]
    sweeps = count(found.sweeps, "sweep")
    how = f"{sweeps} from the tips to the base, the last of which changed nothing"
    reasons = (how if found.converged else f"{sweeps} from the tips to the base, which did not settle",)
    if lacking:
        return doc.Verdict("bad", f"Nothing in the catalogue suffices for {first_names(lacking, 6)}", reasons)
    sums = [(found.total(name), unit) for name, unit in _UNITS.items()]
    totals = ", ".join(f"{number(value)} {unit}" for value, unit in sums if value is not None)
    return doc.Verdict("good", f"Every joint has a motor that suffices: {totals} in all", reasons)


def size_page(found: Catalogue, pictures: bool = True) -> doc.Document:
    """Return the verdict, torque over speed of each joint with the candidates' curves, and what the text says."""
    what = f"Motors of a catalogue: {count(len(found.motors), 'motor')}, {count(len(found.gears), 'gear')}, "
    what += f"{count(len(found.joints), 'joint')}, by {found.by}"
    charts = [_plane(found, joint) for joint in found.joints if joint.choices] if pictures else []
    sections = [*size_sections(found)]
    blocks = [verdict(found), *doc.gallery(charts)]
    data = [("catalogue.json", size_json(found))]
    return doc.page(found.robot, what, blocks, sections[:-1], "", data, "robodyn size --format json prints it")


def _plane(found: Catalogue, joint: JointChoices) -> doc.Chart:
    """Return torque over speed at a joint: its load, that of the best motor with its rotor, both times the ratio, and
    the curves of candidates."""
    speed, load, acceleration = joint.points
    pace, best = np.abs(speed), joint.choices[0]
    gears = {k: gear for k, gear in enumerate(found.gears)}
    motor, gear = found.motors[best.places[0]], gears.get(best.places[1])
    G, J, e = abs(best.ratio), motor.inertia + (gear.inertia if gear else 0.0), gear.efficiency if gear else 1.0
    driving = np.sign(load) * np.sign(speed)
    at_motor = np.abs(G * G * J * acceleration + load * np.where(driving > 0, 1 / e, np.where(driving < 0, e, 1.0)))
    own = "with the rotor of the best" if joint.best else "with the rotor of the nearest miss"
    dots = {"load": (pace, np.abs(load)), own: (pace, at_motor)}
    ends = [joint.max_speed, 1.1 * (motor.speed_limit or 0.0) / G]
    tops = np.array([np.abs(load).max(), at_motor.max()])
    reach, top = max(2.0 * ends[0], ends[1]), 3.0 * float(tops.max())
    lines, colours, named = {}, {"load": "soft", own: "ink"}, []
    chosen = joint.choices[1 : joint.feasible][:_CURVES], joint.choices[max(joint.feasible, 1) :][:_CURVES]
    for label, some, colour in (("others that suffice", chosen[0], "good"), ("do not suffice", chosen[1], "bad")):
        curves = [_curve(found, each, "peak", reach, top) for each in some]
        if curves:
            gap = np.full((2, 1), np.nan)
            lines[label] = tuple(np.hstack([part for curve in curves for part in (curve, gap)]))
            colours[label] = colour
            for each, (x, y) in zip(some, curves, strict=True):
                end = int(np.flatnonzero(np.isfinite(y))[-1:].sum())
                named += [(float(x[end]), float(y[end]), _named(each), colour)] if np.isfinite(y[end]) else []
    for name, colour in (("peak", "c1"), ("continuous", "c2")):
        label = f"{name} of {_named(best)}"
        lines[label], colours[label] = tuple(_curve(found, best, name, reach, np.inf)), colour
    words = f"{joint.name}: {_named(best)}" if joint.best else f"{joint.name}: nothing suffices"
    alt = f"Torque over speed at {joint.name} and curves of motors times the ratio; {joint.feasible} suffice"
    return plane_chart(
        words,
        alt,
        f"speed [{speed_unit(joint.unit)}]",
        f"torque [{joint.unit}]",
        dots=dots,
        lines=lines,
        marks=named,
        colours=colours,
    )


def _curve(found: Catalogue, each: Choice, name: str, reach: float, top: float) -> Floats:
    """Return (2, P) speed and torque at the joint of a motor's curve, up to a speed; nan above a torque."""
    motor, G = found.motors[each.places[0]], abs(each.ratio)
    torque, end = getattr(motor, name), motor.speed_limit or reach * G
    if torque is None:
        return np.full((2, 1), np.nan)
    knots = np.array(torque).T if isinstance(torque, tuple) else np.array([[0.0], [torque]])
    speeds = np.unique([*np.linspace(0.0, min(end, reach * G), _STEPS), *knots[0][knots[0] < min(end, reach * G)]])
    torques = G * np.interp(speeds, *knots)
    return np.array([speeds / G, np.where(torques <= top, torques, np.nan)])


def size_json(found: Catalogue) -> str:
    """Return the document of `size`; docs/reference/schemas has its keys; units are SI."""
    keys = "motor gear ratio feasible margins binding inertia_ratio mass price loss"
    joint = f"name unit peak rms max_speed feasible ruled_out best[{keys}] choices[{keys}]"
    totals = {name: found.total(name) for name in _UNITS}
    return doc.written(
        doc.select(found, f"robot by feasible mass price loss sweeps converged notes joints[{joint}]", **totals)
    )
