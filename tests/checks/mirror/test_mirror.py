"""Left and right: which links are twins, and what is found where they differ."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.example_robots import path_of
from hypothesis import given
from hypothesis import strategies as st

from robodyn.checks.check import check_one
from robodyn.checks.context import Context
from robodyn.checks.examples import ARM_LIMIT, IMAGE, ORIGIN, ORIGIN_IMAGE, TENSOR, two_arms, two_elbows
from robodyn.checks.mirror import Plane, link_inertia, named_pairs, pairs
from robodyn.robot.urdf.document import read
from robodyn.solids.inertia.properties import from_inertia

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
    centre, image = pair.reflected(pair.left.inertial)
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
    assert codes(two_arms(right=f'{ORIGIN}<mass value="2"/>{TENSOR}')) == {"RD313"}
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


def of_links(robot: str, code: str) -> set[str]:
    return {one.subject.name for one in check_one(str(path_of(robot))) if one.code == code and one.subject}


def test_the_right_leg_of_icub_is_found_once() -> None:
    """Its tensors are next to nothing, which RD204 says; that they are not the left leg's is no second finding."""
    leg = {"r_hip_1", "r_hip_2", "r_upper_leg", "r_lower_leg", "r_ankle_1"}
    assert leg <= of_links("icub", "RD204")
    assert of_links("icub", "RD402") == {"r_shoulder_1", "r_shoulder_3"}
    assert not of_links("hyq_no_sensors", "RD403") & of_links("hyq_no_sensors", "RD206")


def test_a_part_that_is_mounted_twice_is_no_copy() -> None:
    """Both grippers of TALOS have the same meshes at the same place, and so the same inertials."""
    for link in ("gripper_right_motor_double_link", "gripper_right_motor_single_link"):
        assert link not in of_links("talos_full_v2", "RD313") | of_links("talos_full_v2", "RD403")
    assert not of_links("pr2", "RD313") | of_links("pr2", "RD403")
    assert "wrist_right_ft_link" not in of_links("talos_full_v2", "RD313") | of_links("talos_full_v2", "RD403")


def test_copied_arms_of_talos_are_found() -> None:
    """Its right arm has the left one's meshes with a negative scale, but the left one's inertials as they are."""
    assert {"arm_right_3_link", "arm_right_4_link"} <= of_links("talos_reduced", "RD313")
    assert {"arm_right_5_link", "arm_right_6_link"} == of_links("talos_reduced", "RD403")


MESH = '<visual>{}<geometry><mesh filename="package://arms/{}.stl"{}/></geometry></visual>'


def with_meshes(left: str, right: str, inertial: str) -> str:
    text = two_arms(right=inertial)
    for side, mesh in (("left", left), ("right", right)):
        text = text.replace(f'<link name="{side}_arm">', f'<link name="{side}_arm">{mesh}')
    return text


@pytest.mark.parametrize(
    ("left", "right", "copied", "turned"),
    [
        (("", "arm", ""), ("", "arm", ""), False, True),
        (("", "arm", ""), ('<origin xyz="0 0 0" rpy="3.141592653589793 0 0"/>', "arm", ""), True, False),
        (("", "arm", ""), ("", "arm", ' scale="1 -1 1"'), True, True),
        (("", "left", ""), ("", "right", ""), True, True),
        (("", "arm", ""), ('<origin xyz="0.4 0 0"/>', "arm", ""), True, True),
        (("", "arm", ' scale="1e-3 1e-3 1e-3"'), ("", "arm", ""), True, True),
    ],
    ids=["mounted twice", "mounted turned", "reflected", "two parts", "elsewhere", "of another size"],
)
def test_what_goes_with_the_meshes(
    left: tuple[str, str, str], right: tuple[str, str, str], copied: bool, turned: bool
) -> None:
    """A copy of the left inertial is right where the meshes are those of the left link; one that is turned by half a
    turn about x, where they are turned so."""
    meshes = MESH.format(*left), MESH.format(*right)
    half_turn = TENSOR.replace('ixy="0.004" ixz="0.002"', 'ixy="-0.004" ixz="-0.002"')
    for origin, tensor, wrong in (
        (ORIGIN_IMAGE, IMAGE, False),
        (ORIGIN, TENSOR, copied),
        ('<origin xyz="0.1 -0.05 -0.2"/>', half_turn, turned),
    ):
        found = codes(with_meshes(*meshes, f'{origin}<mass value="2"/>{tensor}'))
        assert bool(found) is wrong, (origin, found)


@pytest.mark.parametrize(("kind", "wrong"), [("fixed", False), ("revolute", True)])
def test_fixed_parts_of_one_primitive_may_be_one_product(kind: str, wrong: bool) -> None:
    """The force sensor in both wrists of TALOS has a cylinder in place of its mesh, and its own products of inertia."""
    cylinder = '<visual><geometry><cylinder radius="0.1" length="0.2"/></geometry></visual>'
    text = with_meshes(cylinder, cylinder, f'{ORIGIN}<mass value="2"/>{TENSOR}').replace('"revolute"', f'"{kind}"')
    assert bool({"RD313", "RD403"} & {*codes(text)}) is wrong


def test_the_meshes_that_are_seen_count_first() -> None:
    mesh = MESH.format("", "{}", "") + MESH.format("", "box", "").replace("visual", "collision")
    for side, wrong in (("left", False), ("right", True)):
        text = with_meshes(mesh.format("left"), mesh.format(side), f'{ORIGIN}<mass value="2"/>{TENSOR}')
        assert bool(codes(text)) is wrong


def dual_arm(shape: str) -> str:
    """One arm on both sides of a column, elbow and all; on each upper arm there is a shape."""
    text = two_elbows("0.1 0.05 0.3")
    text = text.replace(f'{ORIGIN_IMAGE}<mass value="2"/>{IMAGE}', f'{ORIGIN}<mass value="2"/>{TENSOR}')
    for side in ("left", "right"):
        text = text.replace(f'<link name="{side}_arm">', f'<link name="{side}_arm"><visual>{shape}</visual>')
    return text


@pytest.mark.parametrize(
    ("place", "found"),
    [("0 0.05 0.1", set()), ("0 0 0.1", {"RD313", "RD405"})],
    ids=["beside the plane", "in the plane, which tells nothing"],
)
def test_one_arm_of_primitives_on_both_sides(place: str, found: set[str]) -> None:
    shape = f'<origin xyz="{place}"/><geometry><cylinder radius="0.04" length="0.3"/></geometry>'
    assert codes(dual_arm(shape)) & {"RD313", "RD403", "RD404", "RD405"} == found


@pytest.mark.parametrize("mass", ["3", "1"])
def test_a_wrong_mass_alone_is_no_wrong_tensor(mass: str) -> None:
    assert codes(two_arms(right=f'{ORIGIN_IMAGE}<mass value="{mass}"/>{IMAGE}')) == {"RD401"}


@pytest.mark.parametrize(
    ("mass", "cause"),
    [
        ("2000", "it is in grams, 1000 times the other"),
        ("4.40925", "it is in pounds, 2.2046 times the other"),
        ("0.2", "that of the twin is 10 times the other, as with the decimal point one place off"),
        ("3", None),
    ],
)
def test_the_factor_between_masses_of_twins_is_named(mass: str, cause: str | None) -> None:
    text = two_arms(right=f'{ORIGIN_IMAGE}<mass value="{mass}"/>{IMAGE}')
    (one,) = [finding for finding in check_one(text.encode()) if finding.code == "RD401"]
    assert one.cause == cause
