"""The Coriolis matrix: it makes the Coriolis torques, and M' - 2 C is skew-symmetric."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers.busy_robot import BUSY_SCENE, busy_robot
from helpers.exact_rates import exact_rates
from helpers.oracles import frictionless, random_state, robot, tangent, worst
from helpers.robot_catalogue import names
from helpers.sampled import sampled

import robodyn
from robodyn.dynamics.inverse import coriolis_matrix, mass_runner
from robodyn.scene.scene import Scene

SAMPLES = 4
PAYLOADS = Scene(gravity=(0.0, 0.0, 0.0), payloads=BUSY_SCENE.payloads)


@pytest.fixture(params=["busy", "satellite", *sampled(names(), 7)])
def name(request):
    return request.param


@pytest.fixture(params=[False, True], ids=["fixed", "free"])
def case(name, request):
    return (busy_robot(request.param), PAYLOADS) if name == "busy" else (robot(name, request.param), Scene())


def test_it_makes_the_coriolis_torques(case):
    model, scene = case
    q, qd, _ = random_state(model, np.random.default_rng(1), SAMPLES)
    C = coriolis_matrix(model, q, qd, scene=scene)
    bias, rest = (robodyn.bias_forces(model, q, x, scene=_without_friction(model, scene)) for x in (qd, 0.0))
    assert worst((C @ qd[..., None])[..., 0], bias - rest, (np.abs(C) @ np.abs(qd[..., None])).max(initial=0)) <= 1e-13


def test_passivity(case):
    model, scene = case
    q, qd, _ = random_state(model, np.random.default_rng(2), SAMPLES)
    C, n = coriolis_matrix(model, q, qd, scene=scene), model.n
    rates = exact_rates(mass_runner(model, scene).program, [_along(model, q, qd)], {"q": q})[..., 0].astype(float)
    skew = rates.reshape(SAMPLES, n, n) - 2 * C
    assert worst(skew, -np.swapaxes(skew, -1, -2), np.abs(C).max(initial=0)) <= 1e-13


def _without_friction(model, scene):
    return replace(frictionless(model), gravity=scene.gravity, payloads=scene.payloads)


def _along(model, q, qd):
    out = {}
    for speed, way in zip(qd.T, tangent(model, q), strict=True):
        for entry, rate in way.items():
            out[entry] = out.get(entry, 0.0) + rate * speed
    return out
