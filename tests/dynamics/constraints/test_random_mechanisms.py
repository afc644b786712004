"""Random closed chains against dense equations and Pinocchio; chains of robots/ in memory that is not clean."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from helpers.busy_robot import busy_robot
from helpers.dirty_memory import soil
from helpers.driven_chains import MIDDLE, moving
from helpers.oracles import random_state, worst
from helpers.peers import pin
from helpers.random_mechanisms import COUNT, mechanism
from scipy.spatial.transform import Rotation

import robodyn
from robodyn.dynamics.constraints.constraint_jacobian import contact_jacobian
from robodyn.dynamics.constraints.solve import constraint_forces
from robodyn.dynamics.constraints.torque_distribution import structure
from robodyn.dynamics.plan import plan
from robodyn.scene.scene import GROUND, Scene

SHAPES_AND_DRIVES = [0, 11, 22, 33, 4, 15, 26, 37, 8, 19]
"""Seeds of every shape once, and of every kind of drive."""
SEEDS = [pytest.param(k, marks=[pytest.mark.slow] * (k not in SHAPES_AND_DRIVES)) for k in range(COUNT)]

kept = cache(mechanism)


@pytest.mark.parametrize("seed", SEEDS)
def test_drives_and_loops(seed):
    """Torques of the drives and the loops' wrenches: determined, the least, or the least by weights."""
    one = kept(seed)
    found = constraint_forces(one.model, np.tile(one.q, (len(one.qd), 1)), one.qd, one.qdd, scene=one.scene)
    pairs = [one.solution(*state) for state in zip(one.qd, one.qdd, strict=True)]
    tau, wrenches = (np.array(part) for part in zip(*pairs, strict=True))
    scale = max(np.abs(one.open_torques(*state)).max() for state in zip(one.qd, one.qdd, strict=True))
    assert np.abs(found.tau - tau).max() <= 1e-10 * scale
    got = np.stack([found.wrenches[loop.name] for loop in one.scene.loops], axis=1)
    assert np.abs(got - wrenches).max() <= 1e-10 * np.abs(wrenches).max()


@pytest.mark.parametrize("seed", [8, 18])
def test_loops_that_are_a_little_open(seed):
    """Bennett's linkage off its loop by 1e-7 rad could not move; what is implied is told by how open it is."""
    one = kept(seed)
    off = replace(one, q=one.q + 1e-7 * np.array([1.0, -2.0, 3.0]))
    J = off.rows(np.zeros(3))[0][None]
    decided = structure(J, one.passive)
    assert decided.rank + decided.redundancy == J.shape[2]
    found = structure(J, one.passive, noise=1e-6)
    assert (found.rank + found.redundancy, found.overconstrained) == (J.shape[2] - 1, 3)
    closed = structure(one.rows(np.zeros(3))[0][None], one.passive)
    assert found.torque_determined.tolist() == closed.torque_determined.tolist()


class Pinocchio:
    """A mechanism, bare of all but masses, in Pinocchio."""

    def __init__(self, one):
        self.one, self.model = one, pin.buildModelFromXML(one.text.decode())
        self.data = self.model.createData()
        self.joints = [self.model.joints[self.model.getJointId(f"j{k}")] for k in range(one.n)]
        self.columns = [joint.idx_v for joint in self.joints]
        self.q = pin.neutral(self.model)
        for joint, x in zip(self.joints, one.q, strict=True):
            self.q[joint.idx_q : joint.idx_q + joint.nq] = x if joint.nq == 1 else (np.cos(x), np.sin(x))

    def rates(self, values):
        out = np.zeros(self.model.nv)
        out[self.columns] = values
        return out

    def torques(self, qd, qdd):
        return pin.rnea(self.model, self.data, self.q, self.rates(qd), self.rates(qdd))[self.columns]

    def constraints(self):
        return [self._constraint(loop) for loop in self.one.scene.loops]

    def _constraint(self, loop):
        """In the axes of the loop's other link, which therefore comes first."""
        B = Rotation.from_euler("xyz", loop.rpy).as_matrix() if loop.kind == "weld" else np.eye(3)
        ends = [0 if name == GROUND else self.model.getJointId(f"j{name[1:]}") for name in (loop.to, loop.link)]
        places = pin.SE3(np.eye(3), np.array(loop.to_point)), pin.SE3(B.T, np.array(loop.point))
        kind = pin.ContactType.CONTACT_6D if loop.kind == "weld" else pin.ContactType.CONTACT_3D
        return pin.RigidConstraintModel(kind, self.model, ends[0], places[0], ends[1], places[1], pin.LOCAL)

    def jacobian(self):
        models = self.constraints()
        pin.computeJointJacobians(self.model, self.data, self.q)
        parts = []
        for model in models:
            data = model.createData()
            model.calc(self.model, self.data, data)
            parts.append(pin.getConstraintJacobian(self.model, self.data, model, data))
        return -np.vstack(parts)[:, self.columns]


@pytest.mark.parametrize("seed", [0, 22, 15])
def test_pinocchio(seed):
    """Its tree (`rnea`) and Jacobians of constraints, of point loops and welds."""
    one = kept(seed)
    one = replace(one, scene=Scene(loops=one.scene.loops))
    peer = Pinocchio(one)
    J, _, _ = one.rows(one.qd[0])
    found = peer.jacobian()
    assert found.shape == J.shape
    assert np.abs(found - J).max() <= 1e-13 * np.abs(J).max()
    for state in zip(one.qd, one.qdd, strict=True):
        expected = one.open_torques(*state)
        assert np.abs(peer.torques(*state) - expected).max() <= 1e-13 * np.abs(expected).max()


def test_jacobians_of_contacts_are_those_of_their_points():
    model, rng = busy_robot(True), np.random.default_rng(5)
    points = ((0.1, 0.0, 0.2), (-0.1, 0.3, 0.0), (0.2, 0.1, -0.4))
    a_plan = plan(model, Scene(contacts=(robodyn.Contact("foot", "tool", points),)))
    q, qd, _ = random_state(model, rng, 3)
    found = contact_jacobian(a_plan, q, qd).J.reshape(3, 3, 3, model.n)
    for k, point in enumerate(points):
        assert worst(found[:, k], robodyn.jacobian(model, q, "tool", point)[:, 3:]) <= 1e-13


@pytest.mark.parametrize(("name", "samples"), [(name, 2 + k % 2) for k, name in enumerate(MIDDLE)])
def test_what_stood_in_memory_is_in_no_torque(name, samples, monkeypatch):
    soil(monkeypatch)
    chain = moving(name, samples, 0)
    tau = robodyn.inverse_dynamics(chain.model, *chain.state, scene=chain.scene)
    np.testing.assert_allclose(tau, chain.torques, rtol=0, atol=1e-13 * np.abs(chain.torques).max())
