"""Forces of loops and torques of drives against the DAE form; Jacobians of contacts; memory that is not clean."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers.busy_robot import busy_robot
from helpers.closed_chains import bennett, four_bars, spatial_loop
from helpers.dirty_memory import soil
from helpers.driven_chains import moving
from helpers.oracles import random_state, worst

import robodyn
from robodyn.dynamics.constraints.constraint_jacobian import contact_jacobian, loop_jacobian
from robodyn.dynamics.constraints.torque_distribution import structure
from robodyn.dynamics.plan import plan
from robodyn.equations.dae.dae import dae
from robodyn.programs.vectors import cross
from robodyn.scene.scene import Scene


def given_torques(model, scene, **more):
    """The DAE form with random torques of the drives, and nothing elsewhere."""
    drives = scene.actuated or model.joint_names
    torques = dict(zip(drives, np.random.default_rng(0).normal(size=len(drives)).tolist(), strict=True))
    found = dae(model, scene, tau=torques, **more)
    return found, robodyn.constraint_forces(model, found.q, found.qd, found.qdd, scene=scene)


@pytest.mark.parametrize(
    ("kind", "moving_base", "to", "drives"),
    [
        ("point", False, "b2", 4),
        ("hinge", False, "b2", 2),
        ("weld", False, "b2", 1),
        ("weld", True, "b2", 1),
        ("point", True, "ground", 7),
    ],
)
def test_drives_and_loops_in_space(kind, moving_base, to, drives):
    """Bodies on their own accelerate so under torques of the drives; a base on a ball has ways that nothing drives."""
    model, scene = spatial_loop(4, kind, moving_base, to)
    scene = replace(scene, actuated=model.joint_names[-drives:])
    dae_form, found = given_torques(model, scene, qd={model.joint_names[-1]: 1.0})
    (_, on_link), *_ = dae_form.system.loop_wrenches(dae_form.solution.reactions)
    own = robodyn.forward_kinematics(model, dae_form.q, "a3").R
    other = np.eye(3) if to == "ground" else robodyn.forward_kinematics(model, dae_form.q, to).R
    moment = on_link.n - cross(np.array(scene.loops[0].point), on_link.f)
    expected = [other.T @ own @ part for part in (on_link.f, moment)]
    assert worst(found.tau, dae_form.tau, np.abs(expected).max()) <= 1e-11
    assert worst(found.wrenches["tie"], np.concatenate(expected)) <= 1e-11


@pytest.mark.parametrize(("chain", "drive"), [(bennett, "j1"), (lambda **more: four_bars(2, **more), "k0")])
def test_drives_of_loops_with_equations_that_others_imply(chain, drive):
    dae_form, found = given_torques(*chain(actuated=(drive,)), qd={drive: 1.0})
    assert dae_form.counts.redundant
    assert worst(found.tau, dae_form.tau) <= 1e-10


def test_loops_that_are_a_little_open():
    """Bennett's linkage off its loop by 1e-7 rad could not move; what is implied is told by how open it is."""
    model, scene = bennett(actuated=("j1",))
    a_plan, q, passive = plan(model, scene), dae(model, scene).q, np.array([False, True, True])
    closed, off = (loop_jacobian(a_plan, x[None]).J for x in (q, q + 1e-7 * np.array([1.0, -2.0, 3.0])))
    decided, found, expected = structure(off, passive), structure(off, passive, noise=1e-6), structure(closed, passive)
    assert decided.rank + decided.redundancy == 3
    assert (found.rank + found.redundancy, found.overconstrained) == (2, 3)
    assert found.torque_determined.tolist() == expected.torque_determined.tolist()


def test_jacobians_of_contacts_are_those_of_their_points():
    model, rng = busy_robot(True), np.random.default_rng(5)
    points = ((0.1, 0.0, 0.2), (-0.1, 0.3, 0.0), (0.2, 0.1, -0.4))
    a_plan = plan(model, Scene(contacts=(robodyn.Contact("foot", "tool", points),)))
    q, qd, _ = random_state(model, rng, 3)
    found = contact_jacobian(a_plan, q, qd).J.reshape(3, 3, 3, model.n)
    for k, point in enumerate(points):
        assert worst(found[:, k], robodyn.jacobian(model, q, "tool", point)[:, 3:]) <= 1e-13


@pytest.mark.parametrize(("name", "samples"), [("crank_slider", 2), ("delta", 3)])
def test_what_stood_in_memory_is_in_no_torque(name, samples, monkeypatch):
    soil(monkeypatch)
    chain = moving(name, samples, 0)
    tau = robodyn.inverse_dynamics(chain.model, *chain.state, scene=chain.scene)
    np.testing.assert_allclose(tau, chain.torques, rtol=0, atol=1e-13 * np.abs(chain.torques).max())
