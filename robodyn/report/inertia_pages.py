"""What meshes, links and robots weigh, as pages and as JSON."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import PurePath
from typing import TYPE_CHECKING, Any

import numpy as np

from robodyn.errors import MeshError
from robodyn.programs.vectors import Array, product
from robodyn.report import document as doc
from robodyn.report import inertia as words
from robodyn.report.table import printable
from robodyn.solids.inertia.properties import MassProperties, View
from robodyn.solids.inertia.validity import Box, Validity, validity
from robodyn.solids.mass_properties import Part

if TYPE_CHECKING:
    from robodyn.checks.check import Checked
    from robodyn.robot.masses.declared import LinkInertia, RobotInertia
    from robodyn.robot.masses.shapes import Comparison, LinkShapes
    from robodyn.robot.urdf.parts import Description
    from robodyn.solids.mass_properties import Combination


COM = View()


def inertia_json(outcomes: Sequence[Part | MeshError], view: View) -> str:
    """Return {"meshes": [...]}; of a mesh that failed its `name` and, as a text, the `error` alone."""
    meshes = [
        doc.select(each, "name:file error:sentence") if isinstance(each, MeshError) else part_data(each, view)
        for each in outcomes
    ]
    return doc.written({"meshes": meshes})


def combination_json(found: Combination, view: View) -> str:
    """Return {"meshes": [each in its own axes], "combined": {...}}."""
    places = doc.select(found, "box places warnings", places=list(map(_pose, found.poses)))
    meshes = [part_data(part, view) for part in found.parts]
    return doc.written({"meshes": meshes, "combined": {**body_data(found.body, view), **places}})


def robot_json(found: RobotInertia, view: View, checked: Checked) -> str:
    """Return the robot as one body in the frame of its base, every link with an <inertial>, and what a check says."""
    from robodyn.report.check import check_data

    links = [{**_declared_json(link), "pose": _pose(link.pose), "com_in_base": link.placed.com} for link in found.links]
    rest = {"validity": _validity(validity(found.body)), "check": check_data(checked), "links": links}
    keys = "validity check links_with_mass:massive links warnings"
    whole = body_data(found.body, view)
    return doc.written({**doc.select(found, "robot:name file at"), **whole, **doc.select(found, keys, **rest)})


def link_json(robot: str, found: LinkInertia, view: View, checked: Checked) -> str:
    """Return what a link declares, and what a check says of it."""
    from robodyn.report.check import check_data

    rest = {"check": check_data(checked), "warnings": found.warnings}
    return doc.written({"robot": robot, **_declared_json(found, view), **rest})


def link_shapes_json(robot: str, found: LinkShapes, view: View) -> str:
    meshes, valid = [part.name for part in found.shapes.parts], _validity(validity(found.body))
    keys = "validity box:shapes.box meshes warnings:shapes.remarks"
    rest = doc.select(found, keys, validity=valid, meshes=meshes)
    of = doc.select(found, "link:name line geometry:kind")
    return doc.written({"robot": robot, **of, **body_data(found.body, view), **rest})


def comparison_json(found: Comparison) -> str:
    """Return all links, the most different first, then those that could not be compared, with the reason."""
    links = []
    for link in found.links:
        declared, difference, derived = link.declared, link.difference, None
        if difference:
            meshes = [part_data(part) for part in difference.shapes.parts]
            derived = {**body_data(difference.body), "box": doc.encode(difference.shapes.box), "meshes": meshes}
        keys = "shape line size filename file scale xyz:origin.xyz rpy:origin.rpy"
        one = doc.select(
            link,
            "link:name line shapes declared derived difference[density? com_distance:distance com_offset:offset "
            "moment_ratios:ratios? inertia box_spread:room?] reason remarks",
            shapes=[doc.select(each.geometry, keys, file=each.path) for each in link.shapes],
            declared=declared and {**body_data(declared.body), "validity": _validity(declared.validity)},
            derived=derived,
        )
        links.append(one)
    return doc.written(doc.select(found, "robot:name file geometry:kind links", links=links))


def body_data(body: MassProperties, view: View = COM) -> dict[str, Any]:
    """Return the mass properties of a body; principal axes are rows."""
    about = dict(zip(("point", "matrix"), view.inertia(body), strict=True))
    principal = doc.select(body.principal, "moments axes")
    keys = "mass volume area density com inertia inertia_about principal"
    return doc.select(body, keys, inertia_about=about, principal=principal)


def part_data(part: Part, view: View = COM) -> dict[str, Any]:
    """Return what there is to say of one mesh: planes, axes (the fold of one of revolution is null) and products [kg
    m^2] of its symmetry; numbers beside those of the smooth body with bars, relative, of the centre in metres, null
    where nothing can be said (`bar_corners_on_surface`: of the corrected ones if the corners lie on it)."""
    symmetry: dict[str, Any] | None = None
    if part.symmetry is not None:
        density, keys = part.body.density or 0.0, "axes computed relative zero_by_symmetry:zero"
        products = [doc.select(each, keys, computed=-each.residual * density) for each in part.symmetry.products]
        keys = "planes[normal offset asymmetry verdict] axes[direction point fold? asymmetry verdict] products"
        symmetry = doc.select(part.symmetry, keys, products=products)
    found, smooth, tessellation = part.tessellation, part.corrected, None
    if found is not None and smooth is not None:
        tessellation = {"volume": {"mesh": part.body.volume}, "inertia": {}, "com": {}}
        bars = {"bar": found.mesh, "bar_corrected": found.rest, "bar_corners_on_surface": found.on_surface}
        for name, scale in (("volume", 1.0), ("inertia", 1.0), ("com", part.body.gyration)):
            attribute = "centre" if name == "com" else name
            own = {key: doc.finite(scale * getattr(each, attribute)) for key, each in bars.items()}
            tessellation[name] |= {"corrected": getattr(smooth, name), **own}
    error: dict[str, Any] = {"arithmetic": doc.finite(part.arithmetic), "rounding": doc.finite(part.rounding)}
    error |= {"tessellation": tessellation, "union": part.union}
    keys = "symmetry box closed repairs error arithmetic:method notes warnings"
    more = doc.select(part, keys, symmetry=symmetry, box=Box(part.lo, part.hi), error=error)
    return {**doc.select(part, "name triangles"), **body_data(part.body, view), **more}


def _validity(found: Validity) -> dict[str, Any]:
    return doc.select(found, "physical slack faults", physical=not found.faults)


def _declared_json(link: LinkInertia, view: View = COM) -> dict[str, Any]:
    own = doc.select(link, "link:name line")
    return {**own, **body_data(link.body, view), "validity": _validity(link.validity)}


def _pose(pose: Sequence[Any]) -> dict[str, Any]:
    return dict(zip(("rotation", "origin"), doc.encode(list(pose)), strict=True))


def parts_page(outcomes: Sequence[Part | MeshError], view: View, shapes: Sequence[Array | None]) -> doc.Document:
    """Return what each mesh encloses, how far that holds, and why meshes failed; drawn from triangles (m, 3, 3) [m]."""
    parts = [each for each in outcomes if isinstance(each, Part)]
    failures = [f"{each}." for each in outcomes if isinstance(each, MeshError)]
    failed = f"{len(failures)} of {len(outcomes)} meshes failed"
    blocks: list[doc.Block] = [doc.Verdict("bad", failed, tuple(failures))] if failures else []
    open_ones = ", ".join(printable(part.name) for part in parts if not part.closed)
    doubts = [f"{printable(part.name)}: {text}." for part in parts for text in part.warnings]
    repairs = [f"{printable(part.name)}: repaired, {step.what}." for part in parts for step in part.repairs]
    error = max(max(part.arithmetic, part.rounding, part.union or 0.0) for part in parts)
    reasons = [f"The volume holds within {error:.0e} of itself, for the surface as the file has it.", *repairs, *doubts]
    if any(part.assumed for part in parts):
        reasons.append("The density is assumed: --density or --mass says what it is.")
    level: doc.Level = "bad" if open_ones else "doubtful" if doubts or repairs else "good"
    headlines = {
        "bad": f"Not closed, so that the mass is not definite: {open_ones}",
        "doubtful": "Mass and inertia, with repairs or doubts",
        "good": f"{'Closed' if len(parts) == 1 else 'All closed'} and without faults",
    }
    blocks.append(doc.Verdict(level, headlines[level], tuple(reasons)))
    for k, (part, triangles) in enumerate(zip(parts, shapes, strict=True)):
        blocks += _solid(PurePath(part.name).name, part.body, triangles, f"mesh {k}")
    title = PurePath(parts[0].name).name if len(outcomes) == 1 else "Meshes"
    what = f"Mass properties: {', '.join(part.name for part in parts)}"
    return _page(title, what, blocks, words.inertia_sections(parts, view), inertia_json(outcomes, view))


def combination_page(found: Combination, view: View, shapes: Sequence[Array | None]) -> doc.Document:
    """Return meshes as one rigid body; with a picture of those that have triangles (m, 3, 3) in their own axes [m]."""
    placed = [
        product(triangles, np.asarray(R, dtype=float).T) + np.asarray(p, dtype=float)
        for triangles, (R, p) in zip(shapes, found.poses, strict=True)
        if triangles is not None
    ]
    names = ", ".join(part.name for part in found.parts)
    doubts = [*(f"{part.name}: {text}" for part in found.parts for text in part.warnings), *found.warnings]
    figures = _solid("The whole", found.body, np.concatenate(placed) if placed else None, "whole")
    first, sections = [_possible(found.body, doubts), *figures], words.combination_sections(found, view)
    return _page("Meshes as one rigid body", names, first, sections, combination_json(found, view))


def robot_page(
    found: RobotInertia, description: Description, view: View, checked: Checked, pictures: bool
) -> doc.Document:
    """Return the whole robot, its joints locked."""
    first: list[doc.Block] = [_possible(found.body, found.warnings, checked)]
    if pictures:
        from robodyn.report.pictures.robot import robot_figure, shapes_of
        from robodyn.robot.kinematics import configuration
        from robodyn.robot.load import assemble

        model, shapes = assemble(description), shapes_of(description)[0]
        q = configuration(model, found.at)
        first.append(doc.Gallery((robot_figure(model, q, "", "this configuration", shapes, "robot"),)))
    what = f"Mass properties of the whole robot, {found.massive} of {found.count} links with mass"
    return _page(found.name, what, first, words.robot_sections(found, view, checked), robot_json(found, view, checked))


def link_page(
    found: LinkInertia, description: Description, view: View, checked: Checked, pictures: bool
) -> doc.Document:
    first = [_possible(found.body, (), checked), *_link(description, found, pictures)]
    sections = words.link_sections(description.file, found, view, checked)
    title, what = f"{description.name}: {found.name}", f"Link {found.name} as declared"
    return _page(title, what, first, sections, link_json(description.name, found, view, checked))


def link_shapes_page(found: LinkShapes, description: Description, view: View, pictures: bool) -> doc.Document:
    first = [_possible(found.body, found.shapes.remarks), *_link(description, found, pictures)]
    sections = words.link_shapes_sections(description.file, found, view)
    title, what = f"{description.name}: {found.name}", f"Link {found.name} from its {found.kind} shapes, {found.weight}"
    return _page(title, what, first, sections, link_shapes_json(description.name, found, view))


def differences_page(found: Comparison) -> doc.Document:
    differences = [link.difference.inertia for link in found.links if link.difference is not None]
    far, rest = sum(difference > 0.1 for difference in differences), len(found.links) - len(differences)
    level: doc.Level = "doubtful" if far else "good" if differences else "neutral"
    headline = f"{far} of {len(differences)} links differ from their shapes by more than 10 %"
    verdict = doc.Verdict(level, headline, (f"{rest} more links cannot be compared.",) if rest else ())
    what, sections = "Declared inertias against shapes", words.comparison_sections(found)
    return _page(found.name, what, [verdict], sections, comparison_json(found), "comparison.json")


def _page(
    title: str,
    what: str,
    first: Sequence[doc.Block],
    sections: Iterable[doc.Section],
    data: str,
    name: str = "inertia.json",
) -> doc.Document:
    return doc.page(title, what, first, sections, "Values", [(name, data)], "robodyn inertia --format json prints it")


def _solid(name: str, body: MassProperties, triangles: Array | None, key: str) -> list[doc.Block]:
    if triangles is None:
        return []
    from robodyn.report.pictures.robot import body_figure

    return [doc.Gallery((body_figure(printable(name), body, triangles, key),))]


def _link(description: Description, found: LinkInertia | LinkShapes, pictures: bool) -> list[doc.Block]:
    if not pictures or not found.body.mass:
        return []
    from robodyn.report.pictures.robot import shapes_of

    return _solid(found.name, found.body, shapes_of(description)[0].get(found.name), "link")


def _possible(body: MassProperties, doubts: Sequence[str], checked: Checked | None = None) -> doc.Verdict:
    """Return whether a body can exist, and what is doubtful; no better than what a check of its description found."""
    faults = validity(body).faults if body.mass or body.S_c.any() else ()
    if checked is not None:
        from robodyn.report.check import check_line, check_verdict

        if not checked.fit:
            found = check_verdict(checked)
            return replace(found, reasons=(*found.reasons, *faults, *doubts))
        if checked.findings:
            doubts = (*doubts, f"robodyn check: {check_line(checked)}.")
    if faults:
        return doc.Verdict("bad", "No body can have this mass and inertia", (*faults, *doubts))
    sure = "Physically possible"
    return doc.Verdict("doubtful", f"{sure}, with doubts", tuple(doubts)) if doubts else doc.Verdict("good", sure)
