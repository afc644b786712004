"""`torques` as a page: the verdict, how near limits are, the heaviest load, plots, then what the text says."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.dynamics.constraints.constraint_jacobian import tree_scene
from robodyn.equations.free_body.bodies import free_bodies
from robodyn.errors import RobodynError
from robodyn.loads.history import SPANS, History
from robodyn.loads.result import JointLoad, Result
from robodyn.report import document as doc
from robodyn.report.equations import action_table
from robodyn.report.limits import effort_use, offenders, torques_verdict, worst_joint
from robodyn.report.sizes import Sizes, free_body_sizes, result_sizes, speed_unit
from robodyn.report.table import gravity_text, is_noise, printable
from robodyn.report.torques import load_table, torques_sections
from robodyn.report.torques_json import torques_json
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene
from robodyn.support.floats import ranked
from robodyn.support.wording import count

PLOTTED = 12
"""Joints that have plots: those beyond limits, and the most loaded of the others up to so many."""


def torques_page(result: Result, model: Model, scene: Scene, pictures: bool = True) -> doc.Document:
    """Return the verdict, the figures that matter most, plots, and all that the text says.

    Args:
        pictures: with figures, which needs the result's history.
    """
    what = (
        f"Torques along a motion: {count(len(result.joints), 'joint')}, {count(result.samples, 'sample')}, "
        f"{result.duration:.6g} s, {gravity_text(result.gravity)}"
    )
    blocks: list[doc.Block] = [torques_verdict(result)]
    head, rows = load_table(result)
    files = [("result.json", torques_json(result)), ("joints.csv", doc.csv_text(head, rows))]
    if pictures and result.history is not None:
        blocks += _pictures(result, model, scene, result.history)
        files += _curves(result.history)
    sections = torques_sections(result, explain=True)
    how = "robodyn torques --format json and --out write it to a file"
    return doc.page(result.robot, what, blocks, sections, "Loads", files, how)


def _pictures(result: Result, model: Model, scene: Scene, history: History) -> Iterator[doc.Block]:
    """Yield all figures, heading by heading, joints beyond limits first."""
    from robodyn.report.pictures import torques as pictures

    joints, size, over = result.joints, result_sizes(result), offenders(result)
    in_order = sorted(range(len(joints)), key=lambda k: (joints[k].name not in over, k))
    yield from _heaviest_load(result, model, scene, history)
    if history.joints is not None:
        yield from doc.titled("Along the motion", _joint_figures(result, history, in_order))
        if result.sizing is not None:
            motors = dict(pictures.motor_figures(result.sizing, model, scene, history.joints))
            yield from doc.titled(
                "Motors", doc.gallery(motors[name] for name in sorted(motors, key=lambda name: name not in over))
            )
    loaded = [joints[k] for k in in_order if not is_noise(abs(joints[k].peak), size[joints[k].unit])]
    yield from doc.titled("What makes the peaks", doc.gallery(pictures.share_figures(loaded)))
    if result.constraints is not None and history.contacts is not None:
        contacts = pictures.contact_figures(result.constraints.contacts, history.contacts, size)
        yield from doc.titled("Contacts", doc.gallery(contacts))
    yield from doc.titled("Loads of the base", doc.gallery(pictures.base_figures(result.base_wrench, history, size)))
    energy = pictures.energy_figures(result.checks.energy_balance, history, size)
    yield from doc.titled("Energy", doc.gallery(energy))


def _joint_figures(result: Result, history: History, in_order: list[int]) -> Iterator[doc.Block]:
    """Yield figures of the joints beyond limits and the most loaded, and which joints have none."""
    from robodyn.report.pictures.torques import joint_figure

    joints, size, over = result.joints, result_sizes(result), offenders(result)
    moving = [k for k in in_order if not _rests(joints[k], size)]
    loaded = sorted(ranked(moving, key=lambda k: effort_use(joints[k])), key=lambda k: joints[k].name not in over)
    shown = loaded[: max(PLOTTED, len(over))]
    if len(shown) < len(moving):
        yield doc.Paragraph(
            f"The joints beyond a limit, and those that use most of their limits of effort, {len(shown)} of "
            f"{len(joints)}; the tables have all."
        )
    if still := [printable(joint.name) for joint in joints if _rests(joint, size)]:
        yield doc.Paragraph(f"Without a plot, because they neither move nor carry anything: {', '.join(still)}.")
    if shown and result.samples > 2 * SPANS:
        span = f"{result.duration / SPANS:.2g} s"
        yield doc.Paragraph(f"Drawn from the least and the greatest of every {span}, so that no peak is lost.")
    assert history.joints is not None
    curves = history.joints
    yield from doc.gallery(joint_figure(joints[k], curves, k, size) for k in in_order if k in shown)


def _rests(joint: JointLoad, size: Sizes) -> bool:
    return is_noise(abs(joint.peak), size[joint.unit]) and is_noise(abs(joint.max_speed), size[speed_unit(joint.unit)])


def _curves(history: History) -> Iterator[tuple[str, str]]:
    if history.joints is not None:
        rows = []
        for k, name in enumerate(history.joints.names):
            samples = history.joints.samples(k).values()
            rows += [(name, *(f"{value:.7g}" for value in row)) for row in zip(*samples, strict=True)]
        yield "curves.csv", doc.csv_text(("joint", "time", *history.joints.quantities), rows)


def _heaviest_load(result: Result, model: Model, scene: Scene, history: History) -> Iterator[doc.Block]:
    """Yield the robot at the peak of the joint that is loaded most, and the free body that this joint carries, if the
    robot can be taken apart there."""
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
