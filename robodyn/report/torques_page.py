"""`torques` as a page: verdict, use of limits, the robot moving, plots, what the text says; runs over each other; and
`view`: a robot with sliders for its joints, or along a motion."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from html import escape
from itertools import product
from math import inf
from typing import TYPE_CHECKING

import numpy as np

from robodyn.dynamics.constraints.constraint_jacobian import tree_scene
from robodyn.equations.free_body.bodies import free_bodies
from robodyn.errors import RobodynError
from robodyn.loads.result import DEGREES, JointLoad, Result
from robodyn.loads.sizing import allowed, load_torque, motor_torque, train_of
from robodyn.loads.statistics import joint_of_rates
from robodyn.report import document as doc
from robodyn.report import stage
from robodyn.report.charts import Course, plane_chart, time_chart
from robodyn.report.equations.equations import action_table
from robodyn.report.limits import effort_use, limits_verdict, offenders, use_bars, worst_joint
from robodyn.report.sizes import Sizes, free_body_sizes, result_sizes, speed_unit
from robodyn.report.table import first_names, gravity_text, is_noise, moment, number, printable
from robodyn.report.torques import load_table, torques_json, torques_sections
from robodyn.robot.kinematics import Values, beyond_limits, configuration, nearest_to_zero
from robodyn.robot.model import Joint, Model
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import Floats, ranked
from robodyn.support.wording import count

if TYPE_CHECKING:
    import os

    from robodyn.loads.result import History
    from robodyn.loads.temperature import Heat
    from robodyn.trajectory.motion import Trajectory
    from robodyn.trajectory.read import TrajectoryReader

    Motion = Trajectory | TrajectoryReader | str | os.PathLike[str]

PLOTTED = 12
"""Joints that have plots: those beyond limits, and the most loaded of the others up to so many."""
_NEAR = 0.5
"""A limit is drawn where at least this share of it is reached; it would flatten the curve otherwise."""


def torques_page(result: Result, model: Model, scene: Scene, pictures: bool = True) -> doc.Document:
    """Return the verdict, use of limits, robot and plots if there is a history, and all that the text says."""
    what = (
        f"Torques along a motion: {count(len(result.joints), 'joint')}, {count(result.samples, 'sample')}, "
        f"{result.duration:.6g} s, {gravity_text(result.gravity)}"
    )
    blocks: list[doc.Block] = [limits_verdict(result)]
    head, rows = load_table(result)
    files = [("result.json", torques_json(result)), ("joints.csv", doc.csv_text(head, rows))]
    if pictures and result.history is not None:
        words = (
            "The robot along the motion; links are coloured by what their joints use of their limits, red above 100 %"
        )
        course = Course(result.history.motion)
        shown = stage.robot(model, [motion_of(course, result, model, scene)])
        blocks.append(stage.stage(words, [shown]))
    blocks += use_bars(result)
    if pictures and result.history is not None:
        blocks += _charts(result, model, scene, result.history, course)
    sections = torques_sections(result, explain=True)
    how = "robodyn torques --format json and --out write it to a file"
    return doc.page(result.robot, what, blocks, sections, "Loads", files, how)


def motion_of(course: Course, result: Result, model: Model, scene: Scene) -> dict[str, object]:
    """Return the motion of a page's robot, with what acts and how far limits are used."""
    columns = course.frames
    tree = tree_scene(model, scene) if scene.constrained else scene
    q = [columns[f"q_{name}"] for name in model.coordinates]
    loads = {load.name: load for load in result.joints}
    use = [
        (share, 1.0) if load and (share := _use(course, load, body.joint, scene)) is not None else None
        for body in model.bodies
        for load in [loads.get(body.joint.name)]
    ]
    arrows = stage.loads(model, tree, columns, scene.contacts)
    return stage.motion("", columns["time"], q, rows=course.frame_rows, use=use, arrows=arrows)


