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
from helpers.oracles import random_state, tangent
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


FUNCTIONS = {
    "torques": robodyn.inverse_dynamics,
    "mass_matrix": robodyn.mass_matrix,
    "bias": robodyn.bias_forces,
    "coriolis": robodyn.coriolis_matrix,
    "forward": robodyn.forward_dynamics,
    "derivatives": robodyn.inverse_dynamics_derivatives,
    "forward_derivatives": robodyn.forward_dynamics_derivatives,
    "regressor": robodyn.regressor,
}


def arguments(word, given, columns):
    more = [np.column_stack(list(columns.values()))] if columns else []
    return [*(given[source] for source in ARGUMENTS[word]), *more]


def expected(word, model, scene, given, columns):
    more = {} if word in ("mass_matrix", "coriolis") else {"columns": columns or None}
    found = FUNCTIONS[word](model, *(given[source] for source in ARGUMENTS[word]), scene=scene, **more)
    if word == "regressor":
        return [found.Y, found.rest]
    return list(found) if isinstance(found, tuple) else [found]


def tolerance(word, model, scene, given, least=1e-12):
    """`least`, times the condition of the mass matrix where it is inverted."""
    if not word.startswith("forward"):
        return least
    return least * np.linalg.cond(robodyn.mass_matrix(model, given["q"], scene=scene)).max()


def turns(model, q):
    """(samples, nq, n): how q changes along each rate."""
    out = np.zeros((len(q), model.nq, model.n))
    for rate, way in enumerate(tangent(model, q)):
        for (_, coordinate), slope in way.items():
            out[:, coordinate, rate] = slope
    return out
