"""Left and right: which links are twins, what is found where they differ, and links hung on another parent."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from helpers.example_robots import path_of
from hypothesis import given
from hypothesis import strategies as st

from robodyn.checks.catalogue import BY_CODE
from robodyn.checks.check import Options, check_one
from robodyn.checks.context import Context
from robodyn.checks.examples import ARM_LIMIT, IMAGE, ORIGIN, ORIGIN_IMAGE, TENSOR, inertia, two_arms, two_elbows
from robodyn.checks.mirror import Plane, link_inertia, named_pairs, pairs
from robodyn.robot.masses.mistakes import UPPER
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
        ("LeftElbowLink", "RightElbowLink"),
        ("arm_L_2", "arm_R_2"),
        ("RL_calf", "RR_calf"),
        ("LF_HAA", "RF_HAA"),
        ("lShoulder", "rShoulder"),
        ("ElbowL", "ElbowR"),
        ("LEFT_left_2", "RIGHT_left_2"),
    ],
)
def test_names_of_left_and_right(left: str, right: str) -> None:
    """Letters inside words are no sides."""
    assert list(named_pairs([right, "base", left])) == [(left, right)]
    for pair in (("calf", "carf"), ("lower_leg", "rower_leg"), ("LINK", "RINK"), ("cl", "cr")):
        assert not list(named_pairs(pair))


def test_pairs_need_their_mirrored_place() -> None:
    assert [(pair.left.name, pair.right.name) for pair in pairs(context(two_arms()))] == [("left_arm", "right_arm")]
    moved = two_arms().replace('xyz="0 -0.3 0"', 'xyz="0.2 -0.3 0"')
    # two links always have a plane between them; with a second pair the oblique one is outvoted
    turned = two_arms().replace('xyz="0 -0.3 0"/>', 'xyz="0 -0.3 0" rpy="0.5 0 0"/>')
    assert not pairs(context(turned))
    assert not codes(moved)


@given(st.lists(st.floats(-1, 1).map(lambda x: round(x, 9)), min_size=12, max_size=12))
def test_the_mirror_image_is_that_of_the_mass(numbers: list[float]) -> None:
    """Against MassProperties.placed with a reflection, and the centre against the plane's image of it."""
    A = np.array(numbers[:9]).reshape(3, 3)
    S = A @ A.T + 0.01 * np.eye(3)
    I = np.trace(S) * np.eye(3) - S
    c = np.array(numbers[9:])
    entries, origin = (" ".join(map(repr, each.tolist())) for each in (I[UPPER], c))
    text = two_arms(left=f'<origin xyz="{origin}"/><mass value="2"/>{inertia(entries)}')
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


def test_twins_in_turned_frames() -> None:
    """The right arm's frame turned by half a turn about x: the image is turned along, and nothing is found."""
    turned = two_arms(
        right=f'<origin xyz="0.1 0.05 -0.2"/><mass value="2"/>{inertia("0.02 0.004 -0.002 0.03 -0.003 0.025")}',
        right_joint=f'<axis xyz="0 -1 0"/>{ARM_LIMIT}',
    ).replace('xyz="0 -0.3 0"/>', 'xyz="0 -0.3 0" rpy="3.141592653589793 0 0"/>')
    assert len(pairs(context(turned))) == 1
    assert not codes(turned)


@pytest.mark.parametrize(
    ("mass", "found"), [("2.03", set()), ("2.05", {"RD401"}), ("1.97", set()), ("1.95", {"RD401"})]
)
def test_masses_may_differ_by_two_percent(mass: str, found: set[str]) -> None:
    image = np.array((0.02, -0.004, 0.002, 0.03, -0.003, 0.025)) * (float(mass) / 2.0)
    tensor = inertia(" ".join(map(repr, image.tolist())))
    assert codes(two_arms(right=f'{ORIGIN_IMAGE}<mass value="{mass}"/>{tensor}')) == found


