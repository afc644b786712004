"""The result of `torques` as a report for people."""

from __future__ import annotations

import os
from collections.abc import Iterator

from robodyn.errors import RobodynError
from robodyn.history import SPANS, History
from robodyn.model import Model
from robodyn.report.document import (
    Block,
    Document,
    Download,
    Facts,
    Figure,
    Findings,
    Gallery,
    Heading,
    Paragraph,
    Table,
    Verdict,
    csv_text,
    downloads,
)
from robodyn.report.drawing import PROCESSES, Draw, at_once
from robodyn.report.json_torques import torques_json
from robodyn.report.limits_words import effort_use, limits_verdict, speed_use, worst_joint
from robodyn.report.table import Content, number, printable
from robodyn.report.text_joints import derivation_table, share_table
from robodyn.report.text_torques import base_table, count, effect_table, load_table
from robodyn.result import Result
from robodyn.scene import Scene

PLOTTED = 12
"""Joints that have plots; the most loaded of them where there are more."""


def torques_page(result: Result, model: Model, scene: Scene, pictures: bool = True, draw: Draw = at_once) -> Document:
    """Limits first, then what the joints and the base carry, how that comes about, and whether it can be trusted.

    Args:
        pictures: with figures, which needs the result's history.
        draw: what draws them.
    """
    x, y, z = result.gravity
    what = (
        f"Torques along a motion: {count(len(result.joints), 'joint')}, {count(result.samples, 'sample')}, "
        f"{result.duration:.6g} s, gravity ({x:g}, {y:g}, {z:g}) m/s^2"
    )
    history = result.history if pictures else None
    plots = Plots(result, history, model, draw) if history else None
    files = list(_files(result, history))  # before any figure is waited for
    blocks: list[Block] = [limits_verdict(result)]
    if result.sizing is not None and result.sizing.exceeded:
        from robodyn.report.page_sizing import sizing_verdict

        blocks.append(sizing_verdict(result.sizing))
    if result.accuracy is not None:
        met = result.accuracy.met
        headline = "The accuracy asked for is met" if met else "The accuracy asked for is not met"
        blocks.append(Verdict("good" if met else "bad", headline, (f"{result.accuracy.said}.",)))
    if result.joints:
        blocks += [_facts(result), *_worst(result, model, scene, plots)]
        blocks += [Heading("Joints"), Table("What each joint carries", *load_table(result.joints))]
        blocks += _plots(result, plots)
        if result.sizing is not None:
            from robodyn.report.page_sizing import sizing_blocks

            blocks += sizing_blocks(result, model, scene, history.joints if history else None)
        blocks += _shares(result, plots)
    blocks += [*_base(result, plots), *_momentum(result), *_checks(result, plots), *_trust(result)]
    return Document(result.robot, what, (*blocks, *files))


class Plots:
    """The figures that are drawn from the course of the motion: begun here, and there when they are asked for.

    Attributes:
        shown: the joints with plots; loaded: those whose shares are drawn.
        worst, when: the joint that is loaded most, and its moment.
    """

    def __init__(self, result: Result, history: History, model: Model, draw: Draw) -> None:
        from robodyn.report import figures_torques as figures

        joints = result.joints
        order = sorted(range(len(joints)), key=lambda k: (-effort_use(joints[k]), k))
        self.history, self.shown = history, sorted(order[:PLOTTED])
        self.worst = worst_joint(result)
        chunks = [self.shown[k::PROCESSES] for k in range(PROCESSES)]
        if self.worst is not None:
            joint = joints[self.worst]
            self.when = f"the peak of {printable(joint.name)}, {joint.peak_time:.6g} s"
            pose = (history.states[self.worst]["q"], joint.name, self.when)
            if draw is not at_once and os.path.isfile(model.file):
                self.picture = draw(figures.pose_figure, (model.file, model.floating), *pose)
            else:
                self.picture = at_once(figures.pose_figure, model, *pose)
        if history.joints is not None:
            self._joints = [draw(figures.joint_figures, joints, history.joints, chunk) for chunk in chunks]
        loaded = [joints[k] for k in sorted(order[: 2 * PLOTTED]) if joints[k].peak]
        self.shares = draw(figures.share_figure, loaded) if loaded else None
        self.base = draw(figures.base_figures, result.base_wrench, history)
        self.energy = draw(figures.energy_figure, result.checks.energy_balance, history)

    def joints(self) -> list[Figure]:
        """Those of the joints that are shown, in their order."""
        drawn = [figure for chunk in self._joints for figure in chunk()]
        order = [k for first in range(PROCESSES) for k in self.shown[first::PROCESSES]]
        return [drawn[order.index(k)] for k in self.shown]


def _facts(result: Result) -> Facts:
    """The figures that are looked for first."""
    joints = result.joints
    powerful = max(joints, key=lambda joint: joint.peak_power)
    items = [("Largest power of a joint", f"{number(powerful.peak_power)} W", printable(powerful.name))]
    for use, what in ((effort_use, "effort"), (speed_use, "speed")):
        joint = max(joints, key=use)
        if use(joint):
            items.insert(0, (f"Largest use of a limit of {what}", f"{100 * use(joint):.0f} %", printable(joint.name)))
    work = sum(joint.work_positive for joint in joints)
    back = -sum(joint.work_negative for joint in joints)
    items.append(("Work of all joints", f"{number(work)} J", f"{number(back)} J returned"))
    return Facts(tuple(items))


def _worst(result: Result, model: Model, scene: Scene, plots: Plots | None) -> Iterator[Block]:
    """The robot at the peak of the joint that is loaded most, and the free body that this joint carries."""
    if plots is None or plots.worst is None:
        return
    yield Heading("At the heaviest load")
    drawing = _free_body(model, scene, plots.history, plots.worst, result.joints[plots.worst].name, plots.when)
    picture, why = plots.picture()
    yield Gallery((picture,) if drawing is None else (picture, drawing))
    if why:
        yield Paragraph(why)


