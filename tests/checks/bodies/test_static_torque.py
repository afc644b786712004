"""The most that gravity asks of joints, against closed forms, the recursion and random poses."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.example_robots import path_of
from helpers.sampled import sampled

import robodyn
from robodyn.checks.bodies.statics import (
    gravity_bounds,
    inverse_of_definite,
    joint_space_inertia,
    position_ranges,
    starts,
    static_torques,
)
from robodyn.checks.check import check_one
from robodyn.checks.context import Context
from robodyn.checks.rule import Severity
from robodyn.robot.urdf.document import read

G = 9.81
LINK = '<inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/>'


def planar(lower: float, upper: float, axis: str = "0 1 0") -> str:
    """Two links of 1 m, masses 3 kg and 2 kg at their ends, turning in a plane; the second within limits."""
    links = "".join(
        f'<link name="l{k}"><inertial><origin xyz="1 0 0"/><mass value="{m}"/>{LINK}</inertial></link>'
        for k, m in ((1, 3), (2, 2))
    )
    return f"""<robot name="planar"><link name="base"/>{links}
      <joint name="j1" type="revolute"><parent link="base"/><child link="l1"/><axis xyz="{axis}"/>
        <limit lower="-3" upper="3" effort="0.1" velocity="1"/></joint>
      <joint name="j2" type="revolute"><parent link="l1"/><child link="l2"/><origin xyz="1 0 0"/><axis xyz="{axis}"/>
        <limit lower="{lower}" upper="{upper}" effort="0.1" velocity="1"/></joint></robot>"""


def context(source: object) -> Context:
    return Context(read(source.encode() if isinstance(source, str) else source))


def found(text: str) -> dict[str, float]:
    return {one.joint.name: abs(one.torque) for one in context(text).once(static_torques)}


def test_stretched_arm() -> None:
    torques = found(planar(-2.0, 2.0))
    assert torques["j1"] == pytest.approx(G * (3 * 1 + 2 * 2), rel=1e-9)
    assert torques["j2"] == pytest.approx(G * 2, rel=1e-9)


def test_limits_keep_the_arm_bent() -> None:
    """With q2 = b at least, |3 e(q1) + 2 (e(q1) + e(q1 + q2))| is largest at q2 = b."""
    b = 1.2
    torques = found(planar(b, 2.0))
    assert torques["j1"] == pytest.approx(G * abs(5 + 2 * np.exp(1j * b)), rel=2e-3)


def test_upright_axes_carry_nothing() -> None:
    assert not any(found(planar(-2.0, 2.0, axis="0 0 1")).values())


def test_slides_carry_weight_along_the_vertical() -> None:
    text = planar(-2.0, 2.0, axis="0 0 1").replace('type="revolute"', 'type="prismatic"', 1)
    assert found(text)["j1"] == pytest.approx(G * 5, rel=1e-12)


def test_a_slide_reaches_out_to_its_limit() -> None:
    text = planar(-0.25, 0.5).replace('name="j2" type="revolute"', 'name="j2" type="prismatic"')
    text = text.replace(
        '<axis xyz="0 1 0"/>\n        <limit lower="-0.25"', '<axis xyz="1 0 0"/>\n        <limit lower="-0.25"'
    )
    assert found(text)["j1"] == pytest.approx(G * (3 + 2 * 2.5), rel=1e-9)


ROBOTS = ["panda", "tiago_no_hand", "pr2", "talos_reduced", "g1_29dof_with_hand_rev_1_0", "human", "baxter"]


@pytest.mark.parametrize("stem", ROBOTS)
def test_poses_are_within_limits_and_torques_those_of_the_recursion(stem: str) -> None:
    one = context(path_of(stem))
    model, results = one.model, one.once(static_torques)
    assert results
    low, high = position_ranges(model)
    poses = np.array([result.q for result in results])
    assert ((low <= poses) & (poses <= high)).all()
    tau = robodyn.bias_forces(model, poses, 0.0, executor="numpy")
    for k, result in enumerate(results):
        bound = gravity_bounds(one)[result.joint.name].own
        friction = abs(tau[k, result.joint.rate] - result.torque)
        assert friction <= 1e-12 * max(bound, 1.0)
        assert abs(result.torque) <= bound * (1 + 1e-12)


@pytest.mark.parametrize("stem", ROBOTS)
def test_no_random_pose_asks_for_more(stem: str) -> None:
    one = context(path_of(stem))
    model = one.model
    low, high = position_ranges(model)
    q = low + np.random.default_rng(1).random((4000, model.n)) * (high - low)
    most = np.abs(robodyn.bias_forces(model, q, 0.0)).max(axis=0)
    for result in one.once(static_torques):
        assert most[result.joint.rate] <= 1.02 * abs(result.torque) + 1e-9


def test_the_bound_holds_for_joints_that_are_not_looked_at() -> None:
    one = context(path_of("icub"))
    model = one.model
    low, high = position_ranges(model)
    q = low + np.random.default_rng(2).random((2000, model.n)) * (high - low)
    most = np.abs(robodyn.bias_forces(model, q, 0.0)).max(axis=0)
    bounds = one.once(gravity_bounds)
    single = [joint for joint in model.independent if not any(b.joint.mimics == joint.name for b in model.bodies)]
    assert all(most[joint.rate] <= bounds[joint.name].own * (1 + 1e-12) + 1e-12 for joint in single)


def test_a_finding_names_the_pose_and_the_limit_s_place() -> None:
    text = planar(-2.0, 2.0).replace('effort="0.1"', 'effort="60"', 1)
    (finding,) = (
        one for one in check_one(text.encode()) if one.code == "RD801" and one.subject and one.subject.name == "j1"
    )
    assert finding.bound == 60.0
    assert finding.measured == pytest.approx(G * 7, rel=1e-9)
    assert text.encode()[finding.start : finding.end] == b"60"


@pytest.mark.parametrize(
    ("effort", "severity"), [("34", Severity.WARNING), ("35", Severity.NOTE), ("68", Severity.NOTE)]
)
def test_less_than_twice_the_limit_is_a_remark(effort: str, severity: Severity) -> None:
    """Springs may hold a part of the weight, as PR2's do; the joint carries 68.6 N m."""
    text = planar(-2.0, 2.0).replace('effort="0.1"', f'effort="{effort}"', 1)
    (finding,) = (
        one for one in check_one(text.encode()) if one.code == "RD801" and one.subject and one.subject.name == "j1"
    )
    assert finding.severity is severity


