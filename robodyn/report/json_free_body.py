"""Free bodies as one JSON document with stable keys and full precision."""

from __future__ import annotations

from typing import Any

from robodyn.equations.free_body.types import Action, FreeBodies, FreeBody, JointRow
from robodyn.programs.vectors import product


def free_bodies_json(found: FreeBodies, state: str) -> str:
    """The document: vectors in each body's own axes, and forces and moments in the ground's too."""
    import json

    document = {
        "robot": found.robot,
        "file": found.file,
        "state": state,
        "q": found.q,
        "qd": found.qd,
        "qdd": found.qdd,
        "gravity": found.gravity,
        "tau": found.tau,
        "joints": [_joint(row) for row in found.joints],
        "bodies": [_body(body) for body in found.bodies],
        "residual": {"force": found.residual_force, "moment": found.residual_moment},
        "warnings": list(found.warnings),
    }
    return json.dumps(document, indent=2, allow_nan=False) + "\n"


def _joint(row: JointRow) -> dict[str, Any]:
    return {
        "number": row.number,
        "name": row.name,
        "parent": row.parent,
        "child": row.child,
        "kind": row.kind,
        "axis": row.axis.tolist() if row.kind in ("revolute", "prismatic") else None,
        "freedom": row.freedom,
        "reactions": row.reactions,
        "frame": row.child,
        "force": row.force.tolist(),
        "moment": row.moment.tolist(),
        "drive": row.drive,
    }


def _body(body: FreeBody) -> dict[str, Any]:
    return {
        "number": body.number,
        "name": body.name,
        "links": list(body.links),
        "mass": body.mass,
        "com": body.com.tolist(),
        "frame": {"rotation": body.pose.R.tolist(), "origin": body.pose.p.tolist()},
        "actions": [_action(action, body) for action in body.actions],
        "sum": {"force": body.force.tolist(), "moment_about_origin": body.moment.tolist()},
    }


def _action(action: Action, body: FreeBody) -> dict[str, Any]:
    R, p = body.pose
    return {
        "kind": action.kind,
        "what": action.what,
        "by": action.by,
        "point": action.point.tolist(),
        "force": action.force.tolist(),
        "moment": action.moment.tolist(),
        "ground": {
            "point": (p + product(R, action.point)).tolist(),
            "force": product(R, action.force).tolist(),
            "moment": product(R, action.moment).tolist(),
        },
    }