def _use(course: Course, load: JointLoad, joint: Joint, scene: Scene) -> Floats | None:
    """Return (F,) the largest share that a joint uses of its limits of effort and speed, and those of its motor; above
    1 also beyond a position limit."""
    shares = [
        np.abs(course.frames[f"{key}_{load.name}"]) / limit
        for key, limit in (("tau", load.effort_limit), ("qd", load.velocity_limit))
        if limit
    ]
    motor, shaft = scene.motor.get(joint.name), _at_shaft(course, joint, scene)
    if motor is not None and shaft is not None:
        torque, speed = map(np.abs, shaft)
        with np.errstate(divide="ignore", invalid="ignore"):
            shares.append(np.nan_to_num(torque / allowed(motor.peak, speed), nan=0.0, posinf=10.0))
        if motor.max_speed:
            shares.append(speed / motor.max_speed)
    if any(each.quantity == "position" for each in load.exceeded):
        q, low, high = course.frames[f"q_{joint.name}"], load.lower, load.upper
        over = (q < (-inf if low is None else low)) | (q > (inf if high is None else high))
        shares.append(np.where(over, 1.01, 0.0))
    return np.max(shares, axis=0) if shares else None


def _at_shaft(course: Course, joint: Joint, scene: Scene) -> tuple[Floats, Floats] | None:
    """Return (F,) torque and speed of the motor that drives a joint; None without one."""
    train = train_of(joint, scene)
    if train is None:
        return None
    tau, qd, qdd = (course.frames[f"{key}_{joint.name}"] for key in ("tau", "qd", "qdd"))
    return motor_torque(train, load_torque(train, tau, qdd), qd, qdd), train.gear * qd


def _charts(result: Result, model: Model, scene: Scene, history: History, course: Course) -> Iterator[doc.Block]:
    """Yield all charts, heading by heading; of joints those beyond limits and the most loaded."""
    joints, size, over = result.joints, result_sizes(result), offenders(result)
    moving = [k for k in range(len(joints)) if not _rests(joints[k], size)]
    loaded = sorted(ranked(moving, key=lambda k: effort_use(joints[k])), key=lambda k: joints[k].name not in over)
    shown = sorted(loaded[: max(PLOTTED, len(over))])
    said = []
    if len(shown) < len(moving):
        some = f"{len(shown)} of {len(joints)}; the tables have all."
        said.append(f"The joints beyond a limit, and those that use most of their limits of effort, {some}")
    if still := [printable(joint.name) for joint in joints if _rests(joint, size)]:
        said.append(f"Without a plot, because they neither move nor carry anything: {', '.join(still)}.")
    if shown and course.motion.per > 1:
        rows = f"{course.motion.per} rows"
        said.append(f"Drawn from the least and the greatest of every {rows}, so that no peak is lost.")
    said.append(
        "Point at a plot for values, drag to zoom, double-click for all; in focus it takes the keys: arrows, Page up "
        "and down, Home, End, + and -, Escape."
    )
    charts = [chart for k in shown for chart in _joint_charts(joints[k], course, size)]
    motors = dict(_motor_charts(result, model, scene, course))
    if len(shown) > 1:
        power = {printable(joints[k].name): course.curve(f"power_{joints[k].name}", size["W"]) for k in shown[:10]}
        charts.append(time_chart("Power of joints", "Power of joints", course.time, power, "W", rows=course.rows))
    yield from doc.titled("Along the motion", [*doc.paragraphs(said), *doc.gallery(charts)])
    heat = _heat_chart(history.heat) if history.heat else ()
    yield from doc.titled("Motors", doc.gallery([*motors.values(), *heat]))
    peaks = [joint for joint in joints if not is_noise(abs(joint.peak), size[joint.unit])]
    yield from doc.titled("What makes the peaks", _share_bars(peaks))
    if result.constraints is not None and scene.contacts:
        yield from doc.titled("Contacts", doc.gallery(_contact_chart(result, scene, course)))
    yield from doc.titled("Loads of the base", doc.gallery(_base_charts(result, course, size)))
    yield from doc.titled("Energy", doc.gallery(_energy_chart(result, history, size)))
    yield from _heaviest_load(result, model, scene, history)