def test_sentinel_ranges_are_one_turn() -> None:
    low, high = position_ranges(context(planar(-1e16, 1e16)).model)
    assert (low[1], high[1]) == (-math.pi, math.pi)


@pytest.mark.parametrize("stem", sampled(["baxter", "pr2", "tiago", "g1_29dof_rev_1_0"]))
def test_joint_space_inertia_is_the_mass_matrix(stem: str) -> None:
    """With mimic joints, slides and rotors of transmissions."""
    model = robodyn.load(path_of(stem))
    for q in starts(*position_ranges(model))[:2]:
        expected = robodyn.mass_matrix(model, q)
        assert np.abs(joint_space_inertia(model, q) - expected).max() <= 1e-12 * np.abs(expected).max()


def test_the_inverse_is_one() -> None:
    A = np.random.default_rng(0).normal(size=(30, 40))
    M = A @ A.T
    inverse = inverse_of_definite(M)
    assert inverse is not None
    assert np.abs(inverse @ M - np.eye(30)).max() <= 1e-12 * np.linalg.cond(M)
    assert inverse_of_definite(M - 200 * np.eye(30)) is None


@pytest.mark.parametrize(("damping", "warned"), [(9.9, False), (10.1, True)])
def test_damping_is_measured_against_the_step(damping: float, warned: bool) -> None:
    """Two bodies of 0.01 kg m^2 in a row about x: J = 0.005 kg m^2 between them while both are free, 2 J / b = 1 ms."""
    text = planar(-2.0, 2.0, axis="1 0 0").replace(
        'velocity="1"/></joint></robot>', f'velocity="1"/><dynamics damping="{damping}"/></joint></robot>'
    )
    results = [one for one in check_one(text.encode()) if one.code == "RD804"]
    assert bool(results) == warned
    assert [one.measured for one in results] == pytest.approx([2 * 0.005 / damping] * warned, rel=1e-9)
