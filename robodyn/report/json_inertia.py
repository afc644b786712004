"""Mass properties of parts as one JSON document with stable keys and full precision."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from robodyn.errors import MeshError
from robodyn.report.json_body import COM, body_data, finite
from robodyn.report.json_shape import symmetry_data, tessellation_data
from robodyn.solids.inertia.view import View
from robodyn.solids.mesh_mass import Part


def inertia_json(outcomes: Sequence[Part | MeshError], view: View) -> str:
    """The document: {"meshes": [...]}. Units are SI; matrices are lists of rows; principal axes are rows.

    Of a mesh that failed there are its `name` and, as a text, the `error` alone.
    """
    import json

    meshes = [_failed(each) if isinstance(each, MeshError) else part_data(each, view) for each in outcomes]
    return json.dumps({"meshes": meshes}, indent=2, allow_nan=False) + "\n"


def _failed(error: MeshError) -> dict[str, Any]:
    return {"name": error.file, "error": error.sentence}


def part_data(part: Part, view: View = COM) -> dict[str, Any]:
    """What the document says of one mesh."""
    return {
        "name": part.name,
        "triangles": part.triangles,
        **body_data(part.body, view),
        "symmetry": symmetry_data(part),
        "box": {"lo": part.lo.tolist(), "hi": part.hi.tolist()},
        "closed": part.closed,
        "repairs": [asdict(step) for step in part.repairs],
        "error": {
            "arithmetic": finite(part.arithmetic),
            "rounding": finite(part.rounding),
            "tessellation": tessellation_data(part),
            "union": part.union,
        },
        "arithmetic": part.method,
        "notes": list(part.notes),
        "warnings": list(part.warnings),
    }
