"""Mass matrix and bias, by the same recursion, for any scalar."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robodyn.dynamics.recursions.newton_euler import newton_euler
from robodyn.dynamics.recursions.projection import joint_torques
from robodyn.programs.vectors import Array, Scalar
from robodyn.robot.kinematics import motions
from robodyn.robot.model import Model
from robodyn.solids.inertia.moments import Inertia


def mass_matrix(model: Model, q: Sequence[Scalar], inertias: Sequence[Inertia], armature: Sequence[float]) -> Array:
    """M(q): column j is the torque of a unit acceleration of coordinate j alone, without speed or gravity.

    `M e_j = ID(q, 0, e_j)`; the recursion sees a robot at rest, so a traced column holds only what the bodies beyond
    coordinate j add, and the upper triangle is the lower one's mirror image.

    Args:
        q: nq scalars.
        inertias: of each body.
        armature: n reflected rotor inertias, added on the diagonal [kg m^2].

    Returns:
        (n, n), symmetric by construction.

    Accuracy: 1e-14 of the largest entry.
    """
    n = model.n
    rest = [0.0] * n
    M = np.zeros((n, n), dtype=object)
    for j in range(n):
        unit = [float(k == j) for k in range(n)]
        joints = motions(model, q, rest, unit)
        column = joint_torques(model, joints, newton_euler(model.parents, joints, inertias), {})
        M[j:, j] = M[j, j:] = column[j:]
        M[j, j] = M[j, j] + armature[j]
    return M
