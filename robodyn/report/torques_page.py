"""`torques` as a page: the verdict, how near limits are, the heaviest load, plots, then what the text says."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from robodyn.dynamics.constraints.constraint_jacobian import tree_scene
from robodyn.equations.free_body.bodies import free_bodies
from robodyn.errors import RobodynError
from robodyn.loads.constraint_result import ContactLoad
from robodyn.loads.history import SPANS, Curves, History
from robodyn.loads.result import ComponentLoad, EnergyBalance, JointLoad, Result, Sizing
from robodyn.loads.sizing import load_torque, motor_torque, train_of
from robodyn.loads.statistics import joint_of_rates
from robodyn.report import document as doc
from robodyn.report.equations import action_table
from robodyn.report.limits import effort_use, offenders, torques_verdict, worst_joint
from robodyn.report.pictures import figures as plots
from robodyn.report.pictures.figures import BAD, GRID, INK, SERIES, SOFT, WIDE
from robodyn.report.sizes import Sizes, free_body_sizes, result_sizes, speed_unit
from robodyn.report.table import gravity_text, is_noise, moment, number, printable
from robodyn.report.torques import load_table, torques_json, torques_sections
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene
from robodyn.support.floats import Floats, ranked
from robodyn.support.wording import count, shortened

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

PLOTTED = 12
"""Joints that have plots: those beyond limits, and the most loaded of the others up to so many."""


def torques_page(result: Result, model: Model, scene: Scene, pictures: bool = True) -> doc.Document:
    """Return the verdict, the figures that matter most, plots if there is a history, and all that the text says."""
    what = (
        f"Torques along a motion: {count(len(result.joints), 'joint')}, {count(result.samples, 'sample')}, "
        f"{result.duration:.6g} s, {gravity_text(result.gravity)}"
    )
    blocks: list[doc.Block] = [torques_verdict(result)]
    head, rows = load_table(result)
    files = [("result.json", torques_json(result)), ("joints.csv", doc.csv_text(head, rows))]
    if pictures and result.history is not None:
        blocks += _pictures(result, model, scene, result.history)
        if curves := result.history.joints:
            drawn = []
            for k, name in enumerate(curves.names):
                samples = zip(*curves.samples(k).values(), strict=True)
                drawn += [(name, *(f"{value:.7g}" for value in row)) for row in samples]
            files.append(("curves.csv", doc.csv_text(("joint", "time", *curves.quantities), drawn)))
    sections = torques_sections(result, explain=True)
    how = "robodyn torques --format json and --out write it to a file"
    return doc.page(result.robot, what, blocks, sections, "Loads", files, how)


def _pictures(result: Result, model: Model, scene: Scene, history: History) -> Iterator[doc.Block]:
    """Yield all figures, heading by heading, joints beyond limits first; of joints those and the most loaded."""
    joints, size, over = result.joints, result_sizes(result), offenders(result)
    in_order = sorted(range(len(joints)), key=lambda k: (joints[k].name not in over, k))
    yield from _heaviest_load(result, model, scene, history)
    if history.joints is not None:
        moving = [k for k in in_order if not _rests(joints[k], size)]
        loaded = sorted(ranked(moving, key=lambda k: effort_use(joints[k])), key=lambda k: joints[k].name not in over)
        shown = loaded[: max(PLOTTED, len(over))]
        words = []
        if len(shown) < len(moving):
            some = f"{len(shown)} of {len(joints)}; the tables have all."
            words.append(f"The joints beyond a limit, and those that use most of their limits of effort, {some}")
        if still := [printable(joint.name) for joint in joints if _rests(joint, size)]:
            words.append(f"Without a plot, because they neither move nor carry anything: {', '.join(still)}.")
        if shown and result.samples > 2 * SPANS:
            span = f"{result.duration / SPANS:.2g} s"
            words.append(f"Drawn from the least and the greatest of every {span}, so that no peak is lost.")
        curves = history.joints
        figures = doc.gallery(joint_figure(joints[k], curves, k, size) for k in in_order if k in shown)
        yield from doc.titled("Along the motion", [*doc.paragraphs(words), *figures])
        if result.sizing is not None:
            motors = dict(motor_figures(result.sizing, model, scene, history.joints))
            ranked_motors = (motors[name] for name in sorted(motors, key=lambda name: name not in over))
            yield from doc.titled("Motors", doc.gallery(ranked_motors))
    peaks = [joints[k] for k in in_order if not is_noise(abs(joints[k].peak), size[joints[k].unit])]
    yield from doc.titled("What makes the peaks", doc.gallery(share_figures(peaks)))
    if result.constraints is not None and history.contacts is not None:
        contacts = contact_figures(result.constraints.contacts, history.contacts, size)
        yield from doc.titled("Contacts", doc.gallery(contacts))
    yield from doc.titled("Loads of the base", doc.gallery(base_figures(result.base_wrench, history, size)))
    energy = energy_figures(result.checks.energy_balance, history, size)
    yield from doc.titled("Energy", doc.gallery(energy))


def _rests(joint: JointLoad, size: Sizes) -> bool:
    return is_noise(abs(joint.peak), size[joint.unit]) and is_noise(abs(joint.max_speed), size[speed_unit(joint.unit)])


def _heaviest_load(result: Result, model: Model, scene: Scene, history: History) -> Iterator[doc.Block]:
    """Yield the robot at the peak of the joint that is loaded most, and the free body that it carries, if there is."""
    from robodyn.report.pictures.free_body import NOTES, page_drawing, symbols
    from robodyn.report.pictures.robot import robot_figure, shapes_of

    worst = worst_joint(result)
    if worst is None:
        return
    joint, state = result.joints[worst], history.states[worst]
    when = f"the peak of {printable(joint.name)}, {joint.peak_time:.6g} s"
    assert model.description is not None, "it is not a model of bodies alone"
    shapes, why = shapes_of(model.description)
    figures, tables = [robot_figure(model, state["q"], joint.name, when, shapes, "picture")], []
    tree = tree_scene(model, scene) if scene.constrained else scene
    columns = dict(zip(tree.columns, state["columns"], strict=False))
    try:
        found = free_bodies(model, state["q"], state["qd"], state["qdd"], scene=tree, columns=columns)
    except RobodynError:
        found = None
    for body in found.bodies if found else ():
        if found and model.bodies[body.number].joint.name == joint.name:
            name, size = printable(body.name), free_body_sizes(found)
            forces = printable(", ".join(action.what for action in body.actions))
            alt = f"Free-body diagram of {name} with its forces and moments: {forces}"
            caption = f"What acts on {name}, which {printable(joint.name)} carries"
            figures.append(doc.Figure(caption, alt, page_drawing(body, size)))
            head, rows = action_table(body, size)
            named = [(symbols(action, size), *row) for action, row in zip(body.actions, rows, strict=False)]
            title = ("symbol", "what", *head[1:])
            sums = ("sum", "", *rows[-1][1:])
            tables.append(doc.Table(f"Forces and moments on {name}, {when}", title, [*named, sums], " ".join(NOTES)))
    yield doc.Heading("At the heaviest load")
    yield doc.Gallery(tuple(figures))
    yield from tables
    yield from doc.paragraphs([why] if why else [])


_NEAR = 0.5
"""A limit is drawn where at least this share of it is reached; it would flatten the curve otherwise."""
_LIMIT: dict[str, Any] = {"color": BAD, "linewidth": 1.2, "dashes": (5, 3)}


def joint_figure(joint: JointLoad, curves: Curves, column: int, size: Sizes) -> doc.Figure:
    """Return torque, speed and power of a joint against time, and torque against speed; limits are dashed."""
    load, speed = joint.unit, speed_unit(joint.unit)
    what = "force" if load == "N" else "torque"
    quantities = {
        "torque": (f"{what} [{load}]", size[load], joint.effort_limit),
        "speed": (f"speed [{speed}]", size[speed], joint.velocity_limit),
        "power": ("power [W]", size["W"], None),
    }

    def draw(canvas: Canvas) -> None:
        bottoms_and_heights = ((542, 96), (412, 96), (282, 96), (28, 182))  # px
        *over_time, plane = (plots.panel(canvas, *place) for place in bottoms_and_heights)
        for k, (axes, (quantity, (title, scale, limit))) in enumerate(zip(over_time, quantities.items(), strict=True)):
            time, values = plots.quiet_line(curves, quantity, column, scale)
            axes.plot(time, values, color=SERIES[k], marker="o" if len(time) == 1 else None)
            axes.axhline(0.0, color=SOFT, linewidth=0.8, zorder=1)
            axes.set_title(title)
            axes.tick_params(labelbottom=k == 2)
            if limit is not None:
                largest = float(np.abs(values).max())
                off = "" if largest >= _NEAR * limit else ", off this scale"
                colour = BAD if largest > limit else SOFT
                axes.set_title(f"limit {limit:g}{off}", loc="right", fontsize=10, color=colour)
                for bound, reached in ((-limit, -values.min()), (limit, values.max())):
                    if reached >= _NEAR * limit:
                        axes.axhline(bound, **_LIMIT)
        axes.set_xlabel("time [s]", labelpad=1)
        samples = curves.samples(column)
        speeds, torques = samples["speed"], samples["torque"]
        over = np.zeros(len(speeds), dtype=bool)
        limits = (joint.velocity_limit, speeds, plane.axvline), (joint.effort_limit, torques, plane.axhline)
        for limit, values, line in limits:
            if limit is not None:
                over |= np.abs(values) > limit
                for bound in (-limit, limit):
                    line(bound, **_LIMIT)
        for where, colour in ((~over, SERIES[0]), (over, BAD)):
            plots.dots(plane, speeds[where], torques[where], colour)
        plane.margins(0.08)
        plots.zero_lines(plane)
        plane.set_title(f"{what} [{load}] against speed [{speed}]")

    peak, fastest = number(joint.peak, size[load]), number(joint.max_speed, size[speed])
    alt = (
        f"Joint {printable(joint.name)}: {what}, speed and power against time, and {what} against speed. Peak {what} "
        f"{peak} {load} at {moment(joint.peak_time, joint.peak, size[load])} s, largest speed {fastest} {speed}"
    )
    return doc.Figure(printable(joint.name), alt, plots.plot(WIDE, 660, draw, f"joint {column}"))


def base_figures(loads: Sequence[ComponentLoad], history: History, size: Sizes) -> Iterator[doc.Figure]:
    """Yield forces and moments of the ground on the robot against time; none that are zero throughout."""
    for title, unit, first in (("forces", "N", 0), ("moments", "N m", 3)):
        names = history.base.names[first : first + 3]
        lines = {name: plots.quiet_line(history.base, "load", first + k, size[unit]) for k, name in enumerate(names)}
        if any(values.any() for _, values in lines.values()):
            peaks = [f"{part.name} {number(part.peak, size[unit])} {unit}" for part in loads if part.name in names]
            alt = f"Base {title} against time; peaks: {', '.join(peaks)}"
            yield plots.lines_figure(f"Base {title}: ground on robot", alt, lines, unit)


def energy_figures(balance: EnergyBalance, history: History, size: Sizes) -> Iterator[doc.Figure]:
    """Yield work done on the robot, less losses, and the energy stored, unless both are zero throughout."""
    curves = history.energy
    lines = {name: plots.quiet_line(curves, "energy", k, size["J"]) for k, name in enumerate(curves.names)}
    if any(values.any() for _, values in lines.values()):
        fit = "agree" if balance.consistent else "disagree"
        worst = number(balance.worst, size["J"])
        alt = f"Work done less losses and energy stored against time; they {fit}, at worst by {worst} J"
        looks = {"linewidth": 3.0}, {"dashes": (3, 3), "linewidth": 1.6}
        yield plots.lines_figure("Energy check: work less losses, and energy stored", alt, lines, "J", looks)


def share_figures(joints: Sequence[JointLoad]) -> Iterator[doc.Figure]:
    """Yield what each effect of at least 1e-3 adds to the peaks, in parts of them; what lessens them to the left."""
    names = [name for joint in joints for name, share in joint.shares.items() if abs(share) >= 1e-3 * abs(joint.peak)]
    names = list(dict.fromkeys(names))
    many = -(-len(joints) // 14)
    top = 24 * ((len(names) + 2) // 3) + 8
    for k, part in enumerate(np.array_split(np.arange(len(joints)), many) if many else (), start=1):
        some = [joints[j] for j in part]
        height = 38 * len(some) + top + 40

        def draw(canvas: Canvas, joints: list[JointLoad] = some, height: int = height) -> None:
            axes = canvas.add_axes((0.02, 36 / height, 0.945, 1 - (top + 36) / height))
            rows = np.arange(len(joints)) - 0.16
            right, left = np.zeros(len(rows)), np.zeros(len(rows))
            for k, name in enumerate(names):
                share = np.array([100.0 * joint.shares.get(name, 0.0) / joint.peak for joint in joints])
                start = np.where(share >= 0.0, right, left)
                axes.barh(rows, share, left=start, height=0.42, align="edge", label=name, color=SERIES[k % len(SERIES)])
                right, left = right + share.clip(0.0), left + share.clip(None, 0.0)
            for percent, colour in ((0.0, INK), (100.0, GRID)):
                axes.vlines(np.full(len(rows), percent), rows - 0.04, rows + 0.46, color=colour, linewidth=1.0)
            for row, label in enumerate(shortened([printable(joint.name) for joint in joints], most=52)):
                axes.text(0.0, row - 0.26, label, transform=axes.get_yaxis_transform(), fontsize=10, color=INK)
            axes.set(yticks=[], ylim=(len(joints) - 0.5, -0.75), xlabel="share of the peak [%]")
            axes.spines["left"].set_visible(False)
            axes.grid(visible=False)
            canvas.legend(loc="upper left", ncols=3, fontsize=10, columnspacing=1.0, handlelength=1.0)

        caption = "What makes the peaks" + (f", {k} of {many}" if many > 1 else "")
        alt = f"Bars of what each effect adds to the peaks of {', '.join(printable(joint.name) for joint in some)}"
        yield doc.Figure(caption, alt, plots.plot(WIDE, height, draw, caption))


def contact_figures(contacts: Sequence[ContactLoad], curves: Curves, size: Sizes) -> Iterator[doc.Figure]:
    """Yield of each contact that is ever on its force along the normal against time, all to one scale."""
    top = 1.05 * max((contact.normal.value for contact in contacts), default=0.0)
    for k, contact in enumerate(contacts):
        samples = curves.samples(k)

        def draw(canvas: Canvas, samples: dict[str, Floats] = samples) -> None:
            axes, time, on = plots.panel(canvas, 46, 114), samples["time"], (samples["on"] > 0.0).tolist()
            across = axes.get_xaxis_transform()
            axes.fill_between(time, 0.0, 1.0, where=on, transform=across, color=GRID, linewidth=0.0, zorder=0)
            axes.plot(time, samples["normal"], color=SERIES[0], marker="o" if len(time) == 1 else None)
            axes.set(ylim=(0.0, top or None), title="[N]", xlabel="time [s]")

        if contact.on:
            name, most = printable(contact.name), number(contact.normal.value, size["N"])
            words = f"force along the normal against time, up to {most} N, on {100 * contact.on:.0f} % of it"
            caption = f"{name}: force along the normal; shaded where it is on"
            yield doc.Figure(caption, f"Contact {name}: {words}", plots.plot(WIDE, 190, draw, caption))


def motor_figures(sizing: Sizing, model: Model, scene: Scene, curves: Curves) -> Iterator[tuple[str, doc.Figure]]:
    """Yield for each joint with a motor torque against speed at its shaft, with its curves in all four quadrants."""
    joints = joint_of_rates(model)[6 if model.floating else 0 :]
    for k, (joint, sized) in enumerate(zip(joints, sizing.joints, strict=True)):
        train, motor = train_of(joint, scene), sized.motor
        if train is None or motor is None:
            continue
        samples = curves.samples(k)
        tau, qd, qdd = samples["torque"], samples["speed"], samples["acceleration"]
        torque, speed = motor_torque(train, load_torque(train, tau, qdd), qd, qdd), train.gear * qd
        fastest, lines = max(float(np.abs(speed).max()), motor.speed_limit or 0.0), []
        for curve, colour, label in ((motor.peak_curve, BAD, "peak"), (motor.continuous, SERIES[1], "continuous")):
            if curve is not None:
                speeds, torques = np.array(curve).T
                if len(speeds) == 1:  # a torque at all speeds
                    speeds, torques = np.array((0.0, fastest)), np.repeat(torques, 2)
                else:
                    speeds, torques = np.array((0.0, *speeds, speeds[-1])), np.array((torques[0], *torques, 0.0))
                lines.append((speeds, torques, {"color": colour, "linewidth": 1.2, "dashes": (5, 3)}, label))

        def draw(
            canvas: Canvas, speed: Floats = speed, torque: Floats = torque, lines: Any = lines, motor: Any = motor
        ) -> None:
            axes = plots.panel(canvas, 32, 237)
            for speeds, torques, look, label in lines:
                for across, up in product((1.0, -1.0), repeat=2):
                    axes.plot(across * speeds, up * torques, label=label if across == up == 1.0 else None, **look)
            plots.dots(axes, speed, torque, SERIES[0])
            axes.margins(0.06)
            plots.zero_lines(axes)
            axes.set_title(f"torque [{motor.unit}] against speed [{motor.speed_unit}]", y=1.1)
            if lines:
                axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, columnspacing=1.0)

        name = printable(sized.name)
        alt = (
            f"Motor of {name}: peak torque {number(motor.peak)} {motor.unit}, largest speed "
            f"{number(motor.max_speed)} {motor.speed_unit}, RMS torque {number(motor.rms)} {motor.unit}, against its "
            "curves"
        )
        yield sized.name, doc.Figure(f"Motor of {name}", alt, plots.plot(WIDE, 320, draw, f"motor {k}"))
