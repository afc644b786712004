"""`simulate`: what was integrated and how, what the motion reaches, and what drifted; as a page and as JSON."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import groupby, pairwise
from typing import Any, NamedTuple

import numpy as np

from robodyn.report import document as doc
from robodyn.report.charts import COLOURS, Course, time_chart
from robodyn.report.limits import exceeded_section, limits_data, limits_verdict, use, use_bars, verdict_section
from robodyn.report.sizes import Sizes, motion_units, simulation_sizes, speed_unit
from robodyn.report.table import drift_text, first_names, gravity_text, number, relative_text
from robodyn.simulation.loop_figures import LoopFigures
from robodyn.simulation.result import Simulation
from robodyn.support.floats import Floats, ranked
from robodyn.support.wording import count

FREE = "ODE, qdd = M^-1 (tau - bias) by articulated bodies"
LOOPED = "index-1 DAE, M qdd + bias = tau + J^T lambda, J qdd = -J' qd by M = C C^T and C^-1 J^T = Q R"
_NAMED = 8
"""Equations of loops that are named; of more, the number."""
PLOTTED = 12
"""Joints that have plots; those that move most where there are more."""


def simulation_sections(result: Simulation, explain: bool = False) -> Iterator[doc.Section]:
    """Yield what was integrated and how, what it reaches, and what drifted; to explain also why effects are on or
    off."""
    size = simulation_sizes(result)
    on = [effect.name for effect, why in result.effects if why.active]
    length = f"steps of {result.step:.6g} s" if result.step is not None else f"steps, rtol {result.rtol:.3g}"
    method = f"{result.method.name} of order {result.method.order} ({result.method.about})"
    yield doc.paragraphs(
        [
            f"{result.model.name}: {result.time[-1]:.6g} s, {gravity_text(result.scene.gravity)}",
            f"effects on: {', '.join(on)}; no contact",
            f"form: {LOOPED if result.loops else FREE}",
            f"method: {method}, {result.steps} {length}, {result.evaluations} evaluations, {result.executor}",
        ]
    )
    rows, (positions, speeds) = [], motion_units(result.model)
    for name, unit, q in zip(result.model.coordinates, positions, result.q.T, strict=True):
        rows.append([name, unit, *(size.number(x, unit) for x in (q[0], q[-1], q.min(), q.max()))])
    yield [doc.Table("", ("position", "unit", "at the start", "at the end", "least", "largest"), rows)]
    rows = []
    for name, unit, qd, qdd in zip(result.model.rates, speeds, result.qd.T, result.qdd.T, strict=True):
        row = [name, unit, *(size.number(x, unit) for x in (qd[0], qd[-1], np.abs(qd).max()))]
        rows.append([*row, size.amount(np.abs(qdd).max(), f"{unit}^2")])
    yield [doc.Table("", ("speed", "unit", "at the start", "at the end", "largest", "largest acceleration"), rows)]
    rows = []
    for joint in result.joints:
        unit = speed_unit(joint.unit)
        row = [joint.name, use(joint.max_speed, joint.velocity_limit)]
        row += [size.moment(joint.max_speed_time, joint.max_speed, unit)]
        peak = [size.amount(joint.peak, joint.unit), size.moment(joint.peak_time, joint.peak, joint.unit)]
        rows.append([*row, *(peak if joint.driven else ("-", "-")), use(joint.peak, joint.effort_limit)])
    head = ("joint", "of velocity limit", "at [s]", "drive's peak", "at [s]", "of effort limit")
    yield [doc.Table("", head, rows)] if rows else []
    yield doc.paragraphs(_drift(result, size))
    if result.loops:
        yield from _loops(result.loops, result.model.reach, size)
    if explain:
        effects = [(effect.name, "on" if why.active else "off", why.reason) for effect, why in result.effects]
        yield [doc.Table("Effects", ("effect", "", "why"), effects)]
    if result.ended:
        how = 'joint_limits = "spring" or "ignore" in a scene goes on'
        yield [doc.Paragraph(f"ENDED EARLY: {result.ended} ({how})")]
    yield exceeded_section(result)
    yield doc.remarks("warning", (caveat.text for caveat in result.caveats))
    yield doc.remarks("note", result.notes)
    yield verdict_section(result)


def _drift(result: Simulation, size: Sizes) -> Iterator[str]:
    energy = result.figures.energy
    start, end, work = (size.number(x, "J") for x in (energy[0], energy[-1], result.work[-1]))
    yield f"energy: {start} J at the start, {end} J at the end, work {work} J; {_energy_drift(result, size)[1]}"
    if result.free:
        linear, angular = result.momentum_drift
        yield (
            f"momentum: drift {drift_text(linear, size['N s'])} N s linear, less the weight's, and "
            f"{drift_text(angular, size['N m s'])} N m s angular, about the centre of mass"
        )


def _energy_drift(result: Simulation, size: Sizes) -> tuple[float, str]:
    """Return the drift of energy over the largest kinetic energy, and both in words."""
    kinetic = float(result.figures.kinetic.max())
    relative = result.energy_drift / kinetic if kinetic else 0.0
    drift = f"drift {drift_text(result.energy_drift, size['J'])} J"
    return (
        relative,
        f"{drift}, {relative_text(relative)} of the largest kinetic energy of {size.number(kinetic, 'J')} J",
    )


def _loops(loops: LoopFigures, reach: float, size: Sizes) -> Iterator[doc.Section]:
    """Yield ranks, what each loop carries at most, and how far it comes apart beside the robot's reach [m]."""
    kept = loops.equations - len(loops.dropped)
    lines = [f"loops: {count(loops.equations, 'equation')}, {loops.rank} of them independent at the start"]
    lines[0] += f"; degrees of freedom left: {loops.freedoms}; {loops.stabilised}"
    if loops.dropped:
        lines.append(f"left out, for the others imply them: {first_names(loops.dropped, _NAMED)}")
    if loops.rank < kept:
        lines.append(f"{kept - loops.rank} depend on the others there: how they share their reactions is arbitrary")
    yield doc.paragraphs(lines)
    apart = max(reach, 1.0)
    rows = []
    for name, wrench, gap, slip in zip(loops.names, loops.wrenches.swapaxes(0, 1), loops.gap, loops.slip, strict=True):
        force, turning = (np.sqrt(np.square(wrench[:, part]).sum(axis=1)).max() for part in (slice(3), slice(3, 6)))
        row = [name, size.number(force, "N"), size.number(turning, "N m")]
        rows.append([*row, drift_text(gap, apart), drift_text(slip, apart)])
    head = ("loop", "largest force [N]", "largest moment [N m]", "|phi| [m, rad]", "|phi'| [m/s, rad/s]")
    yield [doc.Table("", head, rows)]


