"""The result of `torques` as text for a person."""

from __future__ import annotations

from robodyn.loads.result import Result
from robodyn.report.input_words import input_words
from robodyn.report.limits_words import limits_text, limits_verdict, offenders_first, use
from robodyn.report.sizes import result_sizes, speed_unit
from robodyn.report.table import PLAIN, Content, Page, moment, number, printable, relative_text
from robodyn.report.text_joints import derivation_table, share_table
from robodyn.support.wording import count


def torques_text(result: Result, explain: bool = False, page: Page = PLAIN) -> str:
    """The report: joints, what makes their peaks, base loads, self-checks, limits exceeded, warnings.

    Args:
        explain: add why each effect is on or off, what it costs, and the plan.
    """
    result = offenders_first(result)
    parts = [_head(result)]
    if result.joints:
        parts += [page.table(load_table(result)), f"What makes the peaks\n{page.table(share_table(result))}"]
    if result.derivation:
        methods, rows = derivation_table(result.derivation, result.samples_suffice)
        parts.append(f"{methods}\n{page.table(rows) if rows else ''}")
    parts.append(_base(result, page))
    if result.momentum:
        from robodyn.report.text_momentum import momentum_table

        title, rows = momentum_table(result.momentum)
        parts.append(f"{title}\n{page.table(rows)}")
    if result.sizing:
        from robodyn.report.text_sizing import sizing_parts

        parts += sizing_parts(result, page)
    if explain:
        plan = f"{result.operations} operations per sample for the torques; {result.executor}: {result.reason}"
        parts.append(f"Effects: {plan}\n{page.table(effect_table(result))}")
    parts.append(_checks(result))
    parts.append(_limits(result, page))
    if result.accuracy:
        met = "" if result.accuracy.met else "NOT MET: "
        parts.append(f"accuracy: {met}{result.accuracy.said}\n")
    parts.append("".join(f"warning: {printable(line)}\n" for line in result.warnings))
    return "\n".join(part for part in parts if part)


def _head(result: Result) -> str:
    x, y, z = result.gravity
    return (
        f"{printable(result.robot)}: {count(len(result.joints), 'joint')}, {count(result.samples, 'sample')}, "
        f"{result.duration:.6g} s, gravity ({x:g}, {y:g}, {z:g}) m/s^2\n"
        + "".join(f"{line}\n" for line in input_words(result))
    )


def load_table(result: Result) -> Content:
    """What each joint carries."""
    size = result_sizes(result)
    rows = []
    for joint in result.joints:
        load, speed = size[joint.unit], speed_unit(joint.unit)
        rows.append(
            (
                joint.name,
                f"{number(joint.peak, load)} {joint.unit}",
                moment(joint.peak_time, joint.peak, load),
                number(joint.rms, load),
                number(joint.cubic_mean, load),
                f"{number(joint.max_speed, size[speed])} {speed}",
                number(joint.peak_power, size["W"]),
                number(joint.work_positive, size["J"]),
                number(joint.work_negative, size["J"]),
                use(joint.peak, joint.effort_limit),
                use(joint.max_speed, joint.velocity_limit),
            )
        )
    head = ("joint", "peak", "at [s]", "RMS", "cubic mean", "max speed", "peak power [W]", "work [J]", "returned [J]")
    return (*head, "of effort limit", "of velocity limit"), rows


def base_table(result: Result) -> Content:
    """Peaks of the base wrench."""
    size = result_sizes(result)
    rows = []
    for part in result.base_wrench:
        unit = "N" if part.name[0] == "f" else "N m"
        peak, rms = number(part.peak, size[unit]), number(part.rms, size[unit])
        rows.append((part.name, f"{peak} {unit}", moment(part.peak_time, part.peak, size[unit]), rms))
    return ("", "peak", "at [s]", "RMS"), rows


def _base(result: Result, page: Page) -> str:
    head, rows = base_table(result)
    title = "Base wrench: ground on robot, about the base's origin"
    if all(rms == "0" for *_, rms in rows):
        return f"{title}: zero throughout\n"
    return f"{title}\n{page.table((head, rows))}"


def effect_table(result: Result) -> Content:
    """Which effects are on, what they cost, and why."""
    rows = [
        (
            effect.name,
            "on" if effect.verdict.active else "off",
            str(effect.operations) if effect.verdict.active else "",
            str(effect.saved) if effect.verdict.active and effect.saved is not None else "",
            effect.verdict.reason,
        )
        for effect in result.effects
    ]
    return ("effect", "", "operations alone", "saved without", "why"), rows


def _checks(result: Result) -> str:
    checks, balance = result.checks, result.checks.energy_balance
    size = result_sizes(result)["J"]
    work, stored, residual, sampling = (
        number(x, size) for x in (balance.work, balance.energy_change, balance.residual, abs(balance.quadrature))
    )
    laws = [relative_text(x) for x in (checks.first_law, checks.second_law, checks.power)]
    return (
        "Self-checks, from momenta and energy\n"
        f"energy: work {work} J, stored {stored} J, residual {residual} J (sampling explains {sampling} J)\n"
        f"laws at {count(checks.samples, 'sample')}, relative error: Euler's first {laws[0]}, second {laws[1]}, "
        f"power {laws[2]}\n"
    )


def _limits(result: Result, page: Page) -> str:
    if not (result.joints or result.doubts):
        return ""
    return limits_text(len(result.joints), result.exceeded, result.limits, limits_verdict(result).headline, page)
