"""The result of `torques`, of one trajectory or of many: joints, their peaks, base loads, self-checks, limits."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from robodyn.loads.result import EffectReport, Result
from robodyn.report.document import Paragraph, Section, Table, paragraphs, remarks
from robodyn.report.limits import offenders_first, unchecked_words, use, verdict_on_limits
from robodyn.report.sizes import Sizes, result_sizes, speed_unit
from robodyn.report.table import Columns, Content, by_columns, gravity_text, printable, relative_text
from robodyn.report.torques_tables import (
    base_table,
    derivation_table,
    effect_table,
    load_table,
    momentum_table,
    share_table,
)
from robodyn.report.torques_verdict import accuracy_blocks, exceeded_section
from robodyn.support.wording import count

if TYPE_CHECKING:
    from robodyn.loads.constraint_result import Constraints
    from robodyn.loads.many import Batch, Outcome, Status, Worst

_NAMED = 6


def torques_sections(result: Result, explain: bool = False) -> Iterator[Section]:
    """Yield joints, what makes their peaks, base loads, self-checks, limits exceeded, warnings; not the verdict.

    Args:
        explain: add why each effect is on or off, what it costs, and the plan.
    """
    result = offenders_first(result)
    yield _head(result)
    if result.joints:
        yield [Table("", *load_table(result))]
        yield [Table("What makes the peaks", *share_table(result))]
    if result.constraints:
        yield from _constraints(result, result.constraints)
    if result.derivation:
        methods, rows = derivation_table(result.derivation, result.samples_suffice)
        yield [Table(methods, *rows) if rows else Paragraph(methods)]
    yield _base(result)
    if result.momentum:
        title, rows = momentum_table(result.momentum)
        yield [Table(title, *rows)]
    if result.sizing:
        from robodyn.report.sizing import sizing_sections

        yield from sizing_sections(result)
    if result.uncertainty:
        from robodyn.report.uncertainty import uncertainty_sections

        yield from uncertainty_sections(result)
    if explain:
        plan = f"{result.operations} operations per sample for the torques; {result.executor}: {result.reason}"
        yield [Table(f"Effects: {plan}", *effect_table(result))]
    yield _checks(result)
    yield exceeded_section(result)
    yield [*accuracy_blocks(result)]
    yield remarks("warning", result.warnings)


def _head(result: Result) -> Section:
    what = f"{count(len(result.joints), 'joint')}, {count(result.samples, 'sample')}, {result.duration:.6g} s"
    robot = f"{result.robot}: {what}, {gravity_text(result.gravity)}"
    return paragraphs([robot, *input_words(result)])


def _constraints(result: Result, found: Constraints) -> Iterator[Section]:
    from robodyn.report.constraints import constraint_lines, constraint_tables

    yield paragraphs(["Constraints", *constraint_lines(found)])
    for title, rows in constraint_tables(result):
        yield [Table(title, *rows)]


def _base(result: Result) -> Section:
    head, rows = base_table(result)
    beside = ", beside its contacts" if result.constraints and result.constraints.contacts else ""
    title = f"Base wrench: ground on robot{beside}, about the base's origin"
    if all(rms == "0" for *_, rms in rows):
        return [Paragraph(f"{title}: zero throughout")]
    return [Table(title, head, rows)]


def _checks(result: Result) -> Section:
    (work, stored, residual, _, sampling), laws = balance_words(result)
    losses = " less friction and drag" if any(map(_takes, result.effects)) else ""
    lines = (
        "Self-checks, from momenta and energy",
        f"energy: work{losses} {work} J, stored {stored} J, residual {residual} J (sampling explains {sampling} J)",
        f"laws at {count(result.checks.samples, 'sample')}, relative error: Euler's first {laws[0]}, second {laws[1]}, "
        f"power {laws[2]}",
    )
    return paragraphs(lines)


_TAKES = ("coulomb friction", "viscous friction", "load friction", "fluid")


def _takes(effect: EffectReport) -> bool:
    """Return whether an effect takes energy, which the work in the balance is without."""
    return effect.verdict.active and effect.name in _TAKES


def balance_words(result: Result) -> tuple[list[str], list[str]]:
    """Return work, stored energy, residual, turnover, what sampling explains [J]; errors of the laws and of power."""
    checks, balance, size = result.checks, result.checks.energy_balance, result_sizes(result)
    energies = balance.work, balance.energy_change, balance.residual, balance.turnover, abs(balance.quadrature)
    laws = checks.first_law, checks.second_law, checks.power
    return [size.number(each, "J") for each in energies], [relative_text(each) for each in laws]


def input_words(result: Result, most: int | None = _NAMED) -> Iterator[str]:
    """Yield what a reader of a report has to know of the table to understand its numbers.

    Args:
        most: joints that are named for each place where some are held; None names all.
    """
    if result.origin:
        stamp = f"{result.origin:.6f}".rstrip("0").rstrip(".")
        yield f"Times count from the first stamp of the table, {stamp} s."
    if result.held:
        yield f"Held still, for want of columns: {'; '.join(_places(result, most))}."


def _places(result: Result, most: int | None) -> Iterator[str]:
    """Yield the places where joints are held, with the joints of each."""
    units = {joint.name: "m" if joint.unit == "N" else "rad" for joint in result.joints}
    places: dict[str, list[str]] = {}
    for name, value in result.held.items():
        floating = "m" if name[-2:] in ("_x", "_y", "_z") else ""
        places.setdefault(f"{value:.6g} {units.get(name, floating)}".strip(), []).append(printable(name))
    for place, names in places.items():
        more = "" if most is None or len(names) <= most else f" and {len(names) - most} more"
        yield f"at {place} {', '.join(names[:most])}{more}"


_LISTED = 3
"""Exceeded limits that a line names."""


def outcome_line(outcome: Outcome) -> str:
    """Return what became of one trajectory."""
    name = printable(outcome.trajectory)
    if outcome.status == "failed":
        return f"{name}: failed"
    before = "finished before, " if outcome.status == "finished before" else ""
    more = f" and {len(outcome.exceeded) - _LISTED} more" if len(outcome.exceeded) > _LISTED else ""
    limits = f", LIMITS EXCEEDED: {printable(', '.join(outcome.exceeded[:_LISTED]))}{more}" if outcome.exceeded else ""
    samples = f"{count(outcome.samples, 'sample')}, {outcome.duration:.6g} s"
    return f"{name}: {before}{samples}{limits} -> {printable(outcome.table)}"


def batch_sections(batch: Batch) -> Iterator[Section]:
    """Yield the summary: how many there are of each kind, and the worst of each joint."""
    kinds: tuple[Status, ...] = ("computed", "finished before", "failed")
    found = [f"{amount} {kind}" for kind in kinds if (amount := batch.count(kind))]
    done = [outcome for outcome in batch.outcomes if outcome.status != "failed"]
    yield [Paragraph(f"{batch.robot}: {count(len(batch.outcomes), 'file')}, {', '.join(found)}")]
    if batch.worst:
        yield [Table("The worst of each joint", *worst_table(batch.worst))]
    if done:
        yield paragraphs(_limits(done, batch.count("failed")))


def _limits(done: Sequence[Outcome], failed: int) -> list[str]:
    """Return what is in doubt, each with the files that it is about, and last the verdict on the limits of all motions.

    Args:
        failed: how many files there are beside those that are done.
    """
    caveats = {caveat.kind: caveat for outcome in done for caveat in reversed(outcome.caveats)}
    limits, over = done[0].limits, sum(bool(outcome.exceeded) for outcome in done)
    lines = [*unchecked_words(limits)]
    for kind in caveats:
        about = [(x.trajectory, caveat.text) for x in done for caveat in x.caveats if caveat.kind == kind]
        others = f" and {count(len(about) - 1, 'other file')}" if len(about) > 1 else ""
        lines.append(f"warning: {about[0][0]}{others}: {about[0][1]}")
    verdict = verdict_on_limits(len(done[0].joints), (), limits, tuple(caveats.values()))
    said = f"LIMITS EXCEEDED in {count(over, 'file')}" if over else verdict.headline
    return [*lines, f"{count(failed, 'file')} failed; of the others: {said}" if failed else said + "." * (not over)]


def worst_table(worst: tuple[Worst, ...]) -> Content:
    size = Sizes()
    for joint in worst:
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
    ]
    if worst[0].level is not None:
        columns += [("verdict", lambda joint: joint.level or ""), ("in", lambda joint: joint.level_in)]
    return by_columns(columns, worst)
