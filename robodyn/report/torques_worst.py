"""The robot at its heaviest load, as a part of a report on torques."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.equations.free_body.types import FreeBodies, FreeBody
from robodyn.errors import RobodynError
from robodyn.loads.history import History
from robodyn.loads.result import Result
from robodyn.report.document import Block, Figure, Gallery, Heading, Paragraph, Table
from robodyn.report.free_body import action_table
from robodyn.report.pictures.svg import NOTES, symbols
from robodyn.report.pictures.torques_plots import Plots
from robodyn.report.sizes import Sizes, free_body_sizes
from robodyn.report.table import printable
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene


def heaviest_load(result: Result, model: Model, scene: Scene, plots: Plots | None) -> Iterator[Block]:
    """The robot at the peak of the joint that is loaded most, and the free body that this joint carries."""
    if plots is None or plots.worst is None:
        return
    yield Heading("At the heaviest load")
    name = result.joints[plots.worst].name
    found = _free_bodies(model, scene, plots.history, plots.worst)
    carried = [body for body in found.bodies if model.bodies[body.number].joint.name == name] if found else []
    picture, why = plots.picture()
    if found is None or not carried:
        yield Gallery((picture,))
    else:
        (body,), size = carried, free_body_sizes(found)
        yield Gallery((picture, _drawing(body, size, name)))
        head, rows = action_table(body, size)
        named = [(symbols(action, size), *row) for action, row in zip(body.actions, rows, strict=False)]
        what = f"Forces and moments on {printable(body.name)}, {plots.when}"
        yield Table(what, ("symbol", "what", *head[1:]), [*named, ("sum", "", *rows[-1][1:])], note=" ".join(NOTES))
    if why:
        yield Paragraph(why)


def _free_bodies(model: Model, scene: Scene, history: History, k: int) -> FreeBodies | None:
    """The robot at the peak of a joint; None where it cannot be taken apart."""
    from robodyn.equations.free_body.bodies import free_bodies

    state = history.states[k]
    columns = dict(zip(scene.columns, state["columns"], strict=False))
    try:
        return free_bodies(model, state["q"], state["qd"], state["qdd"], scene=scene, columns=columns)
    except RobodynError:
        return None


def _drawing(body: FreeBody, size: Sizes, name: str) -> Figure:
    from robodyn.report.pictures.figures import of_page
    from robodyn.report.pictures.free_body import page_drawing

    forces = ", ".join(action.what for action in body.actions)
    alt = f"Free-body diagram of {printable(body.name)} with its forces and moments: {printable(forces)}"
    caption = f"What acts on {printable(body.name)}, which {printable(name)} carries"
    return Figure(caption, alt, of_page(page_drawing(body, size)))
