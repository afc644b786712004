"""Why tensors are wrong: planted causes are named and undone, real ones found; hulls that reach into each other."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from helpers.example_robots import path_of
from helpers.sampled import sampled

from robodyn.checks.bodies import contacts
from robodyn.checks.bodies.contacts import Hull, depth, overlaps, rest
from robodyn.checks.catalogue import BY_CODE
from robodyn.checks.check import Options, check_one, found_in
from robodyn.checks.context import Context
from robodyn.checks.examples import ORIGIN, a_shaped_link, inertia, two_arms
from robodyn.checks.fixes import Fixed, fixed
from robodyn.checks.rules.inertia_mistakes import Cause, causes
from robodyn.programs.vectors import rotation_from_rpy
from robodyn.robot.kinematics import Pose
from robodyn.robot.masses.mistakes import UPPER
from robodyn.robot.urdf.document import read, read_document
from robodyn.robot.urdf.parts import INERTIA
from robodyn.solids.inertia.laws import inertia_matrix, parallel_axis, symmetric
from robodyn.support.floats import Floats

C = np.array((0.1, -0.05, 0.2))
MASS = 2.0
RPY = (0.3, -0.4, 0.5)
H = np.diag((1.0, -1.0, 1.0))
STEINER = parallel_axis(np.zeros((3, 3)), MASS, C)


def tensors(count: int = 3) -> list[np.ndarray]:
    """Tensors of bodies with unequal second moments along skew axes."""
    rng = np.random.default_rng(3)
    axes = (np.linalg.qr(rng.normal(size=(3, 3)))[0] for _ in range(count))
    return [inertia_matrix(Q * rng.uniform((0.004, 0.012, 0.03), (0.006, 0.016, 0.04)) @ Q.T) for Q in axes]


def entries(I: np.ndarray) -> str:
    return inertia(" ".join(map(repr, I[UPPER].tolist())))


def cause_of(left: np.ndarray, right: np.ndarray, rpy: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Cause | None:
    origin = f'<origin xyz="{C[0]} {C[1]} {C[2]}" rpy="{rpy[0]} {rpy[1]} {rpy[2]}"/>'
    text = two_arms(
        right=f'{origin}<mass value="{MASS}"/>{entries(right)}', left=f'{ORIGIN}<mass value="{MASS}"/>{entries(left)}'
    )
    return Context(read(text.encode())).once(causes).get("right_arm")


def signs(I: np.ndarray) -> np.ndarray:
    return 2.0 * np.diag(np.diagonal(I)) - I


def reordered(I: np.ndarray) -> np.ndarray:
    """ixy, ixz and iyz under each other's names."""
    return symmetric((I[0, 0], I[1, 2], I[0, 1], I[1, 1], I[0, 2], I[2, 2]))


def decade(I: np.ndarray) -> np.ndarray:
    return I + np.diag((0.0, 0.0, 9.0 * I[2, 2]))


def permuted(I: np.ndarray) -> np.ndarray:
    return I[np.ix_((1, 2, 0), (1, 2, 0))]


PLANTED: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "RD306": signs,
    "RD307": lambda I: I + STEINER,
    "RD308": lambda I: I - STEINER,
    "RD310": reordered,
    "RD311": decade,
    "RD312": permuted,
}


@pytest.mark.parametrize("code", [*PLANTED, "RD309"])
def test_a_planted_cause_is_named_and_undone(code: str) -> None:
    """RD309: a rotation that is not applied."""
    for I in tensors():
        expected, R = H @ I @ H, rotation_from_rpy(*RPY)
        if code == "RD309":
            cause, expected = cause_of(I, expected, RPY), R.T @ expected @ R
        else:
            cause = cause_of(I, PLANTED[code](expected))
        assert cause is not None
        assert cause.code == code
        assert np.abs(np.array(cause.tensor) - expected[UPPER]).max() <= 1e-11 * np.abs(I).max()


def test_a_copy_a_right_tensor_and_one_that_is_wrong_in_two_ways() -> None:
    I = tensors()[0]
    cause = cause_of(I, I)
    assert cause is not None
    assert (cause.code, cause.tensor, cause.fix) == ("RD313", None, None)
    assert cause_of(I, H @ I @ H) is None
    assert cause_of(I, signs(decade(H @ I @ H))) is None


