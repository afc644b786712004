"""Random parameters of bodies that can exist, near those of a description."""

from __future__ import annotations

import numpy as np

from robodyn.dynamics.plan import plan
from robodyn.dynamics.regressor import parameters
from robodyn.identification.parameters.consistent import parameters_of, prior_of, pseudo_inertia
from robodyn.scene.scene import DEFAULT

SIGNS = {"viscous": 1.0, "forward": 1.0, "backward": -1.0, "rotor": 1.0}


def described(model, scene=DEFAULT):
    """Names and values of a robot's parameters, as the regressor has them."""
    names, theta = zip(*parameters(plan(model, scene)), strict=True)
    return names, np.array(theta)


def truth_near(prior, rng, spread=0.3, friction=1.0):
    """Parameters of bodies that can exist, some way from the prior, and of friction and rotors that do not drive."""
    theta = prior.described.copy()
    for body in prior.bodies:
        L = np.linalg.cholesky(pseudo_inertia(prior.theta[body.columns]))
        X = np.eye(4) + spread * rng.normal(size=(4, 4))
        theta[body.columns] = parameters_of(L @ X @ X.T @ L.T)
    for k, name in enumerate(prior.names):
        sign = SIGNS.get(name.rpartition(".")[2])
        if sign is not None:
            theta[k] = sign * rng.uniform(0.1, friction)
    return theta


def calibration(model, seed, spread=0.3, scene=DEFAULT):
    """Names, values as described, and other values that are possible."""
    names, theta = described(model, scene)
    return names, theta, truth_near(prior_of(model, names, theta, shapes=False), np.random.default_rng(seed), spread)
