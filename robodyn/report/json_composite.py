"""Composite bodies as JSON: combined meshes, a link, a robot at a configuration."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from robodyn.report.check_words import check_data
from robodyn.report.json_body import body_data
from robodyn.report.json_inertia import part_data
from robodyn.robot.masses.declared import LinkInertia, RobotInertia
from robodyn.robot.masses.from_shapes import LinkShapes
from robodyn.solids.composite_mass import Combination
from robodyn.solids.inertia.properties import Pose
from robodyn.solids.inertia.validity import Validity, validity
from robodyn.solids.inertia.view import View

if TYPE_CHECKING:
    from robodyn.checks.run import Checked


def combination_json(found: Combination, view: View) -> str:
    """{"meshes": [each in its own axes], "combined": {...}}."""
    whole = body_data(found.body, view)
    box = {"lo": found.box.lo.tolist(), "hi": found.box.hi.tolist()}
    places = [_pose(pose) for pose in found.poses]
    combined = {**whole, "box": box, "places": places, "warnings": list(found.warnings)}
    return _document({"meshes": [part_data(part, view) for part in found.parts], "combined": combined})


def robot_json(found: RobotInertia, view: View, checked: Checked) -> str:
    """The robot as one body in the frame of its base, every link with an <inertial>, and what a check says."""
    links = [
        {**_declared(link), "pose": _pose(link.pose), "com_in_base": link.placed.com.tolist()} for link in found.links
    ]
    return _document(
        {
            "robot": found.name,
            "file": found.file,
            "at": dict(found.at),
            **body_data(found.body, view),
            "validity": validity_data(validity(found.body)),
            "check": check_data(checked),
            "links_with_mass": found.massive,
            "links": links,
            "warnings": list(found.warnings),
        }
    )


def link_json(robot: str, found: LinkInertia, view: View, checked: Checked) -> str:
    """What a link declares, and what a check says of it."""
    check = check_data(checked)
    return _document({"robot": robot, **_declared(found, view), "check": check, "warnings": list(found.warnings)})


def link_shapes_json(robot: str, found: LinkShapes, view: View) -> str:
    """What the shapes of a link make."""
    return _document(
        {
            "robot": robot,
            "link": found.name,
            "line": found.line,
            "geometry": found.kind,
            **body_data(found.body, view),
            "validity": validity_data(validity(found.body)),
            "box": {"lo": found.shapes.box.lo.tolist(), "hi": found.shapes.box.hi.tolist()},
            "meshes": [part.name for part in found.shapes.parts],
            "warnings": list(found.shapes.remarks),
        }
    )


def validity_data(found: Validity) -> dict[str, Any]:
    """Whether a body can exist, with the margin."""
    return {"physical": not found.faults, "slack": found.slack, "faults": list(found.faults)}


def _declared(link: LinkInertia, view: View | None = None) -> dict[str, Any]:
    data = body_data(link.body) if view is None else body_data(link.body, view)
    return {"link": link.name, "line": link.line, **data, "validity": validity_data(link.validity)}


def _pose(pose: Pose) -> dict[str, Any]:
    R, p = pose
    return {"rotation": R.tolist(), "origin": p.tolist()}


def _document(data: dict[str, Any]) -> str:
    import json

    return json.dumps(data, indent=2, allow_nan=False) + "\n"
