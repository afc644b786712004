"""What a motion asks of joints, motors, contacts, the base and energy, as plots."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from robodyn.loads.constraint_result import ContactLoad
from robodyn.loads.history import Curves, History
from robodyn.loads.result import ComponentLoad, EnergyBalance, JointLoad, MotorLoad, Sizing
from robodyn.loads.sizing import load_torque, motor_torque, train_of
from robodyn.loads.statistics import joint_of_rates
from robodyn.report.document import Figure
from robodyn.report.pictures.figures import (
    BAD,
    GRID,
    INK,
    SERIES,
    SOFT,
    WIDE,
    dots,
    lines_figure,
    panel,
    plot,
    quiet_line,
    zero_lines,
)
from robodyn.report.sizes import Sizes, speed_unit
from robodyn.report.table import moment, number, printable
from robodyn.robot.model import Model
from robodyn.scene.scene import Curve, Scene
from robodyn.support.floats import Floats
from robodyn.support.wording import shortened

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas


_PANELS = ((542, 96), (412, 96), (282, 96), (28, 182))
"""Bottoms and heights of torque, speed and power against time, and of torque against speed [px]."""
_LETTERS = 52
"""So many of a joint's name have room in a figure."""
_TOGETHER = 14
"""So many joints at most share a figure of bars."""
_SEEN = 1e-3
"""Effects of less than this share of every peak are not to be seen in a bar."""
_NEAR = 0.5
"""A limit is drawn where at least this share of it is reached; it would flatten the curve otherwise."""
_LIMIT: dict[str, Any] = {"color": BAD, "linewidth": 1.2, "dashes": (5, 3)}


def joint_figure(joint: JointLoad, curves: Curves, column: int, size: Sizes) -> Figure:
    """Return torque, speed and power of a joint against time, and torque against speed within the limits."""
    load, speed = joint.unit, speed_unit(joint.unit)
    what = "force" if load == "N" else "torque"
    quantities = {
        "torque": (f"{what} [{load}]", size[load], joint.effort_limit),
        "speed": (f"speed [{speed}]", size[speed], joint.velocity_limit),
        "power": ("power [W]", size["W"], None),
    }

    def draw(canvas: Canvas) -> None:
        *over_time, plane = (panel(canvas, *place) for place in _PANELS)
        for k, (axes, (quantity, (title, scale, limit))) in enumerate(zip(over_time, quantities.items(), strict=True)):
            time, values = quiet_line(curves, quantity, column, scale)
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
        _within_limits(plane, joint, curves.samples(column))
        plane.set_title(f"{what} [{load}] against speed [{speed}]")

    peak, fastest = number(joint.peak, size[load]), number(joint.max_speed, size[speed])
    alt = (
        f"Joint {printable(joint.name)}: {what}, speed and power against time, and {what} against speed. Peak {what} "
        f"{peak} {load} at {moment(joint.peak_time, joint.peak, size[load])} s, largest speed {fastest} {speed}"
    )
    return Figure(printable(joint.name), alt, plot(WIDE, 660, draw, f"joint {column}"))


def _within_limits(axes: Axes, joint: JointLoad, samples: dict[str, Floats]) -> None:
    """Draw where the joint is in the plane of speed and torque; outside the dashed lines is beyond a limit."""
    speed, torque = samples["speed"], samples["torque"]
    over = np.zeros(len(speed), dtype=bool)
    for limit, values, line in (
        (joint.velocity_limit, speed, axes.axvline),
        (joint.effort_limit, torque, axes.axhline),
    ):
        if limit is not None:
            over |= np.abs(values) > limit
            for bound in (-limit, limit):
                line(bound, **_LIMIT)
    for where, colour in ((~over, SERIES[0]), (over, BAD)):
        dots(axes, speed[where], torque[where], colour)
    axes.margins(0.08)
    zero_lines(axes)


def base_figures(loads: Sequence[ComponentLoad], history: History, size: Sizes) -> Iterator[Figure]:
    """Yield forces and moments of the ground on the robot against time; none that are zero throughout."""
    for title, unit, first in (("forces", "N", 0), ("moments", "N m", 3)):
        names = history.base.names[first : first + 3]
        lines = {name: quiet_line(history.base, "load", first + k, size[unit]) for k, name in enumerate(names)}
        if any(values.any() for _, values in lines.values()):
            peaks = [f"{part.name} {number(part.peak, size[unit])} {unit}" for part in loads if part.name in names]
            alt = f"Base {title} against time; peaks: {', '.join(peaks)}"
            yield lines_figure(f"Base {title}: ground on robot", alt, lines, unit)


def energy_figures(balance: EnergyBalance, history: History, size: Sizes) -> Iterator[Figure]:
    """Yield work done on the robot, less losses, and the energy that it stores: the same curve if all is right; nothing
    where both are zero throughout."""
    curves = history.energy
    lines = {name: quiet_line(curves, "energy", k, size["J"]) for k, name in enumerate(curves.names)}
    if any(values.any() for _, values in lines.values()):
        fit = "agree" if balance.consistent else "disagree"
        worst = number(balance.worst, size["J"])
        alt = f"Work done less losses and energy stored against time; they {fit}, at worst by {worst} J"
        looks = {"linewidth": 3.0}, {"dashes": (3, 3), "linewidth": 1.6}
        yield lines_figure("Energy check: work less losses, and energy stored", alt, lines, "J", looks)


