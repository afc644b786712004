"""The inertia that each joint feels while all the others are free."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from robodyn.checks.context import Context
from robodyn.checks.statics.torque import MOST_BODIES, position_ranges
from robodyn.programs.vectors import product, rotation_about
from robodyn.robot.model import Joint, Model
from robodyn.solids.inertia.laws import about_centre
from robodyn.support.floats import Floats
from robodyn.support.sums import einsum

_WORTH = 1e-2
"""s; damping that is slower than this on the body's own inertia is of no interest."""


def reflected_inertias(context: Context) -> tuple[tuple[Joint, float], ...]:
    """Return (joint, J) of the joints whose damping may be fast; J = 1 / (M^-1)_ii at the middle of the ranges.

    From stage MODEL on. Empty for a robot whose mass matrix is singular, that has a floating joint or more than
    MOST_BODIES bodies.

    Accuracy: M within 1e-12 of its largest entry.
    """
    model = context.model
    joints = list(_damped(model))
    if not joints or model.nq != model.n or len(model.bodies) > MOST_BODIES:
        return ()
    low, high = position_ranges(model)
    inverse = inverse_of_definite(joint_space_inertia(model, (low + high) / 2.0))
    if inverse is None:
        return ()
    return tuple((joint, 1.0 / float(inverse[joint.rate, joint.rate])) for joint in joints)


def inverse_of_definite(M: Floats) -> Floats | None:
    """Return the inverse of a symmetric positive definite matrix; None where it is not.

    Method: the sweep operator, Gauss-Jordan in place. LAPACK's threads wait for each other on a busy machine, where
    they take a hundred times as long.

    Accuracy: 1e-12 of the largest entry times the condition number.
    """
    A = M.copy()
    for k in range(len(A)):
        pivot = A[k, k]
        if not pivot > 0.0:
            return None
        row = A[k] / pivot
        A -= A[:, k, None] * row
        A[k] = A[:, k] = row
        A[k, k] = -1.0 / pivot
    inverse: Floats = -A
    return inverse


def joint_space_inertia(model: Model, q: Floats) -> Floats:
    """Return M(q) = sum of m J_v^T J_v + J_w^T I_c J_w over the bodies, with rotor inertias on the diagonal.

    For one pose this is ready long before the recursion of `robodyn.mass_matrix` is traced.

    Args:
        q: (n,) rad or m, of a robot without floating joints.

    Accuracy: 1e-12 of the largest entry.
    """
    count, n = len(model.bodies), model.n
    R, p = np.zeros((count, 3, 3)), np.zeros((count, 3))
    axes, spin, slide = np.zeros((count, 3)), np.zeros(count), np.zeros(count)
    M = np.zeros((n, n))
    for i, body in enumerate(model.bodies):
        joint, above = body.joint, body.parent
        R0, p0 = (R[above], p[above]) if above >= 0 else (np.eye(3), np.zeros(3))
        R[i], p[i] = product(R0, joint.R), p0 + product(R0, joint.p)
        axes[i] = product(R[i], joint.axis)
        if joint.kind == "revolute":
            R[i] = product(R[i], rotation_about(joint.axis, joint.multiplier * q[joint.coordinate] + joint.offset))
            spin[i] = joint.multiplier
        elif joint.kind == "prismatic":
            p[i] += axes[i] * (joint.multiplier * q[joint.coordinate] + joint.offset)
            slide[i] = joint.multiplier
        if joint.kind != "fixed":
            M[joint.rate, joint.rate] += joint.multiplier**2 * joint.reduction**2 * joint.rotor_inertia
    return M + _kinetic(model, R, p, axes * spin[:, None], axes * slide[:, None])


def _kinetic(model: Model, R: Floats, p: Floats, spins: Floats, slides: Floats) -> Floats:
    """Return the sum over the bodies, from the bodies' places and each joint's angular and linear velocity per rate."""
    on, rates = _carries(model), [max(body.joint.rate, 0) for body in model.bodies]
    centres = np.array([body.inertia.centre_of_mass for body in model.bodies])
    c = p + product(R, centres[:, :, None])[:, :, 0]
    masses = np.array([body.inertia.m for body in model.bodies])
    inertias = np.array(
        [about_centre(b.inertia.I, b.inertia.m, centre) for b, centre in zip(model.bodies, centres, strict=True)]
    )
    turned = product(R, inertias, R.transpose(0, 2, 1))
    J_w, J_v = np.zeros((2, model.n, len(p), 3))
    np.add.at(J_w, rates, (on[:, :, None] * spins[None]).transpose(1, 0, 2))
    arms = np.cross(spins[None], c[:, None] - p[None]) + slides[None]
    np.add.at(J_v, rates, (on[:, :, None] * arms).transpose(1, 0, 2))
    weighed = einsum("kab,jkb->jka", turned, J_w)
    # einsum and not @, whose threads wait for each other on a busy machine
    both: Floats = einsum("ika,jka->ij", J_v * masses[:, None], J_v) + einsum("ika,jka->ij", J_w, weighed)
    return both


def _carries(model: Model) -> Floats:
    """Return (bodies, joints) 1 where a joint carries a body; the base's joint stands still."""
    on = np.eye(len(model.bodies))
    for i, body in enumerate(model.bodies):
        if body.parent >= 0:
            on[i] += on[body.parent]
    return on


def _damped(model: Model) -> Iterator[Joint]:
    for body in model.bodies:
        joint = body.joint
        if joint.kind not in ("revolute", "prismatic") or joint.mimics is not None or not joint.damping > 0.0:
            continue
        own = body.inertia.m if joint.kind == "prismatic" else float(product(joint.axis, body.inertia.I, joint.axis))
        if own < _WORTH * joint.damping:
            yield joint
