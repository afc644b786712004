"""Equations of motion as JSON: free bodies, and the ODE, closed and DAE forms."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from robodyn.equations.free_body.types import Action, FreeBodies, FreeBody, JointRow
from robodyn.programs.vectors import product
from robodyn.report.json.encode import encode, finite, select, written

if TYPE_CHECKING:
    from robodyn.equations.closed import Closed
    from robodyn.equations.dae.connections import Connection
    from robodyn.equations.dae.dae import Dae
    from robodyn.equations.dae.equations import Equation
    from robodyn.equations.ode import Ode


def free_bodies_json(found: FreeBodies, state: str) -> str:
    """Return vectors in each body's own axes, and forces and moments in the ground's too."""
    return written(
        select(
            found,
            "robot file state q qd qdd gravity tau joints bodies residual warnings",
            state=state,
            joints=list(map(_joint, found.joints)),
            bodies=list(map(_free_body, found.bodies)),
            residual={"force": found.residual_force, "moment": found.residual_moment},
        )
    )


def _joint(row: JointRow) -> dict[str, Any]:
    keys = "number name parent child kind axis freedom reactions frame:child force moment drive"
    return select(row, keys, axis=row.axis if row.kind in ("revolute", "prismatic") else None)


def _free_body(body: FreeBody) -> dict[str, Any]:
    return select(
        body,
        "number name links mass com frame actions sum",
        frame=select(body.pose, "rotation:R origin:p"),
        actions=[_action(action, body) for action in body.actions],
        sum=select(body, "force moment_about_origin:moment"),
    )


def _action(action: Action, body: FreeBody) -> dict[str, Any]:
    R, p = body.pose
    force, moment = product(R, action.force), product(R, action.moment)
    ground = {"point": p + product(R, action.point), "force": force, "moment": moment}
    return select(action, "kind what by point force moment ground", ground=ground)


def ode_json(ode: Ode) -> str:
    """Return the ODE form; a singular M has the condition null."""
    keys = "robot form gravity coordinates rates units q qd M condition bias shares warnings"
    return written(select(ode, keys, form="ode", condition=finite(ode.cond)))


def closed_json(closed: Closed) -> str:
    """Return the closed form; expressions are SymPy's, fractions exact."""
    from robodyn.equations.closed import STATES

    joints = zip(closed.joints, closed.kinds, map(str, closed.q), map(str, closed.qd), strict=True)
    return written(
        select(
            closed,
            "robot form gravity joints M shares check",
            form="closed",
            joints=[dict(zip(("name", "kind", "q", "qd"), each, strict=True)) for each in joints],
            M=[[str(entry) for entry in row] for row in closed.M],
            shares={name: list(map(str, entries)) for name, entries in closed.bias.items()},
            check={"states": STATES, "largest_difference": closed.error, "not_simplified": closed.plain},
        )
    )


def dae_json(found: Dae) -> str:
    """Return the DAE form; what is not defined where nothing resists some motion is null."""
    robot, both = found.robot, found.comparison
    steps = [select(step, "title formula check:checks error scale") for step in found.steps]
    elimination = select(
        found.reduced,
        "steps J Jdot_qd:drift M tau_less_bias:free loops",
        steps=steps,
        loops=select(found.reduced, "G gamma"),
    )
    return written(
        {
            "robot": robot.model.name,
            "form": "dae",
            "gravity": robot.scene.gravity,
            **select(robot.model, "coordinates rates"),
            **select(found, "q qd tau"),
            "counts": _counts(found),
            "bodies": [_body(found, i) for i in range(found.counts.bodies)],
            "connections": _connections(found),
            "residual": {
                name: float(np.abs(part).max(initial=0.0)) for name, part in found.residuals._asdict().items()
            },
            "qdd": None if found.solution is None else found.qdd,
            "elimination": elimination,
            "comparison": both and select(both, "qdd accelerations forces moments"),
            "warnings": found.warnings,
        }
    )


def _counts(found: Dae) -> dict[str, Any]:
    counts, index = found.counts, found.counts.index
    return select(
        counts,
        "bodies positions velocities reactions equations:unknowns rank degrees_of_freedom:freedom redundant "
        "undetermined coefficient_ranks:coefficients coefficient_size:size index",
        positions=6 * counts.bodies,
        velocities=6 * counts.bodies,
        index=index and dict(zip(("positions", "velocities", "accelerations"), index, strict=True)),
    )


def _body(found: Dae, i: int) -> dict[str, Any]:

    robot, solution = found.robot, found.solution
    inertia, place = robot.system.inertias[i], robot.at.places[i]
    a = None if solution is None else solution.a[6 * i : 6 * i + 6]
    wrench = found.wrenches[i] if found.wrenches else None
    return {
        "name": robot.model.bodies[i].name,
        "mass": float(inertia.m),
        "com": inertia.centre_of_mass,
        "inertia": inertia.about_centre,
        "rotation": place.R,
        "centre": place.c - robot.at.places[-1].c,
        **select(robot.at.speeds[i], "w v"),
        "f": robot.matrices.f[6 * i : 6 * i + 6],
        "wd": None if a is None else a[:3],
        "vd": None if a is None else a[3:],
        "joint_wrench": wrench and select(wrench, "force:f moment:n"),
    }


def _connections(found: Dae) -> list[dict[str, Any]]:
    out, row, free = [], 0, 0
    names = dict(enumerate(body.name for body in found.robot.model.bodies))
    for connection in found.robot.system.connections:
        held = [_held(found, connection, j, row + j) for j in range(len(connection.equations))]
        own = [_free(found, equation, k) for k, equation in enumerate(connection.free, free)]
        row, free = row + len(held), free + len(own)
        ends = {"body": names.get(connection.body), "other": names.get(connection.other)}
        keys = "name kind body other equations coordinates"
        out.append(select(connection, keys, **ends, equations=held, coordinates=own))
    return out


def _held(found: Dae, connection: Connection, j: int, k: int) -> dict[str, Any]:
    """Return equation j of a connection, row k of G."""
    name = connection.reactions[j]
    return {
        "reaction": name,
        "rows": _rows(found, connection.equations[j]),
        "gamma": float(found.robot.matrices.gamma[k]),
        "g": float(found.residuals.places[k]),
        "Gv": float(found.residuals.speeds[k]),
        "lambda": None if found.solution is None else float(found.solution.reactions[k]),
        "redundant": (connection.name, name) in found.counts.redundant,
        "undetermined": (connection.name, name) in found.counts.undetermined,
    }


def _free(found: Dae, equation: Equation, k: int) -> dict[str, Any]:
    matrices = found.robot.matrices
    along = {"sigma": matrices.sigma[k], "along": matrices.along[k], "rotor": np.diag(matrices.armature)[k]}
    return {"rows": _rows(found, equation), **{key: float(value) for key, value in along.items()}}


def _rows(found: Dae, equation: Equation) -> list[dict[str, Any]]:
    """Return entries of a row of G or S by number of the body: three for w, three for v."""
    entries: dict[int, Any] = {}
    for body, row in equation.row(found.robot.at):
        if body >= 0:
            entries[body] = entries.get(body, 0.0) + row
    return [{"body": body, "row": encode(row)} for body, row in entries.items()]
