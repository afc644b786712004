"""Identities that dynamics with any effect satisfy: forward against inverse, derivatives, energy, composite bodies."""

from __future__ import annotations

import numpy as np

import robodyn
from helpers.oracles import worst
from robodyn.dynamics.derivatives import forward_dynamics_derivatives, inverse_dynamics_derivatives
from robodyn.dynamics.effects import rigid_bodies
from robodyn.dynamics.effects.effect import Sample
from robodyn.dynamics.plan import applied
from robodyn.dynamics.recursions.composite_body import composite_body
from robodyn.dynamics.recursions.elimination import aligned


def forward_is_the_inverse_of_inverse(model, scene, state, columns):
    """Forward dynamics by both executors, and tau = M qdd + b."""
    q, qd, qdd = state
    given = {"scene": scene, "columns": columns}
    tau = robodyn.inverse_dynamics(model, *state, **given)
    for executor in ("numpy", "compiled"):
        assert worst(robodyn.forward_dynamics(model, q, qd, tau, executor=executor, **given), qdd) <= 1e-11
    M, b = robodyn.mass_matrix(model, q, scene=scene), robodyn.bias_forces(model, q, qd, **given)
    assert worst(np.einsum("kij,kj->ki", M, qdd) + b, tau) <= 1e-13


def derivatives_are_differences(model, scene, state, columns):
    """Derivatives by q where its entries add up, by qd and by qdd; those of forward dynamics are the inverse."""
    q, qd, qdd = state
    given, step = {"scene": scene, "columns": columns}, 1e-6
    inverse = inverse_dynamics_derivatives(model, *state, **given)
    assert worst(inverse.dqdd, robodyn.mass_matrix(model, q, scene=scene)) <= 1e-13
    for k in range(model.n):
        move = step * np.eye(model.n)[k]
        ends = {"dqd": [(q, qd + move, qdd), (q, qd - move, qdd)]}
        if not model.floating:
            ends["dq"] = [(q + move, qd, qdd), (q - move, qd, qdd)]
        for name, moved in ends.items():
            up, down = (robodyn.inverse_dynamics(model, *each, **given) for each in moved)
            found = getattr(inverse, name)
            assert worst(found[..., k], (up - down) / (2 * step), np.abs(found).max()) <= 1e-8
    tau = robodyn.inverse_dynamics(model, *state, **given)
    forward = forward_dynamics_derivatives(model, q, qd, tau, **given)
    found = np.einsum("kij,kjl->kil", inverse.dqdd, forward.dtau)
    assert worst(found, np.broadcast_to(np.eye(model.n), found.shape)) <= 1e-9


def kinetic_energy_is_that_of_the_mass_matrix(model, scene, q, qd):
    M = robodyn.mass_matrix(model, q, scene=scene)
    kinetic = robodyn.momenta(model, q, qd, scene=scene).kinetic
    assert worst(kinetic, 0.5 * np.einsum("ki,kij,kj->k", qd, M, qd)) <= 1e-13


def composite_bodies_give_the_mass_matrix(model, scene, states, rotors):
    """The recursion of composite bodies against that of unit accelerations; rotors: sample -> what they add."""
    straight = aligned(model)
    for q in states:
        sample = Sample(straight, tuple(q.tolist()), (0.0,) * model.n, (0.0,) * model.n)
        inertias = applied([rigid_bodies.PAYLOAD], sample, scene).inertias
        M = np.zeros((model.n, model.n))
        for (i, j), value in composite_body(straight, sample.motions(), inertias, rotors(sample)).items():
            M[i, j] = M[j, i] = value
        assert worst(M, robodyn.mass_matrix(model, q, scene=scene)) <= 1e-13
