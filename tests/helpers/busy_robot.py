"""A robot that excites every effect: skew tree, gripper of mimic joints, gears, damping, a tool fixed to a link."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from helpers.small_robots import body_numbers, joint, link, urdf
from robodyn.robot.load import load
from robodyn.scene.scene import (
    CoupledMotor,
    ExternalWrench,
    Friction,
    Immersed,
    LimitSpring,
    Payload,
    Rotor,
    Scene,
    Spring,
)

AXES = {"j1": (0, 0, 1), "j2": (0.6, 0, -0.8), "j3": (0, -1, 0), "j4": (0.48, 0.6, 0.64)}


def busy_parts():
    rng = np.random.default_rng(21)
    parts = [link(f"l{i}", *body_numbers(rng), rng.uniform(-3, 3, 3)) for i in range(7)]
    parts.append(link("tool", *body_numbers(rng)))

    def placed(name, parent, child, kind="revolute", axis=(1, 0, 0), more=""):
        return joint(name, parent, child, kind, axis, rng.uniform(-0.5, 0.5, 3), rng.uniform(-3, 3, 3), more)

    return [
        *parts,
        placed("j1", "l0", "l1", axis=AXES["j1"], more='<dynamics damping="0.7" friction="0.4"/>'),
        placed("j2", "l1", "l2", axis=AXES["j2"], more='<dynamics damping="0.2" friction="0.9"/>').replace(
            "-9", "-0.5"
        ),
        placed("slide", "l2", "l3", "prismatic", AXES["j4"], '<dynamics damping="1.5"/>'),
        placed("j4", "l1", "l4", "continuous", AXES["j3"], '<dynamics friction="0.3"/>'),
        placed("finger", "l3", "l5", "prismatic", (0, 1, 0), '<dynamics damping="0.5" friction="0.6"/>'),
        placed(
            "follower",
            "l3",
            "l6",
            "revolute",
            AXES["j2"],
            '<mimic joint="finger" multiplier="-2.5" offset="0.3"/><dynamics damping="0.25" friction="0.35"/>',
        ),
        placed("mount", "l3", "tool", "fixed"),
        '<transmission name="t2"><joint name="j2"/><actuator name="m2">'
        "<mechanicalReduction>-30</mechanicalReduction><rotorInertia>2e-4</rotorInertia></actuator></transmission>",
        '<transmission name="t1"><joint name="j1"/><actuator name="m1">'
        "<mechanicalReduction>60</mechanicalReduction></actuator></transmission>",
    ]


@cache
def busy_robot(moving_base=False):
    return load(urdf(*busy_parts()), moving_base=moving_base)


BUSY_SCENE = Scene(
    gravity=(0.3, -2.0, -9.0),
    friction={"slide": Friction(0.4, 0.8, -0.5, 1.7, 0.9), "j4": Friction(0.1, 0.0, -0.2)},
    rotor={"j1": Rotor(1e-4), "slide": Rotor(3e-4, -40.0), "follower": Rotor(5e-4, 12.0)},
    spring={"j2": Spring(3.0, 0.4), "follower": Spring(2.0, -0.2)},
    payloads=(Payload("tool", 1.3, (0.1, 0.2, -0.1), (0.02, 0.001, 0.002, 0.03, -0.003, 0.025)), Payload("l4", 0.4)),
    wrenches=(
        ExternalWrench("tool", (1.0, -2.0, 3.0), (0.4, 0.5, -0.6), (0.1, 0.0, 0.2)),
        ExternalWrench("l4", ("push", 0.0, 2.0), (0.0, "twist", 0.0), (0.0, 0.3, 0.0), "base"),
        ExternalWrench("l6", (0.0, 0.0, -4.0), frame="world"),
        ExternalWrench("l4", (2.0, 0.5, -1.0), (0.1, 0.0, 0.3), (0.2, 0.0, 0.1), cause="loop", axes="tool"),
        ExternalWrench("tool", (1.0, 0.5, 5.0), (0.0, 0.2, 0.0), frame="world", cause="contact"),
    ),
    immersed=(Immersed("tool", 2e-3, (0.05, -0.1, 0.02), (0.3, 0.2, 0.1)), Immersed("l2", 1e-3)),
    fluid_density=1000.0,
    fluid_velocity=(0.4, -0.2, 0.1),
    joint_limits="spring",
    limit_spring=LimitSpring(40.0, 3.0),
)

SPINNING = {
    "j2": Rotor(0.04, -30.0, (0.3, -1.0, 0.5)),
    "slide": Rotor(0.03, -40.0, (0.0, 1.0, 0.2), "tool"),
    "j4": Rotor(0.2, 25.0, on="l1"),
    "follower": Rotor(0.05, 12.0, (1.0, 2.0, -1.0), "l3"),
    "finger": Rotor(0.08, 15.0, (1.0, 0.0, 0.0), "l4"),
    "j1": Rotor(0.07, 20.0, on="l1"),
}
"""On parents, children, links beyond the joint, on another branch, and of mimic joints."""
WRIST = CoupledMotor("wrist motor", {"j2": 1.0, "slide": -0.7}, 2e-3, -30.0, Friction(0.3, 0.5, -0.4, 0.9, 0.3))
CROSSED = CoupledMotor("crossed", {"j4": 0.5, "follower": 0.7, "finger": -0.2}, 1e-3, 20.0, Friction(0.1, 0.2, -0.2))
COUPLED = (WRIST, CROSSED, CoupledMotor("chained", {"slide": 1.0, "j4": 2.0}, 3e-4, 10.0))
EVERY_EFFECT = replace(BUSY_SCENE, rotor=SPINNING, coupled=COUPLED)
"""All effects but friction that grows with load, which has no mass matrix."""