BOX = '<collision><origin xyz="0.5 0 0"/><geometry><box size="1 0.1 0.1"/></geometry></collision>'


def in_box(inertial: str) -> Cause | None:
    text = f'<robot name="r"><link name="bar"><inertial>{inertial}</inertial>{BOX}</link></robot>'
    return Context(read(text.encode())).once(causes).get("bar")


def test_shapes_tell_causes_without_a_twin() -> None:
    bar = np.diag((0.0033, 0.168, 0.168))
    at = '<origin xyz="0.5 0 0" rpy="{}"/><mass value="2"/>'
    assert in_box(at.format("0 0 0") + entries(bar)) is None
    about_origin = in_box(
        at.format("0 0 0") + entries(bar + parallel_axis(np.zeros((3, 3)), 2.0, np.array((0.5, 0, 0))))
    )
    assert about_origin is not None
    assert about_origin.code == "RD307"
    assert np.abs(np.array(about_origin.tensor) - bar[UPPER]).max() <= 1e-12
    standing = in_box(at.format("0 0 0") + entries(np.diag((0.168, 0.0033, 0.168))))
    assert standing is not None
    assert (standing.code, standing.tensor) == ("RD312", tuple(bar[UPPER].tolist()))
    turned = in_box(at.format("0 0 1.5707963267948966") + entries(bar))
    assert turned is None, "its rpy may be left out or its axes permuted"


def test_without_twin_and_shapes_no_order_is_named_but_listed() -> None:
    """MuJoCo's six numbers with names of URDF: iyy and izz hold products. Which product is which, only a twin tells."""
    I = tensors()[0]
    xx, xy, xz, yy, yz, zz = I[UPPER]
    wrong = np.array(((xx, yy, zz), (yy, xy, xz), (zz, xz, yz)))
    text = two_arms(right=f'<mass value="2"/>{entries(wrong)}').replace("left_arm", "other").replace("left_s", "s")
    assert "right_arm" not in Context(read(text.encode())).once(causes)
    (impossible,) = [one for one in check_one(text.encode()) if one.code in ("RD206", "RD207")]
    assert impossible.cause is not None
    assert impossible.cause.startswith("one of these: ")
    assert "MuJoCo" in impossible.cause
    told = cause_of(H @ I @ H, wrong)
    assert told is not None
    assert told.code == "RD310"
    assert told.tensor == pytest.approx(I[UPPER], rel=1e-11)


@pytest.mark.parametrize(("stem", "words"), [("allegro_left_hand", "wrong sign"), ("romeo_laas_small", "subtracted")])
def test_that_a_correction_is_possible_is_no_evidence(stem: str, words: str) -> None:
    """Flipping three signs makes Allegro's fingers possible, adding the parallel-axis term Romeo's links; the meshes of
    the first agree with neither, and the others have none that tell."""
    found = [one for one in check_one(str(path_of(stem))) if one.code in ("RD206", "RD207")]
    assert found
    assert not Context(read(path_of(stem))).once(causes).keys() & {one.subject.name for one in found if one.subject}
    said = [one.cause for one in found if one.cause is not None]
    assert any(words in cause for cause in said)
    assert all(cause.startswith(("one of these: ", "it may be that ")) for cause in said)


@pytest.mark.slow
def test_a_forearm_in_other_axes_is_one_finding() -> None:
    """iCub's forearms are drawn along x, and have centre and tensor along y; of several orders it may be any."""
    found = found_in(str(path_of("icub")), Options(select=("RD302", "RD304", "RD312"))).shown
    (forearms,) = [one for one in found if one.code == "RD312"]
    assert [one.subject.name for one in forearms.places if one.subject] == ["l_forearm", "r_forearm"]
    assert forearms.message.count(" or ") == 1
    assert forearms.remedy == "write it in the axes of the link"
    outside = {place.subject.name for one in found for place in one.places if place.subject and one.code == "RD302"}
    assert "l_upper_arm" in outside
    assert not {"l_forearm", "r_forearm"} & outside


CORNERS = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])


def hull(kind, half, at=(0.0, 0.0, 0.0), rpy=(0.0, 0.0, 0.0)):
    half = np.array(half, float)
    pose = Pose(rotation_from_rpy(*rpy).astype(float), np.array(at, float))
    points = CORNERS * half if kind == "mesh" else None
    return Hull(kind, half, points, pose)


