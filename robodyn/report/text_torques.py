"""The result of `torques` as text for a person."""

from __future__ import annotations

from collections.abc import Sequence
from io import StringIO

from robodyn.result import JointLoad, Result


def torques_text(result: Result, explain: bool = False, color: bool = False) -> str:
    """The report: a table of joints, what makes the peaks, base loads, checks, then limits and warnings.

    Args:
        explain: add why each effect is on or off, and what it costs.
        color: for a terminal that shows colour.
    """
    x, y, z = result.gravity
    lines = [
        f"{result.robot}: {_count(len(result.joints), 'joint')}, {_count(result.samples, 'sample')}, "
        f"{result.duration:.6g} s, gravity ({x:g}, {y:g}, {z:g}) m/s^2",
        *result.derivation,
        "",
    ]
    if result.joints:
        lines += [_loads(result.joints, color), "What makes the peaks", _shares(result, color)]
    lines += ["Base wrench (ground on robot, about the base's origin)", _base(result, color)]
    if explain:
        lines += [f"Effects ({result.operations} operations per sample for the torques)", _effects(result, color)]
    lines += _checks(result)
    lines += [f"over limit: {line}" for line in result.exceeded]
    lines += [f"warning: {line}" for line in result.warnings]
    return "\n".join(lines) + "\n"


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def _loads(joints: Sequence[JointLoad], color: bool) -> str:
    rows = [
        (
            joint.name,
            f"{_number(joint.peak)} {joint.unit}",
            f"{joint.peak_time:.6g} s",
            _number(joint.rms),
            _number(joint.cubic_mean),
            f"{_number(joint.max_speed)} {'m/s' if joint.unit == 'N' else 'rad/s'}",
            f"{_number(joint.peak_power)} W",
            f"{_number(joint.work_positive)} / {_number(joint.work_negative)} J",
            _use(joint.peak, joint.effort_limit),
            _use(joint.max_speed, joint.velocity_limit),
        )
        for joint in joints
    ]
    head = ("joint", "peak", "at", "RMS", "cubic mean", "max speed", "peak power", "work done / returned")
    return table((*head, "of effort limit", "of velocity limit"), rows, color)


def _shares(result: Result, color: bool) -> str:
    active = [effect.name for effect in result.effects if any(effect.name in joint.shares for joint in result.joints)]
    shown = [name for name in active if any(joint.shares[name] for joint in result.joints)]
    rows = [
        (
            joint.name,
            *(_number(joint.shares[name], joint.peak) for name in shown),
            f"{_number(joint.peak)} {joint.unit}",
        )
        for joint in result.joints
    ]
    head = ["joint", *shown, "sum"]
    if any(joint.uncertainty for joint in result.joints):
        head.append("from noise (1 sigma)")
        rows = [(*row, f"+- {_number(joint.uncertainty)}") for row, joint in zip(rows, result.joints, strict=True)]
    if any(joint.hold for joint in result.joints):
        head.append("friction holds")
        rows = [(*row, f"+- {_number(joint.hold)}") for row, joint in zip(rows, result.joints, strict=True)]
    return table(head, rows, color)


def _base(result: Result, color: bool) -> str:
    rows = [
        (
            part.name,
            f"{_number(part.peak)} {'N' if part.name[0] == 'f' else 'N m'}",
            f"{part.peak_time:.6g} s",
            _number(part.rms),
        )
        for part in result.base_wrench
    ]
    return table(("", "peak", "at", "RMS"), rows, color)


def _effects(result: Result, color: bool) -> str:
    rows = [
        (
            effect.name,
            "on" if effect.verdict.active else "off",
            str(effect.operations),
            str(effect.saved or 0),
            effect.verdict.reason,
        )
        for effect in result.effects
    ]
    return table(("effect", "", "alone", "saved without", "why"), rows, color, left=(0, 1, 4))


def _checks(result: Result) -> list[str]:
    checks, balance = result.checks, result.checks.energy_balance
    return [
        f"energy: work {_number(balance.work)} J, stored {_number(balance.energy_change)} J, residual "
        f"{balance.residual:.1e} J (sampling explains {abs(balance.quadrature):.1e} J)",
        f"laws at {_count(checks.samples, 'sample')}: Euler's first {checks.first_law:.0e}, second "
        f"{checks.second_law:.0e}, power {checks.power:.0e} (relative, from the momentum recursion)",
    ]


def _number(x: float, scale: float = 0.0) -> str:
    """Four digits; 0 for what vanishes beside `scale`."""
    return "0" if abs(x) <= 1e-12 * abs(scale) else f"{x:.4g}"


def _use(value: float, limit: float | None) -> str:
    if limit is None:
        return "no limit"
    return f"{abs(value) / limit:.0%} of {limit:g}" if limit > 0 else f"limit {limit:g}"


def table(head: Sequence[str], rows: Sequence[Sequence[str]], color: bool, left: Sequence[int] = (0,)) -> str:
    """A table with a header; columns but those in `left` are aligned at their right."""
    from rich.console import Console
    from rich.table import Table

    grid = Table(box=None, pad_edge=False, header_style="bold")
    for k, title in enumerate(head):
        grid.add_column(title, justify="left" if k in left else "right", no_wrap=True)
    for row in rows:
        grid.add_row(*row)
    out = StringIO()
    Console(file=out, width=400, force_terminal=color, highlight=False, markup=False).print(grid)
    return "\n".join(line.rstrip() for line in out.getvalue().splitlines()) + "\n"
