"""The articulated-body algorithm (ABA), once, for any scalar."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import hypot

import numpy as np

from robodyn.dynamics.recursions.elimination import Elimination
from robodyn.programs.vectors import ZERO, Array, Scalar, cross, skew
from robodyn.robot.kinematics import Motion, Wrench
from robodyn.robot.model import Joint, Model
from robodyn.solids.inertia.laws import Inertia, symmetric

Turn = tuple[Scalar, Scalar]
"""Cosine and sine of an angle."""


def articulated(body: Inertia) -> Array:
    """((I, [m c]), ([m c]^T, m 1)): what takes (wd, a) of a rigid body to the moment and the force (n, f)."""
    H = skew(body.mc)
    return np.block([[body.I, H], [H.T, body.m * np.eye(3)]])


def at_parent(A: Array, joint: Joint, R: Array, p: Array) -> Array:
    """Return the same inertia in the axes and about the origin of the parent.

    I, H and M become `R I R^T` and so on, by three turns unless the joint is floating, then `H' = H + [p] M` and
    `I' = I + [p] H'^T + ([p] H^T)^T`, p being the origin from the parent's in the parent's axes.
    """
    blocks = [A[:3, :3], A[:3, 3:], A[3:, 3:]]
    if joint.kind == "floating":
        I, H, M = (R @ block @ R.T for block in blocks)
    else:
        outer, middle, inner = turns_of(joint, R)
        blocks = [_about_z(block, *inner) for block in blocks]
        blocks = [np.roll(_about_z(np.roll(block, -1, (0, 1)), *middle), 1, (0, 1)) for block in blocks]  # about x
        I, H, M = (_about_z(block, *outer) for block in blocks)
    shift = skew(p)
    H_p = H + shift @ M
    I_p = symmetric((I + shift @ H_p.T + (shift @ H.T).T)[np.triu_indices(3)])
    return np.block([[I_p, H_p], [H_p.T, M]])


def _about_z(B: Array, c: Scalar, s: Scalar) -> Array:
    """R B R^T for a turn R about z: the plane's trace and its antisymmetric part stay, the rest turns twice as far."""
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = B
    stretch, shear = xx - yy, xy + yx
    sine2, product = s * s, c * s
    e, g = sine2 * stretch + product * shear, product * stretch - sine2 * shear
    return np.array(
        (
            (xx - e, xy + g, c * xz - s * yz),
            (yx + g, yy + e, s * xz + c * yz),
            (c * zx - s * zy, s * zx + c * zy, zz),
        )
    )


def wrench_at_parent(b: Array, R: Array, p: Array) -> Array:
    """Return the same wrench (n, f) about the parent's origin in the parent's axes: `R n + p x R f`, `R f`."""
    f = R @ b[3:]
    return np.concatenate((R @ b[:3] + cross(p, f), f))


AXES = {"fixed": (), "revolute": (2,), "prismatic": (5,), "floating": (0, 1, 2, 3, 4, 5)}
"""The entries of a body's acceleration (wd, a) that each kind of joint adds to, where its axis is z."""