def _heat_chart(heat: Heat) -> Iterator[doc.Chart]:
    """Yield how windings get hot, cycle by cycle, with limits that are near."""
    lines, colours = dict[str, tuple[Floats, Floats]](), dict[str, str]()
    for name, (begins, hottest) in heat.courses.items():
        motor, minutes, limit = heat.motors[name], begins / 60.0, f"limit of {printable(name)}"
        lines[printable(name)] = minutes, hottest[:, 0]
        if hottest[:, 0].max() - motor.ambient >= _NEAR * (motor.winding_limit - motor.ambient):
            lines[limit], colours[limit] = (minutes[[0, -1]], np.full(2, motor.winding_limit)), "bad"
    title, axes = "Windings: hottest of each cycle", ("time since the start [min]", f"temperature [{DEGREES}]")
    ends = ", ".join(f"{printable(name)} {number(each[-1, 0])} {DEGREES}" for name, (_, each) in heat.courses.items())
    if lines:
        yield plane_chart(title, f"{title}; at the end {ends}", *axes, lines=lines, colours=colours)


def _rests(joint: JointLoad, size: Sizes) -> bool:
    return is_noise(abs(joint.peak), size[joint.unit]) and is_noise(abs(joint.max_speed), size[speed_unit(joint.unit)])


def _heaviest_load(result: Result, model: Model, scene: Scene, history: History) -> Iterator[doc.Block]:
    """Yield the free body that the joint with the heaviest load carries at its peak, if there is one."""
    worst = worst_joint(result)
    if worst is None:
        return
    joint, state = result.joints[worst], history.states[worst]
    tree = tree_scene(model, scene) if scene.constrained else scene
    columns = dict(zip(tree.columns, state["columns"], strict=False))
    try:
        found = free_bodies(model, state["q"], state["qd"], state["qdd"], scene=tree, columns=columns)
    except RobodynError:
        return
    for body in found.bodies:
        if model.bodies[body.number].joint.name == joint.name:
            when = f"the peak of {printable(joint.name)}, {joint.peak_time:.6g} s"
            title = f"Forces and moments on {printable(body.name)}, {when}, in its axes; they add up to zero"
            yield doc.Heading("At the heaviest load")
            yield doc.Table(title, *action_table(body, free_body_sizes(found)))


def _joint_charts(joint: JointLoad, course: Course, size: Sizes) -> Iterator[doc.Chart]:
    """Yield torque and speed of a joint over time, and torque over speed; limits are dashed."""
    load, speed, name = joint.unit, speed_unit(joint.unit), printable(joint.name)
    what = "force" if load == "N" else "torque"
    peak, fastest = number(joint.peak, size[load]), number(joint.max_speed, size[speed])
    at = moment(joint.peak_time, joint.peak, size[load])
    for quantity, key, unit, most, limit, said in (
        (what, "tau", load, joint.peak, joint.effort_limit, f"peak {peak} {load} at {at} s"),
        ("speed", "qd", speed, joint.max_speed, joint.velocity_limit, f"largest {fastest} {speed}"),
    ):
        near = limit is not None and abs(most) >= _NEAR * limit
        levels = [(limit, "limit"), (-limit, "limit")] if near and limit else []
        caption = f"{name}: {quantity} [{unit}]" + (
            f", limit {limit:g}{'' if near else ', off this scale'}" if limit else ""
        )
        curves = {quantity: course.curve(f"{key}_{joint.name}", size[unit])}
        colours = ("c1" if key == "tau" else "c2",)
        alt = f"{quantity} of {name} over time: {said}"
        yield time_chart(caption, alt, course.time, curves, unit, rows=course.rows, levels=levels, colours=colours)
    speeds, torques = course.frames[f"qd_{joint.name}"], course.frames[f"tau_{joint.name}"]
    lines = {}
    for limit, most, along, row in (
        (joint.effort_limit, joint.peak, speeds, 1),
        (joint.velocity_limit, joint.max_speed, torques, 0),
    ):
        if limit is not None and abs(most) >= _NEAR * limit:
            ends = np.array((along.min(), along.max(), np.nan) * 2)
            at_limit = np.array((limit, limit, np.nan, -limit, -limit, np.nan))
            lines["effort limit" if row else "speed limit"] = (ends, at_limit) if row else (at_limit, ends)
    alt = f"{what} over speed of {name}: peak {peak} {load}, largest speed {fastest} {speed}"
    yield plane_chart(
        f"{name}: {what} over speed",
        alt,
        f"speed [{speed}]",
        f"{what} [{load}]",
        dots={"samples": (speeds, torques)},
        lines=lines,
        colours={"samples": "c1", "effort limit": "bad", "speed limit": "bad"},
        time=course.frames["time"],
    )