@pytest.mark.parametrize(
    ("first", "second", "expected"),
    [
        (hull("sphere", (0.2,) * 3), hull("sphere", (0.3,) * 3, (0.3, 0.2, 0.1)), 0.5 - 0.14**0.5),
        (hull("box", (0.1, 0.2, 0.3)), hull("box", (0.1, 0.2, 0.3), (0.15, 0.0, 0.1)), 0.05),
        (hull("mesh", (0.1, 0.2, 0.3)), hull("box", (0.1, 0.2, 0.3), (0.15, 0.0, 0.1)), 0.05),
        (hull("box", (0.5, 0.5, 0.5)), hull("capsule", (0.1, 0.1, 0.4), (0.0, 0.0, 0.8)), 0.1),
        (hull("box", (0.5, 0.5, 0.5)), hull("cylinder", (0.1, 0.1, 0.4), (0.0, 0.55, 0.0)), 0.05),
        (hull("box", (0.5, 0.5, 0.5)), hull("cylinder", (0.1, 0.1, 0.4), (0.0, 0.85, 0.0), (np.pi / 2, 0, 0)), 0.05),
        (hull("sphere", (0.2,) * 3), hull("box", (0.1, 0.1, 0.1), (0.28, 0.0, 0.0), (0.0, 0.0, 0.6)), None),
        (hull("sphere", (0.2,) * 3), hull("sphere", (0.3,) * 3, (0.5, 0.1, 0.0)), 0.0),
    ],
)
def test_depth(first, second, expected):
    found = depth(first, second, 0.0)
    assert found == pytest.approx(depth(second, first, 0.0), abs=2e-3), "a percent of the smaller body"
    if expected is None:
        assert 0 < found < 0.2
    else:
        assert expected - 1e-12 <= found <= expected * 1.01 + 1e-3


def found(text, folder):
    file = folder / "arm.urdf"
    file.write_text(text, encoding="utf-8")
    return [(first.name, second.name) for _, first, second, _ in overlaps(Context(read_document(file)))]


def test_neighbours_and_pairs_disabled_in_the_srdf_are_left_out(tmp_path):
    bad, good = BY_CODE["RD610"].bad, BY_CODE["RD610"].good
    assert found(bad, tmp_path) == [("fore", "tool")]
    assert found(good, tmp_path) == []
    assert found(good.replace('link="tool"/><origin xyz="0 0 0.1"', 'link="tool"/><origin xyz="0 0 0"'), tmp_path) == []
    srdf = '<robot name="arm"><disable_collisions link1="tool" link2="fore" reason="Never"/></robot>'
    (tmp_path / "arm.srdf").write_text(srdf, encoding="utf-8")
    assert found(bad, tmp_path) == []


@pytest.mark.parametrize("robot", sampled(["panda_collision", "centauro", "talos_reduced", "tiago_pro"], 4))
def test_depths_are_those_of_mujoco(robot):
    mujoco = pytest.importorskip("mujoco")
    path = path_of(robot)
    context = Context(read_document(path))
    text = path.read_text(encoding="utf-8").replace("package://example-robot-data", str(path.parents[3]))
    compiler = '<compiler strippath="false" fusestatic="false" balanceinertia="true" boundmass="1e-6"'
    more = f'<mujoco>{compiler} boundinertia="1e-9"/></mujoco>'
    text = re.sub(r"(<robot[^>]*>)", rf"\1{more}", text, count=1)
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    for joint in context.view.joints:
        k = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, joint.name)
        if k >= 0:
            data.qpos[model.jnt_qposadr[k]] = rest(joint)
    mujoco.mj_forward(model, data)
    deepest: dict[frozenset[str], float] = {}
    for contact in data.contact:
        names = frozenset(model.body(model.geom_bodyid[geom]).name for geom in contact.geom)
        deepest[names] = max(deepest.get(names, 0.0), -contact.dist)
    ours = {frozenset((first.name, second.name)): deep for deep, first, second, _ in overlaps(context)}
    assert ours
    assert ours == pytest.approx({pair: deepest[pair] for pair in ours}, rel=0, abs=2.5e-3)


MANY = 400
LINK = '<link name="{}">{}</link>'
JOINT = (
    '<joint name="j{1}" type="revolute"><parent link="{0}"/><child link="{1}"/><axis xyz="0 0 1"/>'
    '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
)