def share_figures(joints: Sequence[JointLoad]) -> Iterator[Figure]:
    """Yield for every joint what each effect adds to its peak, in parts of the peak, some joints in each figure."""
    names = [name for joint in joints for name, share in joint.shares.items() if abs(share) >= _SEEN * abs(joint.peak)]
    many = -(-len(joints) // _TOGETHER)
    for k, part in enumerate(np.array_split(np.arange(len(joints)), many) if many else (), start=1):
        caption = "What makes the peaks" + (f", {k} of {many}" if many > 1 else "")
        yield _share_figure([joints[j] for j in part], list(dict.fromkeys(names)), caption)


def _share_figure(joints: Sequence[JointLoad], names: Sequence[str], caption: str) -> Figure:
    """Return what makes the peaks, stacked to the right, and what lessens them, to the left."""
    labels = shortened([printable(joint.name) for joint in joints], _LETTERS)
    top = 24 * ((len(names) + 2) // 3) + 8
    height = 38 * len(joints) + top + 40

    def draw(canvas: Canvas) -> None:
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
        for row, label in enumerate(labels):
            axes.text(0.0, row - 0.26, label, transform=axes.get_yaxis_transform(), fontsize=10, color=INK)
        axes.set(yticks=[], ylim=(len(labels) - 0.5, -0.75), xlabel="share of the peak [%]")
        axes.spines["left"].set_visible(False)
        axes.grid(visible=False)
        canvas.legend(loc="upper left", ncols=3, fontsize=10, columnspacing=1.0, handlelength=1.0)

    alt = f"Bars of what each effect adds to the peaks of {', '.join(printable(joint.name) for joint in joints)}"
    return Figure(caption, alt, plot(WIDE, height, draw, caption))


def contact_figures(contacts: Sequence[ContactLoad], curves: Curves, size: Sizes) -> Iterator[Figure]:
    """Yield of each contact that is ever on its force along the normal against time, all to one scale.

    Args:
        curves: of `normal` and `on`, contact by contact.
    """
    top = 1.05 * max((contact.normal.value for contact in contacts), default=0.0)
    for k, contact in enumerate(contacts):
        samples = curves.samples(k)

        def draw(canvas: Canvas, samples: dict[str, Floats] = samples) -> None:
            axes, time, on = panel(canvas, 46, 114), samples["time"], (samples["on"] > 0.0).tolist()
            across = axes.get_xaxis_transform()
            axes.fill_between(time, 0.0, 1.0, where=on, transform=across, color=GRID, linewidth=0.0, zorder=0)
            axes.plot(time, samples["normal"], color=SERIES[0], marker="o" if len(time) == 1 else None)
            axes.set(ylim=(0.0, top or None), title="[N]", xlabel="time [s]")

        if contact.on:
            name, most = printable(contact.name), number(contact.normal.value, size["N"])
            words = f"force along the normal against time, up to {most} N, on {100 * contact.on:.0f} % of it"
            caption = f"{name}: force along the normal; shaded where it is on"
            yield Figure(caption, f"Contact {name}: {words}", plot(WIDE, 190, draw, caption))


def motor_figures(sizing: Sizing, model: Model, scene: Scene, curves: Curves) -> Iterator[tuple[str, Figure]]:
    """Yield for each joint with a motor torque against speed at its shaft, with its curves."""
    joints = joint_of_rates(model)[6 if model.floating else 0 :]
    for k, (joint, sized) in enumerate(zip(joints, sizing.joints, strict=True)):
        train = train_of(joint, scene)
        if train is not None and sized.motor is not None:
            samples = curves.samples(k)
            tau, qd, qdd = samples["torque"], samples["speed"], samples["acceleration"]
            torque = motor_torque(train, load_torque(train, tau, qdd), qd, qdd)
            yield sized.name, _motor_figure(sized.name, sized.motor, train.gear * qd, torque, k)


def _motor_figure(name: str, motor: MotorLoad, speed: Floats, torque: Floats, k: int) -> Figure:
    fastest = max(float(np.abs(speed).max()), motor.speed_limit or 0.0)

    def draw(canvas: Canvas) -> None:
        axes = panel(canvas, 32, 237)
        for curve, colour, label in ((motor.peak_curve, BAD, "peak"), (motor.continuous, SERIES[1], "continuous")):
            if curve is not None:
                _draw_curve(axes, curve, fastest, colour, label)
        dots(axes, speed, torque, SERIES[0])
        axes.margins(0.06)
        zero_lines(axes)
        axes.set_title(f"torque [{motor.unit}] against speed [{motor.speed_unit}]", y=1.1)
        if motor.peak_curve or motor.continuous:
            axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, columnspacing=1.0)

    alt = (
        f"Motor of {printable(name)}: peak torque {number(motor.peak)} {motor.unit}, largest speed "
        f"{number(motor.max_speed)} {motor.speed_unit}, RMS torque {number(motor.rms)} {motor.unit}, against its curves"
    )
    return Figure(f"Motor of {printable(name)}", alt, plot(WIDE, 320, draw, f"motor {k}"))


def _draw_curve(axes: Axes, curve: Curve, fastest: float, colour: str, label: str) -> None:
    """Draw a curve of magnitudes in all four quadrants; one point is a torque at all speeds."""
    speeds, torques = np.array(curve).T
    if len(speeds) == 1:
        speeds, torques = np.array((0.0, fastest)), np.repeat(torques, 2)
    else:
        speeds, torques = np.array((0.0, *speeds, speeds[-1])), np.array((torques[0], *torques, 0.0))
    for across, up in product((1.0, -1.0), repeat=2):
        once = label if across == up == 1.0 else None
        axes.plot(across * speeds, up * torques, color=colour, linewidth=1.2, dashes=(5, 3), label=once)
