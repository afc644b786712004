"""From places and speeds of single bodies back to the coordinates of the joints."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robodyn.equations.dae.consistent import flat_speeds, projected
from robodyn.equations.dae.equations import stacked, values
from robodyn.equations.dae.posed import Posed, own_rates
from robodyn.equations.dae.state import State
from robodyn.programs.vectors import product
from robodyn.support.ties import first_largest

Floats = NDArray[np.float64]


def coordinates_of(robot: Posed, at: State) -> tuple[Floats, Floats]:
    """q and qd of the joints where the bodies are as in `at`, whose places fulfil the joints' constraints.

    A hinge's turn is the one nearest to that of `robot`; mimic joints are left to their masters.
    """
    model, system = robot.model, robot.system
    qd = own_rates(model, system, product(stacked(system.free, at), flat_speeds(at)).tolist())
    q = np.zeros(model.nq)
    for i, (body, connection) in enumerate(zip(model.bodies, system.joints, strict=True)):
        joint = body.joint
        if joint.kind == "floating":
            R_o = at.places[body.parent].R if body.parent >= 0 else np.eye(3)
            turn = product(joint.R.T, R_o.T, at.places[i].R)
            q[joint.coordinate : joint.coordinate + 7] = [*values(connection.free[3:], at), *quaternion(turn)]
        elif joint.kind != "fixed" and joint.mimics is None:
            q[joint.coordinate] = connection.free[0].value(at)
    return q, np.array(qd)


def quaternion(R: Floats) -> Floats:
    """(x, y, z, w) with w >= 0 of a rotation, by its largest component.

    Source: Shepperd, *Quaternion from rotation matrix* (1978).
    """
    squares = np.array([*(1.0 + 2.0 * np.diag(R) - np.trace(R)), 1.0 + np.trace(R)])
    k = first_largest(squares)
    h = np.empty(4)
    h[3] = squares[3]
    if k == 3:
        h[:3] = R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]
    else:
        i, j = (k + 1) % 3, (k + 2) % 3
        h[k], h[i], h[j], h[3] = squares[k], R[i, k] + R[k, i], R[j, k] + R[k, j], R[j, i] - R[i, j]
    h = h / np.sqrt(product(h, h))
    if abs(h[3]) <= 1e-15:  # half a turn: the largest component is positive, whichever sign rounding gives w
        h[3] = 0.0
    found: Floats = -h if h[3] < 0.0 else h
    return found


def consistent(robot: Posed) -> tuple[Floats, Floats]:
    """q and qd near those of `robot` that fulfil all constraints, loops too; see `consistent.projected`.

    Raises:
        InputError: there are none nearby.
    """
    return coordinates_of(robot, projected(robot.system, robot.at, robot.length))