@pytest.mark.parametrize(
    ("right_joint", "found"),
    [
        (f'<axis xyz="0 1 0"/>{ARM_LIMIT}', set()),
        (f'<axis xyz="0 1 0"/>{ARM_LIMIT.replace(chr(34) + "3" + chr(34), chr(34) + "4" + chr(34))}', {"RD404"}),
        (f'<axis xyz="0 -1 0"/>{ARM_LIMIT}', {"RD404"}),
        ('<axis xyz="0 -1 0"/><limit lower="-2" upper="0.5" effort="30" velocity="3"/>', set()),
        (f'<axis xyz="0 1 1"/>{ARM_LIMIT}', {"RD404"}),
        (f'<axis xyz="0 1 0"/>{ARM_LIMIT.replace("-0.5", "-0.51")}', set()),
    ],
)
def test_limits_change_sides_with_the_axis(right_joint: str, found: set[str]) -> None:
    assert codes(two_arms(right_joint=right_joint)) == found


@pytest.mark.slow
def test_copied_arms_of_talos_are_found() -> None:
    """Its right arm has the left one's meshes with a negative scale, but the left one's inertials as they are."""
    found = check_one(str(path_of("talos_reduced")), Options(select=("RD313", "RD403")))
    of = {code: {one.subject.name for one in found if one.code == code and one.subject} for code in ("RD313", "RD403")}
    assert {"arm_right_3_link", "arm_right_4_link"} <= of["RD313"]
    assert {f"arm_{side}_{k}_link" for side in ("left", "right") for k in (5, 6)} == of["RD403"]


MESH = '<visual>{}<geometry><mesh filename="package://arms/{}.stl"{}/></geometry></visual>'


def with_more(text: str, left: str, right: str) -> str:
    """A robot with more in the links of its arms."""
    for side, more in (("left", left), ("right", right)):
        text = text.replace(f'<link name="{side}_arm">', f'<link name="{side}_arm">{more}')
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
        found = codes(with_more(two_arms(right=f'{origin}<mass value="2"/>{tensor}'), *meshes))
        assert bool(found) is wrong, (origin, found)


@pytest.mark.parametrize(
    ("mass", "cause"),
    [
        ("1", None),
        ("2000", "it is in grams, 1000 times the other"),
        ("4.40925", "it is in pounds, 2.2046 times the other"),
        ("0.2", "that of the twin is 10 times the other, as with the decimal point one place off"),
        ("3", None),
    ],
)
def test_the_factor_between_masses_of_twins_is_named(mass: str, cause: str | None) -> None:
    """And a wrong mass alone is no wrong tensor."""
    text = two_arms(right=f'{ORIGIN_IMAGE}<mass value="{mass}"/>{IMAGE}')
    assert codes(text) == {"RD401"}
    found = [finding for finding in check_one(text.encode()) if finding.code == "RD401"]
    assert len(found) == (1 if mass in ("2000", "4.40925") else 2), "both, if none is sure"
    assert found[-1].cause == cause


def built(links: dict[str, str]) -> Context:
    """A robot of links on their parents."""
    names = dict.fromkeys((*links, *links.values()))
    joints = (
        f'<joint name="to_{child}" type="fixed"><parent link="{parent}"/><child link="{child}"/></joint>'
        for child, parent in links.items()
    )
    text = f'<robot name="r">{"".join(f"<link name={name!r}/>" for name in names)}{"".join(joints)}</robot>'
    return Context(read(text.encode(), "r.urdf"))


def odd_parents(one: Context) -> list[tuple[str, str]]:
    return [(fault.what.split(" a child")[0], fault.remedy) for fault in BY_CODE["RD112"].check(one)]


LEGS = {f"{leg}_hip": "trunk" for leg in ("FL", "FR", "RL", "RR")}
for part, over in (("thigh", "hip"), ("calf", "thigh")):
    LEGS |= {f"{leg}_{part}": f"{leg}_{over}" for leg in ("FL", "FR", "RL", "RR")}
ARMS = {"LeftArm": "torso", "RightArm": "torso", "LeftHand": "LeftArm", "RightHand": "RightArm", "torso": "base"}


