"""Parts of a report on torques: the heaviest load, drives and bearings, and whether the numbers can be trusted."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.dynamics.constraints.constraint_jacobian import tree_scene
from robodyn.equations.free_body.types import FreeBodies, FreeBody
from robodyn.errors import RobodynError
from robodyn.loads.caveats import energy_caveat
from robodyn.loads.history import Curves, History
from robodyn.loads.result import Result
from robodyn.report.document import Block, Figure, Findings, Gallery, Heading, Paragraph, Table, paragraphs
from robodyn.report.free_body import action_table
from robodyn.report.limits import offenders, offenders_first
from robodyn.report.pictures.svg import NOTES, symbols
from robodyn.report.pictures.torques_plots import Plots
from robodyn.report.sizes import Sizes, free_body_sizes
from robodyn.report.sizing import sizing_sections
from robodyn.report.table import printable
from robodyn.report.torques import balance_words
from robodyn.report.torques_tables import derivation_table, effect_table
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene
from robodyn.support.wording import count


def heaviest_load(result: Result, model: Model, scene: Scene, plots: Plots | None) -> Iterator[Block]:
    """Yield the robot at the peak of the joint that is loaded most, and the free body that this joint carries."""
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
    """Return the robot at the peak of a joint; None where it cannot be taken apart."""
    from robodyn.equations.free_body.bodies import free_bodies

    state, tree = history.states[k], tree_scene(model, scene) if scene.constrained else scene
    columns = dict(zip(tree.columns, state["columns"], strict=False))
    try:
        return free_bodies(model, state["q"], state["qd"], state["qdd"], scene=tree, columns=columns)
    except RobodynError:
        return None


def _drawing(body: FreeBody, size: Sizes, name: str) -> Figure:
    from robodyn.report.pictures.figures import of_page
    from robodyn.report.pictures.free_body import page_drawing

    forces = ", ".join(action.what for action in body.actions)
    alt = f"Free-body diagram of {printable(body.name)} with its forces and moments: {printable(forces)}"
    caption = f"What acts on {printable(body.name)}, which {printable(name)} carries"
    return Figure(caption, alt, of_page(page_drawing(body, size)))


def trust(result: Result, plots: Plots | None) -> Iterator[Block]:
    """Yield the self-checks; how the motion was derived, which effects count, and warnings."""
    yield from _checks(result, plots)
    yield from _grounds(result)


def _checks(result: Result, plots: Plots | None) -> Iterator[Block]:
    checks, balance = result.checks, result.checks.energy_balance
    yield Heading("Self-checks")
    (work, stored, rest, turnover, sampling), laws = balance_words(result)
    reasons = [
        f"Work done on the robot, less losses, is {work} J and the change of stored energy {stored} J, with "
        f"{turnover} J going in and out; the difference is {rest} J, of which sampling explains {sampling} J.",
        f"Euler's laws and the power balance hold at {count(checks.samples, 'sample')} within {laws[0]}, {laws[1]} and "
        f"{laws[2]} of the largest force, moment and power.",
    ]
    if not balance.consistent:
        off = energy_caveat(balance, result.samples, result.duration)
        reasons.insert(0, f"{off.text}." if off else "")
        yield Findings((("doubtful", "The energy balance does not close", tuple((each, False) for each in reasons)),))
    else:
        yield from paragraphs(("Energy and momentum balance.", *reasons))
    if plots is not None and (energy := plots.energy()):
        yield Gallery(tuple(energy))


def _grounds(result: Result) -> Iterator[Block]:
    """Yield how the motion was derived, which effects count, and warnings."""
    if result.derivation:
        methods, rows = derivation_table(result.derivation, result.samples_suffice)
        yield Heading("Derivatives")
        yield Table(methods, *rows) if rows else Paragraph(f"{methods}.")
    yield Heading("Effects")
    plan = f"{result.operations} operations per sample; {result.executor}: {result.reason}"
    saved = any(effect.saved is not None for effect in result.effects)
    yield Table("Which effects count, and why", *effect_table(result, saved), note=plan)
    if result.warnings:
        yield Heading("Warnings")
        yield Findings(tuple(("doubtful", line, ()) for line in result.warnings))


def sizing_blocks(result: Result, model: Model, scene: Scene, curves: Curves | None) -> Iterator[Block]:
    """Yield torque against speed at the shafts of motors, and tables.

    Args:
        curves: of the joints; None without figures.
    """
    sizing = result.sizing
    if sizing is None:
        return
    yield Heading("Motors, bearings, foundation")
    if curves is not None:
        from robodyn.report.pictures.torques_plots import motor_figures

        figures = dict(motor_figures(sizing, model, scene, curves))
        over = offenders(result)
        ordered = sorted(figures, key=lambda name: name not in over)
        if ordered:
            yield Gallery(tuple(figures[name] for name in ordered))
    for section in sizing_sections(offenders_first(result)):
        yield from (block for block in section if isinstance(block, Table))  # verdicts lead the page
