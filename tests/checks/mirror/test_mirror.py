"""Left and right: which links are twins, and what is found where they differ."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.example_robots import path_of
from hypothesis import given, settings
from hypothesis import strategies as st

from robodyn.checks.context import Context
from robodyn.checks.examples import ARM_LIMIT, IMAGE, ORIGIN, ORIGIN_IMAGE, TENSOR, two_arms
from robodyn.checks.mirror.pairs import Plane, link_inertia, named_pairs, pairs, reflected
from robodyn.checks.run import check_one
from robodyn.robot.urdf.document import read
from robodyn.solids.inertia.conversions import from_inertia

EPS = np.finfo(float).eps


def context(text: str) -> Context:
    return Context(read(text.encode()))


def codes(text: str) -> set[str]:
    return {finding.code for finding in check_one(text.encode()) if finding.code[:3] in ("RD3", "RD4")}


@pytest.mark.parametrize(
    ("left", "right"),
    [
        ("left_hip", "right_hip"),
        ("gripper_left_1", "gripper_right_1"),
        ("LeftElbowLink", "RightElbowLink"),
        ("l_wrist", "r_wrist"),
        ("arm_l", "arm_r"),
        ("arm_L_2", "arm_R_2"),
        ("FL_hip", "FR_hip"),
        ("RL_calf", "RR_calf"),
        ("LF_HAA", "RF_HAA"),
        ("lh_foot", "rh_foot"),
        ("LHipYaw", "RHipYaw"),
        ("lShoulder", "rShoulder"),
        ("ElbowL", "ElbowR"),
        ("LEFT_left_2", "RIGHT_left_2"),
    ],
)
def test_names_of_left_and_right(left: str, right: str) -> None:
    assert list(named_pairs([right, "base", left])) == [(left, right)]


@pytest.mark.parametrize(
    ("name", "other"), [("ball", "barr"), ("calf", "carf"), ("lower_leg", "rower_leg"), ("LINK", "RINK"), ("cl", "cr")]
)
def test_letters_inside_words_are_not_sides(name: str, other: str) -> None:
    assert not list(named_pairs([name, other]))


def test_pairs_need_their_mirrored_place() -> None:
    assert [(pair.left.name, pair.right.name) for pair in pairs(context(two_arms()))] == [("left_arm", "right_arm")]
    moved = two_arms().replace('xyz="0 -0.3 0"', 'xyz="0.2 -0.3 0"')
    # two links always have a plane between them; with a second pair the oblique one is outvoted
    turned = two_arms().replace('xyz="0 -0.3 0"/>', 'xyz="0 -0.3 0" rpy="0.5 0 0"/>')
    assert not pairs(context(turned))
    assert not codes(moved)


def test_what_hangs_on_an_unconfirmed_pair_is_not_confirmed() -> None:
    hand = """<link name="left_hand"/><link name="right_hand"/>
      <joint name="left_j" type="fixed"><parent link="left_arm"/><child link="left_hand"/></joint>
      <joint name="right_j" type="fixed"><parent link="base"/><child link="right_hand"/>
        <origin xyz="0 -0.3 0"/></joint></robot>"""
    names = {pair.left.name for pair in pairs(context(two_arms().replace("</robot>", hand)))}
    assert names == {"left_arm"}


@given(st.lists(st.floats(-1, 1).map(lambda x: round(x, 9)), min_size=12, max_size=12))
@settings(deadline=None, max_examples=30)
def test_the_mirror_image_is_that_of_the_mass(numbers: list[float]) -> None:
    """Against MassProperties.placed with a reflection, and the centre against the plane's image of it."""
    A = np.array(numbers[:9]).reshape(3, 3)
    S = A @ A.T + 0.01 * np.eye(3)
    I = np.trace(S) * np.eye(3) - S
    c = np.array(numbers[9:])
    entries = " ".join(f'{name}="{float(I[k])!r}"' for name, k in zip(NAMES, PLACES, strict=True))
    origin = " ".join(repr(x) for x in c.tolist())
    text = two_arms(left=f'<origin xyz="{origin}"/><mass value="2"/><inertia {entries}/>')
    (pair,) = pairs(context(text))
    assert pair.left.inertial is not None
    centre, image = reflected(pair, pair.left.inertial)
    H = Plane(np.array((0.0, 1.0, 0.0)), 0.0).H
    expected = from_inertia(2.0, c, I).placed(H, np.zeros(3))
    assert np.abs(image - expected.inertia).max() <= 64 * EPS * np.abs(I).max()
    assert np.abs(centre - expected.com).max() <= 4 * EPS * max(1.0, np.abs(c).max())
    kept, same = link_inertia(pair.left.inertial)
    assert (kept == c).all()
    assert np.abs(same - I).max() <= EPS * np.abs(I).max()


