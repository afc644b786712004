"""How sure the figures of a motion are: error bars, which parameters make them, and probabilities of verdicts."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from robodyn.loads.result import Result
from robodyn.loads.uncertainty_result import Uncertain, UncertainJoint, UncertainLoad
from robodyn.report.document import Facts, Paragraph, Section, Table, paragraphs
from robodyn.report.sizes import Sizes, result_sizes
from robodyn.report.table import Content, first_names, is_noise, printable
from robodyn.support.wording import count

_SHOWN = 3
"""Parameters that are named of each load, with more than `_LEAST` of its variance."""
_LEAST = 0.01
_OF_LINKS = {"mass": "mass", "com": "centre of mass", "inertia": "inertia", "friction": "friction"}


def uncertainty_sections(result: Result) -> Iterator[Section]:
    """Yield error bars of joints, motors, bearings and the base, what makes them, and how likely limits are kept."""
    found = result.uncertainty
    if found is None:
        return
    size = result_sizes(result)
    for title, loads in _groups(found):
        yield [Table(title, *_bars(loads, size))]
    rows = [(each.load.name, ranks(each.load.shares), ranks(each.load.rms_shares)) for each in found.joints]
    if rows:
        title = "Which parameters matter most, by their share of the variance"
        yield [Table(title, ("joint", "of the peak", "of the RMS"), rows)]
    yield paragraphs(_notes(found))
    limited = [joint for joint in found.joints if joint.suffices is not None]
    if limited:
        yield [Paragraph("Limits are kept with these probabilities"), _chances(found, limited)]


def _groups(found: Uncertain) -> Iterator[tuple[str, list[tuple[str, UncertainLoad]]]]:
    motors = [each.motor for each in found.joints if each.motor is not None]
    resultants = [
        (f"{joint} {load.name}", load)
        for joint, loads in found.bearings.items()
        for load in loads
        if load.name in ("radial", "tilting")
    ]
    many = count(len(found.parameters), "uncertain parameter")
    for title, loads in (
        (f"Joints: error bars of {many}", [(each.load.name, each.load) for each in found.joints]),
        ("Motors: error bars", [(load.name, load) for load in motors]),
        ("Bearings: error bars", resultants),
        ("Base wrench: error bars", [(load.name, load) for load in found.base]),
    ):
        if any(load.shares or load.rms_shares for _, load in loads):
            yield title, loads


def _bars(loads: Sequence[tuple[str, UncertainLoad]], size: Sizes) -> Content:
    rows = []
    for name, load in loads:
        row = [name]
        for bar, unit in ((load.peak, f" {load.unit}"), (load.rms, "")):
            error = "0" if is_noise(bar.standard_error, size[load.unit]) else f"{bar.standard_error:.2g}"
            row += [f"{size.number(bar.value, load.unit)}{unit}", error]
            row += [f"{size.number(bar.low, load.unit)} to {size.number(bar.high, load.unit)}"]
        rows.append(row)
    each = ("std error", "95 %")
    return ("", "peak", *each, "RMS", *each), rows


def ranks(shares: Mapping[str, float]) -> str:
    """Return the parameters with most of a variance in words: "mass of forearm 61 %, friction of elbow 30 %"."""
    most = [(name, share) for name, share in list(shares.items())[:_SHOWN] if share >= _LEAST]
    return ", ".join(f"{parameter(name)} {100.0 * share:.0f} %" for name, share in most) or "-"


def parameter(name: str) -> str:
    """Return a parameter in words, one of the regressor by its name there."""
    owner, _, quantity = name.rpartition(".")
    return printable(f"{_OF_LINKS[quantity]} of {owner}" if quantity in _OF_LINKS else name)


def _notes(found: Uncertain) -> Iterator[str]:
    """Yield which error bars derivatives alone would have got wrong, and what a covariance leaves out."""
    bars = [(name, load) for _, loads in _groups(found) for name, load in loads]
    both = [
        (f"{what} of {printable(name)}", bar)
        for name, load in bars
        for what, bar in (("peak", load.peak), ("RMS", load.rms))
    ]
    names = [name for name, bar in both if bar.method == "draws"]
    if names:
        most = first_names(names, _SHOWN)
        yield (
            f"By {found.draws} draws of the parameters, for they are not linear in them: {most}. The other error bars "
            "are by derivatives."
        )
    if any(name.rpartition(".")[2] not in _OF_LINKS for name in found.parameters):
        yield (
            "Parameters that the covariance does not name count as sure: what a log did not show, such as most of what "
            "bearings and the base bear, is less sure than this."
        )


def _chances(found: Uncertain, limited: Sequence[UncertainJoint]) -> Facts:
    """Return for each joint the probability that it suffices, and that of each limit that is not sure."""
    items = []
    for joint in limited:
        unsure = [
            f"{each.quantity} {probability(each.probability)}" for each in joint.limits if each.probability < 0.999
        ]
        suffices = joint.suffices or 0.0
        each = f": {', '.join(unsure)}" if unsure else ""
        items.append((joint.load.name, f"suffices with {probability(suffices)}{each}"))
    if found.suffices is not None and len(limited) > 1:
        items.append(("all joints", f"suffice with {probability(found.suffices)}"))
    return Facts(tuple(items))


def probability(p: float) -> str:
    """Return a probability in percent, as precisely as it is known."""
    if not 0.001 < p < 0.999:
        return "more than 99.9 %" if p > 0.5 else "less than 0.1 %"
    return f"{100.0 * p:.1f} %" if not 0.01 < p < 0.99 else f"{100.0 * p:.0f} %"
