"""A description at a glance as one JSON document with stable keys."""

from __future__ import annotations

from typing import Any

from robodyn.checks.overview import Branch, Overview
from robodyn.report.check_words import check_data
from robodyn.report.json_body import finite
from robodyn.robot.urdf.description import Joint, Limit


def overview_json(found: Overview) -> str:
    """The document; links and joints stand depth first, units are SI and radians."""
    import json

    document = {
        "robot": found.name,
        "file": found.file,
        "counts": {
            "links": len(found.branches),
            "links_with_mass": found.massive,
            "joints": sum(found.types.values()),
            "joints_by_type": dict(found.types),
            "mimic_joints": found.mimics,
            "merged_fixed_joints": found.types.get("fixed", 0),
            "degrees_of_freedom": found.freedoms,
            "base_degrees_of_freedom": found.base_freedoms,
        },
        "mass": finite(found.mass),
        "com": None if found.com is None else found.com.tolist(),
        "com_frame": found.base,
        "at": dict(found.at),
        "at_zero": not found.moved,
        "links": [_link(branch) for branch in found.branches],
        "joints": [_joint(branch.joint) for branch in found.branches if branch.joint],
        "meshes": {
            "references": found.meshes.references,
            "files": found.meshes.names,
            "missing": [
                {"link": link, "kind": each.kind, "filename": each.filename, "line": each.line}
                for link, each in found.meshes.missing
            ],
        },
        "check": check_data(found.checked),
        "notes": list(found.notes),
        "next": list(found.next),
    }
    return json.dumps(document, indent=2, allow_nan=False) + "\n"


def _link(branch: Branch) -> dict[str, Any]:
    joint = None if branch.joint is None else branch.joint.name
    return {"name": branch.name, "line": branch.line, "depth": branch.depth, "mass": branch.mass, "joint": joint}


def _joint(joint: Joint) -> dict[str, Any]:
    limit, mimic = joint.limit or Limit(), joint.mimic
    return {
        "name": joint.name,
        "line": joint.line,
        "type": joint.type,
        "parent": joint.parent,
        "child": joint.child,
        "axis": None if joint.type in ("fixed", "floating") else list(joint.axis),
        "lower": limit.lower,
        "upper": limit.upper,
        "effort": limit.effort,
        "velocity": limit.velocity,
        "mimic": mimic and {"joint": mimic.joint, "multiplier": mimic.multiplier, "offset": mimic.offset},
    }
