"""Reference numbers and small tools for tests of dynamics: normwise errors, random states, programs on arrays."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import numpy as np

from robodyn.dynamics.plan import runner_of
from robodyn.robot.load import load
from robodyn.scene.scene import Friction, Scene

REFERENCE = Path(__file__).parents[1] / "data" / "reference"
ROBOTS = Path(__file__).parents[2] / "robots"
EPS = np.finfo(float).eps
TAU_SCALE_TINY = np.finfo(float).tiny


@cache
def reference(name):
    return json.loads((REFERENCE / f"{name}.json").read_text())


@cache
def golden_model(name):
    return load(REFERENCE / "urdf" / f"{name}.urdf")


@cache
def robot(name, moving_base=False):
    return load(ROBOTS / f"{name}.urdf", moving_base=moving_base)


def worst(found, expected, scale=None):
    """max |found - expected| of `scale`, by default of the largest |expected|; 0 where all agree exactly."""
    found, expected = np.asarray(found, dtype=float), np.asarray(expected, dtype=float)
    assert found.shape == expected.shape
    assert np.isfinite(found).all()
    difference = np.abs(found - expected).max(initial=0.0)
    largest = np.abs(expected).max(initial=0.0) if scale is None else scale
    return difference / max(largest, TAU_SCALE_TINY)


def frictionless(model, **more):
    """A scene that switches off the friction that the description declares."""
    names = [body.joint.name for body in model.bodies if body.joint.kind in ("revolute", "prismatic")]
    return Scene(friction=dict.fromkeys(names, Friction()), **more)


def random_state(model, rng, samples):
    """q, qd, qdd of every kind of coordinate; quaternions are of unit length."""
    q = rng.uniform(-2, 2, (samples, model.nq))
    for joint in model.independent:
        if joint.kind == "floating":
            h = rng.normal(size=(samples, 4))
            q[:, joint.coordinate + 3 : joint.coordinate + 7] = h / np.linalg.norm(h, axis=1)[:, None]
    return q, *rng.uniform(-3, 3, (2, samples, model.n))


def run(program, plan, q, qd, qdd, columns=None):
    """The outputs of a program of this plan for arrays of samples."""
    q, qd, qdd = (np.atleast_2d(np.asarray(x, dtype=float)) for x in (q, qd, qdd))
    extra = np.empty((len(q), 0)) if columns is None else columns
    return runner_of(program, plan)({"q": q, "qd": qd, "qdd": qdd, "columns": extra}, len(q))


def tangent(model, q):
    """How q changes along each rate, from the definition of a turn about the body's axes: q (w, 0) / 2."""
    out = []
    for joint in model.independent:
        k = joint.coordinate
        if joint.kind != "floating":
            out.append({("q", k): 1})
            continue
        x, y, z, w = q[:, k + 3 : k + 7].T
        for turn in ((w, z, -y, -x), (-z, w, x, -y), (y, -x, w, -z)):
            out.append({("q", k + 3 + i): part / 2 for i, part in enumerate(turn)})
        out += [{("q", k + i): 1} for i in range(3)]
    return out
