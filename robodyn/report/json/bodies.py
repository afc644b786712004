"""Mass properties as JSON: of meshes, composite bodies, links and robots, and of declared inertias beside shapes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from robodyn.errors import MeshError
from robodyn.report.json.encode import encode, finite, select, written
from robodyn.solids.inertia.conversions import View
from robodyn.solids.inertia.properties import MassProperties
from robodyn.solids.inertia.validity import Validity, validity
from robodyn.solids.mesh_mass import Part

if TYPE_CHECKING:
    from robodyn.checks.check import Checked
    from robodyn.robot.masses.compare import Comparison, Difference, LinkComparison
    from robodyn.robot.masses.declared import LinkInertia, RobotInertia
    from robodyn.robot.masses.shapes import LinkShapes
    from robodyn.robot.urdf.geometry import Shape
    from robodyn.solids.composite_mass import Combination
    from robodyn.solids.mesh.tessellation.bars import Bars, Tessellation

COM = View()


def inertia_json(outcomes: Sequence[Part | MeshError], view: View) -> str:
    """Return {"meshes": [...]}; of a mesh that failed its `name` and, as a text, the `error` alone."""
    return written({"meshes": [_outcome(each, view) for each in outcomes]})


def _outcome(outcome: Part | MeshError, view: View) -> dict[str, Any]:
    if isinstance(outcome, MeshError):
        return select(outcome, "name:file error:sentence")
    return part_data(outcome, view)


def combination_json(found: Combination, view: View) -> str:
    """Return {"meshes": [each in its own axes], "combined": {...}}."""
    places = [_pose(pose) for pose in found.poses]
    combined = {
        **body_data(found.body, view),
        **select(found, "box places warnings", box=_box(found.box), places=places),
    }
    return written({"meshes": [part_data(part, view) for part in found.parts], "combined": combined})


def robot_json(found: RobotInertia, view: View, checked: Checked) -> str:
    """Return the robot as one body in the frame of its base, every link with an <inertial>, and what a check says."""
    from robodyn.report.check_words import check_data

    links = [
        {**_declared(link), "pose": _pose(link.pose), "com_in_base": link.placed.com.tolist()} for link in found.links
    ]
    check, valid = check_data(checked), validity_data(validity(found.body))
    return written(
        {
            **select(found, "robot:name file at"),
            **body_data(found.body, view),
            **select(
                found,
                "validity check links_with_mass:massive links warnings",
                validity=valid,
                check=check,
                links=links,
            ),
        }
    )


def link_json(robot: str, found: LinkInertia, view: View, checked: Checked) -> str:
    """Return what a link declares, and what a check says of it."""
    from robodyn.report.check_words import check_data

    return written({"robot": robot, **_declared(found, view), "check": check_data(checked), "warnings": found.warnings})


def link_shapes_json(robot: str, found: LinkShapes, view: View) -> str:
    """Return what the shapes of a link make."""
    return written(
        {
            "robot": robot,
            **select(found, "link:name line geometry:kind"),
            **body_data(found.body, view),
            "validity": validity_data(validity(found.body)),
            "box": _box(found.shapes.box),
            "meshes": [part.name for part in found.shapes.parts],
            "warnings": found.shapes.remarks,
        }
    )


def comparison_json(found: Comparison) -> str:
    """Return all links, the most different first, then those that could not be compared, with the reason."""
    return written(select(found, "robot:name file geometry:kind links", links=list(map(_compared, found.links))))


def body_data(body: MassProperties, view: View = COM) -> dict[str, Any]:
    """Return the mass properties of a body; principal axes are rows."""
    about = dict(zip(("point", "matrix"), view.inertia(body), strict=True))
    return select(
        body,
        "mass volume area density com inertia inertia_about principal",
        inertia_about=about,
        principal=select(body.principal, "moments axes"),
    )


def part_data(part: Part, view: View = COM) -> dict[str, Any]:
    """Return what there is to say of one mesh."""
    error: dict[str, Any] = {"arithmetic": finite(part.arithmetic), "rounding": finite(part.rounding)}
    error |= {"tessellation": _tessellation(part), "union": part.union}
    return {
        **select(part, "name triangles"),
        **body_data(part.body, view),
        **select(
            part,
            "symmetry box closed repairs error arithmetic:method notes warnings",
            symmetry=_symmetry(part),
            box=_box((part.lo, part.hi)),
            error=error,
        ),
    }


def _symmetry(part: Part) -> dict[str, Any] | None:
    """Return planes, axes and products [kg m^2]; the fold of an axis of revolution is null."""
    found, density = part.symmetry, part.body.density or 0.0
    if found is None:
        return None
    return {
        "planes": [select(plane, "normal offset asymmetry verdict") for plane in found.planes],
        "axes": [select(axis, "direction point fold asymmetry verdict", fold=finite(axis.fold)) for axis in found.axes],
        "products": [
            select(each, "axes computed relative zero_by_symmetry:zero", computed=-each.residual * density)
            for each in found.products
        ],
    }


def _tessellation(part: Part) -> dict[str, Any] | None:
    """Return numbers of the mesh beside those of the smooth body.

    Bars are relative, of the centre in metres; null where nothing can be said. `bar_corners_on_surface` is that of the
    corrected numbers if the corners lie on the smooth surface, `bar_corrected` wherever they lie.
    """
    found, smooth = part.tessellation, part.corrected
    if found is None or smooth is None:
        return None
    volume = {"mesh": part.body.volume, "corrected": smooth.volume}
    return {
        "volume": {**volume, **_bars(found, lambda bars: bars.volume)},
        "inertia": {"corrected": smooth.inertia, **_bars(found, lambda bars: bars.inertia)},
        "com": {"corrected": smooth.com, **_bars(found, lambda bars: bars.centre * part.body.gyration)},
    }


def _bars(found: Tessellation, of: Callable[[Bars], float]) -> dict[str, float | None]:
    bars = (found.mesh, found.rest, found.on_surface)
    return dict(zip(("bar", "bar_corrected", "bar_corners_on_surface"), map(finite, map(of, bars)), strict=True))


def validity_data(found: Validity) -> dict[str, Any]:
    """Return whether a body can exist, with the margin."""
    return select(found, "physical slack faults", physical=not found.faults)


def _declared(link: LinkInertia, view: View = COM) -> dict[str, Any]:
    return {**select(link, "link:name line"), **body_data(link.body, view), "validity": validity_data(link.validity)}


def _compared(link: LinkComparison) -> dict[str, Any]:
    declared, difference = link.declared, link.difference
    return select(
        link,
        "link:name line shapes declared derived difference reason remarks",
        shapes=list(map(_shape, link.shapes)),
        declared=declared and {**body_data(declared.body), "validity": validity_data(declared.validity)},
        derived=difference and _derived(difference),
        difference=difference and _difference(difference),
    )


def _shape(shape: Shape) -> dict[str, Any]:
    keys = "shape line size filename file scale xyz:origin.xyz rpy:origin.rpy"
    return select(shape.geometry, keys, file=shape.path)


def _derived(found: Difference) -> dict[str, Any]:
    meshes = [part_data(part) for part in found.shapes.parts]
    return {**body_data(found.body), "box": _box(found.shapes.box), "meshes": meshes}


def _difference(found: Difference) -> dict[str, Any]:
    return select(
        found,
        "density com_distance:distance com_offset:offset moment_ratios inertia box_spread",
        density=finite(found.density),
        moment_ratios=[finite(ratio) for ratio in found.ratios],
        box_spread=finite(found.room),
    )


def _box(ends: Sequence[Any]) -> dict[str, Any]:
    return dict(zip(("lo", "hi"), encode(list(ends)), strict=True))


def _pose(pose: Sequence[Any]) -> dict[str, Any]:
    return dict(zip(("rotation", "origin"), encode(list(pose)), strict=True))
