"""Shares add up to the whole, and each scales as its effect does."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers.busy_robot import BUSY_SCENE, busy_robot
from helpers.example_robots import real
from helpers.oracles import EPS, golden_model, random_state, robot, run, worst
from helpers.robot_files import FOLDER

from robodyn.dynamics.effects import rigid_bodies
from robodyn.dynamics.inverse import inverse_dynamics, mass_matrix
from robodyn.dynamics.plan import EFFECTS, Plan
from robodyn.scene.read import load_scene
from robodyn.scene.scene import CoupledMotor, Friction, Rotor, Scene

SAMPLES = 20


def _columns(scene, rng):
    return {name: rng.normal(size=SAMPLES) for name in scene.columns}


SPINNING = {**BUSY_SCENE.rotor, "slide": Rotor(3e-4, -40.0, (0.0, 1.0, 0.2), "tool")}
COUPLED_TOO = replace(
    BUSY_SCENE,
    rotor=SPINNING,
    coupled=(CoupledMotor("m", {"j1": 1.0, "j2": -0.5}, 1e-3, 20.0, Friction(0.3)),),
    friction={**BUSY_SCENE.friction, "j4": replace(BUSY_SCENE.friction["j4"], load=0.1)},
)
SYSTEMS = {
    "busy and coupled": lambda: (busy_robot(), COUPLED_TOO),
    "busy and free": lambda: (busy_robot(True), BUSY_SCENE),
    "gripper": lambda: (robot("gripper"), load_scene(FOLDER / "gripper.toml")),
    "anymal": lambda: (real("anymal", True), Scene()),
}


@pytest.mark.parametrize("name", SYSTEMS)
def test_shares_sum_to_tau(name):
    model, scene = SYSTEMS[name]()
    rng = np.random.default_rng(6)
    state, columns = random_state(model, rng, SAMPLES), _columns(scene, rng)
    tau = inverse_dynamics(model, *state, scene=scene, columns=columns)
    plan = Plan(model, scene)
    table = np.column_stack([*columns.values()]) if columns else None
    shares = {effect.name: run(plan.share(effect), plan, *state, table) for effect in plan.effects}
    assert worst(sum(shares.values()), tau) <= 1e-13
    for share_name, share in shares.items():
        assert share.any() == (share_name != "mimic")


def test_every_effect_is_on_in_the_busy_scene():
    assert [effect.name for effect in Plan(busy_robot(True), COUPLED_TOO).effects] == [
        effect.name for effect in EFFECTS
    ]


SCALES = [1e-8, 1e150]


@pytest.mark.parametrize("scale", SCALES)
def test_coriolis_is_quadratic(scale):
    """By subtraction of gravity the slowest would have errors of 1e-1; its own program has none."""
    model = golden_model("tree15_bf2_skew0.3")
    q, qd, _ = random_state(model, np.random.default_rng(7), 20)
    plan = Plan(model, Scene())
    share, still = plan.share(rigid_bodies.CORIOLIS), np.zeros_like(qd)
    unit = run(share, plan, q, qd, still)
    found = run(share, plan, q, scale * qd, still) / scale / scale
    assert worst(found, unit) <= 1e-15


@pytest.mark.parametrize("scale", SCALES)
def test_inertia_is_linear_and_gravity_too(scale):
    model = golden_model("tree15_bf2_skew0.3")
    q, _, qdd = random_state(model, np.random.default_rng(7), 20)
    plan, still = Plan(model, Scene()), np.zeros_like(qdd)
    share = plan.share(rigid_bodies.INERTIA)
    unit = run(share, plan, q, still, qdd)
    assert worst(run(share, plan, q, still, scale * qdd) / scale, unit) <= 1e-15
    M = mass_matrix(model, q)
    assert worst(np.einsum("ijk,ik->ij", M, qdd), unit) <= 1e-14
    heavy = Plan(model, Scene(gravity=(0, 0, -9.81 * scale)))
    weight = run(plan.share(rigid_bodies.GRAVITY), plan, q, still, still)
    assert worst(run(heavy.share(rigid_bodies.GRAVITY), heavy, q, still, still) / scale, weight) <= 8 * EPS


def test_an_effect_is_the_difference_that_it_makes():
    """But for those that are told apart by what else is on: gravity pulls on payloads and drives buoyancy."""
    model = busy_robot(True)
    rng = np.random.default_rng(10)
    state, columns = random_state(model, rng, SAMPLES), _columns(BUSY_SCENE, rng)
    plan, table = Plan(model, BUSY_SCENE), np.column_stack([*columns.values()])
    whole = run(plan.torques(), plan, *state, table)
    for effect in plan.effects:
        if effect.name not in ("inertia", "coriolis", "moving base", "gravity"):
            difference = whole - run(plan.without(effect), plan, *state, table)
            assert worst(run(plan.share(effect), plan, *state, table), difference, np.abs(whole).max()) <= 1e-14
    weightless = replace(BUSY_SCENE, gravity=(0.0, 0.0, 0.0))
    with_weight, without = (
        run(each.share(rigid_bodies.PAYLOAD), each, *state, table) for each in (plan, Plan(model, weightless))
    )
    difference = whole - run(plan.without(rigid_bodies.GRAVITY), plan, *state, table)
    share = run(plan.share(rigid_bodies.GRAVITY), plan, *state, table) + with_weight - without
    assert worst(share, difference, np.abs(whole).max()) <= 1e-14