def simulation_page(result: Simulation, pictures: bool = True) -> doc.Document:
    """Return how the motion ends and how far it can be trusted, then the motion itself."""
    what = f"Simulated motion: {result.model.n} degrees of freedom, {result.time[-1]:.6g} s, {result.steps} steps"
    relative, drift = _energy_drift(result, simulation_sizes(result))
    energy, end = f"Energy: {drift}.", f"{result.time[-1]:.6g} s"
    verdict = doc.Verdict("good", f"The motion ran for its {end}, and its energy balances", (energy,))
    if result.ended:
        verdict = doc.Verdict("bad", f"The motion ended early, at {end}", (result.ended, energy))
    elif relative > 1e-3:  # above it steps are too long
        verdict = doc.Verdict("doubtful", "The energy drifts: take shorter steps or a smaller tolerance", (energy,))
    verdicts = [verdict, *([limits_verdict(result)] if result.joints or result.caveats else [])]
    worst_first = ("bad", "doubtful", "neutral", "good")
    worst, *others = sorted(verdicts, key=lambda verdict: worst_first.index(verdict.level))
    also = tuple(line for other in others for line in (f"{other.headline}.", *other.reasons))
    blocks: list[doc.Block] = [replace(worst, reasons=(*worst.reasons, *also))]
    blocks += _moving(result) if pictures else use_bars(result)
    table = doc.csv_text(("time", *result.names), np.column_stack((result.time, result.columns)).tolist())
    files = [("result.json", simulation_json(result)), ("motion.csv", table)]
    how = "robodyn simulate --format json and --out write it to a file"
    *sections, _ = simulation_sections(result, explain=True)  # the last is the verdict
    return doc.page(result.model.name, what, blocks, sections, "Motion", files, how)


