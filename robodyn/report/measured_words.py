"""Faults of a log in words, with their standard errors and what they explain."""

from __future__ import annotations

import numpy as np

from robodyn.identification.compare import Comparison, JointComparison
from robodyn.identification.faults import Fault
from robodyn.report.table import is_noise, printable
from robodyn.support.sums import einsum

_TOLD = 0.01
"""Of a joint's residual: a share that is named."""
_DIGITS = 4


def percent(share: float) -> str:
    """Return a share in words."""
    return f"{100 * share:.0f} %" if share > 0.1 else f"{100 * share:.1f} %"


def fault_words(found: Comparison, fault: Fault) -> str:
    """Return what a fault is, with its standard error, and how much it explains of which residuals."""
    ranked = sorted(range(len(found.joints)), key=lambda j: -fault.shares[j])
    shares = [
        f"{percent(fault.shares[j])} at {printable(found.joints[j].name)}" for j in ranked if fault.shares[j] >= _TOLD
    ]
    sure = "explains" if fault.certain else "would explain"
    doubt = "" if fault.certain else " (not told apart from other effects)"
    j = fault.effect.joint
    if j is None:
        of = f"of residuals: {', '.join(shares)}" if shares else "less than 1 % of any residual"
        return f"{_payload(found, fault)} {sure} {of}{doubt}"
    what = effect_words(
        found.joints[j], fault.effect.kind, float(fault.values[0]), float(fault.covariance[0, 0] ** 0.5)
    )
    return f"{what} {sure} {percent(fault.shares[j])} of its residual{doubt}"


def effect_words(joint: JointComparison, kind: str, value: float, error: float) -> str:
    """Return an effect of a joint with its standard error."""
    name, unit, per = printable(joint.name), joint.unit, "rad" if joint.unit == "N m" else "m"
    if kind == "gain":
        return f"A gain of {bar(1 + value, error)} at {name} (torque constant or gear)"
    if kind == "delay":
        return f"A delay of the measured torque of {bar(1e3 * value, 1e3 * error)} ms at {name}"
    words = {
        "offset": ("An offset", unit),
        "viscous": ("Viscous friction", f"{unit} s/{per}"),
        "coulomb": ("Coulomb friction", unit),
        "rotor": ("Rotor inertia", "kg m^2" if unit == "N m" else "kg"),
    }
    title, of = words[kind]
    return f"{title} of {bar(value, error, joint.measured)} {of} at {name}"


def bar(value: float, error: float, scale: float = 1.0) -> str:
    """Return a value with its standard error, to two digits of the error; 0 for what is noise beside it, or beside
    the scale of the quantity."""
    if is_noise(max(abs(value), error), scale):
        return "0"
    if abs(value) < 0.05 * error:
        value = 0.0
    if max(abs(value), error) < 1e-3:
        return f"{value:.2g} +- {error:.1e}"
    digits = min(max(0, 1 - int(np.floor(np.log10(max(error, 1e-9))))), _DIGITS)
    return f"{value:.{digits}f} +- " + (f"{error:.{digits}f}" if error >= 10.0**-digits else f"{error:.0e}")


def _payload(found: Comparison, fault: Fault) -> str:
    m, error = float(fault.values[0]), float(fault.covariance[0, 0] ** 0.5)
    if not 0.0 < 3.0 * error < abs(m):
        return f"A load at {printable(found.load_link)} whose mass cannot be told"
    centre = fault.values[1:4] / m
    rate = np.column_stack((-centre / m, np.eye(3) / m))
    errors = np.sqrt(einsum("ia,ab,ib->i", rate, fault.covariance[:4, :4], rate))
    told = np.diag(fault.covariance)[1:4] > 0.0
    where = ", ".join(
        bar(float(x), float(e)) if there else "?" for x, e, there in zip(centre, errors, told, strict=True)
    )
    return f"A payload of {bar(m, error)} kg at {printable(found.load_link)}, its centre at ({where}) m,"
