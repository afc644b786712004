"""Differences that users of other programs reported, built from their words: found, explained, and in N m."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.peers import peer

import robodyn

TURNED = (
    '<robot name="right"><link name="world"/><link name="body">'
    '<inertial><origin xyz="0 0 0" rpy="0 0 1.5707963267948966"/>'
    '<mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="2" iyz="0" izz="2.5"/></inertial></link>'
    '<joint name="roll" type="continuous"><parent link="world"/><child link="body"/><axis xyz="1 0 0"/></joint></robot>'
)
WHAT_MUJOCO_MADE = (
    '<mujoco model="imported"><worldbody><body name="body"><joint name="roll" axis="1 0 0"/>'
    '<inertial pos="0 0 0" mass="1" diaginertia="1 2 2.5"/></body></worldbody></mujoco>'
)


def test_the_rotation_of_an_inertial_is_lost():
    """MuJoCo's import of URDF, its issue 3559: 1 N m at 1 rad/s^2 about x for 2 N m."""
    peer("mujoco")
    a, b = robodyn.load(TURNED.encode()), robodyn.load(WHAT_MUJOCO_MADE.encode())
    found = robodyn.compare(a, b)
    (one,) = [each for each in found.differences if each.acts]
    assert (one.kind, one.name, one.cause) == ("inertia", "body", "in B the rotation of the inertial is lost")
    assert found.worst is not None
    assert found.worst.difference is one
    assert found.worst.a == pytest.approx(2.0 * found.worst.acceleration["roll"], rel=1e-12)
    assert found.worst.b == pytest.approx(found.worst.acceleration["roll"], rel=1e-12)


def test_torques_there_are_those_of_mujoco():
    """Of a pair whose inertia and mounting differ, at the pose and motion that is worst."""
    mujoco = peer("mujoco")
    body = '<body name="{}" pos="{}"><joint name="{}" axis="{}"/>'
    body += '<inertial pos="0.1 0.02 0" mass="{}" fullinertia="{}"/>{}</body>'
    tip = body.format("tip", "0.4 0 0", "elbow", "0 1 0", "1.5", "0.02 0.03 0.04 0.001 0.002 -0.003", "")
    texts = [
        f'<mujoco model="{name}"><worldbody>{body.format("arm", place, "shoulder", "0 1 1", 2, inertia, tip)}'
        "</worldbody></mujoco>"
        for name, place, inertia in (("a", "0 0 1", "0.03 0.05 0.06 0 0 0"), ("b", "0 0 1", "0.03 0.06 0.05 0 0 0"))
    ]
    found = robodyn.compare(*(robodyn.load(text.encode()) for text in texts))
    for one in found.torques:
        for text, value in zip(texts, (one.a, one.b), strict=True):
            model = mujoco.MjModel.from_xml_string(text)
            data = mujoco.MjData(model)
            for k, name in enumerate(("shoulder", "elbow")):
                data.qpos[k], data.qvel[k], data.qacc[k] = one.pose[name], one.speed[name], one.acceleration[name]
            mujoco.mj_inverse(model, data)
            torque = data.qfrc_inverse[("shoulder", "elbow").index(one.joint)]
            assert value == pytest.approx(torque, abs=1e-9 * np.abs(data.qfrc_inverse).max())
