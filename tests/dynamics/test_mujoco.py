"""MuJoCo's inverse dynamics, with damping, Coulomb friction and armature, on robots with inertias that it accepts.

`qfrc_inverse = M qacc + bias - passive - constraint` is what the actuators must supply. Friction loss is a constraint
whose force saturates at `frictionloss`; at speeds well above zero that is Coulomb's law.
"""

from __future__ import annotations

import numpy as np
import pytest
from helpers.oracles import random_state, worst
from helpers.peers import mujoco
from helpers.small_robots import built, joint, link, random_tree_parts, urdf

from robodyn.dynamics.inverse import inverse_dynamics
from robodyn.dynamics.mass import mass_matrix
from robodyn.robot.load import load
from robodyn.scene.parts import Friction, Rotor
from robodyn.scene.scene import Scene

KINDS = ("revolute", "prismatic", "continuous")


class MujocoRobot:
    """A description as MuJoCo reads it, without limits; joints by name."""

    def __init__(self, text, names):
        spec = mujoco.MjSpec.from_string(text.decode())
        for one in spec.joints:
            one.limited = 0
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        self.dofs = np.array([self.model.joint(name).dofadr[0] for name in names])
        self.places = [self.model.joint(name).qposadr[0] for name in names]

    def inverse(self, q, qd, qdd):
        return np.array([self._one(*row) for row in zip(q, qd, qdd, strict=True)])

    def _one(self, q, qd, qdd):
        self.data.qpos[self.places], self.data.qvel[self.dofs], self.data.qacc[self.dofs] = q, qd, qdd
        mujoco.mj_inverse(self.model, self.data)
        return self.data.qfrc_inverse[self.dofs].copy()

    def mass_matrix(self, q):
        self.data.qpos[self.places] = q
        mujoco.mj_forward(self.model, self.data)
        columns = np.zeros((self.model.nv, self.model.nv))
        for column, unit in zip(columns, np.eye(self.model.nv), strict=True):
            mujoco.mj_mulM(self.model, self.data, column, unit)
        return columns[np.ix_(self.dofs, self.dofs)]


def _pair(seed):
    text = urdf(*random_tree_parts(np.random.default_rng(seed), 7, kinds=KINDS))
    model = load(text)
    return model, MujocoRobot(text, model.joint_names)


@pytest.mark.parametrize("seed", range(4))
def test_torques(seed):
    model, other = _pair(seed)
    state = random_state(model, np.random.default_rng(seed), 10)
    assert worst(inverse_dynamics(model, *state), other.inverse(*state)) <= 1e-13


@pytest.mark.parametrize("seed", range(4))
def test_damping_friction_and_armature(seed):
    model, other = _pair(seed)
    rng = np.random.default_rng(seed)
    damping, loss, armature = rng.uniform(0.1, 2, (3, model.n))
    for name, values in (("damping", damping), ("frictionloss", loss), ("armature", armature)):
        getattr(other.model, f"dof_{name}")[other.dofs] = values
    friction = {name: Friction(d, f, -f) for name, d, f in zip(model.joint_names, damping, loss, strict=True)}
    rotor = {name: Rotor(a / 50**2, -50.0) for name, a in zip(model.joint_names, armature, strict=True)}
    scene = Scene(friction=friction, rotor=rotor)
    q, qd, qdd = random_state(model, rng, 10)
    qd += np.sign(qd)
    assert worst(inverse_dynamics(model, q, qd, qdd, scene=scene), other.inverse(q, qd, qdd)) <= 1e-13
    assert worst(mass_matrix(model, q[0], scene=scene), other.mass_matrix(q[0])) <= 1e-13


def test_damping_and_friction_of_the_description():
    """Both read the same attributes of <dynamics>."""
    parts = [link("base"), link("l1", 2, (0.5, 0, 0), (0.1, 0, 0, 0.1, 0, 0.1))]
    parts += [link("l2", 1, (0.5, 0, 0), (0.1, 0, 0, 0.1, 0, 0.1))]
    parts += [joint("j1", "base", "l1", axis=(0, 1, 0), more='<dynamics damping="3" friction="5"/>')]
    parts += [joint("j2", "l1", "l2", axis=(0, 1, 0), xyz=(1, 0, 0), more='<dynamics damping="0.3" friction="0.5"/>')]
    model, other = built(*parts), MujocoRobot(urdf(*parts), ("j1", "j2"))
    state = np.zeros((2, 2)), np.array([[1.0, 2.0], [-1.0, 3.0]]), np.zeros((2, 2))
    assert worst(inverse_dynamics(model, *state), other.inverse(*state)) <= 1e-13
