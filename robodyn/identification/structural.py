"""The base parameters of a model itself: those that torques at any state can tell apart."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from robodyn.dynamics.effects.friction import joints_with_friction
from robodyn.dynamics.regressor import regressor
from robodyn.identification.base import Base, base_of
from robodyn.identification.householder import triangular
from robodyn.robot.model import Model
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import Floats


def structural_base(model: Model, scene: Scene = DEFAULT) -> Base:
    """Return the base parameters of a model in a scene, from the regressor at random states: Y theta = Y_base beta.

    Args:
        model: of a tree; scene: its friction and gravity count, its springs, wrenches and fluids do not.

    Raises:
        SceneError: the scene has loops or contacts.

    Accuracy: `Y[:, independent] matrix` within 1e-10 of the largest entry of each column of Y, at any state.
    """
    rows, names = random_rows(model, scene)
    return base_of(triangular(rows), names)


def random_rows(model: Model, scene: Scene = DEFAULT) -> tuple[Floats, tuple[str, ...]]:
    """Return rows of the regressor at random states, three for each parameter, and the parameters' names.

    Half of the states are slow, so that Stribeck's friction is there.
    """
    rng = np.random.default_rng(19)
    inner = replace(scene, wrenches=(), immersed=())
    still = np.zeros((1, model.n))
    rest = np.zeros(model.nq)
    rest[[first + 3 for _, first in model.quaternions]] = 1.0
    names = regressor(model, rest, still, still, scene=inner, executor="numpy").names
    samples = 2 + 3 * len(names) // max(model.n, 1)
    q = rng.uniform(-2.0, 2.0, (samples, model.nq))
    qd, qdd = rng.uniform(-3.0, 3.0, (2, samples, model.n))
    for _, joint, friction in joints_with_friction(model, scene):
        if friction.stribeck is not None:
            qd[::2, joint.rate] *= friction.stribeck_velocity / 2.0
    return regressor(model, q, qd, qdd, scene=inner).Y.reshape(-1, len(names)), names
