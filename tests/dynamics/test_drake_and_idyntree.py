"""Drake on a tree of fifteen joints, iDynTree on a free quadruped."""

from __future__ import annotations

import numpy as np
from helpers.example_robots import path_of, real
from helpers.oracles import frictionless, golden_model, random_state, worst
from helpers.peers import peer

from robodyn.dynamics.inverse import inverse_dynamics
from robodyn.dynamics.mass import mass_matrix


def test_drake():
    parsing = peer("pydrake.multibody.parsing")
    multibody = peer("pydrake.multibody.plant")
    model = golden_model("tree15_bf2_skew0.3")
    plant = multibody.MultibodyPlant(0.0)
    parsing.Parser(plant).AddModels(model.file)
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName(model.bodies[0].name))
    plant.Finalize()
    context = plant.CreateDefaultContext()
    order = [plant.GetJointByName(name).velocity_start() for name in model.joint_names]
    state = random_state(model, np.random.default_rng(1), 10)
    expected = []
    for row in zip(*state, strict=True):
        q, qd, qdd = np.zeros((3, model.n))
        q[order], qd[order], qdd[order] = row
        plant.SetPositions(context, q)
        plant.SetVelocities(context, qd)
        M, bias = plant.CalcMassMatrix(context), plant.CalcBiasTerm(context)
        expected.append((M @ qdd + bias - plant.CalcGravityGeneralizedForces(context))[order])
    assert worst(inverse_dynamics(model, *state), expected) <= 1e-13
    assert worst(mass_matrix(model, state[0][-1]), M[np.ix_(order, order)]) <= 1e-13


def _rotation(h):
    """Of a unit quaternion x y z w, as Euler wrote it."""
    x, y, z, w = h
    return np.array(
        [
            [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
        ]
    )


def test_idyntree():
    """Its mixed representation has the base's linear and angular velocity in the ground's axes."""
    idyntree = peer("idyntree.bindings")
    model = real("solo12", True)
    names = list(model.joint_names[1:])
    loader = idyntree.ModelLoader()
    assert loader.loadReducedModelFromFile(str(path_of("solo12")), names)
    robot = idyntree.KinDynComputations()
    assert robot.loadRobotModel(loader.model())
    assert robot.setFrameVelocityRepresentation(idyntree.MIXED_REPRESENTATION)
    assert robot.getFloatingBase() == model.bodies[0].name
    state = random_state(model, np.random.default_rng(2), 10)
    expected = []
    for q, qd, qdd in zip(*state, strict=True):
        pose, R = np.eye(4), _rotation(q[3:7])
        pose[:3, :3], pose[:3, 3] = R, q[:3]
        velocity, acceleration = (np.concatenate((x[3:6], R @ x[:3])) for x in (qd, qdd))
        assert robot.setRobotState(pose, q[7:], velocity, qd[6:], np.array([0, 0, -9.81]))
        out = idyntree.FreeFloatingGeneralizedTorques(robot.model())
        idle = idyntree.LinkWrenches(robot.model())
        idle.zero()
        given = idyntree.VectorDynSize(len(names))
        for k, value in enumerate(qdd[6:]):
            given.setVal(k, float(value))
        base = idyntree.Vector6()
        for k, value in enumerate(acceleration):
            base.setVal(k, float(value))
        assert robot.inverseDynamics(base, given, idle, out)
        wrench = out.baseWrench().asVector().toNumPy()
        expected.append(np.concatenate((R.T @ wrench[3:], wrench[:3], out.jointTorques().toNumPy())))
    assert worst(inverse_dynamics(model, *state, scene=frictionless(model)), expected) <= 1e-13
