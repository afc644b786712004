"""A model in axes that suit elimination: hinges and slides along z, the next joint's axis across x."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from robodyn.programs.vectors import cross, length, product, snapped
from robodyn.robot.model import Body, Floats, Frame, Joint, Model
from robodyn.solids.inertia.moments import Inertia

UNDECIDED = 1e-6
"""Axes with a smaller sine between them count as parallel: they decide no direction."""


def aligned(model: Model) -> Model:
    """The same robot with other axes in its bodies; origins stay, and so do q, qd and tau.

    Body i's new axes stand in its old ones as the columns of Q_i: z along its joint, x across this and the axis of the
    first joint that it carries, as Denavit and Hartenberg's. Then `R' = Q_j^T R Q_i` is a turn about x, then one about
    z. Coordinate axes become others without rounding.

    Accuracy: each number of the model within 16 eps of the largest of its vector or matrix.
    """
    first: dict[int, Joint] = {}
    for body in model.bodies[1:]:
        if body.joint.kind in ("revolute", "prismatic"):
            first.setdefault(body.parent, body.joint)
    Q = [_axes(body.joint, first.get(i)) for i, body in enumerate(model.bodies)]
    bodies = tuple(_turned(body, Q[i], Q[body.parent] if i else np.eye(3)) for i, body in enumerate(model.bodies))
    links = {name: Frame(i, product(Q[i].T, R), product(Q[i].T, p)) for name, (i, R, p) in model.links.items()}
    return Model(model.name, model.file, bodies, links, model.notes)


def _axes(joint: Joint, carried: Joint | None) -> Floats:
    """The new axes of the body that `joint` moves, in its old ones; those of a base or a free body stay."""
    if joint.kind not in ("revolute", "prismatic"):
        return np.eye(3)
    z = joint.axis
    x = np.zeros(3) if carried is None else cross(z, product(carried.R, carried.axis))
    if length(x) < UNDECIDED:
        x = np.roll(np.eye(3)[int(np.argmax(np.abs(z)))], 1)
    x = x / length(x)
    x = x - z * (z * x).sum()
    x = snapped(x / length(x))
    return np.stack((x, cross(z, x), z), axis=1)


def _turned(body: Body, Q: Floats, Q_parent: Floats) -> Body:
    m, mc, I = body.inertia
    I = product(Q.T, np.triu(I) + np.triu(I, 1).T, Q)
    R, p, axis = body.joint.R, body.joint.p, body.joint.axis
    joint = replace(
        body.joint,
        R=snapped(product(Q_parent.T, R, Q)),
        p=product(Q_parent.T, p),
        axis=snapped(product(Q.T, axis)),
    )
    return replace(body, joint=joint, inertia=Inertia(m, product(Q.T, mc), 0.5 * (I + I.T)))