@pytest.mark.parametrize(
    ("links", "link", "parent", "expected"),
    [
        (LEGS, "FL_calf", "FR_thigh", ("FL_calf", "FL_thigh", "")),
        (LEGS, "RR_calf", "RR_hip", ("RR_calf", "RR_thigh", "")),
        (LEGS, "FL_calf", "trunk", ("FL_calf", "FL_thigh", "")),
        (LEGS, "RL_hip", "FL_hip", ("RL_hip", "trunk", "")),
        (ARMS, "LeftHand", "RightArm", ("LeftHand", "LeftArm", "")),
    ],
)
def test_one_hung_elsewhere(links: dict[str, str], link: str, parent: str, expected: tuple[str, str, str]) -> None:
    """Where no name says the other side, both are named."""
    odd, right, other = expected
    remedy = f"make {right!r} its parent" + f", or {other!r} is the wrong one" * bool(other)
    assert odd_parents(built(links)) == []
    assert odd_parents(built({**links, link: parent})) == [(f"it makes {odd!r}", remedy)]


def test_joints_at_other_places_are_a_design() -> None:
    text = two_elbows().replace('parent link="right_arm"', 'parent link="base"')
    assert len(odd_parents(context(text))) == 1
    assert not odd_parents(context(text.replace("0.1 -0.05 0.3", "0.2 -0.05 0.3")))


def test_two_and_two_are_a_design() -> None:
    """Cameras in front and behind stand on faces, those at the sides on the trunk: each has company."""
    cameras = {f"{side}_camera": "trunk" for side in ("left", "right")}
    faces = {f"{end}_camera": f"{end}_face" for end in ("front", "rear")} | {
        f"{k}_face": "trunk" for k in ("front", "rear")
    }
    more = {
        f"{k}_{what}": f"{k}_camera" for k in ("front", "rear", "left", "right") for what in ("lens", "optics", "led")
    }
    assert odd_parents(built({**cameras, **faces, **more})) == []


SIGNS = (
    ("0.02 -0.0004 0.0002 0.03 -0.0003 0.025", []),
    ("0.02 0.0004 0.0002 0.03 -0.0003 0.025", ["ixy has not"]),
    ("0.02 0.0004 0.0002 0.03 0.0003 0.025", ["ixy and iyz have not"]),
    ("0.02 0.00041 0.0002 0.03 -0.0003 0.025", []),
)


@pytest.mark.parametrize(("right", "words"), SIGNS)
def test_small_products_follow_the_centre(right: str, words: list[str]) -> None:
    """Where all else of twins is each other's image to the last digit, a sign is a slip however small the product."""
    left = f'{ORIGIN}<mass value="2"/>{inertia("0.02 0.0004 0.0002 0.03 0.0003 0.025")}'
    text = two_arms(left=left, right=f'{ORIGIN_IMAGE}<mass value="2"/>{inertia(right)}')
    found = [one for one in check_one(text.encode()) if one.code == "RD403"]
    assert len(found) == 2 * len(words)
    assert all(word in one.message for one in found for word in words)


def row(names: str, child: str, parent: str) -> Context:
    """A robot whose links hang on each other in a row on turning joints, but for one of them."""
    links = ["base", *names.split()]
    over = dict(zip(links[1:], links, strict=False)) | {child: parent}
    body = f'<inertial><mass value="1"/>{TENSOR}</inertial>'
    text = "".join(f'<link name="{name}">{body}</link>' for name in links) + "".join(
        f'<joint name="to_{one}" type="revolute"><parent link="{on}"/><child link="{one}"/>{ARM_LIMIT}</joint>'
        for one, on in over.items()
    )
    return Context(read(f'<robot name="r">{text}</robot>'.encode(), "r.urdf"))


@pytest.mark.parametrize(
    ("names", "child", "parent", "right"),
    [
        ("shoulder upper_arm forearm wrist_1 wrist_2", "wrist_1", "upper_arm", "forearm"),
        ("link_1 link_2 link_3 link_4 tool", "link_4", "link_2", "link_3"),
        ("link_1 link_2 link_3 link_4", "link_4", "link_2", ""),
        ("link1 link2 link3", "link2", "base", "link1"),
        ("l4 l3 l2 l1 tool", "l1", "l3", "l2"),
        ("link_1 link_2 link_3 link_4", "link_4", "link_1", ""),
        ("yaw pitch roll", "roll", "yaw", ""),
        ("shoulder upper_arm forearm wrist_1", "wrist_1", "forearm", ""),
    ],
)
def test_a_link_in_a_row_is_not_passed_over(names: str, child: str, parent: str, right: str) -> None:
    expected = [(f"it makes {child!r}", f"make {right!r} its parent")] if right else []
    assert odd_parents(row(names, child, parent)) == expected


