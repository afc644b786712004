"""Identities that dynamics with any effect satisfy: forward against inverse, derivatives, energy, composite bodies."""

from __future__ import annotations

import numpy as np

import robodyn
from helpers.oracles import worst
from robodyn.dynamics.effects import rigid_bodies
from robodyn.dynamics.effects.effect import Sample
from robodyn.dynamics.plan import applied
from robodyn.dynamics.recursions.composite_body import composite_body
from robodyn.dynamics.recursions.elimination import aligned


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
