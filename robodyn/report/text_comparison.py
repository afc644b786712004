"""Declared against shape-derived mass properties as text for a person."""

from __future__ import annotations

from robodyn.report.table import PLAIN, Page, number, printable
from robodyn.robot.masses.compare import UNCERTAIN, Comparison, Difference, LinkComparison

_HEAD = (
    *("link", "difference [%]", "mass [kg]", "density [kg/m^3]", "centres apart [m]"),
    *("I_1 ratio", "I_2 ratio", "I_3 ratio", "remarks"),
)


def comparison_text(found: Comparison, page: Page = PLAIN) -> str:
    """A table, the most different link first, then remarks link by link, then what could not be compared and why."""
    pairs = [(link, link.difference) for link in found.links if link.difference is not None]
    rest = [link for link in found.links if link.difference is None]
    head = (
        f"{printable(found.file)}: robot '{printable(found.name)}', declared inertias against the <{found.kind}> "
        f"shapes at the declared masses, {len(pairs)} of {len(found.links)} links\n"
    )
    parts = [head]
    if pairs:
        rows = [_row(link, difference) for link, difference in pairs]
        legend = (
            "difference: |I_declared - I_shapes| / |I_shapes| about the centres of mass; "
            "ratios: declared over shapes' principal moments\n"
        )
        parts.append(page.table((_HEAD, rows)) + legend)
    remarks = [f"{link.name} (line {link.line}): {text}" for link in found.links for text in link.remarks]
    parts += _section("Remarks", remarks)
    parts += _section("Not compared", [f"{link.name} (line {link.line}): {link.reason}" for link in rest])
    return "\n".join(parts)


def _section(title: str, lines: list[str]) -> list[str]:
    return ["\n".join((title, *map(printable, lines), ""))] if lines else []


def _row(link: LinkComparison, found: Difference) -> tuple[str, ...]:
    count = len(link.remarks)
    return (
        link.name,
        f"{100 * found.inertia:.3g}" if found.inertia > UNCERTAIN else "0",
        number(found.body.mass),
        number(found.density),
        number(found.distance, max(map(abs, (*found.shapes.box.lo, *found.shapes.box.hi)))),
        *(number(ratio) for ratio in found.ratios),
        f"{count} below" if count else "-",
    )
