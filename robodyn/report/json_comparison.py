"""Declared against shape-derived mass properties as JSON."""

from __future__ import annotations

from typing import Any

from robodyn.report.json_body import body_data, finite
from robodyn.report.json_composite import validity_data
from robodyn.report.json_inertia import part_data
from robodyn.robot.masses.compare import Comparison, Difference, LinkComparison
from robodyn.robot.urdf.geometry import Shape


def comparison_json(found: Comparison) -> str:
    """All links, the most different first, then those that could not be compared, with the reason."""
    import json

    links = [_link(link) for link in found.links]
    data = {"robot": found.name, "file": found.file, "geometry": found.kind, "links": links}
    return json.dumps(data, indent=2, allow_nan=False) + "\n"


def _link(link: LinkComparison) -> dict[str, Any]:
    declared = link.declared
    return {
        "link": link.name,
        "line": link.line,
        "shapes": [_shape(shape) for shape in link.shapes],
        "declared": None
        if declared is None
        else {**body_data(declared.body), "validity": validity_data(declared.validity)},
        "derived": None if link.difference is None else _derived(link.difference),
        "difference": None if link.difference is None else _difference(link.difference),
        "reason": link.reason,
        "remarks": list(link.remarks),
    }


def _shape(shape: Shape) -> dict[str, Any]:
    geometry = shape.geometry
    return {
        "shape": geometry.shape,
        "line": geometry.line,
        "size": list(geometry.size),
        "filename": geometry.filename,
        "file": None if shape.path is None else str(shape.path),
        "scale": list(geometry.scale),
        "xyz": list(geometry.origin.xyz),
        "rpy": list(geometry.origin.rpy),
    }


def _derived(found: Difference) -> dict[str, Any]:
    box = found.shapes.box
    return {
        **body_data(found.body),
        "box": {"lo": box.lo.tolist(), "hi": box.hi.tolist()},
        "meshes": [part_data(part) for part in found.shapes.parts],
    }


def _difference(found: Difference) -> dict[str, Any]:
    return {
        "density": finite(found.density),
        "com_distance": found.distance,
        "com_offset": found.offset.tolist(),
        "moment_ratios": [finite(ratio) for ratio in found.ratios.tolist()],
        "inertia": found.inertia,
        "box_spread": finite(found.room),
    }
