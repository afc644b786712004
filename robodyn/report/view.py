"""A robot to look at: a page with sliders for its joints, or that of `torques`, which plays a motion."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, field
from html import escape
from typing import TYPE_CHECKING

from robodyn.checks.overview import branches
from robodyn.equations.dae.dae import closed_state
from robodyn.errors import RobodynError
from robodyn.report import document as doc
from robodyn.report import stage
from robodyn.report.check import tree_table
from robodyn.report.table import first_names, number
from robodyn.robot.kinematics import Values, beyond_limits, configuration, nearest_to_zero
from robodyn.robot.model import Model
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.wording import count

if TYPE_CHECKING:
    import os

    from robodyn.trajectory.motion import Trajectory
    from robodyn.trajectory.read import TrajectoryReader

    Motion = Trajectory | TrajectoryReader | str | os.PathLike[str]


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
    if motion is not None:
        from robodyn.loads.torques import torques
        from robodyn.report.torques_page import torques_page

        return torques_page(torques(model, motion, scene, history=True), model, scene)
    q, said = configuration(model, nearest_to_zero(model) if at is None else at), []
    if scene.loops:
        begin = "which do not close near this pose"
        with suppress(RobodynError):
            q, begin = closed_state(model, scene, at, ())[0], "closed at first"
        names = first_names([loop.name for loop in scene.loops], 4)
        said.append(f"Loops: {names}, {begin}. Sliders move the joints of the tree one by one, and open loops.")
    said += beyond_limits(model, q)
    shapes, why = stage.shapes_of_bodies(model)
    robot = stage.robot(model, [stage.pose(model, q.tolist(), stage.weights(model, scene))])
    words = "The robot, whose joints are moved below"
    blocks: list[doc.Block] = [stage.stage(words, [robot], [shapes], bars=bool(why))]
    blocks += doc.paragraphs(filter(None, [*said, why]))
    if model.description is not None:
        blocks.append(tree_table(list(branches(model.description)), "Links, and the joints that carry them"))
    what = f"{count(model.n, 'degree')} of freedom, {count(len(model.bodies), 'body', 'bodies')}"
    return doc.Document(model.name, f"{what}, {number(model.total_mass)} kg", tuple(blocks))
