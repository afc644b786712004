"""What a motion asks of each joint, of contacts, of the base and of energy, as plots."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache, partial
from typing import TYPE_CHECKING

import numpy as np

from robodyn.loads.constraint_result import ContactLoad
from robodyn.loads.history import Curves, History
from robodyn.loads.result import ComponentLoad, EnergyBalance, JointLoad
from robodyn.report.document import Figure
from robodyn.report.pictures.figures import (
    BAD,
    GRID,
    INK,
    LOW,
    SERIES,
    SOFT,
    WIDE,
    Lines,
    Sheet,
    against_time,
    dots,
    few_ticks,
    limit_lines,
    panel,
    plot,
    zero_lines,
)
from robodyn.report.sizes import Sizes, speed_unit
from robodyn.report.table import moment, number, printable
from robodyn.support.floats import Floats, ranked
from robodyn.support.wording import shortened

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas


_TALL = 660
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


@lru_cache(maxsize=2)
def _sheet(height: int) -> Sheet:
    """Return what figures of a height are drawn on, one after another."""
    return Sheet(WIDE, height)


def joint_figure(joint: JointLoad, curves: Curves, column: int, size: Sizes) -> Figure:
    """Return torque, speed and power of a joint against time, and torque against speed within the limits."""
    speed = speed_unit(joint.unit)
    what = "force" if joint.unit == "N" else "torque"

    def draw(canvas: Canvas) -> None:
        axes = canvas.axes or [_panel(canvas, k) for k in range(len(_PANELS))]
        limits = {"torque": joint.effort_limit, "speed": joint.velocity_limit, "power": None}
        titles = {"torque": f"{what} [{joint.unit}]", "speed": f"speed [{speed}]", "power": "power [W]"}
        for k, (quantity, limit) in enumerate(limits.items()):
            _over_time(axes[k], curves.line(quantity, column), titles[quantity], limit, SERIES[k])
        _envelope(axes[3], joint, curves.samples(column))
        axes[3].set_title(f"{what} [{joint.unit}] against speed [{speed}]")

    caption = printable(joint.name)
    return Figure(caption, _joint_words(joint, what, size), _sheet(_TALL).plot(draw, f"joint {column}"))


def _panel(canvas: Canvas, k: int) -> Axes:
    """Return one of the axes of a joint's figure."""
    bottom, height = _PANELS[k]
    axes = panel(canvas, bottom, height, _TALL)
    axes.tick_params(labelbottom=k >= 2)
    if k == 2:
        axes.set_xlabel("time [s]")
        axes.xaxis.set_label_coords(0.5, -0.2)  # given, so that no tick is measured for it
    few_ticks(axes)
    return axes


def base_figures(loads: Sequence[ComponentLoad], history: History, size: Sizes) -> list[Figure]:
    """Return forces and moments of the ground on the robot against time; none that are zero throughout."""
    found = []
    for title, unit, first in (("forces", "N", 0), ("moments", "N m", 3)):
        names = history.base.names[first : first + 3]
        lines = {name: history.base.line("load", first + k) for k, name in enumerate(names)}
        if not any(values.any() for _, values in lines.values()):
            continue

        def draw(canvas: Canvas, lines: Lines = lines, unit: str = unit) -> None:
            against_time(canvas, lines, unit)

        peaks = [f"{part.name} {number(part.peak, size[unit])} {unit}" for part in loads if part.name in names]
        alt = f"Base {title} against time; peaks: {', '.join(peaks)}"
        found.append(Figure(f"Base {title}: ground on robot", alt, _sheet(LOW).plot(draw, title)))
    return found


def energy_figure(balance: EnergyBalance, history: History, size: Sizes) -> Figure:
    """Return work done on the robot, less losses, and the energy that it stores: the same curve if all is right."""

    lines = {name: history.energy.line("energy", k) for k, name in enumerate(history.energy.names)}

    def draw(canvas: Canvas) -> None:
        against_time(canvas, lines, "J", ({"linewidth": 3.0}, {"dashes": (3, 3), "linewidth": 1.6}))

    fit = "agree" if balance.consistent else "disagree"
    worst = number(balance.worst, size["J"])
    alt = f"Work done less losses and energy stored against time; they {fit}, at worst by {worst} J"
    return Figure("Energy check: work less losses, and energy stored", alt, _sheet(LOW).plot(draw, "energy"))


