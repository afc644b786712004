"""The result of `torques` as text for a person."""

from __future__ import annotations

from collections.abc import Sequence

from robodyn.limits import Excess
from robodyn.report.limits_words import limits_verdict, unchecked_words
from robodyn.report.table import PLAIN, Content, Page, number, printable
from robodyn.report.text_joints import derivation_table, share_table
from robodyn.result import JointLoad, Result


def torques_text(result: Result, explain: bool = False, page: Page = PLAIN) -> str:
    """The report: joints, what makes their peaks, base loads, self-checks, limits exceeded, warnings.

    Args:
        explain: add why each effect is on or off, what it costs, and the plan.
    """
    parts = [_head(result)]
    if result.joints:
        parts += [page.table(load_table(result.joints)), f"What makes the peaks\n{page.table(share_table(result))}"]
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
    )


def count(amount: int, noun: str) -> str:
    return f"{amount} {noun}" if amount == 1 else f"{amount} {noun}s"


def load_table(joints: Sequence[JointLoad]) -> Content:
    """What each joint carries."""
    rows = [
        (
            joint.name,
            f"{number(joint.peak)} {joint.unit}",
            f"{joint.peak_time:.6g}",
            number(joint.rms),
            number(joint.cubic_mean),
            f"{number(joint.max_speed)} {'m/s' if joint.unit == 'N' else 'rad/s'}",
            number(joint.peak_power),
            number(joint.work_positive),
            number(joint.work_negative),
            use(joint.peak, joint.effort_limit),
            use(joint.max_speed, joint.velocity_limit),
        )
        for joint in joints
    ]
    head = ("joint", "peak", "at [s]", "RMS", "cubic mean", "max speed", "peak power [W]", "work [J]", "returned [J]")
    return (*head, "of effort limit", "of velocity limit"), rows


def use(value: float, limit: float | None) -> str:
    """How much of a limit a value takes, in percent."""
    if limit is None:
        return "-"
    percent = 100.0 * abs(value) / limit
    return f"{'<1' if 0.0 < percent < 0.5 else f'{percent:.0f}'}% of {limit:g}"


def base_table(result: Result) -> Content:
    """Peaks of the base wrench."""
    scale = {"f": result.checks.largest_force, "m": result.checks.largest_moment}
    rows = []
    for part in result.base_wrench:
        kind = part.name[0]
        peak, rms = number(part.peak, scale[kind]), number(part.rms, scale[kind])
        rows.append((part.name, f"{peak} {'N' if kind == 'f' else 'N m'}", f"{part.peak_time:.6g}", rms))
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
    work, stored, residual, sampling = (
        number(x, balance.turnover)
        for x in (balance.work, balance.energy_change, balance.residual, abs(balance.quadrature))
    )
    laws = [f"{x:.0e}" if x else "0" for x in (checks.first_law, checks.second_law, checks.power)]
    return (
        "Self-checks, from momenta and energy\n"
        f"energy: work {work} J, stored {stored} J, residual {residual} J (sampling explains {sampling} J)\n"
        f"laws at {count(checks.samples, 'sample')}, relative error: Euler's first {laws[0]}, second {laws[1]}, "
        f"power {laws[2]}\n"
    )


def _limits(result: Result, page: Page) -> str:
    exceeded = result.exceeded
    unchecked = "".join(f"{line}\n" for line in unchecked_words(result.limits))
    if not exceeded:
        return f"{limits_verdict(result).headline}.\n{unchecked}" if result.joints or result.doubts else ""
    found: dict[str, dict[str, list[str]]] = {}
    for excess in exceeded:
        found.setdefault(excess.joint, {}).setdefault(excess.quantity, []).append(_over(excess))
    quantities = [name for name in ("effort", "velocity", "position") if any(name in row for row in found.values())]
    rows = [(joint, *("; ".join(row.get(name, ())) for name in quantities)) for joint, row in found.items()]
    title = f"LIMITS EXCEEDED by {len(found)} of {count(len(result.joints), 'joint')}"
    return f"{title}\n{page.table((('joint', *quantities), rows))}{unchecked}"


def _over(excess: Excess) -> str:
    return f"{excess.value:.6g} {excess.unit}, limit {excess.limit:.6g}"