def _moving(result: Simulation) -> Iterator[doc.Block]:
    """Yield the robot along its motion, how much of limits it uses, and curves of all that was recorded."""
    from robodyn.support.courses import Courses

    plots, size = [*_plots(result)], simulation_sizes(result)
    curves = {f"{plot.what} {label}": each for plot in plots for label, each in plot.curves.items()}
    courses = Courses(("time", *result.names), tuple(curves))
    courses.update([result.time, *result.columns.T], [*curves.values()])
    course = Course(courses)
    yield from _stage(result, course)
    yield from use_bars(result)
    for heading, group in groupby(plots, key=lambda plot: plot.heading):
        charts = []
        for plot in group:
            what, unit, scale = plot.what, plot.unit, size[plot.unit]
            shown = {label: course.curve(f"{what} {label}", scale) for label in plot.curves}
            if any(np.any(curve) for curve in shown.values()):
                ends = (
                    f"{name} {number(x.min(), scale)} to {number(x.max(), scale)}" for name, x in plot.curves.items()
                )
                levels = [(limit, "limit") for limit in plot.limits if limit is not None]
                alt = f"{what} [{unit}] over time: {', '.join(ends)}"
                look: dict[str, Any] = {"rows": course.rows, "levels": levels}
                charts.append(time_chart(f"{what} [{unit}]", alt, course.time, shown, unit, **look))
        yield from doc.titled(heading, doc.gallery(charts))


class _Plot(NamedTuple):
    """Curves (N,) of one unit by label."""

    heading: str
    what: str
    unit: str
    curves: dict[str, Floats]
    limits: Iterable[float | None] = ()


def _plots(result: Simulation) -> Iterator[_Plot]:
    model, figures = result.model, result.figures
    joints = [joint for joint in model.independent if joint.kind != "floating"]
    most = ranked(range(len(joints)), key=lambda k: float(np.ptp(result.q[:, joints[k].coordinate])))
    for k in sorted(most[:PLOTTED]):
        name, at, rate, own = joints[k].name, joints[k].coordinate, joints[k].rate, result.joints[k]
        place, speed, load = ("m", "m/s", "force") if own.unit == "N" else ("rad", "rad/s", "torque")
        effort, velocity = ([x and -x, x] for x in (own.effort_limit, own.velocity_limit))
        q, qd, tau = result.q[:, at], result.qd[:, rate], result.tau[:, rate]
        yield _Plot("Joints", f"{name}: position", place, {"position": q}, (joints[k].lower, joints[k].upper))
        yield _Plot("Joints", f"{name}: speed", speed, {"speed": qd}, velocity)
        yield _Plot("Joints", f"{name}: drive's {load}", own.unit, {f"drive's {load}": tau}, effort)

    def axes(vectors: Floats) -> dict[str, Floats]:
        return dict(zip("xyz", vectors.T, strict=True))

    for joint in model.independent:
        if joint.kind == "floating":
            name, at, rate = joint.name, joint.coordinate, joint.rate
            turns, shifts = (axes(result.qd[:, k : k + 3]) for k in (rate, rate + 3))
            yield _Plot("Base", f"{name}: position", "m", axes(result.q[:, at : at + 3]))
            yield _Plot("Base", f"{name}: velocity", "m/s", shifts)
            yield _Plot("Base", f"{name}: angular velocity, in its own axes", "rad/s", turns)
    if result.free:
        yield _Plot("Momenta", "Linear momentum", "N s", axes(figures.linear))
        yield _Plot("Momenta", "Angular momentum, about the mass centre", "N m s", axes(figures.angular))
    if result.loops:
        for what, unit, first in (("Force", "N", 0), ("Moment", "N m", 3)):
            whole = np.sqrt(np.square(result.loops.wrenches[:, :, first : first + 3]).sum(axis=2))
            curves = dict(zip(result.loops.names[: len(COLOURS)], whole.T, strict=False))
            yield _Plot("Loops", f"{what} of loops", unit, curves)
    work = result.work - result.work[0]
    parts = {"kinetic": figures.kinetic, "potential": figures.energy - figures.kinetic, "work done": work}
    yield _Plot("Energy", "Energies, and work done by drives and wrenches", "J", parts)
    yield _Plot("Energy", "Drift: stored energy less work", "J", {"drift": figures.energy - figures.energy[0] - work})


