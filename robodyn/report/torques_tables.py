"""The tables of a report on torques: loads of joints and base, shares of effects, derivatives, momentum."""

from __future__ import annotations

from collections.abc import Iterable

from robodyn.dynamics.momenta import GROUND
from robodyn.loads.result import ComponentLoad, EffectReport, JointLoad, MomentumReport, Result
from robodyn.report.limits import use
from robodyn.report.sizes import result_sizes, speed_unit
from robodyn.report.table import Columns, Content, by_columns, is_noise, moment, number, printable
from robodyn.trajectory.motion import NOISE, Derivation, JointDerivation

_KNOWN = 1e-6
"""Of a peak: an error bar that is smaller is left out."""
_UNITS = {"com": "m", "p": "kg m/s", "L": "kg m^2/s", "T": "J", "V": "J", "power": "W"}


def load_table(result: Result) -> Content:
    """Return what each joint carries."""
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


def base_table(result: Result) -> Content:
    """Return peaks of the base wrench."""
    size, units = result_sizes(result), {"f": "N", "m": "N m"}
    columns: Columns[ComponentLoad] = [
        ("", lambda part: part.name),
        ("peak", lambda part: size.amount(part.peak, units[part.name[0]])),
        ("at [s]", lambda part: size.moment(part.peak_time, part.peak, units[part.name[0]])),
        ("RMS", lambda part: size.number(part.rms, units[part.name[0]])),
    ]
    return by_columns(columns, result.base_wrench)


def effect_table(result: Result, saved: bool = True) -> Content:
    """Return which effects are on, what they cost, and why.

    Args:
        saved: with the operations that each takes beside the others.
    """
    columns: Columns[EffectReport] = [
        ("effect", lambda effect: effect.name),
        ("", lambda effect: "on" if effect.verdict.active else "off"),
        ("operations alone", lambda effect: _figure(effect, effect.operations)),
        ("saved without", lambda effect: _figure(effect, effect.saved)),
        ("why", lambda effect: effect.verdict.reason),
    ]
    return by_columns([column for column in columns if saved or column[0] != "saved without"], result.effects)


def _figure(effect: EffectReport, operations: int | None) -> str:
    return str(operations) if effect.verdict.active and operations is not None else ""


def share_table(result: Result) -> Content:
    """Return for every joint what each effect adds to its peak; effects that add nothing are left out.

    Error bars of closed chains are not called 95 %: they are of accelerations alone, and there velocities that were
    derived count too.
    """
    joints, size = result.joints, result_sizes(result)
    names = [effect.name for effect in result.effects]
    present = [name for name in names if not all(is_noise(abs(j.shares.get(name, 0.0)), size[j.unit]) for j in joints)]
    head = ["joint", *present, "sum"]
    rows = [[joint.name, *(number(joint.shares[name], size[joint.unit]) for name in present)] for joint in joints]
    for joint, row in zip(joints, rows, strict=True):
        row.append(f"{number(joint.peak, size[joint.unit])} {joint.unit}")
    loops = result.constraints is not None and result.constraints.loops
    bars = "error (of accelerations)" if loops else "error (95 %)"
    for title, values in (
        (bars, [_bar(joint, size[joint.unit]) for joint in joints]),
        ("friction holds", [f"+- {hold}" if (hold := number(joint.hold)) != "0" else "" for joint in joints]),
    ):
        if any(values):
            head.append(title)
            for row, value in zip(rows, values, strict=True):
                row.append(value)
    return tuple(head), [tuple(row) for row in rows]


def _bar(joint: JointLoad, scale: float) -> str:
    """Return the error bar of the largest torque, empty if that is known to a millionth, or its bar is not known.

    Where doubt is more of it than noise, two standard deviations, it is a bound, with the noise beside it.

    Args:
        scale: what makes the torques, at its largest.
    """
    bar, noise = joint.error_bar, NOISE * joint.uncertainty
    if bar is None or bar <= _KNOWN * abs(joint.peak) or is_noise(bar, scale):
        return ""
    return f"+- {bar:.2g}" if bar <= 2.0 * noise else f"within {bar:.2g}" + (f", noise {noise:.2g}" if noise else "")


def derivation_table(derivation: Derivation, samples_suffice: bool = True) -> tuple[str, Content | None]:
    """Return a line that names the methods, and rows for joints with noise in their data; for all if methods differ."""
    joints = derivation.joints
    velocity, acceleration = _named(joint.velocity for joint in joints), _named(joint.acceleration for joint in joints)
    several = len({*velocity, *acceleration}) > 1
    quantities = " and ".join(name for name, used in (("velocity", velocity), ("acceleration", acceleration)) if used)
    shown = [joint for joint in joints if joint.noise or several]
    text = f"Derived: {quantities} by {'these methods' if several else (acceleration or velocity)[0]}"
    if not shown:
        return f"{text}; {'the data are clean' if samples_suffice else 'the samples are too few'}", None
    columns: Columns[JointDerivation] = [
        ("joint", lambda joint: joint.name),
        ("method", lambda joint: joint.acceleration if joint.velocity == "given" else joint.velocity),
        ("from", lambda joint: joint.source),
        ("its noise", lambda joint: f"{joint.noise:.2g}"),
        ("grid", lambda joint: f"{joint.quantum:.3g}" if joint.quantum else ""),
        ("noise left", lambda joint: f"{joint.std:.2g}"),
    ]
    return text, by_columns(columns, shown)


def _named(methods: Iterable[str]) -> list[str]:
    return [method for method in dict.fromkeys(methods) if method != "given"]


def momentum_table(report: MomentumReport) -> tuple[str, Content]:
    """Return a title that says about what and in which frame, and for each quantity its least and its greatest."""
    owner = "the ground" if report.frame == GROUND else printable(report.frame)
    about = {"origin": "the origin", "com": "the mass centre"}.get(str(report.about)) or "({:g}, {:g}, {:g}) m".format(
        *report.about
    )
    scales = _scales(report)
    rows = []
    for row in report.ranges:
        kind = row.name.partition("_")[0]
        name = f"{row.name} [{_UNITS[kind]}]"
        least, greatest = (
            (number(value, scales[kind]), moment(time, value, scales[kind]))
            for value, time in ((row.least, row.least_time), (row.greatest, row.greatest_time))
        )
        rows.append((name, *least, *greatest))
    title = f"Momentum and energy in the frame of {owner}, L about {about}; power is tau . qd"
    return title, (("", "least", "at [s]", "greatest", "at [s]"), rows)


def _scales(report: MomentumReport) -> dict[str, float]:
    """Return what is noise beside: L also beside p at the mass centre's distance, energies beside their largest."""
    scales: dict[str, float] = {}
    for row in report.ranges:
        kind = row.name.partition("_")[0]
        scales[kind] = max(scales.get(kind, 0.0), abs(row.least), abs(row.greatest))
    scales["L"] = max(scales["L"], scales["p"] * scales["com"])
    scales["T"] = scales["V"] = max(scales["T"], scales["V"])
    return scales
