"""What meshes, links and robots weigh, as pages and as JSON."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import PurePath
from typing import TYPE_CHECKING, Any

import numpy as np

from robodyn.errors import MeshError
from robodyn.programs.vectors import Array
from robodyn.report import document as doc
from robodyn.report import inertia as words
from robodyn.report.table import number, point_text, printable
from robodyn.solids.inertia.properties import MassProperties, View
from robodyn.solids.inertia.validity import Box, Validity, validity
from robodyn.solids.mass_properties import Part
from robodyn.support.wording import count

if TYPE_CHECKING:
    from robodyn.checks.check import Checked
    from robodyn.equations.composite import Composite, Share
    from robodyn.robot.masses.declared import LinkInertia, RobotInertia
    from robodyn.robot.masses.shapes import Comparison, LinkShapes
    from robodyn.robot.urdf.parts import Description, Kind
    from robodyn.solids.mass_properties import Combination


COM = View()
_FAR = 0.1
"""Of an inertia: what a link may be from its shapes."""


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


def robot_json(found: RobotInertia, view: View, checked: Checked, shares: Composite) -> str:
    """Return the robot, or some links, as one body in a frame, every link with an <inertial>, its share term by term,
    and what a check says."""
    from robodyn.report.check import check_data

    links = []
    for link, share in zip(found.links, shares.bodies, strict=True):
        own = {"pose": _pose(link.pose), "com_in_base": link.placed.com, "share": _share(share, shares.momentum)}
        links.append({**_declared_json(link), **own})
    rest = {"validity": _validity(validity(found.body)), "check": check_data(checked), "links": links}
    keys = "validity check links_with_mass:massive links warnings"
    whole = body_data(found.body, view)
    if shares.momentum:
        whole["momentum"] = _momentum(shares.whole)
    return doc.written({**doc.select(found, "robot:name file at frame"), **whole, **doc.select(found, keys, **rest)})


def letters_json(description: Description, found: Composite) -> str:
    """Return bodies as one in letters: expressions as texts, `symbols` with value and meaning of each letter."""
    from robodyn.report.renderers.letters import text_of

    def texts(values: Any) -> Any:
        return [texts(x) for x in values] if isinstance(values, np.ndarray) else text_of(values)

    whole = found.whole
    data = doc.select(description, "robot:name file") | {"frame": found.frame}
    data["symbols"] = [doc.select(letter, "name value meaning") for letter in found.letters]
    data |= {"mass": text_of(whole.m), "com": texts(whole.c)}
    data["inertia_about"] = {"point": texts(found.point), "matrix": texts(whole.inertia)}
    if found.momentum:
        data["momentum"] = _momentum(whole, texts)
    data["bodies"] = [
        {"body": body.name, "mass": text_of(body.m), "com": texts(body.c)}
        | {"share": _share(body, found.momentum, texts)}
        for body in found.bodies
    ]
    return doc.written(data)


def _share(share: Share, momentum: bool, texts: Callable[[Any], Any] = doc.encode) -> dict[str, Any]:
    parts = {"own": share.own, "turned": share.turned, "parallel_axis": share.moved, "sum": share.inertia}
    out = {name: texts(x) for name, x in parts.items()}
    return out | ({"momentum": _momentum(share, texts)} if momentum else {})


def _momentum(share: Share, texts: Callable[[Any], Any] = doc.encode) -> dict[str, Any]:
    return {"linear": texts(share.P), "angular": texts(share.L)}


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
    open_ones = ", ".join(printable(part.name) for part in parts if not part.closed)
    doubts = [f"{printable(part.name)}: {text}." for part in parts for text in part.warnings]
    repairs = [f"{printable(part.name)}: repaired, {step.what}." for part in parts for step in part.repairs]
    error = max(max(part.arithmetic, part.rounding, part.union or 0.0) for part in parts)
    holds = f"The volume holds within {error:.0e} of itself, for the surface as the file has it."
    reasons = [*failures, holds, *repairs, *doubts]
    if any(part.assumed for part in parts):
        reasons.append("The density is assumed: --density or --mass says what it is.")
    level: doc.Level = "bad" if failures or open_ones else "doubtful" if doubts or repairs else "good"
    headlines = {
        "bad": f"Not closed, so that the mass is not definite: {open_ones}",
        "doubtful": "Mass and inertia, with repairs or doubts",
        "good": f"{'Closed' if len(parts) == 1 else 'All closed'} and without faults",
    }
    headline = f"{len(failures)} of {len(outcomes)} meshes failed" if failures else headlines[level]
    blocks = [doc.Verdict(level, headline, tuple(reasons)), *_solids(parts, shapes)]
    title = PurePath(parts[0].name).name if len(outcomes) == 1 else "Meshes"
    what = f"Mass properties: {', '.join(part.name for part in parts)}"
    return _page(title, what, blocks, words.inertia_sections(parts, view), inertia_json(outcomes, view))


def combination_page(found: Combination, view: View, shapes: Sequence[Array | None]) -> doc.Document:
    """Return meshes as one rigid body; with a view of those that have triangles (m, 3, 3) in their own axes [m]."""
    names = ", ".join(part.name for part in found.parts)
    doubts = [*(f"{part.name}: {text}" for part in found.parts for text in part.warnings), *found.warnings]
    first = [_possible(found.body, doubts), *_solids(found.parts, shapes, found)]
    sections = words.combination_sections(found, view)
    return _page("Meshes as one rigid body", names, first, sections, combination_json(found, view))


def robot_page(
    found: RobotInertia,
    description: Description,
    view: View,
    checked: Checked,
    shares: Composite,
    pictures: bool,
) -> doc.Document:
    """Return the robot, or some links, the joints locked."""
    first: list[doc.Block] = [_possible(found.body, found.warnings, checked)]
    if pictures:
        caption = "The robot at this configuration: mass centres, and ellipsoids of the same masses and inertias"
        chosen = [link.name for link in found.links] if found.composite else []
        first += _robot(description, caption, found.at, found.body.placed(*found.frame_pose), chosen)
    who = "some links" if found.composite else "the whole robot"
    what = f"Mass properties of {who}, {found.massive} of {count(found.count, 'link')} with mass"
    sections = words.robot_sections(found, view, checked, shares, terms=True)
    return _page(found.name, what, first, sections, robot_json(found, view, checked, shares))


def link_page(
    found: LinkInertia, description: Description, view: View, checked: Checked, pictures: bool
) -> doc.Document:
    first = [_possible(found.body, (), checked), *_link(description, found, pictures, "visual")]
    sections = words.link_sections(description.file, found, view, checked)
    title, what = f"{description.name}: {found.name}", f"Link {found.name} as declared"
    return _page(title, what, first, sections, link_json(description.name, found, view, checked))


def link_shapes_page(found: LinkShapes, description: Description, view: View, pictures: bool) -> doc.Document:
    first = [_possible(found.body, found.shapes.remarks), *_link(description, found, pictures, found.kind)]
    sections = words.link_shapes_sections(description.file, found, view)
    title, what = f"{description.name}: {found.name}", f"Link {found.name} from its {found.kind} shapes, {found.weight}"
    return _page(title, what, first, sections, link_shapes_json(description.name, found, view))


def differences_page(found: Comparison, description: Description, pictures: bool) -> doc.Document:
    """Return how far declared inertias are from those of shapes, the robot with the links that differ lit."""
    from robodyn.robot.masses.shapes import UNCERTAIN

    differences = {link.name: link.difference.inertia for link in found.links if link.difference is not None}
    differences = {name: each if each > UNCERTAIN else 0.0 for name, each in differences.items()}
    far, rest = [name for name, each in differences.items() if each > _FAR], len(found.links) - len(differences)
    level: doc.Level = "doubtful" if far else "good" if differences else "neutral"
    headline = f"{len(far)} of {len(differences)} links differ from their shapes by more than {100 * _FAR:.0f} %"
    reasons = (f"{count(rest, 'more link')} cannot be compared.",) if rest else ()
    first: list[doc.Block] = [doc.Verdict(level, headline, reasons)]
    if pictures:
        caption = "The robot, links that differ lit, and ellipsoids of the declared masses and inertias"
        first += _robot(description, caption, lit=far)
    rows = [
        (name, [(f"{100 * each:.3g} %", 0.0, min(100 * each, 100.0), "doubtful" if name in far else "good")], "")
        for name, each in differences.items()
    ]
    caption, note = "Inertia: declared less that of the shapes, over the latter", "About the mass centres; to 100 %."
    first += [doc.Bars(caption, rows, note)] if rows else []
    what, sections = "Declared inertias against shapes", words.comparison_sections(found)
    return _page(found.name, what, first, sections, comparison_json(found), "comparison.json")


def _page(
    title: str,
    what: str,
    first: Sequence[doc.Block],
    sections: Iterable[doc.Section],
    data: str,
    name: str = "inertia.json",
) -> doc.Document:
    return doc.page(title, what, first, sections, "Values", [(name, data)], "robodyn inertia --format json prints it")


def _robot(
    description: Description, caption: str, at: Any = (), whole: MassProperties | None = None, lit: Iterable[str] = ()
) -> Iterator[doc.Block]:
    """Yield a view of a robot, standing at a configuration with principal axes of the whole, or to be moved."""
    from robodyn.report import stage
    from robodyn.robot.kinematics import configuration
    from robodyn.robot.load import assemble

    model = assemble(description)
    still = stage.pose(model, configuration(model, at).tolist()) | ({"sliders": []} if whole else {})
    inertias = {body.name: np.asarray(body.inertia.about_centre, dtype=float) for body in model.bodies}
    said = {name: f"principal moments {_moments(np.linalg.eigvalsh(inertia))}" for name, inertia in inertias.items()}
    colours = dict.fromkeys((model.bodies[model.links[link].body].name for link in lit), "doubtful")
    shown = stage.robot(model, [still], words=said, lit=colours)
    marks = _axes([(whole, model.reach)]) if whole else []
    yield stage.stage(caption, [shown], marks, ellipsoids=True, through=bool(whole))


def _link(description: Description, found: LinkInertia | LinkShapes, pictures: bool, kind: Kind) -> list[doc.Block]:
    if not pictures or not found.body.mass:
        return []
    from robodyn.report.stage import shapes_of

    return _solids([found], [shapes_of(description, kind)[0].get(found.name)])


def _solids(
    solids: Sequence[Part | LinkInertia | LinkShapes], shapes: Sequence[Array | None], whole: Combination | None = None
) -> list[doc.Block]:
    """Return a view of what has triangles in its axes [m]: as parts of a whole with its principal axes, or beside each
    other with principal axes and planes of symmetry of each."""
    from robodyn.report import stage
    from robodyn.report.charts import COLOURS

    robots, bodies = list[dict[str, Any]](), list[tuple[MassProperties, float]]()
    discs, said = list[tuple[Array, Array, float]](), list[str]()
    side, poses = 0.0, whole.poses if whole else [(np.eye(3), np.zeros(3))] * len(solids)
    for solid, triangles, (R, at) in zip(solids, shapes, poses, strict=True):
        if triangles is None:
            continue
        name, body = PurePath(solid.name).name, solid.body
        low, high = triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))
        reach = float((high - low).max())
        p = np.asarray(at, dtype=float)
        if whole is None and len(solids) > 1:  # to the right of the one before, on one floor
            p = np.array((side - high[0], -(low[1] + high[1]) / 2, -low[2]))
            side -= high[0] - low[0] + 0.3 * reach
        moments = f"principal moments {_moments(body.principal.moments)}"
        said.append(f"{name}: {number(body.mass)} kg, centre of mass {point_text(body.com, reach)} m, {moments}")
        colour = COLOURS[len(robots) % len(COLOURS)] if whole else None
        robots.append(stage.solid(name, body, triangles, (R, p), words=moments, colour=colour))
        bodies.append((body.placed(R, p), reach))
        symmetry = solid.symmetry if isinstance(solid, Part) and not whole else None
        for plane in symmetry.planes if symmetry else ():
            if plane.verdict != "none":
                centre = body.com + (plane.offset - plane.normal @ body.com) * plane.normal
                discs.append((centre + p, 1e-3 * reach * plane.normal, 0.65 * reach))
    if not robots:
        return []
    marks = _axes([(whole.body, float((whole.box.hi - whole.box.lo).max()))] if whole else bodies)
    marks += (
        [stage.mark(count(len(discs), "plane of symmetry", "planes of symmetry"), "c5", discs, 0.3, len(discs) <= 3)]
        if discs
        else []
    )
    caption = f"Centre of mass{', principal axes and planes of symmetry' if discs else ' and principal axes'}"
    declared = not isinstance(solids[0], Part)
    return [stage.stage(caption, robots, marks, through=True, ellipsoids=declared, alt="; ".join(said))]


def _axes(bodies: Sequence[tuple[MassProperties, float]]) -> list[dict[str, Any]]:
    """Return principal axes of bodies that are so large [m], of one with its moments."""
    from robodyn.report import stage

    marks = []
    for k, colour in enumerate(("bad", "good", "c1")):
        axes = [(body, 1.4 * reach * body.principal.axes[k]) for body, reach in bodies]
        moment = f": {number(words.certain(bodies[0][0].principal.moments)[k])} kg m^2" if len(bodies) == 1 else ""
        lines = [(body.com - 0.5 * axis, axis, 0.003 * float(np.linalg.norm(axis))) for body, axis in axes]
        marks.append(stage.mark(f"principal axis {k + 1}{moment}", colour, lines))
    return marks


def _moments(moments: Array) -> str:
    return f"{', '.join(map(number, words.certain(moments)))} kg m^2"


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