CYLINDER = '<collision>{}<geometry><cylinder radius="{}" length="0.2"/></geometry></collision>'


def with_shapes(left: str, right: str) -> set[str]:
    found = check_one(with_more(two_arms(), left, right).encode())
    return {one.subject.name for one in found if one.code == "RD406" and one.subject}


def test_shapes_of_twins() -> None:
    """One alone is named where the other has none, or where its <visual> tells."""
    at, image = '<origin xyz="0.1 0.05 0.2"/>', '<origin xyz="0.1 -0.05 0.2"/>'
    one, wide = (CYLINDER.format(at, radius) for radius in ("0.1", "0.2"))
    seen = one.replace("collision", "visual")
    assert not with_shapes(one, CYLINDER.format(image, "0.1"))
    assert with_shapes(one, "") == {"right_arm"}
    assert with_shapes(one, CYLINDER.format(image, "0.2")) == {"left_arm", "right_arm"}
    assert with_shapes(seen + wide, (seen + one).replace(at, image)) == {"left_arm"}
    assert with_shapes(seen + one, (seen + one).replace(at, image).replace(image, "", 1)) == {"right_arm"}


def test_the_mesh_of_the_other_side(tmp_path: Path) -> None:
    for name in ("left_arm.stl", "right_arm.stl", "arm.stl", "other.stl"):
        (tmp_path / name).write_bytes(b"")

    def found(left: str, right: str) -> list[tuple[str, str]]:
        file = tmp_path / "robot.urdf"
        meshes = (MESH.format("", name, "").replace("package://arms/", "") for name in (left, right))
        file.write_text(with_more(two_arms(), *meshes))
        said = check_one(str(file), Options(select=("RD406",)))
        return [(one.subject.name, one.remedy) for one in said if one.subject is not None]

    assert found("left_arm", "left_arm") == [("right_arm", "write 'right_arm.stl'")]
    assert found("right_arm", "right_arm") == [("left_arm", "write 'left_arm.stl'")]
    assert found("left_arm", "right_arm") == found("other", "other") == found("right_arm", "left_arm") == []


def test_one_arm_mounted_on_both_sides() -> None:
    """Where the elbows hang alike on one part, which both arms are, forearms are alike and no images."""
    mesh = '<visual><geometry><mesh filename="package://arms/arm.stl"/></geometry></visual>'
    text = with_more(two_elbows("0.1 0.05 0.3"), mesh, mesh)
    text = text.replace(f"{ORIGIN_IMAGE}", ORIGIN).replace(IMAGE, TENSOR)
    assert all(pair.is_alike for pair in pairs(context(text)))
    assert not codes(text)
    range_ = 'name="right_elbow" type="revolute">'
    at = text.index('upper="2"', text.index(range_))
    other = text[:at] + 'upper="1"' + text[at + len('upper="2"') :]
    assert codes(other) == {"RD404"}


@pytest.mark.parametrize(
    ("y", "expected"), [("-0.05", set()), ("0.05", {"RD403"}), ("-0.4", {"RD403"}), ("-2", {"RD302", "RD403"})]
)
def test_a_centre_outside_is_told_by_the_twin(y: str, expected: set[str]) -> None:
    """Once: where the centre has to be is what the twin tells. One that is far outside is an error by itself."""
    box = '<visual>{}<geometry><box size="0.3 0.09 0.3"/></geometry></visual>'
    text = two_arms(right=f'<origin xyz="0.1 {y} 0.2"/><mass value="2"/>{IMAGE}')
    assert codes(with_more(text, box.format(ORIGIN), box.format(ORIGIN_IMAGE))) - {"RD301"} == expected
