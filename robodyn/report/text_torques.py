"""The result of `torques` as text for a person."""

from __future__ import annotations

from robodyn.limits import Excess
from robodyn.report.input_words import input_words
from robodyn.report.limits_words import limits_verdict, offenders_first, unchecked_words
from robodyn.report.sizes import result_sizes, speed_unit
from robodyn.report.table import PLAIN, Content, Page, is_noise, moment, number, printable, relative_text
from robodyn.report.text_joints import derivation_table, share_table
from robodyn.result import Result


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
        methods, rows = derivation_table(result.derivation)
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


def count(amount: int, noun: str) -> str:
    return f"{amount} {noun}" if amount == 1 else f"{amount} {noun}s"


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


def use(value: float, limit: float | None) -> str:
    """How much of a limit a value takes, in percent."""
    if limit is None:
        return "-"
    percent = 0.0 if is_noise(abs(value), limit) else 100.0 * abs(value) / limit
    return f"{'<1' if 0.0 < percent < 0.5 else f'{percent:.0f}'}% of {limit:g}"


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
    unchecked = "".join(f"{line}\n" for line in unchecked_words(result.limits))
    if not result.exceeded:
        return f"{limits_verdict(result).headline}.\n{unchecked}" if result.joints or result.doubts else ""
    head, rows = exceeded_table(result)
    title = f"LIMITS EXCEEDED by {len(rows)} of {count(len(result.joints), 'joint')}"
    return f"{title}\n{page.table((head, rows))}{unchecked}"


def exceeded_table(result: Result) -> Content:
    """The limits that are exceeded, joint by joint."""
    found: dict[str, dict[str, list[str]]] = {}
    for excess in result.exceeded:
        found.setdefault(excess.joint, {}).setdefault(excess.quantity, []).append(_over(excess))
    quantities = [name for name in ("effort", "velocity", "position") if any(name in row for row in found.values())]
    rows = [(joint, *("; ".join(row.get(name, ())) for name in quantities)) for joint, row in found.items()]
    return ("joint", *quantities), rows


def _over(excess: Excess) -> str:
    return f"{excess.value:.6g} {excess.unit}, limit {excess.limit:.6g}"
