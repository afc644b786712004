"""Real robots stand, shift their weight and walk: contact forces against Pinocchio, statics and hand-made limits."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from helpers.example_robots import path_of
from helpers.oracles import worst
from helpers.pinocchio_robots import PinocchioRobot
from helpers.walking import WALKERS, sway, walk

import robodyn
from robodyn.dynamics.constraints.constraint_jacobian import columns_of
from robodyn.scene.scene import ExternalWrench

EVERY = ["Go2", pytest.param("TALOS", marks=pytest.mark.slow)]


@cache
def walked(name):
    """Four steps of a quadruped, two of a biped."""
    return walk(WALKERS[name], 17, len(WALKERS[name].feet), 0.1)


@cache
def swaying(name):
    walker = WALKERS[name]
    return sway(walker, 18, 0.2 * walker.stride, 0.05)


@cache
def report(name):
    """What `torques` says of the walk."""
    walker = WALKERS[name]
    return robodyn.torques(walker.model, walked(name).trajectory(walker.scene()), walker.scene()).constraints


@pytest.mark.parametrize("moves", [walked, swaying])
@pytest.mark.parametrize("name", EVERY)
def test_forces_balance_the_base_and_leave_the_torques_that_pinocchio_finds(name, moves):
    walker, motion = WALKERS[name], moves(name)
    model, weight = walker.model, 9.81 * walker.model.total_mass
    found = robodyn.constraint_forces(
        model, motion.q, motion.qd, motion.qdd, scene=walker.scene(), columns=motion.columns
    )
    peer = PinocchioRobot(path_of(walker.stem), free=True)
    expected = peer.torques(model, motion.q, motion.qd, motion.qdd)
    for foot, link in walker.feet.items():
        for row, q in enumerate(motion.q):
            J, _ = peer.point_jacobian(model, q, link, np.mean(walker.sole, axis=0))
            expected[row] -= J.T @ found.wrenches[foot][row]
    assert np.abs(expected[:, :6]).max() <= 1e-10 * weight
    assert worst(found.tau[:, 6:], expected[:, 6:]) <= 1e-10
    assert not found.tau[:, :6].any()


@pytest.mark.parametrize("name", EVERY)
def test_a_walk_keeps_within_friction_and_soles(name):
    found = report(name)
    assert found.balanced
    for contact in found.contacts:
        assert 0.0 <= contact.friction_used.value <= 1.0
        assert contact.least_normal.value >= 0.0
        assert contact.margin is None or contact.margin.value >= 0.0
        assert 0.5 < contact.on < 1.0


@pytest.mark.parametrize("name", EVERY)
def test_a_robot_at_rest_weighs_what_it_weighs(name):
    walker, motion = WALKERS[name], swaying(name)
    weight = 9.81 * walker.model.total_mass
    on = {column: values[0] for column, values in motion.columns.items()}
    found = robodyn.constraint_forces(walker.model, motion.q[0], 0, 0, scene=walker.scene(), columns=on)
    total = sum(wrench[:3] for wrench in found.wrenches.values())
    assert np.abs(total - (0.0, 0.0, weight)).max() <= 1e-12 * weight


def test_the_least_friction_is_just_enough():
    walker, least = WALKERS["Go2"], report("Go2").least_friction
    assert 0.005 < least < 0.7
    for factor, enough in ((1.001, True), (0.999, False)):
        scene = walker.scene(friction=factor * least)
        found = robodyn.torques(walker.model, walked("Go2").trajectory(scene), scene).constraints
        assert found.balanced == enough
        assert {span.kind for span in found.missing} == (set() if enough else {"slip"})


@pytest.mark.parametrize("name", ["Go2", pytest.param("TALOS", marks=pytest.mark.slow)])
def test_ice_under_one_foot_takes_no_force_along_it(name):
    walker, motion = WALKERS[name], swaying(name)
    scene = walker.scene()
    icy, *others = scene.contacts
    scene = replace(scene, contacts=(replace(icy, friction=0.0), *others))
    found = robodyn.torques(walker.model, motion.trajectory(scene), scene).constraints
    assert found.balanced
    assert found.contacts[0].friction_used.value == 0.0
    assert found.contacts[0].force.value == pytest.approx(found.contacts[0].normal.value, rel=1e-12)
    assert found.contacts[1].friction_used.value > 0.0


def pushed(name, force, friction=0.7):
    """What `torques` says of a swaying robot that is pushed at its base, in its own weight, from 1 s to 1.5 s."""
    walker, motion = WALKERS[name], swaying(name)
    weight = 9.81 * walker.model.total_mass
    axes = ("px", "py", "pz")
    wrench = ExternalWrench(link=walker.model.bodies[0].name, force=axes, frame="world")
    scene = replace(walker.scene(friction=friction), wrenches=(wrench,))
    during = (motion.time >= 1.0) & (motion.time <= 1.5)
    more = {axis: weight * part * during for axis, part in zip(axes, force, strict=True)}
    found = robodyn.torques(walker.model, motion.trajectory(scene, more), scene)
    return found, motion.time[during], weight


@pytest.mark.parametrize(
    ("name", "kind", "force", "friction"),
    [
        ("Go2", "slip", (0, 0.08, 0), 0.06),
        ("Go2", "tip", (0, 1.5, 0), 50.0),
        ("Go2", "pull", (0, 0, 1.5), 0.7),
        pytest.param("TALOS", "tip", (0, 1.5, 0), 50.0, marks=pytest.mark.slow),
    ],
)
def test_pushes_that_no_contact_forces_hold(name, kind, force, friction):
    found, during, weight = pushed(name, force, friction)
    (span,) = found.constraints.missing
    assert (span.kind, span.start, span.end) == (kind, during[0], during[-1])
    assert found.constraints.balanced is False
    assert 1e-3 * weight < max(span.force.value, span.moment.value) <= 1.6 * weight
    if kind == "pull":
        assert span.force.value == pytest.approx(0.5 * weight, rel=0.05)
    (caveat,) = found.caveats
    assert "no contact forces balance the motion" in caveat.text
    assert " N m are missing at " in caveat.text


@pytest.mark.parametrize("slope", ["gravity", "normal"])
def test_a_slope_takes_friction_of_its_tangent(slope):
    walker, motion, angle = WALKERS["Go2"], swaying("Go2"), 0.1
    direction = np.array((np.sin(angle), 0.0, np.cos(angle)))
    if slope == "gravity":
        scene = replace(walker.scene(normal=(0.0, 0.0, 1.0)), gravity=tuple((-9.81 * direction).tolist()))
    else:
        scene = walker.scene(normal=tuple(direction.tolist()))
    still = replace(motion, q=np.repeat(motion.q[:1], 3, axis=0), qd=motion.qd[:3] * 0, qdd=motion.qdd[:3] * 0)
    still = replace(still, time=motion.time[:3], columns={key: values[:3] for key, values in motion.columns.items()})
    found = robodyn.torques(walker.model, still.trajectory(scene), scene).constraints
    assert found.balanced
    assert found.least_friction == pytest.approx(np.tan(angle), rel=2e-6)


def test_history_has_what_feet_press_with_and_when_they_are_on():
    walker, motion = WALKERS["Go2"], walked("Go2")
    scene = walker.scene()
    found = robodyn.torques(walker.model, motion.trajectory(scene), scene, history=True)
    samples = dict(zip(found.history.motion.names, found.history.motion.first.T, strict=True))
    np.testing.assert_array_equal(samples["time"], motion.time)
    for contact in found.constraints.contacts:
        on = samples[f"on_{contact.name}"]
        np.testing.assert_array_equal(on, motion.columns[f"on_{contact.name}"])
        normal = samples[columns_of(contact.name)[2]]
        assert normal.max() == contact.normal.value
        assert not normal[on == 0.0].any()