def articulated_body(
    model: Model,
    motions: Sequence[Motion],
    inertias: Sequence[Inertia],
    biases: Sequence[Wrench],
    forces: Sequence[Scalar],
    rotors: Mapping[tuple[int, int], float],
    spins: Sequence[tuple[int, int, Array]] = (),
) -> list[Scalar]:
    """Return how much faster than in `motions` the coordinates accelerate: M^-1 (forces - J^T biases).

    Inward, from the tips to the base, a body answers to an acceleration x = (wd, a) with the wrench `A x + b`. Its
    joint, S being its axis, moves freely: with `U = A S`, `D = S . U + rotor` and `u = force - S . b` its parent feels
    `A - U U^T / D` and `b + U u / D`. Outward, `qdd = (u - U . x) / D`. A coordinate that moves several joints is
    carried inward as a column of its own until a body carries them all, and so is one that a rotor couples with others,
    or with a body whose turning it resists.

    Source: Featherstone, *Rigid Body Dynamics Algorithms* (2008), table 7.1. Bodies accelerate here from what they do
    in `motions`, so that velocities are in `biases` alone; shared coordinates as in Jain, *Robot and Multibody
    Dynamics* (2011), ch. 11.

    Args:
        model: of `aligned`.
        biases: the wrench on each body, in its axes, that `motions` calls for and nothing else supplies.
        forces: n scalars, along the coordinates, those of a floating joint in the body's axes, as is what is returned.
        rotors: reflected rotor inertias, by coordinates i <= j [kg m^2 or kg].
        spins: as those of `Terms`.

    Raises:
        InputError: nothing resists a joint.
    """
    A, b = [articulated(body) for body in inertias], [np.concatenate((bias.n, bias.f)) for bias in biases]
    work, joints_of, ends = Elimination(A, b, rotors, forces), *_coordinates(model, rotors, spins)
    for i, rate, moment in spins:
        work.G[i][rate] = work.G[i].get(rate, 0.0) + np.concatenate((moment, ZERO))
    for i, body in reversed(list(enumerate(model.bodies))):
        joint, (R, p, *_) = body.joint, motions[i]
        own = dict(enumerate(AXES[joint.kind], joint.rate))
        for rate in (rate for rate in ends[i] if rate not in own):
            work.coordinate(i, rate, model.rates[rate])
        for rate, axis in own.items():
            if joints_of[rate] == 1:
                work.axis(i, axis, rate, joint.name)
            else:
                work.join(i, axis, rate, joint.multiplier)
                if rate in ends[i]:
                    work.coordinate(i, rate, model.rates[rate])
        if (j := body.parent) >= 0:
            work.A[j] = work.A[j] + at_parent(work.A[i], joint, R, p)
            work.b[j] = work.b[j] + wrench_at_parent(work.b[i], R, p)
            for rate, column in work.G[i].items():
                work.G[j][rate] = work.G[j].get(rate, 0.0) + wrench_at_parent(column, R, p)
    x: list[Array] = []
    y: list[Scalar] = [0.0] * model.n
    for i, (body, (R, p, *_)) in enumerate(zip(model.bodies, motions, strict=True)):
        wd, a = np.split(x[body.parent] if i else np.zeros(6), 2)
        x.append(np.concatenate((R.T @ wd, R.T @ (a + cross(wd, p)))).astype(object))
        for step in reversed(work.steps[i]):
            step.back(x[i], y)
    return y


def _coordinates(
    model: Model, rotors: Mapping[tuple[int, int], float], spins: Sequence[tuple[int, int, Array]]
) -> tuple[list[int], list[list[int]]]:
    """Return for each coordinate how many joints move with it, and for each body the shared ones that end there.

    A shared coordinate ends at the outermost body that carries all the joints that it moves, and the rotors that spin
    with it; coordinates that rotors couple end together, where a body carries all their joints from below.
    """
    bodies: dict[int, list[int]] = {}
    for i, body in enumerate(model.bodies):
        for rate, _ in enumerate(AXES[body.joint.kind], body.joint.rate):
            bodies.setdefault(rate, []).append(i)
    ends: list[list[int]] = [[] for _ in model.bodies]
    counts = [len(bodies[rate]) for rate in range(model.n)]
    together = list(range(model.n))  # of each coordinate, the first of those that rotors couple with it
    for (i, j), rotor in rotors.items():
        if i != j and rotor:
            low, high = sorted((together[i], together[j]))
            together = [low if each == high else each for each in together]
    for first in sorted(set(together)):
        group = [rate for rate in range(model.n) if together[rate] == first]
        moved = [i for rate in group for i in bodies[rate]]
        if len(group) > 1:
            moved = [model.bodies[i].parent for i in moved]
        moved += [i for i, rate, _ in spins if rate in group]
        for rate in group if len(moved) > 1 else ():
            counts[rate] = len(moved)
            above = set(moved)
            while len(above) > 1:
                last = max(above)
                above = above - {last} | {model.parents[last]}
            ends[above.pop()].append(rate)
    return counts, ends


def turns_of(joint: Joint, R: Array) -> tuple[Turn, Turn, Turn]:
    """Turns about z, x and z that make R; the first two are constants, being those that bring z to the joint's axis."""
    sx, cx, z = float(joint.R[0, 2]), -float(joint.R[1, 2]), float(joint.R[2, 2])
    sine = hypot(sx, cx)
    c, s = (cx / sine, sx / sine) if sine else (1.0, 0.0)
    return (c, s), (z, sine), (c * R[0, 0] + s * R[1, 0], -(c * R[0, 1] + s * R[1, 1]))
