"""Buoyancy and drag by their formulas."""

from __future__ import annotations

import numpy as np
from helpers.busy_robot import busy_robot
from helpers.oracles import EPS, frictionless, random_state, run, worst
from helpers.small_robots import built, joint, link

from robodyn.dynamics.effects import rigid_bodies, wrenches
from robodyn.dynamics.inverse import inverse_dynamics
from robodyn.dynamics.plan import Plan
from robodyn.scene.parts import Immersed, Payload
from robodyn.scene.scene import Scene

WATER = 1000.0


def test_a_body_of_waters_density_weighs_nothing():
    """Buoyancy is the weight of the displaced water at its centre: a payload of that mass, upside down."""
    model = busy_robot(True)
    q = random_state(model, np.random.default_rng(1), 20)[0]
    volume, centre = 1.3e-3, (0.1, -0.2, 0.3)
    still = Scene(gravity=(1.0, 2.0, -9.0))
    bare = inverse_dynamics(model, q, 0, 0, scene=still)
    scene = Scene(
        still.gravity,
        payloads=(Payload("tool", WATER * volume, centre),),
        immersed=(Immersed("tool", volume, centre),),
        fluid_density=WATER,
    )
    assert worst(inverse_dynamics(model, q, 0, 0, scene=scene), bare) <= 16 * EPS


def test_drag_of_a_swinging_paddle():
    model = built(link("base"), link("paddle"), joint("j", "base", "paddle", axis=(0, 0, 1)))
    area, arm = (0.3, 0.5, 0.7), 0.8
    scene = Scene(immersed=(Immersed("paddle", 0.0, (arm, 0, 0), area),), fluid_density=WATER)
    for qd in (2.0, -2.0, 0.0):
        tau = inverse_dynamics(model, [0.4], [qd], [0.0], scene=scene)[0]
        assert worst(tau, 0.5 * WATER * area[1] * abs(qd * arm) * (qd * arm) * arm) <= 4 * EPS


def test_drag_sees_the_velocity_relative_to_the_stream():
    model = built(link("base"), link("hull"), joint("j", "base", "hull", "prismatic", axis=(1, 0, 0)))
    scene = Scene(immersed=(Immersed("hull", drag_area=(0.2, 0, 0)),), fluid_density=WATER, fluid_velocity=(1.5, 9, 9))
    for qd in (-1.0, 0.0, 1.5, 4.0):
        tau = inverse_dynamics(model, [0.0], [qd], [0.0], scene=scene)[0]
        assert worst(tau, 0.1 * WATER * abs(qd - 1.5) * (qd - 1.5), WATER) <= 4 * EPS


def test_drag_takes_power_in_still_water():
    model = busy_robot(True)
    state = random_state(model, np.random.default_rng(2), 50)
    immersed = tuple(Immersed(name, 0.0, (0.1, 0.2, -0.1), (0.3, 0.2, 0.1)) for name in ("l1", "tool", "l6"))
    plan = Plan(model, frictionless(model, immersed=immersed, fluid_density=WATER))
    share = run(plan.share(wrenches.FLUID), plan, *state)
    assert (np.einsum("ij,ij->i", share, state[1]) > 0).all()
    assert rigid_bodies.GRAVITY in plan.effects