def _stage(result: Simulation, course: Course) -> Iterator[doc.Block]:
    from robodyn.dynamics.constraints.constraint_jacobian import tree_scene
    from robodyn.report import stage

    model, frames = result.model, course.frames
    used: dict[str, tuple[Floats, float]] = {}
    for each in result.joints:
        limits = (("tau", each.effort_limit), ("qd", each.velocity_limit))
        if shares := [np.abs(frames[f"{kind}_{each.name}"]) / limit for kind, limit in limits if limit]:
            used[each.name] = np.max(shares, axis=0), 1.0
    tree = tree_scene(model, result.scene) if result.scene.constrained else result.scene
    q, uses = [frames[f"q_{name}"] for name in model.coordinates], [used.get(body.joint.name) for body in model.bodies]
    arrows = stage.loads(model, tree, frames)
    motion = stage.motion("", frames["time"], q, rows=course.frame_rows, use=uses, arrows=arrows)
    marks = []
    for joint in model.independent:
        places = result.q[:, joint.coordinate : joint.coordinate + 3]
        if joint.kind == "floating" and np.ptp(places, axis=0).max() > 0.0:
            ends = places[np.unique(np.linspace(0, len(places) - 1, 200).astype(int))]
            pieces = [(a, b - a, 0.004 * (model.reach or 1.0)) for a, b in pairwise(ends)]
            marks.append(stage.mark(f"path of {joint.name}", "c2", pieces))
    words = "The simulated motion"
    words += "; links are coloured by what their joints use of their limits, red above 100 %" if used else ""
    yield stage.stage(words, [stage.robot(model, [motion])], marks)


def simulation_json(result: Simulation) -> str:
    """Return the document of `simulate`; docs/reference/schemas has its keys."""
    from robodyn.simulation.result import deepest, held
    from robodyn.trajectory.columns.signals import COMPONENTS

    model, energy, own, spring, loops = result.model, result.figures.energy, result.loops, None, None
    if result.scene.limit_spring:
        found = deepest(model, result.time, result.q, result.qd)
        spring = found and doc.select(found, "joint:stop.joint.name side:stop.word value:stop.value depth time limits")
    if own:
        finals = [dict(zip(COMPONENTS, wrench, strict=True)) for wrench in own.wrenches[-1].tolist()]
        every = zip(own.names, finals, own.gap, own.slip, strict=True)
        closures = [dict(zip(("name", "final", "gap", "slip"), closure, strict=True)) for closure in every]
        keys = "equations dropped rank freedoms usual_freedoms:usual singular stabilised closures"
        loops = doc.select(own, keys, closures=closures)
    states = []
    for row in (0, -1):
        q = dict(zip(model.coordinates, result.q[row].tolist(), strict=True))
        states.append({"q": q, "qd": dict(zip(model.rates, result.qd[row].tolist(), strict=True))})
    document = doc.select(
        result,
        "robot:model.name duration gravity:scene.gravity method steps evaluations executor ended start final energy "
        "momentum_drift loops held limit_spring effects joints limits_exceeded:exceeded limits within_limits verdict "
        "doubts:caveats warnings notes",
        duration=result.time[-1],
        method={**doc.select(result.method, "name order"), **doc.select(result, "step rtol")},
        ended=result.ended or None,
        start=states[0],
        final=states[1],
        energy={"start": energy[0], "end": energy[-1], "work": result.work[-1], "drift": result.energy_drift},
        momentum_drift=dict(zip(("linear", "angular"), result.momentum_drift, strict=True)) if result.free else None,
        loops=loops,
        held=[
            doc.select(each, "joint:joint.name time creep speed")
            for each in held(model, result.scene, result.time, result.qd)
        ],
        limit_spring=spring,
        effects=[doc.select(why, "name active reason", name=effect.name) for effect, why in result.effects],
        limits=limits_data(result.limits),
        verdict=limits_verdict(result),
        warnings=[caveat.text for caveat in result.caveats],
    )
    if result.target:
        document["accuracy"] = doc.select(result, "target expected:expected_error")
    return doc.written(document)