def _base_charts(result: Result, course: Course, size: Sizes) -> Iterator[doc.Chart]:
    """Yield forces and moments of the ground on the robot over time; none that are zero throughout."""
    for title, unit, first in (("forces", "N", 0), ("moments", "N m", 3)):
        parts = result.base_wrench[first : first + 3]
        if any(not is_noise(abs(part.peak), size[unit]) for part in parts):
            peaks = ", ".join(f"{part.name} {number(part.peak, size[unit])} {unit}" for part in parts)
            curves = {part.name: course.curve(f"base_{part.name}", size[unit]) for part in parts}
            alt = f"Base {title} over time; peaks: {peaks}"
            yield time_chart(f"Base {title}: ground on robot", alt, course.time, curves, unit, rows=course.rows)


def _energy_chart(result: Result, history: History, size: Sizes) -> Iterator[doc.Chart]:
    """Yield work done on the robot, less losses, and the energy stored, unless both are zero throughout."""
    balance, energy = result.checks.energy_balance, history.energy
    curves = {name: energy.of(name) for name in energy.curves}
    if any(not is_noise(float(np.abs(np.stack(both)).max()), size["J"]) for both in curves.values()):
        fit = "agree" if balance.consistent else "disagree"
        worst = number(balance.worst, size["J"])
        alt = f"Work done less losses and energy stored over time; they {fit}, at worst by {worst} J"
        caption = "Energy check: work less losses, and energy stored"
        yield time_chart(caption, alt, energy.first[:, 0], curves, "J")


def _share_bars(joints: Sequence[JointLoad]) -> list[doc.Block]:
    """Return what each effect of at least 1e-3 adds to the peaks, in parts of them; what lessens them is red."""
    rows = []
    for joint in joints:
        shares = [(name, 100.0 * share / joint.peak) for name, share in joint.shares.items()]
        shown = [(name, share) for name, share in shares if abs(share) >= 0.1]
        bars = [
            (f"{name} {share:.3g} %", 0.0, min(abs(share), 100.0), "bad" if share < 0.0 else "c1")
            for name, share in shown
        ]
        rows.append((joint.name, bars, ""))
    note = "Red bars lessen the peak."
    return [doc.Bars("Share of each effect in the peak", rows, note)] if rows else []


def _contact_chart(result: Result, scene: Scene, course: Course) -> Iterator[doc.Chart]:
    """Yield the forces of contacts along their normals over time."""
    from robodyn.dynamics.constraints.constraint_jacobian import columns_of, normal_of

    assert result.constraints is not None
    curves = {}
    for contact in scene.contacts:
        parts = [course.frames[column] for column in columns_of(contact.name)[:3]]
        curves[printable(contact.name)] = sum(
            n * part for n, part in zip(normal_of(contact, scene), parts, strict=True)
        )
    most = ", ".join(
        f"{printable(each.name)} {number(each.normal.value)} N, on {100 * each.on:.0f} % of the time"
        for each in result.constraints.contacts
    )
    alt = f"Forces of contacts along their normals over time; largest: {most}"
    rows = course.frame_rows
    yield time_chart("Contacts: force along the normal [N]", alt, course.frames["time"], curves, "N", rows=rows)


