"""Whether torques can be trusted, as a part of a report on them: self-checks, derivatives, effects, warnings."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.loads.doubts import energy_doubt
from robodyn.loads.result import Result
from robodyn.report.document import Block, Findings, Gallery, Heading, Paragraph, Table, Verdict
from robodyn.report.pictures.torques_plots import Plots
from robodyn.report.sizes import result_sizes
from robodyn.report.table import Content, number, relative_text
from robodyn.report.torques_tables import derivation_table, effect_table
from robodyn.support.wording import count


def trust(result: Result, plots: Plots | None) -> Iterator[Block]:
    """The self-checks; how the motion was derived, which effects count, and warnings."""
    yield from _checks(result, plots)
    yield from _grounds(result)


def _checks(result: Result, plots: Plots | None) -> Iterator[Block]:
    checks, balance = result.checks, result.checks.energy_balance
    yield Heading("Self-checks")
    size = result_sizes(result)["J"]
    work, stored, rest, turnover, sampling = (
        number(value, size)
        for value in (
            *(balance.work, balance.energy_change, balance.residual),
            *(balance.turnover, abs(balance.quadrature)),
        )
    )
    laws = [relative_text(value) for value in (checks.first_law, checks.second_law, checks.power)]
    reasons = [
        f"Work done on the robot, less losses, is {work} J and the change of stored energy {stored} J, with "
        f"{turnover} J going in and out; the difference is {rest} J, of which sampling explains {sampling} J.",
        f"Euler's laws and the power balance hold at {count(checks.samples, 'sample')} within {laws[0]}, {laws[1]} and "
        f"{laws[2]} of the largest force, moment and power.",
    ]
    if not balance.consistent:
        off = energy_doubt(balance, result.samples, result.duration)
        reasons.insert(0, f"{off.said}." if off else "")
        yield Verdict("doubtful", "The energy balance does not close", tuple(reasons))
    else:
        yield Verdict("good", "Energy and momentum balance", tuple(reasons))
    if plots is not None and (energy := plots.energy()):
        yield Gallery(tuple(energy))


def _grounds(result: Result) -> Iterator[Block]:
    """How the motion was derived, which effects count, and warnings."""
    if result.derivation:
        methods, rows = derivation_table(result.derivation, result.samples_suffice)
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
