"""The robot at its heaviest load, as a part of a report on torques."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.errors import RobodynError
from robodyn.history import History
from robodyn.model import Model
from robodyn.report.document import Block, Figure, Gallery, Heading, Paragraph
from robodyn.report.plots_torques import Plots
from robodyn.report.table import printable
from robodyn.result import Result
from robodyn.scene import Scene


def heaviest_load(result: Result, model: Model, scene: Scene, plots: Plots | None) -> Iterator[Block]:
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
    from robodyn.report.sizes import free_body_sizes
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
    svg = of_page(drawing(body, f"{printable(model.name)}, at {when}", free_body_sizes(found)))
    forces = ", ".join(action.what for action in body.actions)
    alt = f"Free-body diagram of {printable(body.name)} with its forces and moments: {printable(forces)}"
    return Figure(f"What acts on {printable(body.name)}, which {printable(name)} carries", alt, svg, wide=True)
