"""`envelope`: worst poses, bounds, what can be carried; the robot in these poses, and a map around the worst."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf

import numpy as np

from robodyn.report import document as doc
from robodyn.report.charts import plane_chart
from robodyn.report.table import gravity_text, number, percent, point_text, printable
from robodyn.robot.kinematics import configuration
from robodyn.sizing.envelope import Envelope, JointEnvelope, Load
from robodyn.support.floats import BEYOND, Floats, ranked
from robodyn.support.wording import count, shown

_PICTURED = 12
"""Joints whose worst poses a page shows, those that use most of their limits."""
_GRID = 41
_COLOURS = ("c1", "c3", "c2", "c6", "bad")
"""Of a map, for each quarter of the worst torque, and beyond the limit."""
Size = dict[str, float]


def envelope_sections(found: Envelope) -> Iterator[doc.Section]:
    """Yield joints with their worst poses, bearings, the base, remarks and the verdict, with what can be carried."""
    size = _sizes(found)
    joints = count(len(found.joints), "joint")
    yield doc.paragraphs([f"{found.robot}: {joints} holding still, {gravity_text(found.scene.gravity)}"])
    rows = []
    for joint in found.joints:
        use = "-" if joint.use is None else f"{percent(100.0 * joint.use)} %"
        limits = [(joint.effort_limit, "effort"), (joint.motor_limit, "motor")]
        by = [f"{number(limit)} by {what}" for limit, what in limits if limit is not None and limit == joint.limit][:1]
        rows.append([joint.name, *_load(joint.load, size), _gap(joint.load), *(by or ["-"]), use])
    head = ["joint", "most", "no pose exceeds", "gap", "limit", "use"]
    yield [doc.Table("The most that weight asks of joints", head, rows)]
    rows = [
        [joint.name, *(_position(x) for x in joint.load.pose.values())] for joint in found.joints if joint.load.value
    ]
    note = "Joints that do not matter stand where they are nearest to 0."
    yield [doc.Table("In these poses [rad, m]", ["worst of", *found.box], rows, note)] if rows else []
    rows = [
        [joint.name, *_load(joint.tilting, size), _gap(joint.tilting), *_load(joint.radial, size), _gap(joint.radial)]
        for joint in found.joints
    ]
    head = ["joint", "tilting moment", "no pose exceeds", "gap", "radial force", "no pose exceeds", "gap"]
    yield [doc.Table("Bearings and guides, at the joint's origin", head, rows)]
    value, bound = _load(found.tipping, size)
    tipping = ("tipping moment of the base", value), ("no pose exceeds", f"{bound} N m, gap {_gap(found.tipping)}")
    yield [doc.Facts((*tipping, ("weight on the base", f"{number(found.weight)} N")))]
    yield doc.remarks("note", _notes(found))
    end = verdict(found)
    yield doc.paragraphs([f"{end.headline}.", *end.reasons])


def _sizes(found: Envelope) -> Size:
    """Return the largest load of each unit, beside which others are nothing."""
    size = {"N": abs(found.weight), "N m": found.tipping.bound}
    for load in (load for joint in found.joints for load in (joint.load, joint.tilting, joint.radial)):
        size[load.unit] = max(size[load.unit], load.bound)
    return size


def _load(load: Load, size: Size) -> tuple[str, str]:
    value, bound = (number(x, size[load.unit]) for x in (load.value, load.bound))
    return f"{value} {load.unit}", bound


def _gap(load: Load) -> str:
    return "-" if not load.value else "<0.01 %" if load.gap < 1e-4 else f"{100.0 * load.gap:.2g} %"


def _position(value: float) -> str:
    return f"{0.0 if abs(value) < 5e-5 else value:.4f}"


def _payload(found: Envelope) -> Iterator[str]:
    one = found.payload
    if one is None:
        return
    where = f"{shown(one.link)}{f' at {point_text(one.point)} m' if any(one.point) else ''}"
    if one.mass is None:
        yield f"Payload on {where}: no mass makes a joint pass a limit that is known."
    elif one.mass == 0.0:
        yield f"Payload on {where}: none, {one.joint} is beyond its limit without."
    else:
        pose = ", ".join(f"{name} {_position(x)}" for name, x in one.pose.items())
        sure = f"with {number(one.certified or 0.0)} kg no pose passes a limit"
        yield f"Payload on {where}: {number(one.mass)} kg, by {one.joint} at {pose}; {sure}."


def _notes(found: Envelope) -> Iterator[str]:
    yield from found.notes
    if found.unlimited:
        names = ", ".join(map(printable, found.unlimited))
        yield f"no limit of effort or motor is known of {names}"
    if found.samples is not None:
        one = found.samples
        reach = f"{one.count} random poses reach {100.0 * one.share:.4g} % of a bound at most"
        yield f"{reach}, of {one.of}" if one.of else reach


def verdict(found: Envelope) -> doc.Verdict:
    """Return whether every pose can be held, and what can be carried in all."""
    if found.samples is not None and found.samples.share > 1.0:
        return doc.Verdict("bad", f"A random pose exceeds the bound of {found.samples.of}: please report this robot")
    over = found.exceeded
    if over:
        lines = [f"{joint.name}: {_said(joint)}" for joint in over]
        some = "1 joint is" if len(over) == 1 else f"{len(over)} joints are"
        return doc.Verdict("bad", f"{some} beyond the limit in the worst pose", (*lines[:15], *_payload(found)))
    unsure = [x for x in found.joints if x.limit is not None and x.load.bound > BEYOND * x.limit]
    worst = found.worst
    if worst is None:
        return doc.Verdict("neutral", "No limit of effort or motor is known", (*_payload(found),))
    if unsure:
        names = ", ".join(joint.name for joint in unsure)
        what = f"No pose was found beyond a limit, and none is excluded for {names}"
        return doc.Verdict("doubtful", what, (*_payload(found),))
    level: doc.Level = "neutral" if found.unlimited else "good"
    where = " that is known" if found.unlimited else ""
    reasons = f"{worst.name}: {_said(worst)}.", *_payload(found)
    return doc.Verdict(level, f"Every pose can be held within every limit{where}", reasons)


def _said(joint: JointEnvelope) -> str:
    share = f"{percent(100.0 * (joint.use or 0.0))} % of {number(joint.limit or 0.0)}"
    return f"{number(abs(joint.load.value))} {joint.load.unit}, {share}"


def envelope_page(found: Envelope, pictures: bool = True) -> doc.Document:
    """Return the verdict, use of limits, the robot in its worst poses, a map, and what the text says."""
    blocks: list[doc.Block] = [verdict(found), *_bars(found)]
    loaded = ranked([joint for joint in found.joints if joint.load.value], key=lambda x: x.use or 0.0)
    if pictures and loaded:
        from robodyn.report import stage

        arrows = [x for x in stage.weights(found.model, found.scene) if any(any(part) for part in x["values"])]
        poses = []
        for joint in loaded[:_PICTURED]:
            share = "" if joint.use is None else f", {percent(100.0 * joint.use)} % of its limit"
            name = f"{joint.name}: {number(joint.load.value)} {joint.load.unit}{share}"
            q = configuration(found.model, dict(joint.load.pose))
            poses.append(stage.pose(found.model, q.tolist(), arrows) | {"name": name})
        worst = {body.name for body in found.model.bodies if body.joint.name == loaded[0].name}
        shown_robot = stage.robot(found.model, poses, lit=worst)
        what = "The robot in its worst poses; in red what the joint with most use of its limit carries"
        blocks += [stage.stage(what, [shown_robot]), *_maps(found, loaded[:2])]
    *sections, _ = envelope_sections(found)
    files, how = [("envelope.json", envelope_json(found))], "robodyn envelope --format json prints it"
    return doc.page(found.robot, "Worst poses of holding still", blocks, sections, "Loads", files, how)


def _bars(found: Envelope) -> list[doc.Block]:
    rows = []
    limited = ranked([joint for joint in found.joints if joint.use is not None], key=lambda x: x.use or 0.0)
    for joint in limited:
        use = 100.0 * min(joint.use or 0.0, 10.0)
        colour = "bad" if joint in found.exceeded else "doubtful" if use > 80.0 else "good"
        rows.append((joint.name, [(f"{percent(use)} %", 0.0, min(use, 100.0), colour)], ""))
    note = "Of the effort limit, or of what the motor holds without end where that is less."
    return [doc.Bars("Use of limits in the worst pose", rows, note)] if rows else []


def _maps(found: Envelope, joints: list[JointEnvelope]) -> Iterator[doc.Block]:
    """Yield, for each joint, its torque over the two coordinates that change it most, the others in its worst pose."""
    charts = []
    units = {one.name: "m" if one.load.unit == "N" else "rad" for one in found.joints}
    for joint in joints:
        names, at, worst = [*found.box], joint.load.pose, abs(joint.load.value)
        lines = [{name: np.linspace(*ends, _GRID)} for name, ends in found.box.items()]
        far = [float(np.ptp(np.abs(_torques(found, joint, line)))) for line in lines]
        order = ranked(range(len(names)), key=lambda k: far[k])[:2]
        a, b = (names[k] for k in sorted(order if len(order) > 1 else order * 2))
        x, y = (each.ravel() for each in np.meshgrid(*(np.linspace(*found.box[name], _GRID) for name in (a, b))))
        torque = np.abs(_torques(found, joint, {a: x, b: y}))
        level = np.minimum(torque * (len(_COLOURS) - 1) / worst, len(_COLOURS) - 2).astype(np.int64)
        level[torque > (joint.limit or inf)] = len(_COLOURS) - 1
        tops = [
            f"to {number(worst * (k + 1) / (len(_COLOURS) - 1))} {joint.load.unit}" for k in range(len(_COLOURS) - 1)
        ]
        labels = dict(enumerate([*tops, "beyond the limit"]))
        dots = {label: (x[level == k], y[level == k]) for k, label in labels.items() if (level == k).any()}
        colours = {label: _COLOURS[k] for k, label in labels.items()}
        what = f"{printable(joint.name)} over {printable(a)} and {printable(b)}"
        more = "; the others as in its worst pose" if len(names) > 2 else ""
        said = f"worst: {number(joint.load.value)} {joint.load.unit}"
        alt = f"{what}; {said} at {_position(at[a])}, {_position(at[b])}"
        axes = (f"{printable(name)} [{units[name]}]" for name in (a, b))
        marks = [(at[a], at[b], said, "ink")]
        charts.append(plane_chart(what + more, alt, *axes, dots=dots, colours=colours, marks=marks))
    yield from doc.titled("Where it is heavy", doc.gallery(charts))


def _torques(found: Envelope, joint: JointEnvelope, moved: dict[str, Floats]) -> Floats:
    """(N,) the torque of a joint where some coordinates are moved from its worst pose."""
    from robodyn.dynamics.inverse import inverse_dynamics

    model, count = found.model, len(next(iter(moved.values())))
    q = np.tile(configuration(model, dict(joint.load.pose)), (count, 1))
    place = {name: k for k, name in enumerate(model.coordinates)}
    for name, values in moved.items():
        q[:, place[name]] = values
    rate = next(one.rate for one in model.independent if one.name == joint.name)
    return np.asarray(inverse_dynamics(model, q, 0.0, 0.0, scene=found.scene)[:, rate])


def envelope_json(found: Envelope) -> str:
    """Return all loads with bounds and poses, and what can be carried."""
    load = "[value bound gap? unit pose]"
    keys = "name torque:load.value bound:load.bound gap:load.gap? unit:load.unit pose:load.pose "
    keys += f"effort_limit motor_limit limit use? tilting {load} radial {load}"
    one, payload = found.payload, None
    if one is not None:
        binding = doc.select(one, "joint pose") if one.joint else None
        payload = doc.select(one, "link point mass certified binding", binding=binding)
    return doc.written(
        doc.select(
            found,
            "robot gravity:scene.gravity joints base box payload samples [count share of] exceeded unlimited notes",
            joints=[doc.select(joint, keys) for joint in found.joints],
            base=doc.select(found, f"tipping {load} weight"),
            payload=payload,
            exceeded=[joint.name for joint in found.exceeded],
            notes=[*_notes(found)],
        )
    )
