"""Mass properties of meshes, composite bodies, links and robots: amounts, inertia, symmetry, and how far they hold."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Sequence
from math import inf, isfinite
from typing import TYPE_CHECKING, Any

import numpy as np

from robodyn.report.document import Facts, Heading, Paragraph, Section, Table, paragraphs, remarks
from robodyn.report.table import NOISE, is_noise, number, point_text, printable
from robodyn.solids.inertia.properties import MassProperties, View
from robodyn.solids.inertia.validity import Validity, validity
from robodyn.solids.mass_properties import Part
from robodyn.support.floats import Floats, ranked
from robodyn.support.wording import count

if TYPE_CHECKING:
    from robodyn.checks.check import Checked
    from robodyn.equations.composite import Composite, Share
    from robodyn.robot.masses.declared import LinkInertia, RobotInertia
    from robodyn.robot.masses.shapes import Comparison, LinkShapes
    from robodyn.robot.urdf.parts import Description
    from robodyn.solids.mass_properties import Combination


AXES = ("x", "y", "z")
ORDER = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
"""Of the entries of a symmetric matrix."""
_UNKNOWN = "an unknown amount (facets too coarse)"
_MOST = 9
"""Planes and axes that are listed; of the others there is a count."""


def inertia_sections(parts: Sequence[Part], view: View) -> Iterator[Section]:
    """Yield of each part mass, centre, inertia as the view asks for it, principal moments, errors, warnings."""
    for part in parts:
        reach = float(np.abs((part.lo, part.hi)).max())
        size = " x ".join(number(x) for x in part.hi - part.lo)
        state = "closed" if part.closed else "not closed"
        yield [Paragraph(f"{printable(part.name)}: {count(part.triangles, 'triangle')}, {state}, {size} m")]
        yield [amounts(part.body, reach, ", at an assumed density" if part.assumed else "", part.body.area)]
        yield from inertia_tables(part.body, view)
        yield _symmetry(part, reach)
        arithmetic = f"arithmetic {part.arithmetic:.0e} ({part.method})"
        lines = [f"relative error of the volume: {arithmetic}, rounding of the file at most {part.rounding:.0e}"]
        lines += [] if part.union is None else [f"holes and overlaps: relative error at most {part.union:.0e}"]
        repairs = []
        for step in part.repairs:
            volumes = f"volume {number(step.volume_before)} to {number(step.volume_after)} m^3"
            repairs.append(f"{step.what}; {volumes}")
        lines += [*_tessellation(part, reach), *part.notes]
        yield [*paragraphs(lines), *remarks("repaired", repairs), *remarks("warning", part.warnings)]


def amounts(body: MassProperties, reach: float = 0.0, remark: str = "", area: float | None = None) -> Facts:
    """Return mass with a remark, volume, area [m^2], density and mass centre, 0 beside `reach` [m], as far as known."""
    found = (("volume", body.volume, "m^3"), ("area", area, "m^2"), ("density", body.density, "kg/m^3"))
    items = [("mass", f"{number(body.mass)} kg{remark}")]
    items += [(name, f"{number(value)} {unit}") for name, value, unit in found if value is not None]
    return Facts((*items, ("centre of mass", f"{point_text(body.com, reach)} m")))


def inertia_tables(body: MassProperties, view: View) -> Iterator[Section]:
    """Yield the inertia matrix as the view asks for it; principal moments and axes, and which axes are not unique."""
    _, matrix = view.inertia(body)
    scale = float(np.abs(matrix).max())
    rows = [(AXES[i], *(number(x, scale) for x in matrix[i])) for i in range(3)]
    yield [Table(f"Inertia {view.words} [kg m^2]", ("", *AXES), rows)]
    principal = body.principal
    moments, axes = certain(principal.moments), principal.axes.round(6) + 0.0
    rows = [(str(k + 1), number(moments[k]), *(f"{x:.6f}" for x in axes[k])) for k in range(3)]
    head = ("", "moment [kg m^2]", *(f"axis {name}" for name in AXES))
    table = Table("Principal moments about the centre of mass", head, rows)
    yield [table, *paragraphs([principal.remark] if principal.remark else [])]


def certain(moments: Floats) -> Floats:
    """Return principal moments, 0 for those that rounding alone may have made."""
    return np.where(np.abs(moments) <= NOISE * np.abs(moments).max(), 0.0, moments)


def _symmetry(part: Part, reach: float) -> Section:
    found, rows = part.symmetry, []
    if found is None:
        return []
    for plane in found.planes:
        rows.append(("plane", plane.normal, number(plane.offset, reach), plane.asymmetry, plane.verdict))
    for axis in found.axes:
        name = "axis of revolution" if axis.fold == inf else f"axis, {axis.fold:.0f}-fold"
        rows.append((name, axis.direction, point_text(axis.point, reach), axis.asymmetry, axis.verdict))
    cells = [
        (name, f"({', '.join(f'{x + 0.0:.4g}' for x in way.round(9))})", f"{place} m", _short(asymmetry, 1.0), verdict)
        for name, way, place, asymmetry, verdict in rows
        if verdict != "none"
    ]
    if not cells:
        least = [f"; the nearest plane leaves {_percent(plane.asymmetry)} outside" for plane in found.planes[:1]]
        return paragraphs(["Symmetry", f"none{''.join(least)}"])
    lines = [f"and {len(cells) - _MOST} more"] if len(cells) > _MOST else []
    products, density = [product for product in found.products if product.zero], part.body.density
    if products and density is not None:
        scale = float(np.trace(part.body.inertia))
        computed = ", ".join(_short(-product.residual * density, scale) for product in products)
        names = ", I".join(product.axes for product in products)
        lines.append(f"0 by symmetry: I{names} (computed {computed} kg m^2)")
    head = ("", "normal or axis", "at", "asymmetry", "verdict")
    return [Table("Symmetry", head, cells[:_MOST]), *paragraphs(lines)]


def _tessellation(part: Part, reach: float) -> Sequence[str]:
    """Return how far facets leave the numbers from those of a smooth body; nothing where they were not asked."""
    found, smooth = part.tessellation, part.corrected
    if found is None or smooth is None:
        return ()
    if not found.mesh.volume:
        return ("tessellation: no facets that may stand for a curved face",)
    moments = ", ".join(number(x) for x in smooth.principal.moments)
    meant, tight, wide = list[str](), list[str](), list[str]()
    for bars, words in ((found.mesh, meant), (found.on_surface, tight), (found.rest, wide)):
        apart = bars.centre * part.body.gyration
        words += [_percent(bars.volume), _percent(bars.inertia), f"{apart:.1g} m" if isfinite(apart) else _UNKNOWN]
    volume, inertia, centre = (f"within {on}, else {off}" for on, off in zip(tight, wide, strict=True))
    return (
        "tessellation: if facets are meant flat, nothing is missing; if they stand for smooth faces, the volume is off "
        f"by up to {meant[0]}, the inertia by {meant[1]}, the centre of mass by {meant[2]}",
        f"with smooth faces through the corners: volume {number(smooth.volume or 0.0)} m^3, "
        f"principal moments {moments} kg m^2, centre of mass {point_text(smooth.com, reach)} m",
        f"if the corners are on them: volume {volume}; inertia {inertia}; centre of mass {centre}",
    )


def _short(value: float, scale: float) -> str:
    return "0" if is_noise(abs(value), scale) else f"{value:.0e}"


def _percent(share: float) -> str:
    return f"{100 * share:.2g} %" if isfinite(share) else _UNKNOWN


def combination_sections(found: Combination, view: View) -> Iterator[Section]:
    """Yield the parts by mass, and the body that they make."""
    reach = float(np.abs(found.box).max())
    repairs = [f"{part.name}: {step.what}" for part in found.parts for step in part.repairs]
    warnings = [f"{part.name}: {text}" for part in found.parts for text in part.warnings]
    yield [Paragraph(f"{len(found.parts)} meshes as one rigid body")]
    yield [_by_mass("part", [part.name for part in found.parts], found.placed, found.body, reach)]
    yield [amounts(found.body, reach, ", at an assumed density" if any(part.assumed for part in found.parts) else "")]
    yield from inertia_tables(found.body, view)
    yield [*remarks("repaired", repairs), *remarks("warning", [*warnings, *found.warnings])]


def robot_sections(
    found: RobotInertia,
    view: View,
    checked: Checked,
    shares: Composite,
    terms: bool = False,
) -> Iterator[Section]:
    """Yield links by mass, the robot or some links at a configuration, shares term by term and momenta where these are
    asked for, and what a check says of the robot."""
    placed = [found.placed(link) for link in found.links]
    reach = max(float(np.abs(body.com).max()) for body in placed)
    at = ", ".join(f"{name} {value:.6g}" for name, value in found.at.items()) or "no joint moves"
    what = f"{found.massive} of {count(found.count, 'link')} with mass, in the frame of {_frame(found.frame)}"
    who = "links " + ", ".join(printable(link.name) for link in found.links) + ", " if found.composite else ""
    yield paragraphs([f"{printable(found.file)}: robot '{printable(found.name)}', {who}{what}", f"at {at}"])
    slack = [f"{round(link.validity.slack, 3) + 0.0:.3f}" for link in found.links]
    yield [_by_mass("link", [link.name for link in found.links], placed, found.body, reach, slack)]
    yield [amounts(found.body, reach)]
    yield from inertia_tables(found.body, view)
    _, matrix = view.inertia(found.body)
    scale = float(np.abs(matrix).max())
    gone = np.vectorize(lambda x: is_noise(abs(x), scale))(matrix)
    through = [is_noise(abs(x), reach * found.body.mass) for x in shares.first]
    yield paragraphs(vanishing(gone, through, [number(x, reach) for x in shares.place]))
    if terms:
        yield [_terms(shares, view)]
    if shares.momentum:
        yield [_momenta(shares, view)]
    verdicts = [_physical(validity(found.body), " as a whole"), _checked(checked)]
    yield [*paragraphs(verdicts), *remarks("warning", found.warnings)]


def vanishing(zero: Any, through: Sequence[bool], places: Sequence[str]) -> list[str]:
    """Return which axes are principal because products of inertia vanish, and the plane that would make it so.

    Args:
        zero: (3, 3) which entries of the matrix are 0; through: whether the mass centre lies in the plane through the
            point that is normal to x, y, z, at these places.
    """
    lines = []
    for k, axis in enumerate(AXES):
        others = [AXES[min(j, k)] + AXES[max(j, k)] for j in range(3) if j != k]
        if all(zero[k][j] for j in range(3) if j != k):
            what = f"I_{others[0]} = I_{others[1]} = 0: {axis} is a principal axis"
            if through[k]:
                lines.append(f"{what}, as a plane of symmetry {axis} = {places[k]} would make it")
            else:
                lines.append(f"{what}, but by no plane of symmetry: the mass centre is not at {axis} = {places[k]}")
    return lines


def letters_sections(description: Description, found: Composite, view: View) -> Iterator[Section]:
    """Yield what bodies in letters make together, and each by itself."""
    from robodyn.report.renderers.letters import text_of

    bodies, whole = ", ".join(map(printable, found.names)), found.whole
    what = f"{printable(description.file)}: robot '{printable(description.name)}', bodies {bodies}, in the frame of"
    legend = [f"q_{k}: joint {printable(joint)}" for k, joint in found.joints]
    legend = [", ".join([*legend, "c_1 = cos q_1, s_12 = sin(q_1 + q_2), s_11 = sin(2 q_1)"])] if legend else []
    yield paragraphs([f"{what} {_frame(found.frame)}", *legend])
    rows = [(letter.name, f"{letter.value:.6g}", letter.meaning) for letter in found.letters]
    if rows:
        yield [Table("Letters", ("", "value", ""), rows)]
    yield [Heading("Mass and mass centre"), *paragraphs([f"m = {text_of(whole.m)}", *_entries("c", whole.c)])]
    gone = vanishing(whole.inertia == 0, [x == 0 for x in found.first], list(map(text_of, found.place)))
    yield [Heading(f"Inertia {view.words}"), *paragraphs([*_entries("I", whole.inertia), *gone])]
    if found.momentum:
        lines = [*_entries("P", whole.P), *_entries("L", whole.L)]
        yield [Heading(f"Linear momentum, and angular {view.words}"), *paragraphs(lines)]
    for body in found.bodies:
        terms = [*_terms_of(body), *((("P", body.P), ("L", body.L)) if found.momentum else ())]
        lines = [f"{name}: {', '.join(_entries('', values)) or '0'}" for name, values in terms]
        yield [Heading(f"Share of {printable(body.name)}"), *paragraphs(lines)]


def _frame(name: str) -> str:
    return "the base" if name == "base" else printable(name)


def _terms_of(share: Share) -> list[tuple[str, Any]]:
    own = [] if share.own is share.turned else [("I_c, own axes", share.own)]
    return [*own, ("R I_c R^T", share.turned), ("m (|d|^2 1 - d d^T)", share.moved), ("sum", share.inertia)]


def _entries(name: str, values: Any) -> list[str]:
    """Return the entries of a vector or a symmetric matrix as equations; without a name those that are not zero."""
    from robodyn.report.renderers.letters import text_of

    entries = (
        zip(AXES, values, strict=True) if values.ndim == 1 else ((AXES[i] + AXES[j], values[i, j]) for i, j in ORDER)
    )
    return [f"{name}{'_' * bool(name)}{key} = {text_of(x)}" for key, x in entries if name or x != 0]


def _terms(found: Composite, view: View) -> Table:
    scale = float(np.abs(found.whole.inertia).max())
    rows = [
        (printable(share.name), what, *(number(matrix[at], scale) for at in ORDER))
        for share in (*found.bodies, found.whole)
        for what, matrix in _terms_of(share)
    ]
    head = ("link", "term", *(AXES[i] + AXES[j] for i, j in ORDER))
    note = "R turns the link's axes into those asked for; d leads from the point to the link's mass centre"
    return Table(f"Shares of the inertia {view.words} [kg m^2]", head, rows, note)


def _momenta(found: Composite, view: View) -> Table:
    shares = (*found.bodies, found.whole)
    linear, angular = (float(np.abs([getattr(share, name) for share in shares]).max()) for name in "PL")
    rows = [
        (printable(share.name), *(number(x, linear) for x in share.P), *(number(x, angular) for x in share.L))
        for share in shares
    ]
    head = ("link", *(f"P_{axis} [kg m/s]" for axis in AXES), *(f"L_{axis} [kg m^2/s]" for axis in AXES))
    return Table(f"Linear momentum, and angular {view.words}; relative to the ground", head, rows)


def _by_mass(
    what: str,
    names: Sequence[str],
    bodies: Sequence[MassProperties],
    whole: MassProperties,
    reach: float,
    slack: Sequence[str] = (),
) -> Table:
    rows = []
    for k in ranked(range(len(bodies)), [body.mass for body in bodies].__getitem__):
        mass, share = bodies[k].mass, bodies[k].mass / whole.mass
        row = [names[k], number(mass), f"{100 * share:.1f}", *(number(x, reach) for x in bodies[k].com)]
        rows.append([*row, *slack[k : k + 1]])
    head = [what, "mass [kg]", "share [%]", "x [m]", "y [m]", "z [m]", *["slack"] * bool(slack)]
    return Table(f"{what.capitalize()}s by mass, with their centres of mass", head, rows)


def link_sections(file: str, found: LinkInertia, view: View, checked: Checked) -> Iterator[Section]:
    """Yield what a link declares, whether a body can be so, and what a check says of the link."""
    yield [Paragraph(f"{printable(file)}:{found.line}: link '{printable(found.name)}' as declared, in its own frame")]
    yield [amounts(found.body)]
    yield from inertia_tables(found.body, view)
    yield paragraphs([_physical(found.validity), _checked(checked)])


def link_shapes_sections(file: str, found: LinkShapes, view: View) -> Iterator[Section]:
    """Yield what the shapes of a link make."""
    what = f"link '{printable(found.name)}' from its <{found.kind}> shapes, in its own frame"
    yield [Paragraph(f"{printable(file)}:{found.line}: {what}")]
    yield [amounts(found.body, float(np.abs(found.shapes.box).max()), f", {found.weight}")]
    yield from inertia_tables(found.body, view)
    yield [Paragraph(_physical(validity(found.body))), *remarks("remark", found.shapes.remarks)]


def comparison_sections(found: Comparison) -> Iterator[Section]:
    """Yield a table, the most different link first; remarks link by link; what could not be compared, and why."""
    from robodyn.robot.masses.shapes import UNCERTAIN

    rows, lines, rest = [], [], []
    for link in found.links:
        difference, place = link.difference, f"{link.name} (line {link.line})"
        lines += [f"{place}: {text}" for text in link.remarks]
        if difference is None:
            rest.append(f"{place}: {link.reason}")
            continue
        row = [link.name, f"{100 * difference.inertia:.3g}" if difference.inertia > UNCERTAIN else "0"]
        row += [number(difference.body.mass), number(difference.density)]
        row.append(number(difference.distance, float(np.abs(difference.shapes.box).max())))
        row += map(number, difference.ratios)
        rows.append([*row, f"{len(link.remarks)} below" if link.remarks else "-"])
    what = f"declared inertias against the <{found.kind}> shapes at the declared masses"
    of = f"{len(rows)} of {len(found.links)} links"
    yield [Paragraph(f"{printable(found.file)}: robot '{printable(found.name)}', {what}, {of}")]
    if rows:
        legend = (
            "difference: |I_declared - I_shapes| / |I_shapes| about the centres of mass; "
            "ratios: declared over shapes' principal moments"
        )
        head = ["link", "difference [%]", "mass [kg]", "density [kg/m^3]", "centres apart [m]"]
        yield [Table("", [*head, "I_1 ratio", "I_2 ratio", "I_3 ratio", "remarks"], rows), Paragraph(legend)]
    for title, part in (("Remarks", lines), ("Not compared", rest)):
        yield paragraphs([title, *part] if part else [])


def _checked(checked: Checked) -> str:
    from robodyn.report.check import check_line

    listed = f" (robodyn check {shlex.quote(checked.files[0])})" if checked.findings else ""
    return f"check: {check_line(checked)}{listed}"


def _physical(found: Validity, which: str = "") -> str:
    """Return the verdict with its margin: I_1 + I_2 - I_3 over the largest moment, twice the least second moment."""
    small, middle, large = map(number, certain(found.moments))
    slack = round(found.slack, 4) + 0.0
    margin = f"I_1 + I_2 - I_3 = {small} + {middle} - {large} kg m^2, {slack:.4f} of the largest"
    if found.faults:
        return f"not physical{which}: {'; '.join(found.faults)} ({margin})"
    return f"physical{which}: no second moment is negative ({margin})"
