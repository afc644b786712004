"""Robots and scenes whose dynamics are exported, what robodyn finds for them, and modules of exported text."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from types import ModuleType

import numpy as np
import pytest

import robodyn
from helpers.busy_robot import BUSY_SCENE, busy_robot
from helpers.command_line import ROBOTS
from helpers.oracles import random_state
from robodyn.scene.scene import DEFAULT

SAMPLES = 6
BUSY = replace(BUSY_SCENE, wrenches=tuple(wrench for wrench in BUSY_SCENE.wrenches if not wrench.columns))


@cache
def named(name, scene=None):
    scene = robodyn.load_scene(ROBOTS / scene) if scene else DEFAULT
    return robodyn.load(ROBOTS / f"{name}.urdf", moving_base=scene.moving_base), scene


CASES = {
    "scara": lambda: named("scara"),
    "puma560": lambda: named("puma560", "puma560_motors.toml"),
    "mimic": lambda: named("gripper", "gripper.toml"),
    "free": lambda: named("satellite", "satellite.toml"),
    "busy_free": lambda: (busy_robot(moving_base=True), BUSY),
    "columns": lambda: (busy_robot(moving_base=True), BUSY_SCENE),
}
each_case = pytest.mark.parametrize(
    "case", ["mimic", "free", *(pytest.param(case, marks=pytest.mark.slow) for case in ("columns", "scara", "puma560"))]
)


def module_of(text):
    """The module whose source this is."""
    module = ModuleType("exported")
    exec(compile(text, "exported.py", "exec"), module.__dict__)
    return module


def states(model, scene):
    """q, qd, qdd, tau, and the columns that wrenches name."""
    rng = np.random.default_rng(1)
    q, qd, qdd = random_state(model, rng, SAMPLES)
    return {"q": q, "qd": qd, "qdd": qdd, "tau": rng.uniform(-5, 5, (SAMPLES, model.n))}, {
        name: rng.uniform(-1, 1, SAMPLES) for name in scene.columns
    }


ARGUMENTS = {
    "torques": ("q", "qd", "qdd"),
    "mass_matrix": ("q",),
    "bias": ("q", "qd"),
    "coriolis": ("q", "qd"),
    "forward": ("q", "qd", "tau"),
    "derivatives": ("q", "qd", "qdd"),
    "forward_derivatives": ("q", "qd", "tau"),
    "regressor": ("q", "qd", "qdd"),
}


def arguments(word, given, columns):
    """The arrays that an exported function takes, in its order."""
    more = [np.column_stack(list(columns.values()))] if columns else []
    return [*(given[source] for source in ARGUMENTS[word]), *more]


def expected(word, model, scene, given, columns):
    """What robodyn returns: a list of arrays."""
    arrays, more = [given[source] for source in ARGUMENTS[word]], {"scene": scene, "columns": columns or None}
    if word == "mass_matrix":
        return [robodyn.mass_matrix(model, *arrays, scene=scene)]
    if word == "coriolis":
        return [robodyn.coriolis_matrix(model, *arrays, scene=scene)]
    if word == "regressor":
        found = robodyn.regressor(model, *arrays, **more)
        return [found.Y, found.rest]
    functions = {
        "torques": robodyn.inverse_dynamics,
        "bias": robodyn.bias_forces,
        "forward": robodyn.forward_dynamics,
        "derivatives": robodyn.inverse_dynamics_derivatives,
        "forward_derivatives": robodyn.forward_dynamics_derivatives,
    }
    found = functions[word](model, *arrays, **more)
    return list(found) if isinstance(found, tuple) else [found]


def tolerance(word, model, scene, given, least=1e-12):
    """`least`, times the condition of the mass matrix where it is inverted."""
    if not word.startswith("forward"):
        return least
    return least * np.linalg.cond(robodyn.mass_matrix(model, given["q"], scene=scene)).max()


def turns(model, q):
    """(samples, nq, n): how q changes along each rate; a turn w about the body's axes changes it by q (w, 0) / 2."""
    out = np.zeros((len(q), model.nq, model.n))
    for joint in model.independent:
        k, r = joint.coordinate, joint.rate
        if joint.kind != "floating":
            out[:, k, r] = 1.0
            continue
        x, y, z, w = q[:, k + 3 : k + 7].T
        for i, turn in enumerate(((w, z, -y, -x), (-z, w, x, -y), (y, -x, w, -z))):
            out[:, k + 3 : k + 7, r + i] = np.stack(turn, -1) / 2
        out[:, k : k + 3, r + 3 : r + 6] = np.eye(3)
    return out