NAMES = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
PLACES = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))


def test_twins_in_turned_frames() -> None:
    """The right arm's frame turned by half a turn about x: the image is turned along, and nothing is found."""
    turned = two_arms(
        right='<origin xyz="0.1 0.05 -0.2"/><mass value="2"/>'
        '<inertia ixx="0.02" ixy="0.004" ixz="-0.002" iyy="0.03" iyz="-0.003" izz="0.025"/>',
        right_joint=f'<axis xyz="0 -1 0"/>{ARM_LIMIT}',
    ).replace('xyz="0 -0.3 0"/>', 'xyz="0 -0.3 0" rpy="3.141592653589793 0 0"/>')
    assert len(pairs(context(turned))) == 1
    assert not codes(turned)


@pytest.mark.parametrize(
    ("mass", "found"), [("2.03", set()), ("2.05", {"RD401"}), ("1.97", set()), ("1.95", {"RD401"})]
)
def test_masses_may_differ_by_two_percent(mass: str, found: set[str]) -> None:
    scale = float(mass) / 2.0
    tensor = IMAGE
    for number in ("0.025", "0.004", "0.002", "0.003", "0.02", "0.03"):
        tensor = tensor.replace(f'{number}"', f'{float(number) * scale!r}"')
    assert codes(two_arms(right=f'{ORIGIN_IMAGE}<mass value="{mass}"/>{tensor}')) == found


def test_a_wrong_tensor_is_reported_once() -> None:
    assert codes(two_arms(right=f'{ORIGIN_IMAGE}<mass value="2"/>{TENSOR}')) == {"RD313"}
    assert codes(two_arms(right=f'{ORIGIN}<mass value="2"/>{TENSOR}')) == {"RD313", "RD403"}
    skewed = IMAGE.replace('"0.002"', '"0.006"')
    assert codes(two_arms(right=f'{ORIGIN_IMAGE}<mass value="2"/>{skewed}')) <= {"RD402", "RD403"}


@pytest.mark.parametrize(
    ("right_joint", "found"),
    [
        (f'<axis xyz="0 1 0"/>{ARM_LIMIT}', set()),
        (f'<axis xyz="0 1 0"/>{ARM_LIMIT.replace("30", "31")}', {"RD404"}),
        (f'<axis xyz="0 1 0"/>{ARM_LIMIT.replace(chr(34) + "3" + chr(34), chr(34) + "4" + chr(34))}', {"RD404"}),
        (f'<axis xyz="0 -1 0"/>{ARM_LIMIT}', {"RD404"}),
        ('<axis xyz="0 -1 0"/><limit lower="-2" upper="0.5" effort="30" velocity="3"/>', set()),
        (f'<axis xyz="0 1 1"/>{ARM_LIMIT}', {"RD404"}),
        (f'<axis xyz="0 1 0"/>{ARM_LIMIT.replace("-0.5", "-0.51")}', set()),
    ],
)
def test_limits_change_sides_with_the_axis(right_joint: str, found: set[str]) -> None:
    assert codes(two_arms(right_joint=right_joint)) == found


def test_sliding_twins_keep_the_axis_s_image() -> None:
    slide = f'<axis xyz="0 -1 0"/>{ARM_LIMIT}'
    text = two_arms(right_joint=slide).replace('type="revolute"', 'type="prismatic"')
    assert not codes(text)
    assert codes(text.replace('xyz="0 -1 0"/>', 'xyz="0 1 0"/>')) == {"RD404"}


@pytest.mark.parametrize("name", ["go2", "g1_29dof_rev_1_0", "solo12", "xarm7", "kinova", "panda", "ur5_robot"])
def test_clean_robots_have_no_findings(name: str) -> None:
    found = [
        one.code for one in check_one(str(path_of(name))) if one.code.startswith("RD4") or "RD306" <= one.code < "RD4"
    ]
    assert not found


def test_the_right_leg_of_icub_is_found_by_its_left_twin() -> None:
    found = {one.subject.name for one in check_one(str(path_of("icub"))) if one.code == "RD402" and one.subject}
    assert {"r_hip_1", "r_hip_2", "r_upper_leg", "r_lower_leg", "r_ankle_1"} <= found


def test_copied_grippers_of_talos_are_found() -> None:
    found = {(one.code, one.subject.name) for one in check_one(str(path_of("talos_full_v2"))) if one.subject}
    for link in ("gripper_right_motor_double_link", "gripper_right_motor_single_link"):
        assert {("RD313", link), ("RD403", link)} <= found
