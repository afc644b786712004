"""`torques` as a page: limits first, then what joints and base carry, how that comes about, whether to trust it."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.dynamics.constraints.constraint_jacobian import tree_scene
from robodyn.equations.free_body.types import FreeBodies, FreeBody
from robodyn.errors import RobodynError
from robodyn.loads.error_bars import energy_caveat
from robodyn.loads.history import SPANS, Curves, History
from robodyn.loads.result import Result
from robodyn.report.document import (
    Block,
    Document,
    Facts,
    Figure,
    Findings,
    Gallery,
    Heading,
    HeatMap,
    Paragraph,
    Table,
    csv_text,
    data_blocks,
    gallery,
    paragraphs,
)
from robodyn.report.equations import action_table
from robodyn.report.limits import (
    LINES,
    accuracy_blocks,
    effort_use,
    exceeded_table,
    offenders,
    offenders_first,
    speed_use,
    torques_verdict,
    use,
)
from robodyn.report.pictures.free_body import NOTES, symbols
from robodyn.report.pictures.torques_plots import Plots
from robodyn.report.sizes import Sizes, free_body_sizes, result_sizes
from robodyn.report.sizing import constraint_lines, constraint_tables, sizing_sections
from robodyn.report.table import gravity_text, number, printable
from robodyn.report.torques import (
    balance_words,
    base_table,
    derivation_table,
    effect_table,
    input_words,
    load_table,
    momentum_table,
    share_table,
)
from robodyn.report.torques_json import torques_json
from robodyn.report.uncertainty import uncertainty_blocks
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene
from robodyn.support.floats import ranked
from robodyn.support.wording import count


def torques_page(result: Result, model: Model, scene: Scene, pictures: bool = True) -> Document:
    """Return limits first, then what joints and base carry, how that comes about, and whether to trust it.

    Args:
        pictures: with figures, which needs the result's history.
    """
    what = (
        f"Torques along a motion: {count(len(result.joints), 'joint')}, {count(result.samples, 'sample')}, "
        f"{result.duration:.6g} s, {gravity_text(result.gravity)}"
    )
    history = result.history if pictures else None
    plots = Plots(result, history, model)
    ordered = offenders_first(result)
    blocks: list[Block] = [torques_verdict(result), *accuracy_blocks(result)]
    blocks += paragraphs(input_words(result, most=None))
    if result.joints:
        blocks += [_facts(result), *_limits(ordered), *heaviest_load(result, model, scene, plots)]
        blocks += [Heading("Joints"), Table("What each joint carries", *load_table(ordered))]
        blocks += _plots(result, plots)
        if result.sizing is not None:
            blocks += sizing_blocks(result, model, scene, history.joints if history else None)
        blocks += [*uncertainty_blocks(result), Heading("What makes the peaks"), *gallery(plots.shares())]
        blocks.append(Table("What each effect adds to the peak of a joint", *share_table(ordered)))
    if result.constraints is not None:
        blocks += [Heading("Loops and contacts"), *paragraphs(constraint_lines(result.constraints))]
        blocks += gallery(plots.contacts())
        blocks += [Table(title, *rows) for title, rows in constraint_tables(result)]
    blocks += _base(result, plots)
    if result.momentum is not None:
        title, rows = momentum_table(result.momentum)
        blocks += [Heading("Momentum and energy"), Table(title, *rows)]
    blocks += [*_self_checks(result, plots), *_grounds(result)]
    return Document(result.robot, what, (*blocks, *_files(result, history)))


def _facts(result: Result) -> Facts:
    """Return the figures that are looked for first."""
    joints, size = result.joints, result_sizes(result)
    powerful = ranked(joints, key=lambda joint: joint.peak_power)[0]
    items = []
    for share, what in ((effort_use, "effort"), (speed_use, "speed")):
        joint = ranked(joints, key=share)[0]
        if share(joint):
            items.append((f"Largest use of a limit of {what}", f"{100 * share(joint):.0f} %", printable(joint.name)))
    items.append(("Largest power of a joint", f"{number(powerful.peak_power, size['W'])} W", printable(powerful.name)))
    work = sum(joint.work_positive for joint in joints)
    back = -sum(joint.work_negative for joint in joints)
    items.append(("Work of all joints", f"{number(work, size['J'])} J", f"{number(back, size['J'])} J returned"))
    return Facts(tuple(items))


def _limits(result: Result) -> Iterator[Block]:
    """Yield a map of all joints, and a table of the limits that are exceeded where the verdict does not name them all.

    Args:
        result: with the joints that exceed limits first.
    """
    found = heat_map(result)
    if found is None:
        return
    yield Heading("Use of limits")
    if len(result.exceeded) > LINES + 1:
        yield Table("Limits that are exceeded", *exceeded_table(result.exceeded))
    yield found


def heat_map(result: Result) -> HeatMap | None:
    """Return how much of its limits of effort and velocity each joint uses; None where there are no limits."""
    rows = []
    for joint in result.joints:
        cells = (
            (use(joint.peak, joint.effort_limit), None if joint.effort_limit is None else effort_use(joint)),
            (use(joint.max_speed, joint.velocity_limit), None if joint.velocity_limit is None else speed_use(joint)),
        )
        rows.append((joint.name, cells))
    if all(share is None for _, cells in rows for _, share in cells):
        return None
    return HeatMap("How much of its limits each joint uses", ("effort", "velocity"), rows)


def _plots(result: Result, plots: Plots) -> Iterator[Block]:
    if not plots.shown:
        return
    yield Heading("Along the motion")
    if len(plots.shown) + len(plots.still) < len(result.joints):
        yield Paragraph(
            f"The joints beyond a limit, and those that use most of their limits of effort, {len(plots.shown)} of "
            f"{len(result.joints)}; the tables have all."
        )
    if plots.still:
        names = ", ".join(printable(result.joints[k].name) for k in plots.still)
        yield Paragraph(f"Without a plot, because they neither move nor carry anything: {names}.")
    if result.samples > 2 * SPANS:
        yield Paragraph(
            f"Drawn from the least and the greatest of every {result.duration / SPANS:.2g} s, so that no peak is lost."
        )
    yield Gallery(tuple(plots.joints()))


def _base(result: Result, plots: Plots) -> Iterator[Block]:
    yield Heading("Loads of the base")
    head, rows = base_table(result)
    if all(row[-1] == "0" for row in rows):
        beside = " but those of its contacts" if result.constraints and result.constraints.contacts else ""
        yield Paragraph(f"No force and no moment between ground and robot throughout{beside}.")
        return
    yield from gallery(plots.base())
    yield Table("Ground on robot, about the base's origin", head, rows)


def _files(result: Result, history: History | None) -> list[Block]:
    head, rows = load_table(result)
    files = [("result.json", torques_json(result)), ("joints.csv", csv_text(head, rows))]
    if history is not None and history.joints is not None:
        files.append(("curves.csv", _curves(history)))
    return data_blocks(files, "robodyn torques --format json and --out write it to a file")


def _curves(history: History) -> str:
    """Return what is plotted, one row for each sample and joint."""
    assert history.joints is not None
    rows = []
    for k, name in enumerate(history.joints.names):
        samples = history.joints.samples(k)
        rows += [(name, *(f"{value:.7g}" for value in row)) for row in zip(*samples.values(), strict=True)]
    return csv_text(("joint", "time", *history.joints.quantities), rows)


def heaviest_load(result: Result, model: Model, scene: Scene, plots: Plots) -> Iterator[Block]:
    """Yield the robot at the peak of the joint that is loaded most, and the free body that this joint carries."""
    if plots.history is None or plots.worst is None:
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


def _self_checks(result: Result, plots: Plots) -> Iterator[Block]:
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
    yield from gallery(plots.energy())


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
        yield from gallery(figures[name] for name in ordered)
    for section in sizing_sections(offenders_first(result)):
        yield from (block for block in section if isinstance(block, Table))  # verdicts lead the page
