"""How many operations CasADi's graph of the torques has, beside the textbook's recursion written in CasADi."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.command_line import ROBOTS
from helpers.example_robots import path_of
from helpers.exported import module_of
from helpers.oracles import frictionless, random_state, worst
from helpers.peers import peer

import robodyn

GRAVITY = np.array([0, 0, 0, 0, 0, 9.81])


def spatial_rnea(casadi, model):
    """Featherstone's recursive Newton-Euler algorithm in spatial vectors, for revolute joints, in SX."""

    def cross(x):
        return casadi.skew(x)

    def crm(v):
        w, u = cross(v[:3]), cross(v[3:])
        return casadi.vertcat(casadi.horzcat(w, casadi.SX(3, 3)), casadi.horzcat(u, w))

    q, qd, qdd = (casadi.SX.sym(name, model.n) for name in ("q", "qd", "qdd"))
    v, a, f, X, S, tau = [], [], [], [], [], [None] * model.n
    for body in model.bodies:
        joint, (m, mc, I) = body.joint, body.inertia
        turn, axis = casadi.SX(casadi.DM(np.eye(3))), casadi.sparsify(casadi.DM(np.zeros(3)))
        if joint.kind != "fixed":
            axis, k = casadi.sparsify(casadi.DM(joint.axis)), cross(casadi.sparsify(casadi.DM(joint.axis)))
            turn = turn + casadi.sin(q[joint.coordinate]) * k + (1 - casadi.cos(q[joint.coordinate])) * (k @ k)
        E = casadi.sparsify(casadi.SX(casadi.DM(joint.R)) @ turn).T
        r = casadi.sparsify(casadi.DM(joint.p))
        X.append(casadi.vertcat(casadi.horzcat(E, casadi.SX(3, 3)), casadi.horzcat(-E @ cross(r), E)))
        S.append(casadi.vertcat(axis, casadi.DM(3, 1)))
        first = body.parent < 0
        speed = S[-1] * (qd[joint.rate] if joint.kind != "fixed" else 0)
        more = S[-1] * (qdd[joint.rate] if joint.kind != "fixed" else 0)
        v.append(speed if first else X[-1] @ v[body.parent] + speed)
        before = casadi.sparsify(casadi.DM(GRAVITY)) if first else a[body.parent]
        a.append(X[-1] @ before + more + crm(v[-1]) @ speed)
        h = cross(casadi.sparsify(casadi.DM(mc)))
        inertia = casadi.sparsify(
            casadi.vertcat(casadi.horzcat(casadi.DM(I), h), casadi.horzcat(-h, m * casadi.DM(np.eye(3))))
        )
        f.append(inertia @ a[-1] - crm(v[-1]).T @ (inertia @ v[-1]))
    for i, body in reversed(list(enumerate(model.bodies))):
        if body.joint.kind != "fixed":
            tau[body.joint.rate] = S[i].T @ f[i]
        if body.parent >= 0:
            f[body.parent] = f[body.parent] + X[i].T @ f[i]
    return casadi.Function("tau", [q, qd, qdd], [casadi.vertcat(*tau)])


def operations(casadi, function):
    """How many operations there are; inputs, outputs and constants are none."""
    aside = {casadi.OP_INPUT, casadi.OP_OUTPUT, casadi.OP_CONST}
    return sum(function.instruction_id(k) not in aside for k in range(function.n_instructions()))


@pytest.mark.parametrize(("name", "part"), [("puma560", 0.67), ("ur5_robot", 0.58)])
def test_fewer_operations_than_the_textbook(name, part):
    casadi = peer("casadi")
    model = robodyn.load(path_of(name) if name == "ur5_robot" else ROBOTS / f"{name}.urdf")
    scene = frictionless(model)
    module = module_of(robodyn.export(model, "casadi", scene=scene))
    plain = spatial_rnea(casadi, model)
    state = [x[0] for x in random_state(model, np.random.default_rng(3), 1)]
    tau = robodyn.inverse_dynamics(model, *state, scene=scene)
    for function in (plain, module.torques):
        assert worst(function(*state).full()[:, 0], tau) <= 1e-12
    ours, theirs = operations(casadi, module.torques), operations(casadi, plain)
    assert ours <= part * theirs