def share_figures(joints: Sequence[JointLoad]) -> list[Figure]:
    """Return for every joint what each effect adds to its peak, in parts of the peak, some joints in each figure."""
    names = [name for joint in joints for name, share in joint.shares.items() if abs(share) >= _SEEN * abs(joint.peak)]
    effects, many = list(dict.fromkeys(names)), -(-len(joints) // _TOGETHER)
    size, found = -(-len(joints) // many), []
    for k in range(many):
        caption = "What makes the peaks" + (f", {k + 1} of {many}" if many > 1 else "")
        found.append(_share_figure(joints[k * size : (k + 1) * size], effects, caption))
    return found


def _share_figure(joints: Sequence[JointLoad], names: Sequence[str], caption: str) -> Figure:
    shares = np.array([[joint.shares.get(name, 0.0) / joint.peak for joint in joints] for name in names])
    labels = shortened([printable(joint.name) for joint in joints], _LETTERS)
    top = 24 * ((len(names) + 2) // 3) + 8
    height = 38 * len(joints) + top + 40

    def draw(canvas: Canvas) -> None:
        axes = canvas.subplots()
        canvas.subplots_adjust(left=0.02, right=0.965, top=1 - top / height, bottom=36 / height)
        _bars(axes, shares, names)
        for row, label in enumerate(labels):
            axes.text(0.0, row - 0.26, label, transform=axes.get_yaxis_transform(), fontsize=10, color=INK)
        axes.set_yticks([])
        axes.set_ylim(len(labels) - 0.5, -0.75)
        axes.spines["left"].set_visible(False)
        axes.set_xlabel("share of the peak [%]")
        axes.grid(visible=False)
        canvas.legend(loc="upper left", ncols=3, fontsize=10, columnspacing=1.0, handlelength=1.0)

    return Figure(caption, _share_words(joints), plot(WIDE, height, draw, caption))


def _over_time(axes: Axes, line: tuple[Floats, Floats], title: str, limit: float | None, colour: str) -> None:
    axes.plot(*line, color=colour, marker="o" if len(line[0]) == 1 else None)
    axes.set_title(title)
    axes.axhline(0.0, color=SOFT, linewidth=0.8, zorder=1)
    axes.set_title("", loc="right")
    if limit is None:
        return
    largest = float(np.abs(line[1]).max())
    if largest < _NEAR * limit:
        axes.set_title(f"limit {limit:g}, off this scale", loc="right", fontsize=10, color=SOFT)
        return
    axes.set_title(f"limit {limit:g}", loc="right", fontsize=10, color=BAD if largest > limit else SOFT)
    for bound, reached in ((-limit, -line[1].min()), (limit, line[1].max())):
        if reached >= _NEAR * limit:
            axes.axhline(bound, color=BAD, linewidth=1.2, dashes=(5, 3))


def _envelope(axes: Axes, joint: JointLoad, samples: dict[str, Floats]) -> None:
    """Draw where the joint is in the plane of speed and torque; outside the dashed lines is beyond a limit."""
    speed, torque = samples["speed"], samples["torque"]
    over = np.zeros(len(speed), dtype=bool)
    for limit, values in ((joint.velocity_limit, speed), (joint.effort_limit, torque)):
        over |= np.abs(values) > (np.inf if limit is None else limit)
    for where, colour in ((~over, SERIES[0]), (over, BAD)):
        dots(axes, *_apart(speed[where], torque[where]), colour)
    axes.margins(0.08)
    limit_lines(axes, joint.effort_limit, joint.velocity_limit)
    zero_lines(axes)


def _apart(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Return one of the points that fall on the same pixel."""
    if not len(x):
        return x, y
    grid = [np.rint(300 * (each - each.min()) / (np.ptp(each) or 1.0)) for each in (x, y)]
    _, first = np.unique(np.stack(grid), axis=1, return_index=True)
    return x[first], y[first]


def _bars(axes: Axes, shares: Floats, names: Sequence[str]) -> None:
    """Draw what makes a peak, stacked to the right, and what lessens it, to the left."""
    from matplotlib.ticker import FuncFormatter

    rows = np.arange(shares.shape[1]) - 0.16
    right, left = np.zeros(len(rows)), np.zeros(len(rows))
    for k, (name, share) in enumerate(zip(names, shares, strict=True)):
        start = np.where(share >= 0.0, right, left)
        axes.barh(rows, share, left=start, height=0.42, align="edge", label=name, color=SERIES[k % len(SERIES)])
        right, left = right + np.maximum(share, 0.0), left + np.minimum(share, 0.0)
    for share, colour in ((0.0, INK), (1.0, GRID)):
        axes.vlines(np.full(len(rows), share), rows - 0.04, rows + 0.46, color=colour, linewidth=1.0)
    axes.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{100 * x:.0f}"))


def _joint_words(joint: JointLoad, what: str, size: Sizes) -> str:
    load, speed = size[joint.unit], speed_unit(joint.unit)
    peak, fastest = number(joint.peak, load), number(joint.max_speed, size[speed])
    least, most = (number(power, size["W"]) for power in (joint.least_power, joint.peak_power))
    limits = [] if joint.effort_limit is None else [f"limit {joint.effort_limit:g} {joint.unit}"]
    limits += [] if joint.velocity_limit is None else [f"limit {joint.velocity_limit:g} {speed}"]
    return (
        f"Joint {printable(joint.name)}: {what}, speed and power against time, and {what} against speed. "
        f"Peak {what} {peak} {joint.unit} at {moment(joint.peak_time, joint.peak, load)} s, largest speed "
        f"{fastest} {speed}, power from {least} to {most} W" + (f"; {', '.join(limits)}" if limits else "")
    )


def _part(joint: JointLoad, share: tuple[str, float]) -> float:
    """Return the part of the joint's peak that an effect makes."""
    return share[1] / joint.peak


def _share_words(joints: Sequence[JointLoad]) -> str:
    said = []
    for joint in joints:
        name, share = ranked([*joint.shares.items()] or [("nothing", 0.0)], partial(_part, joint))[0]
        said.append(f"{printable(joint.name)} {name} {100 * share / joint.peak:.0f} %")
    return f"Bars of what each effect adds to the peak of each joint; the largest: {', '.join(said)}"


_CONTACT_LOW = 190
"""Height of a figure [px]."""


def contact_figures(contacts: Sequence[ContactLoad], curves: Curves, size: Sizes) -> list[Figure]:
    """Return of each contact that is ever on its force along the normal against time, all to one scale.

    Args:
        curves: of `normal` and `on`, contact by contact.
    """
    top = 1.05 * max((contact.normal.value for contact in contacts), default=0.0)
    return [_contact_figure(contact, curves, k, top, size) for k, contact in enumerate(contacts) if contact.on]


def _contact_figure(contact: ContactLoad, curves: Curves, column: int, top: float, size: Sizes) -> Figure:
    samples = curves.samples(column)

    def draw(canvas: Canvas) -> None:
        axes = canvas.add_axes((0.16, 0.24, 0.805, 0.6))
        time, on = samples["time"], samples["on"] > 0.0
        across = axes.get_xaxis_transform()
        axes.fill_between(time, 0.0, 1.0, where=on.tolist(), transform=across, color=GRID, linewidth=0.0, zorder=0)
        axes.plot(time, samples["normal"], color=SERIES[0], marker="o" if len(time) == 1 else None)
        axes.set_ylim(0.0, top or None)
        axes.set_title("[N]")
        axes.set_xlabel("time [s]")
        few_ticks(axes)

    name, most = printable(contact.name), number(contact.normal.value, size["N"])
    words = f"Contact {name}: force along the normal against time, up to {most} N, on {100 * contact.on:.0f} % of it"
    return Figure(f"{name}: force along the normal; shaded where it is on", words, plot(WIDE, _CONTACT_LOW, draw, name))
