"""What makes the peaks of joints, and how far derived motion can be trusted, as rows of text."""

from __future__ import annotations

from collections.abc import Iterable

from robodyn.loads.result import JointLoad, Result
from robodyn.report.sizes import result_sizes
from robodyn.report.table import Content, is_noise, number
from robodyn.trajectory.motion import Derivation

_KNOWN = 1e-6
"""Of a peak: an error bar that is smaller is left out."""


def share_table(result: Result) -> Content:
    """For every joint what each effect adds to its peak; effects that add nothing are left out."""
    joints, size = result.joints, result_sizes(result)
    names = [effect.name for effect in result.effects]
    present = [name for name in names if not all(is_noise(abs(j.shares.get(name, 0.0)), size[j.unit]) for j in joints)]
    head = ["joint", *present, "sum"]
    rows = [[joint.name, *(number(joint.shares[name], size[joint.unit]) for name in present)] for joint in joints]
    for joint, row in zip(joints, rows, strict=True):
        row.append(f"{number(joint.peak, size[joint.unit])} {joint.unit}")
    for title, values in (
        ("error (95 %)", [_bar(joint) for joint in joints]),
        ("friction holds", [number(joint.hold) for joint in joints]),
    ):
        if set(values) != {"0"}:
            head.append(title)
            for row, value in zip(rows, values, strict=True):
                row.append("" if value == "0" else f"+- {value}")
    return tuple(head), [tuple(row) for row in rows]


def _bar(joint: JointLoad) -> str:
    """Return the error bar of a peak; 0 if it is known to a millionth."""
    return f"{joint.error_bar:.2g}" if joint.error_bar > _KNOWN * abs(joint.peak) else "0"


def derivation_table(derivation: Derivation, samples_suffice: bool = True) -> tuple[str, Content | None]:
    """A line that names the methods, and rows for the joints with noise in their data; for all if methods differ."""
    joints = derivation.joints
    velocity, acceleration = _named(joint.velocity for joint in joints), _named(joint.acceleration for joint in joints)
    several = len({*velocity, *acceleration}) > 1
    quantities = " and ".join(name for name, used in (("velocity", velocity), ("acceleration", acceleration)) if used)
    shown = [joint for joint in joints if joint.noise or several]
    text = f"Derived: {quantities} by {'these methods' if several else (acceleration or velocity)[0]}"
    if not shown:
        return f"{text}; {'the data are clean' if samples_suffice else 'the samples are too few'}", None
    rows: list[tuple[str, ...]] = [
        (
            joint.name,
            joint.acceleration if joint.velocity == "given" else joint.velocity,
            joint.source,
            f"{joint.noise:.2g}",
            f"{joint.quantum:.3g}" if joint.quantum else "",
            f"{joint.std:.2g}",
        )
        for joint in shown
    ]
    head = (
        "joint",
        "method",
        "from",
        "its noise",
        "grid",
        "noise left",
    )
    return text, (head, rows)


def _named(methods: Iterable[str]) -> list[str]:
    return [method for method in dict.fromkeys(methods) if method != "given"]