def _motor_charts(result: Result, model: Model, scene: Scene, course: Course) -> Iterator[tuple[str, doc.Chart]]:
    """Yield of each joint with a motor torque over speed at its shaft, its curves in all four quadrants, and the point
    that is judged against the continuous curve: RMS torque at the mean speed."""
    joints = joint_of_rates(model)[6 if model.floating else 0 :]
    for joint, sized in zip(joints, result.sizing.joints if result.sizing else (), strict=bool(result.sizing)):
        shaft, motor = _at_shaft(course, joint, scene), sized.motor
        if shaft is None or motor is None:
            continue
        torque, speed = shaft
        fastest, lines = max(float(np.abs(speed).max()), motor.speed_limit or 0.0), {}
        for curve, label in ((motor.peak_curve, "peak curve"), (motor.continuous, "continuous curve")):
            if curve is not None:
                speeds, torques = np.array(curve).T
                if len(speeds) == 1:  # a torque at all speeds
                    speeds, torques = np.array((0.0, fastest)), np.repeat(torques, 2)
                else:
                    speeds, torques = np.array((0.0, *speeds, speeds[-1])), np.array((torques[0], *torques, 0.0))
                quadrants = [*product((1.0, -1.0), repeat=2)]
                across, up = (
                    np.concatenate([np.append(sign[k] * part, np.nan) for sign in quadrants])
                    for k, part in enumerate((speeds, torques))
                )
                lines[label] = across, up
        name, over = printable(sized.name), motor.continuous_limit is not None and motor.rms > motor.continuous_limit
        unit, colours = motor.unit, {"samples": "c1", "peak curve": "bad", "continuous curve": "c2"}
        said = f"RMS torque {number(motor.rms)} {unit} at the mean speed {number(motor.mean_speed)} {motor.speed_unit}"
        alt = f"Motor of {name}: peak torque {number(motor.peak)} {unit}, {said}, against its curves"
        yield (
            sized.name,
            plane_chart(
                f"Motor of {name}",
                alt,
                f"speed [{motor.speed_unit}]",
                f"torque [{unit}]",
                dots={"samples": (speed, torque)},
                lines=lines,
                marks=[
                    (
                        motor.mean_speed,
                        motor.rms,
                        "RMS torque at the mean speed, which is judged",
                        "bad" if over else "good",
                    )
                ],
                colours=colours,
                time=course.frames["time"],
            ),
        )


def compared_sections(results: Sequence[tuple[str, Result]]) -> Iterator[doc.Section]:
    """Yield peak, RMS and largest speed of every joint in every run, each run's verdict last."""
    first = results[0][1]
    for title, key, unit_of in (
        ("Peak of every joint", "peak", lambda joint: joint.unit),
        ("RMS of every joint", "rms", lambda joint: joint.unit),
        ("Largest speed of every joint", "max_speed", lambda joint: speed_unit(joint.unit)),
    ):
        rows = []
        for k, joint in enumerate(first.joints):
            values = [getattr(result.joints[k], key) for _, result in results]
            most = max(map(abs, values))
            rows.append((joint.name, *(number(value, most) for value in values), unit_of(joint)))
        yield [doc.Table(title, ("joint", *(name for name, _ in results), ""), rows)]
    yield doc.paragraphs([f"{printable(name)}: {limits_verdict(result).headline}." for name, result in results])