def _free_body(model: Model, scene: Scene, history: History, k: int, name: str, when: str) -> Figure | None:
    from robodyn.free_body.bodies import free_bodies
    from robodyn.report.figures import of_page
    from robodyn.report.svg_free_body import drawing

    number_of = next((i for i, body in enumerate(model.bodies) if body.joint.name == name), None)
    if number_of is None:
        return None
    state = history.states[k]
    columns = dict(zip(scene.columns, state["columns"], strict=False))
    try:
        found = free_bodies(model, state["q"], state["qd"], state["qdd"], scene=scene, columns=columns)
    except RobodynError:
        return None
    body = found.bodies[number_of]
    svg = of_page(drawing(body, f"{printable(model.name)}, at {when}"))
    forces = ", ".join(action.what for action in body.actions)
    alt = f"Free-body diagram of {printable(body.name)} with its forces and moments: {printable(forces)}"
    return Figure(f"What acts on {printable(body.name)}, which {printable(name)} carries", alt, svg, wide=True)


def _plots(result: Result, plots: Plots | None) -> Iterator[Block]:
    if plots is None:
        return
    yield Heading("Along the motion")
    if len(plots.shown) < len(result.joints):
        yield Paragraph(
            f"The {len(plots.shown)} joints that use most of their limits of effort; the tables have all "
            f"{len(result.joints)}."
        )
    if result.samples > 2 * SPANS:
        yield Paragraph(
            f"Drawn from the least and the greatest of every {result.duration / SPANS:.2g} s, so that no peak is lost."
        )
    yield Gallery(tuple(plots.joints()))


def _shares(result: Result, plots: Plots | None) -> Iterator[Block]:
    yield Heading("What makes the peaks")
    if plots is not None and plots.shares is not None:
        yield Gallery((plots.shares(),))
    yield Table("What each effect adds to the peak of a joint", *share_table(result))


def _base(result: Result, plots: Plots | None) -> Iterator[Block]:
    yield Heading("Loads of the base")
    head, rows = base_table(result)
    if all(row[-1] == "0" for row in rows):
        yield Paragraph("No force and no moment between ground and robot throughout.")
        return
    if plots is not None:
        yield Gallery(tuple(plots.base()))
    yield Table("Ground on robot, about the base's origin", head, rows)


def _momentum(result: Result) -> Iterator[Block]:
    if result.momentum is not None:
        from robodyn.report.text_momentum import momentum_table

        title, rows = momentum_table(result.momentum)
        yield Heading("Momentum and energy")
        yield Table(title, *rows)


def _checks(result: Result, plots: Plots | None) -> Iterator[Block]:
    checks, balance = result.checks, result.checks.energy_balance
    yield Heading("Self-checks")
    figures = (number(value, balance.turnover) for value in (balance.work, balance.energy_change, balance.residual))
    work, stored, rest = figures
    laws = [f"{value:.0e}" if value else "0" for value in (checks.first_law, checks.second_law, checks.power)]
    reasons = [
        f"Work done on the robot, less losses, is {work} J and the change of stored energy {stored} J, with "
        f"{number(balance.turnover)} J going in and out; the difference is {rest} J, of which sampling explains "
        f"{number(abs(balance.quadrature), balance.turnover)} J.",
        f"Euler's laws and the power balance hold at {count(checks.samples, 'sample')} within {laws[0]}, {laws[1]} and "
        f"{laws[2]} of the largest force, moment and power.",
    ]
    if not balance.consistent:
        reasons.insert(0, "Velocities or accelerations are not the rates of the positions: check the trajectory.")
        yield Verdict("doubtful", "The energy balance does not close", tuple(reasons))
    else:
        yield Verdict("good", "Energy and momentum balance", tuple(reasons))
    if plots is not None:
        yield Gallery((plots.energy(),))


def _trust(result: Result) -> Iterator[Block]:
    """How the motion was derived, which effects count, and warnings."""
    if result.derivation:
        methods, rows = derivation_table(result.derivation)
        yield Heading("Derivatives")
        yield Table(methods, *rows) if rows else Paragraph(f"{methods}.")
    yield Heading("Effects")
    plan = f"{result.operations} operations per sample; {result.executor}: {result.reason}"
    yield Table("Which effects count, and why", *_effect_table(result), note=plan)
    if result.warnings:
        yield Heading("Warnings")
        yield Findings(tuple(("doubtful", line, ()) for line in result.warnings))


def _effect_table(result: Result) -> Content:
    """Without the column of what is saved, where that was not computed."""
    head, rows = effect_table(result)
    if any(effect.saved is not None for effect in result.effects):
        return head, rows
    return (*head[:3], *head[4:]), [(*row[:3], *row[4:]) for row in rows]


def _files(result: Result, history: History | None) -> Iterator[Block]:
    head, rows = load_table(result.joints)
    files = [
        Download("result.json", "application/json", torques_json(result)),
        Download("joints.csv", "text/csv", csv_text(head, rows)),
    ]
    if history is not None and history.joints is not None:
        files.append(Download("curves.csv", "text/csv", _curves(history)))
    yield Heading("Data")
    yield downloads(files, "robodyn torques --format json and --out write it to a file")


def _curves(history: History) -> str:
    """What is plotted, one row for each sample and joint."""
    assert history.joints is not None
    rows = []
    for k, name in enumerate(history.joints.names):
        samples = history.joints.samples(k)
        rows += [(name, *(f"{value:.7g}" for value in row)) for row in zip(*samples.values(), strict=True)]
    return csv_text(("joint", "time", *history.joints.quantities), rows)
