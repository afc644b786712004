"""The recursive Newton-Euler algorithm (RNEA), once, for any scalar: wrenches and torques."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from robodyn.programs.vectors import ZERO, Array, Scalar, cross, skew, vector
from robodyn.robot.kinematics import Motion, Wrench
from robodyn.robot.model import Joint, Model
from robodyn.solids.inertia.laws import Inertia


def newton_euler(
    parents: Sequence[int],
    motions: Sequence[Motion],
    inertias: Sequence[Inertia],
    gravity: Array = ZERO,
    wrenches: Iterable[tuple[int, Wrench]] = (),
) -> list[Wrench]:
    """Return the wrench that each body's parent exerts on it, from the motion of the joints.

    Outward, from the base to the tips, in body axes (j is the parent of i, R and p its joint's rotation and offset):
    `w_i = R^T w_j + w_J`, `wd_i = R^T wd_j + R^T w_j x w_J + wd_J`, `a_i = R^T (a_j + U_j p) + 2 R^T w_j x v_J + a_J`
    with `U = [wd] + [w][w]`: the point r of a body accelerates by `a + U r`. Gravity is an upward acceleration of the
    ground. Inward, Euler's laws about the body's origin: `f_i = m a + U m c - f_ext + sum R f`, `n_i = m c x a + I wd +
    w x I w - n_ext + sum (R n + p x R f)`.

    Source: Luh, Walker and Paul (1980); U and m c as in Khalil and Dombre, *Modeling, Identification and Control of
        Robots* (2002), ch. 9.

    Args:
        parents: parents[i] < i is the body that carries body i; -1 is the ground. motions: relative to the parent.
        gravity: (3,) m/s^2, in the ground's axes.
        wrenches: (i, wrench) that act ON body i, like those returned about its origin and in its axes.

    Accuracy: 1e-14 of the largest wrench for chains of up to 100 bodies.
    """
    each = inertial_wrenches(parents, motions, inertias, gravity)
    f, n = [wrench.f for wrench in each], [wrench.n for wrench in each]
    for i, wrench in wrenches:
        f[i], n[i] = f[i] - wrench.f, n[i] - wrench.n
    for i in reversed(range(len(parents))):
        if (j := parents[i]) >= 0:
            R, p = motions[i].R, motions[i].p
            f_in = R @ f[i]
            f[j], n[j] = f[j] + f_in, n[j] + R @ n[i] + cross(p, f_in)
    return [Wrench(*pair) for pair in zip(f, n, strict=True)]


def inertial_wrenches(
    parents: Sequence[int], motions: Sequence[Motion], inertias: Sequence[Inertia], gravity: Array = ZERO
) -> list[Wrench]:
    """Return the wrench that moves each body by itself: the outward half of `newton_euler`, with the same arguments."""
    w: list[Array] = []
    wd: list[Array] = []
    a: list[Array] = []
    U: list[Array] = []
    f: list[Array] = []
    n: list[Array] = []
    for j, joint, body in zip(parents, motions, inertias, strict=True):
        w_j, wd_j, a_j, U_j = (w[j], wd[j], a[j], U[j]) if j >= 0 else (ZERO, ZERO, -gravity, skew(ZERO))
        w_in = joint.R.T @ w_j
        w.append(w_in + joint.w)
        wd.append(joint.R.T @ wd_j + cross(w_in, joint.w) + joint.wd)
        a.append(joint.R.T @ (a_j + U_j @ joint.p) + 2.0 * cross(w_in, joint.v) + joint.a)
        U.append(skew(wd[-1]) + skew(w[-1]) @ skew(w[-1]))
        f.append(a[-1] * body.m + U[-1] @ body.mc)
        n.append(cross(body.mc, a[-1]) + euler(body.I, w[-1], wd[-1]))
    return [Wrench(*pair) for pair in zip(f, n, strict=True)]


def euler(I: Array, w: Array, wd: Array) -> Array:
    """Return the moment I wd + w x (I w) that turns a body: Euler's second law about its mass centre or a fixed point.
    By entries of I, in the body's axes: 30 operations instead of 42, and few for a diagonal I. Accuracy: 8 eps (|I|
    |wd| + |I| |w|^2)."""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = I
    x, y, z = w
    dx, dy, dz = wd
    return vector(
        xx * dx + (zz - yy) * (y * z) - xy * (x * z - dy) + xz * (x * y + dz) + yz * (y * y - z * z),
        yy * dy + (xx - zz) * (x * z) - yz * (x * y - dz) + xy * (y * z + dx) + xz * (z * z - x * x),
        zz * dz + (yy - xx) * (x * y) - xz * (y * z - dx) + yz * (x * z + dy) + xy * (x * x - y * y),
    )


def along_joint(joint: Joint, reaction: Wrench) -> Scalar:
    """Return the part of a wrench along a joint's axis: revolute `axis . n`, prismatic `axis . f`."""
    along: Scalar = joint.axis @ (reaction.n if joint.kind == "revolute" else reaction.f)
    return along


def joint_torques(
    model: Model, motions: Sequence[Motion], reactions: Sequence[Wrench], at_joint: Mapping[int, Scalar]
) -> list[Scalar]:
    """Return the generalized force along every coordinate: tau = S^T (f, n) + what acts at the joint itself,
    `at_joint`. A floating joint gives the moment in the body's axes and the force in the parent's, which are dual to
    its rates. A mimic joint's torque is reflected onto its leader by its multiplier."""
    tau: list[Scalar] = [0.0] * model.n
    for i, body in enumerate(model.bodies):
        joint, reaction = body.joint, reactions[i]
        if joint.kind == "floating":
            force = joint.R.T @ (motions[i].R @ reaction.f)
            tau[joint.rate : joint.rate + 6] = [*reaction.n, *force]
        elif joint.kind != "fixed":
            along = along_joint(joint, reaction)
            tau[joint.rate] = tau[joint.rate] + joint.multiplier * (along + at_joint.get(i, 0.0))
    return tau
