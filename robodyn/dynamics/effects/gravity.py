"""Gravity: the ground accelerates upwards."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from robodyn.dynamics.effects.effect import Effect, Sample, Terms, Verdict, ZeroColumns
from robodyn.programs.vectors import Scalar
from robodyn.robot.kinematics import Motion, poses
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene


def why(model: Model, scene: Scene, zero_columns: ZeroColumns) -> Verdict:
    some = "gravity is ({:g}, {:g}, {:g}) m/s^2".format(*scene.gravity)
    return Verdict.of(any(scene.gravity), "gravity is zero", some)


def add(terms: Terms, sample: Sample, scene: Scene) -> Terms:
    return replace(terms, gravity=np.array(scene.gravity, dtype=float))


def stored(sample: Sample, terms: Terms, scene: Scene, motions: list[Motion]) -> Scalar:
    """Potential energy -sum m g . r [J], zero for a mass at the ground's origin."""
    energy: Scalar = 0.0
    for pose, body in zip(poses(sample.model.parents, motions), terms.inertias, strict=True):
        energy = energy - terms.gravity @ (pose.R @ body.mc + body.m * pose.p)
    return energy


EFFECT = Effect("gravity", "the ground's acceleration -g", why, add, stored=stored)
