"""The DAE form as one JSON document with stable keys and full precision."""

from __future__ import annotations

from typing import Any

import numpy as np

from robodyn.equations.dae.connections import Connection
from robodyn.equations.dae.dae import Dae
from robodyn.equations.dae.equations import Equation
from robodyn.equations.dae.system import about_centre


def dae_json(found: Dae) -> str:
    """The document; what is not defined where nothing resists some motion is null."""
    import json

    robot, counts, solution = found.robot, found.counts, found.solution
    document = {
        "robot": robot.model.name,
        "form": "dae",
        "gravity": robot.scene.gravity,
        "coordinates": robot.model.coordinates,
        "rates": robot.model.rates,
        "q": found.q.tolist(),
        "qd": found.qd.tolist(),
        "tau": found.tau.tolist(),
        "counts": {
            "bodies": counts.bodies,
            "positions": 6 * counts.bodies,
            "velocities": 6 * counts.bodies,
            "reactions": counts.reactions,
            "equations": counts.unknowns,
            "rank": counts.rank,
            "degrees_of_freedom": counts.freedom,
            "redundant": [list(names) for names in counts.redundant],
            "undetermined": [list(names) for names in counts.undetermined],
            "coefficient_ranks": counts.coefficients,
            "coefficient_size": counts.size,
            "index": _index(found),
        },
        "bodies": [_body(found, i) for i in range(counts.bodies)],
        "connections": _connections(found),
        "residual": {name: _largest(part) for name, part in found.residuals._asdict().items()},
        "qdd": None if solution is None or found.qdd is None else found.qdd.tolist(),
        "elimination": _elimination(found),
        "comparison": _comparison(found),
        "warnings": found.warnings,
    }
    return json.dumps(document, indent=2, allow_nan=False) + "\n"


def _index(found: Dae) -> dict[str, int] | None:
    index = found.counts.index
    return None if index is None else dict(zip(("positions", "velocities", "accelerations"), index, strict=True))


def _largest(values: Any) -> float:
    return float(np.abs(values).max(initial=0.0))


def _body(found: Dae, i: int) -> dict[str, Any]:
    robot, solution = found.robot, found.solution
    inertia, place, speed = robot.system.inertias[i], robot.at.places[i], robot.at.speeds[i]
    a = None if solution is None else solution.a[6 * i : 6 * i + 6].tolist()
    wrench = found.wrenches[i] if found.wrenches else None
    return {
        "name": robot.model.bodies[i].name,
        "mass": float(inertia.m),
        "com": inertia.centre_of_mass.tolist(),
        "inertia": about_centre(inertia).tolist(),
        "rotation": place.R.tolist(),
        "centre": (place.c - robot.at.places[-1].c).tolist(),
        "w": speed.w.tolist(),
        "v": speed.v.tolist(),
        "f": robot.matrices.f[6 * i : 6 * i + 6].tolist(),
        "wd": None if a is None else a[:3],
        "vd": None if a is None else a[3:],
        "joint_wrench": None if wrench is None else {"force": wrench.f.tolist(), "moment": wrench.n.tolist()},
    }


def _connections(found: Dae) -> list[dict[str, Any]]:
    robot, counts, out = found.robot, found.counts, []
    row, free, matrices = 0, 0, found.robot.matrices
    for connection in robot.system.connections:
        held = []
        for k, (name, equation) in enumerate(zip(connection.reactions, connection.equations, strict=True), row):
            held.append(
                {
                    "reaction": name,
                    "rows": _rows(found, equation),
                    "gamma": float(matrices.gamma[k]),
                    "g": float(found.residuals.places[k]),
                    "Gv": float(found.residuals.speeds[k]),
                    "lambda": None if found.solution is None else float(found.solution.reactions[k]),
                    "redundant": (connection.name, name) in counts.redundant,
                    "undetermined": (connection.name, name) in counts.undetermined,
                }
            )
        own = [
            {
                "rows": _rows(found, equation),
                "sigma": float(matrices.sigma[k]),
                "along": float(matrices.along[k]),
                "rotor": float(matrices.armature[k]),
            }
            for k, equation in enumerate(connection.free, free)
        ]
        row, free = row + len(held), free + len(own)
        out.append(_connection(found, connection, held, own))
    return out


def _connection(
    found: Dae, connection: Connection, held: list[dict[str, Any]], own: list[dict[str, Any]]
) -> dict[str, Any]:
    names = [body.name for body in found.robot.model.bodies]
    return {
        "name": connection.name,
        "kind": connection.kind,
        "body": names[connection.body] if connection.body >= 0 else None,
        "other": names[connection.other] if connection.other >= 0 else None,
        "equations": held,
        "coordinates": own,
    }


def _rows(found: Dae, equation: Equation) -> list[dict[str, Any]]:
    """Entries of a row of G or S by number of the body: three for w, three for v."""
    entries: dict[int, Any] = {}
    for body, row in equation.row(found.robot.at):
        if body >= 0:
            entries[body] = entries.get(body, 0.0) + row
    return [{"body": body, "row": row.tolist()} for body, row in entries.items()]


def _elimination(found: Dae) -> dict[str, Any]:
    left = found.reduced
    return {
        "steps": [
            {"title": s.title, "formula": s.formula, "check": s.checks, "error": s.error, "scale": s.scale}
            for s in found.steps
        ],
        "J": left.J.tolist(),
        "Jdot_qd": left.drift.tolist(),
        "M": left.M.tolist(),
        "tau_less_bias": left.free.tolist(),
        "loops": {"G": left.G.tolist(), "gamma": left.gamma.tolist()},
    }


def _comparison(found: Dae) -> dict[str, Any] | None:
    both = found.comparison
    if both is None:
        return None
    return {
        "qdd": both.qdd.tolist(),
        "accelerations": both.accelerations,
        "forces": both.forces,
        "moments": both.moments,
    }