def shapes(kind, shift=0.0):
    return "".join(
        f'<{kind}><origin xyz="{0.01 * k + shift} 0 0"/><geometry><box size="0.1 0.1 0.1"/></geometry></{kind}>'
        for k in range(MANY)
    )


def context(*links):
    names = "abcd"[: len(links)]
    parts = [LINK.format(name, content) for name, content in zip(names, links, strict=True)]
    joints = [JOINT.format(*pair) for pair in pairwise(names)]
    return Context(read(f'<robot name="r">{"".join(parts + joints)}</robot>'.encode()))


def test_pairs_of_links_are_compared_a_bounded_number_of_times(monkeypatch):
    calls = Counter()

    def deep(*given, original=contacts.depth):
        calls["depth"] += 1
        return original(*given)

    monkeypatch.setattr(contacts, "depth", deep)
    ((_, first, second, _),) = contacts.overlaps(context(shapes("collision"), shapes("visual"), shapes("collision")))
    assert (first.name, second.name) == ("a", "c")
    assert calls["depth"] <= contacts._MOST_PAIRS < MANY**2


def with_tensor(text: str, name: str, tensor: str) -> bytes:
    """The description with other moments of one link."""
    at = text.index("<inertia ", text.index(f'<link name="{name}"'))
    return (text[:at] + tensor + text[text.index("/>", at) + 2 :]).encode()


def tensor_of(data: bytes, name: str) -> Floats:
    link = Context(read(data)).view.link[name]
    assert link.tensor is not None
    return symmetric(link.tensor)


def unsafely_fixed(data: bytes) -> Fixed:
    return fixed(data, "arm.urdf", check_one, unsafe=True)


def test_an_impossible_tensor_becomes_the_mirror_image_of_its_twins() -> None:
    text = two_arms()
    names = [link.name for link in Context(read(text.encode())).view.links]
    left, right = (next(name for name in names if side in name) for side in ("left", "right"))
    broken = with_tensor(text, right, '<inertia ixx="0.7" ixy="0.3" ixz="0.1" iyy="0.02" iyz="-0.2" izz="0.05"/>')
    result = unsafely_fixed(broken)
    assert [made.fix.what for made in result.made] == [f"correct the inertia: the mirror image of that of '{left}'"]
    assert np.allclose(tensor_of(result.after, right), tensor_of(text.encode(), right), rtol=1e-9)


def test_without_a_twin_it_becomes_that_of_the_shapes_where_it_is_far_from_them() -> None:
    bar = '<inertial><origin xyz="0.5 0 0"/><mass value="2"/>{}</inertial>'
    for moments, written in (((-5.0, 7.0, 9.0), True), ((-0.001, 0.168, 0.168), False)):
        link = bar.format(entries(np.diag(moments)))
        data = f'<robot name="r"><link name="bar">{link}{BOX}</link></robot>'.encode()
        what = [made.fix.what for made in unsafely_fixed(data).made]
        assert what == ["correct the inertia: that of its shapes, uniform, of its mass"] * written
        if written:
            assert not {one.code for one in check_one(unsafely_fixed(data).after)} & {"RD206", "RD207", "RD301"}


def test_units_are_written_in_si() -> None:
    """What was in g m^2 has the tensor that it had before to 15 digits."""
    sound = a_shaped_link()
    link = next(one for one in Context(read(sound.encode())).view.links if one.tensor)
    assert link.tensor is not None
    tensor = " ".join(f'{name}="{1000 * value!r}"' for name, value in zip(INERTIA, link.tensor, strict=True))
    result = unsafely_fixed(with_tensor(sound, link.name, f"<inertia {tensor}/>"))
    assert [made.finding.code for made in result.made] == ["RD305"]
    assert np.allclose(tensor_of(result.after, link.name), symmetric(link.tensor), rtol=1e-14)


def test_a_fix_that_would_leave_another_finding_of_the_link_is_refused() -> None:
    """The mirror image is no help where the masses differ as well."""
    text = two_arms().replace('0.2"/><mass value="2"/>', '0.2"/><mass value="3"/>').replace('"3"', '"2"', 1)
    broken = '<inertia ixx="0.7" ixy="0.3" ixz="0.1" iyy="0.02" iyz="-0.2" izz="0.05"/>'
    result = unsafely_fixed(with_tensor(text, "right_arm", broken))
    assert result.made == ()
    assert ["it would leave RD401" in one.why for one in result.refused] == [True]
