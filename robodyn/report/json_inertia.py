"""Mass properties of parts as one JSON document with stable keys and full precision."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from robodyn.inertia.view import View
from robodyn.part import Part


def inertia_json(parts: Sequence[Part], view: View) -> str:
    """The document: {"meshes": [...]}. Units are SI; matrices are lists of rows; principal axes are rows."""
    import json

    return json.dumps({"meshes": [_part(part, view) for part in parts]}, indent=2, allow_nan=False) + "\n"


def _part(part: Part, view: View) -> dict[str, Any]:
    body = part.body
    point, matrix = view.inertia(body)
    return {
        "name": part.name,
        "triangles": part.triangles,
        "mass": body.mass,
        "volume": body.volume,
        "area": body.area,
        "density": body.density,
        "com": body.com.tolist(),
        "inertia": body.inertia.tolist(),
        "inertia_about": {"point": point.tolist(), "matrix": matrix.tolist()},
        "principal": {"moments": body.principal.moments.tolist(), "axes": body.principal.axes.tolist()},
        "box": {"lo": part.lo.tolist(), "hi": part.hi.tolist()},
        "closed": part.closed,
        "repairs": [asdict(step) for step in part.repairs],
        "error": {"arithmetic": _finite(part.arithmetic), "rounding": _finite(part.rounding)},
        "arithmetic": part.method,
        "notes": list(part.notes),
        "warnings": list(part.warnings),
    }


def _finite(value: float) -> float | None:
    return value if value < float("inf") else None