def compared_page(results: Sequence[tuple[str, Result]], model: Model, scene: Scene, pictures: bool) -> doc.Document:
    """Return runs of one robot laid over each other: robots and curves in the colour of their run."""
    levels = ("bad", "doubtful", "neutral", "good")
    verdicts = [(name, limits_verdict(result)) for name, result in results]
    worst = min((verdict.level for _, verdict in verdicts), key=levels.index)
    words = tuple(f"{printable(name)}: {verdict.headline}." for name, verdict in verdicts)
    many = sum(verdict.level == "bad" for _, verdict in verdicts)
    said = (
        f"{many} of {len(results)} runs of {printable(model.name)} {'exceeds' if many == 1 else 'exceed'} limits"
        if many
        else ""
    )
    blocks: list[doc.Block] = [doc.Verdict(worst, said or f"{len(results)} runs of {printable(model.name)}", words)]
    courses = [Course(result.history.motion) for _, result in results if pictures and result.history is not None]
    if courses:
        size = result_sizes(results[0][1])
        robots = [
            stage.robot(
                model,
                [motion_of(course, result, model, scene)],
                name=name,
                colour=f"c{k}",
                alpha=1.0 if k == 1 else 0.5,
            )
            for k, ((name, result), course) in enumerate(zip(results, courses, strict=True), start=1)
        ]
        blocks.append(stage.stage("The runs over each other", robots))
        time = np.unique(np.concatenate([course.frames["time"] for course in courses]))
        charts = []
        for joint in results[0][1].joints:
            for key, unit in (("tau", joint.unit), ("qd", speed_unit(joint.unit))):
                curves = {}
                for (name, _), course in zip(results, courses, strict=True):
                    own, values = course.frames["time"], course.frames[f"{key}_{joint.name}"]
                    curves[printable(name)] = np.interp(time, own, values, np.nan, np.nan)
                if any(not is_noise(float(np.nanmax(np.abs(values))), size[unit]) for values in curves.values()):
                    what = "speed" if key == "qd" else "force" if unit == "N" else "torque"
                    caption = f"{printable(joint.name)}: {what} [{unit}]"
                    charts.append(
                        time_chart(caption, f"{what} of {printable(joint.name)} in every run", time, curves, unit)
                    )
        blocks += doc.titled("Along the motions", doc.gallery(charts))
    what = f"Torques along {count(len(results), 'motion')}, {gravity_text(scene.gravity)}"
    return doc.page(model.name, what, blocks, compared_sections(results), "Loads", [], "")


@dataclass(frozen=True)
class View:
    """A page of a robot, which notebooks show; `html` is its text."""

    name: str
    html: str = field(repr=False)

    def _repr_html_(self) -> str:
        frame = "width:100%;height:44em;border:0"
        return f'<iframe sandbox="allow-scripts" style="{frame}" srcdoc="{escape(self.html)}"></iframe>'


def view(model: Model, motion: Motion | None = None, scene: Scene = DEFAULT, at: Values | None = None) -> View:
    """Return a page that shows a robot in 3-D: a notebook shows it, and its `html` can be written to a file.

    Args:
        motion: of `robodyn.motion`, a file, or a reader of `robodyn.read_motion`: the page is that of `torques`, which
            plays it. Without one joints have sliders.
        at: where they begin [rad or m], in order or by name; else zero, or the limit nearest to it.

    Raises:
        InputError: as `torques`; a joint of `at` is none; jinja2 or uplot-python is not installed.
    """
    from robodyn.report.renderers.pages import html

    return View(model.name, html(view_page(model, motion, scene, at)))


def view_page(model: Model, motion: Motion | None, scene: Scene, at: Values | None) -> doc.Document:
    """Return the page of `view`."""
    from robodyn.checks.overview import branches
    from robodyn.equations.dae.dae import closed_state
    from robodyn.report.check import tree_table

    if motion is not None:
        from robodyn.loads.torques import torques

        return torques_page(torques(model, motion, scene, history=True), model, scene)
    q, said = configuration(model, nearest_to_zero(model) if at is None else at), []
    if scene.loops:
        begin = "which do not close near this pose"
        with suppress(RobodynError):
            q, begin = closed_state(model, scene, at, ())[0], "closed at first"
        names = first_names([loop.name for loop in scene.loops], 4)
        said.append(f"Loops: {names}, {begin}. Sliders move the joints of the tree one by one, and open loops.")
    said += beyond_limits(model, q)
    robot = stage.robot(model, [stage.pose(model, q.tolist(), stage.weights(model, scene))])
    words = "The robot, whose joints are moved below"
    blocks: list[doc.Block] = [stage.stage(words, [robot]), *doc.paragraphs(said)]
    if model.description is not None:
        blocks.append(tree_table(list(branches(model.description)), "Links, and the joints that carry them"))
    what = f"{count(model.n, 'degree')} of freedom, {count(len(model.bodies), 'body', 'bodies')}"
    return doc.Document(model.name, f"{what}, {number(model.total_mass)} kg", tuple(blocks))
