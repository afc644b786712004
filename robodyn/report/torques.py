"""`torques` of one trajectory or of many: joints, their peaks, base loads, effects, self-checks, limits; and JSON."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from robodyn.loads.result import JointLoad, MomentumReport, Result
from robodyn.report.document import Block, Paragraph, Section, Table, encode, paragraphs, remarks, select, written
from robodyn.report.limits import exceeded_section, limits_data, limits_verdict, unchecked_words, use, verdict_on_limits
from robodyn.report.motor_loads import constraint_sections, sizing_sections, uncertainty_sections
from robodyn.report.sizes import Sizes, result_sizes, speed_unit
from robodyn.report.table import (
    Columns,
    Content,
    by_columns,
    filled,
    first_names,
    gravity_text,
    printable,
    relative_text,
)
from robodyn.support.wording import count
from robodyn.trajectory.motion import NOISE, Derivation, JointDerivation

if TYPE_CHECKING:
    from robodyn.loads.many import Batch, Outcome, Status, Worst

KINDS: tuple[Status, ...] = ("computed", "finished before", "failed")
_TAKES = ("coulomb friction", "viscous friction", "load friction", "fluid")
"""Effects that take energy, which the work in the balance is without."""
_OVER_TIME = {
    *("at [s]", "RMS", "cubic mean", "peak power [W]", "work [J]", "returned [J]", "duty", "static RMS", "hold share"),
    *("copper loss [J]", "gear loss [J]", "drawn [J]", "least [W]", "winding once", "housing once", "mean"),
}
"""Columns of motions alone, which a motion of one sample, a pose, is printed without."""
_UNITS = {"com": "m", "p": "kg m/s", "L": "kg m^2/s", "T": "J", "V": "J", "power": "W"}


def torques_sections(result: Result, explain: bool = False) -> Iterator[Section]:
    """Yield joints, peaks, base loads, self-checks and so on, but the verdict; to explain also effects and the plan."""
    for section in _sections(result, explain):
        yield [_of_a_pose(block) for block in section] if result.samples == 1 else section


def _sections(result: Result, explain: bool) -> Iterator[Section]:
    size = result_sizes(result)
    what = f"{count(len(result.joints), 'joint')}, {count(result.samples, 'sample')}, {result.duration:.6g} s"
    lines = [f"{result.robot}: {what}, {gravity_text(result.gravity)}"]
    if result.origin:
        stamp = f"{result.origin:.6f}".rstrip("0").rstrip(".")
        lines.append(f"Times count from the first stamp of the table, {stamp} s.")
    if result.held:
        held = [f"{name} at {value:.6g}" for name, value in result.held.items()]
        lines.append(f"Held still, for want of columns, in m or rad: {first_names(held, most=6)}.")
    yield paragraphs(lines)
    if result.joints:
        yield [Table("", *load_table(result))]
        yield [Table("What makes the peaks", *share_table(result))]
    if result.constraints:
        yield from constraint_sections(result.constraints, size)
    if result.derivation:
        yield [_derivation(result.derivation, result.samples_suffice)]
    wrench = []
    for part in result.base_wrench:
        unit = "N" if part.name[0] == "f" else "N m"
        peak = size.amount(part.peak, unit), size.moment(part.peak_time, part.peak, unit)
        wrench.append((part.name, *peak, size.number(part.rms, unit)))
    beside = ", beside its contacts" if result.constraints and result.constraints.contacts else ""
    title = f"Base wrench: ground on robot{beside}, about the base's origin"
    still = all(rms == "0" for *_, rms in wrench)
    yield [Paragraph(f"{title}: zero throughout") if still else Table(title, ("", "peak", "at [s]", "RMS"), wrench)]
    if result.momentum:
        yield [_momentum(result.momentum)]
    if result.sizing:
        yield from sizing_sections(result, result.sizing)
    if result.uncertainty:
        yield from uncertainty_sections(result.uncertainty, size)
    if explain:
        rows = []
        for effect in result.effects:
            on, saved = effect.verdict.active, "" if effect.saved is None else str(effect.saved)
            cost = [str(effect.operations), saved] if on else ["", ""]
            rows.append([effect.name, "on" if on else "off", *cost, effect.verdict.reason])
        plan = f"{result.operations} operations per sample for the torques; {result.executor}: {result.reason}"
        head = ("effect", "", "operations alone", "saved without", "why")
        yield [Table(f"Effects: {plan}", *filled(head, rows))]
    checks, balance = result.checks, result.checks.energy_balance
    energies = balance.work, balance.energy_change, balance.residual, abs(balance.quadrature)
    work, stored, residual, sampling = (size.number(each, "J") for each in energies)
    laws = [relative_text(each) for each in (checks.first_law, checks.second_law, checks.power)]
    losses = " less friction and drag" if any(x.verdict.active and x.name in _TAKES for x in result.effects) else ""
    yield paragraphs(
        [
            "Self-checks, from momenta and energy",
            f"energy: work{losses} {work} J, stored {stored} J, residual {residual} J (sampling explains {sampling} J)",
            f"laws at {count(checks.samples, 'sample')}, relative error: Euler's first {laws[0]}, second {laws[1]}, "
            f"power {laws[2]}",
        ]
    )
    yield exceeded_section(result)
    if result.accuracy:
        yield [Paragraph(f"accuracy: {'' if result.accuracy.met else 'NOT MET: '}{result.accuracy.said}")]
    yield remarks("warning", result.warnings)


def _of_a_pose(block: Block) -> Block:
    """Return a block without columns that only a motion has."""
    if not isinstance(block, Table):
        return block
    kept = [k for k, head in enumerate(block.head) if head not in _OVER_TIME]
    return replace(block, head=[block.head[k] for k in kept], rows=[[row[k] for k in kept] for row in block.rows])


def outcome_line(outcome: Outcome) -> str:
    name = printable(outcome.trajectory)
    if outcome.status == "failed":
        return f"{name}: failed"
    before = "finished before, " if outcome.status == "finished before" else ""
    limits = f", LIMITS EXCEEDED: {first_names(outcome.exceeded, most=3)}" if outcome.exceeded else ""
    samples = f"{count(outcome.samples, 'sample')}, {outcome.duration:.6g} s"
    return f"{name}: {before}{samples}{limits} -> {printable(outcome.table)}"


def batch_sections(batch: Batch) -> Iterator[Section]:
    """Yield how many there are of each kind, the worst of each joint, what is in doubt, and the verdict on all."""
    found = [f"{amount} {kind}" for kind in KINDS if (amount := batch.count(kind))]
    done = [outcome for outcome in batch.outcomes if outcome.status != "failed"]
    yield [Paragraph(f"{batch.robot}: {count(len(batch.outcomes), 'file')}, {', '.join(found)}")]
    if batch.worst:
        size = Sizes()
        for joint in batch.worst:
            for unit, value in ((joint.unit, joint.peak), (speed_unit(joint.unit), joint.max_speed)):
                size[unit] = max(size.get(unit, 0.0), abs(value))
        columns: Columns[Worst] = [
            ("joint", lambda joint: joint.name),
            ("peak", lambda joint: size.amount(joint.peak, joint.unit)),
            ("at [s]", lambda joint: size.moment(joint.peak_time, joint.peak, joint.unit)),
            ("in", lambda joint: joint.peak_in),
            ("of effort limit", lambda joint: use(joint.peak, joint.effort_limit)),
            ("RMS", lambda joint: size.number(joint.rms, joint.unit)),
            ("in", lambda joint: joint.rms_in),
            ("max speed", lambda joint: size.amount(joint.max_speed, speed_unit(joint.unit))),
            ("in", lambda joint: joint.max_speed_in),
            ("of velocity limit", lambda joint: use(joint.max_speed, joint.velocity_limit)),
            ("verdict", lambda joint: joint.level or ""),
            ("in", lambda joint: joint.level_in if joint.level else ""),
        ]
        yield [Table("The worst of each joint", *by_columns(columns, batch.worst))]
    if not done:
        return
    limits, over, failed = done[0].limits, sum(bool(outcome.exceeded) for outcome in done), batch.count("failed")
    lines = [*unchecked_words(limits)]
    caveats = {caveat.kind: caveat for outcome in done for caveat in reversed(outcome.caveats)}
    for kind, first in caveats.items():
        files = [outcome.trajectory for outcome in done if any(caveat.kind == kind for caveat in outcome.caveats)]
        lines.append(f"warning: {first_names(files, most=1)}: {first.text}")
    verdict = verdict_on_limits(len(done[0].joints), (), limits, tuple(caveats.values()))
    said = f"LIMITS EXCEEDED in {count(over, 'file')}" if over else verdict.headline
    last = f"{count(failed, 'file')} failed; of the others: {said}" if failed else said + "." * (not over)
    yield paragraphs([*lines, last])


def load_table(result: Result) -> Content:
    size = result_sizes(result)
    columns: Columns[JointLoad] = [
        ("joint", lambda joint: joint.name),
        ("peak", lambda joint: size.amount(joint.peak, joint.unit)),
        ("at [s]", lambda joint: size.moment(joint.peak_time, joint.peak, joint.unit)),
        ("RMS", lambda joint: size.number(joint.rms, joint.unit)),
        ("cubic mean", lambda joint: size.number(joint.cubic_mean, joint.unit)),
        ("max speed", lambda joint: size.amount(joint.max_speed, speed_unit(joint.unit))),
        ("peak power [W]", lambda joint: size.number(joint.peak_power, "W")),
        ("work [J]", lambda joint: size.number(joint.work_positive, "J")),
        ("returned [J]", lambda joint: size.number(joint.work_negative, "J")),
        ("of effort limit", lambda joint: use(joint.peak, joint.effort_limit)),
        ("of velocity limit", lambda joint: use(joint.max_speed, joint.velocity_limit)),
    ]
    return by_columns(columns, result.joints)


def share_table(result: Result) -> Content:
    """Return for every joint what each effect adds to its peak, without effects that add nothing."""
    joints, size = result.joints, result_sizes(result)
    present = [
        effect.name
        for effect in result.effects
        if any(size.number(joint.shares.get(effect.name, 0.0), joint.unit) != "0" for joint in joints)
    ]
    rows = []
    for joint in joints:
        shares = (size.number(joint.shares[name], joint.unit) for name in present)
        hold = size.number(joint.hold, joint.unit)
        more = _bar(joint, size), "" if hold == "0" else f"+- {hold}"
        rows.append([joint.name, *shares, size.amount(joint.peak, joint.unit), *more])
    loops = result.constraints is not None and result.constraints.loops
    bars = "error (of accelerations)" if loops else "error (95 %)"  # derived velocities of loops count, too
    return filled(["joint", *present, "sum", bars, "friction holds"], rows)


def _bar(joint: JointLoad, size: Sizes) -> str:
    """Return the error bar of the largest torque, empty if below a millionth or not known; a bound with the noise
    beside it where doubt is more of it than noise, two standard deviations."""
    bar, noise = joint.error_bar, NOISE * joint.uncertainty
    if bar is None or bar <= 1e-6 * abs(joint.peak) or size.number(bar, joint.unit) == "0":
        return ""
    return f"+- {bar:.2g}" if bar <= 2.0 * noise else f"within {bar:.2g}" + (f", noise {noise:.2g}" if noise else "")


def _derivation(derivation: Derivation, samples_suffice: bool) -> Block:
    """Return a line that names the methods, over joints with noise in their data; over all if methods differ."""
    joints = derivation.joints
    what = [each for each in ("velocity", "acceleration") if any(getattr(joint, each) != "given" for joint in joints)]
    methods = dict.fromkeys(getattr(joint, each) for joint in joints for each in what)
    methods.pop("given", None)
    shown = [joint for joint in joints if joint.noise or len(methods) > 1]
    text = f"Derived: {' and '.join(what)} by {'these methods' if len(methods) > 1 else ''.join(methods)}"
    if not shown:
        return Paragraph(f"{text}; {'the data are clean' if samples_suffice else 'the samples are too few'}")
    columns: Columns[JointDerivation] = [
        ("joint", lambda joint: joint.name),
        ("method", lambda joint: joint.acceleration if joint.velocity == "given" else joint.velocity),
        ("from", lambda joint: joint.source),
        ("its noise", lambda joint: f"{joint.noise:.2g}"),
        ("grid", lambda joint: f"{joint.quantum:.3g}" if joint.quantum else ""),
        ("noise left", lambda joint: f"{joint.std:.2g}"),
    ]
    return Table(text, *by_columns(columns, shown))


def _momentum(report: MomentumReport) -> Table:
    from robodyn.dynamics.momenta import GROUND

    owner = "the ground" if report.frame == GROUND else printable(report.frame)
    names = {"origin": "the origin", "com": "the mass centre"}
    about = names.get(str(report.about)) or "({:g}, {:g}, {:g}) m".format(*report.about)
    kinds = [row.name.partition("_")[0] for row in report.ranges]
    scales = Sizes(dict.fromkeys(kinds, 0.0))
    for kind, row in zip(kinds, report.ranges, strict=True):
        scales[kind] = max(scales[kind], abs(row.least), abs(row.greatest))
    scales["L"] = max(scales["L"], scales["p"] * scales["com"])  # L also beside p at the mass centre's distance
    scales["T"] = scales["V"] = max(scales["T"], scales["V"])
    rows = []
    for kind, row in zip(kinds, report.ranges, strict=True):
        least = scales.number(row.least, kind), scales.moment(row.least_time, row.least, kind)
        most = scales.number(row.greatest, kind), scales.moment(row.greatest_time, row.greatest, kind)
        rows.append((f"{row.name} [{_UNITS[kind]}]", *least, *most))
    title = f"Momentum and energy in the frame of {owner}, L about {about}; power is tau . qd"
    return Table(title, ("", "least", "at [s]", "greatest", "at [s]"), rows)


def torques_json(result: Result) -> str:
    """Return the document of `torques`, with the keys of docs/reference/schemas; units are SI."""
    effects: list[Any] = []
    sizing: Any = None
    for effect in result.effects:
        share = {joint.name: joint.shares[effect.name] for joint in result.joints if effect.name in joint.shares}
        one = select(effect, "name active:verdict.active reason:verdict.reason share operations", share=share)
        effects.append(one if effect.saved is None else {**one, "operations_saved_without": effect.saved})
    balance = select(
        result.checks.energy_balance,
        "work energy_change residual quadrature_error:quadrature turnover largest_residual:worst consistent",
    )
    document = select(
        result,
        "robot samples duration gravity joints base_wrench effects checks plan derivatives time_origin:origin held "
        "limits_exceeded:exceeded limits within_limits verdict doubts:caveats warnings",
        base_wrench=_by_name(result.base_wrench),
        effects=effects,
        checks=select(result.checks, "energy_balance first_law second_law power samples", energy_balance=balance),
        plan=select(result, "executor operations reason"),
        derivatives=result.derivation.joints if result.derivation else [],
        limits=limits_data(result.limits),
        verdict=limits_verdict(result),
    )
    if result.sizing:
        bearings = []
        for bearing in result.sizing.bearings:
            directions = dict(zip(("u", "v", "axis"), bearing.directions, strict=True))
            parts = _by_name((*bearing.components, bearing.radial, bearing.tilting))
            bearings.append({**select(bearing, "joint kind"), "directions": directions, "components": parts})
        sizing = {
            "joints": result.sizing.joints,
            "bearings": bearings,
            "foundation": _by_name(result.sizing.foundation),
            **({} if result.sizing.bus is None else {"bus": result.sizing.bus}),
        }
    optional = {"momentum": result.momentum, "accuracy": result.accuracy, "sizing": sizing}
    optional |= {"constraints": result.constraints, "uncertainty": result.uncertainty}
    return written({**document, **{key: part for key, part in optional.items() if part is not None}})


def _by_name(loads: Iterable[object]) -> dict[str, Any]:
    found: list[dict[str, Any]] = [encode(load) for load in loads]
    return {load.pop("name"): load for load in found}


def batch_json(batch: Batch) -> str:
    """Return `robot`, `files` in the order of the trajectories, the `worst` of each joint, and counts."""
    files = []
    for outcome in batch.outcomes:
        if outcome.status == "failed":
            files.append(select(outcome, "trajectory status error"))
        else:
            every = {key: value for key, value in encode(outcome).items() if key not in ("joints", "error")}
            files.append({**every, "limits": limits_data(outcome.limits), "within_limits": outcome.within_limits})
    counts = {kind.replace(" ", "_"): batch.count(kind) for kind in KINDS}
    keys = "robot files worst computed finished_before failed within_limits"
    return written(select(batch, keys, files=files, **counts))
