"""Why tensors are wrong: planted causes are named and undone, real ones found, clean robots left alone."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from helpers.example_robots import path_of

from robodyn.checks.bodies.causes import Cause, causes
from robodyn.checks.check import Options, check_one, found_in
from robodyn.checks.context import Context
from robodyn.checks.examples import ORIGIN, two_arms
from robodyn.programs.vectors import rotation_from_rpy
from robodyn.robot.masses.mistakes import UPPER, Given, corrections
from robodyn.robot.urdf.document import read
from robodyn.solids.inertia.laws import inertia_matrix, parallel_axis

C = np.array((0.1, -0.05, 0.2))
MASS = 2.0
RPY = (0.3, -0.4, 0.5)
H = np.diag((1.0, -1.0, 1.0))
STEINER = parallel_axis(np.zeros((3, 3)), MASS, C)


def tensors(count: int = 3) -> list[np.ndarray]:
    """Tensors of bodies with unequal second moments along skew axes."""
    rng = np.random.default_rng(3)
    out = []
    for _ in range(count):
        Q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        out.append(inertia_matrix(Q @ np.diag(rng.uniform((0.004, 0.012, 0.03), (0.006, 0.016, 0.04))) @ Q.T))
    return out


def entries(I: np.ndarray) -> str:
    names = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    return "<inertia " + " ".join(f'{n}="{x!r}"' for n, x in zip(names, I[UPPER].tolist(), strict=True)) + "/>"


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
    wrong = np.diag(np.diagonal(I))
    for (i, j), value in zip(((0, 1), (0, 2), (1, 2)), (I[1, 2], I[0, 1], I[0, 2]), strict=True):
        wrong[i, j] = wrong[j, i] = value
    return wrong


def decade(I: np.ndarray) -> np.ndarray:
    wrong = I.copy()
    wrong[2, 2] *= 10.0
    return wrong


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


@pytest.mark.parametrize("code", PLANTED)
@pytest.mark.parametrize("I", tensors(), ids=range(3))
def test_a_planted_cause_is_named_and_undone(code: str, I: np.ndarray) -> None:
    cause = cause_of(I, PLANTED[code](H @ I @ H))
    assert cause is not None
    assert cause.code == code
    assert cause.tensor is not None
    expected = (H @ I @ H)[UPPER]
    assert np.abs(np.array(cause.tensor) - expected).max() <= 1e-11 * np.abs(STEINER).max()


@pytest.mark.parametrize("I", tensors(), ids=range(3))
def test_rotation_that_is_not_applied(I: np.ndarray) -> None:
    R = rotation_from_rpy(*RPY)
    cause = cause_of(I, H @ I @ H, RPY)
    assert cause is not None
    assert cause.code == "RD309"
    assert np.abs(np.array(cause.tensor) - (R.T @ H @ I @ H @ R)[UPPER]).max() <= 1e-11 * np.abs(I).max()


@pytest.mark.parametrize("I", tensors(), ids=range(3))
def test_a_copy_and_a_right_tensor(I: np.ndarray) -> None:
    cause = cause_of(I, I)
    assert cause is not None
    assert (cause.code, cause.tensor, cause.fix) == ("RD313", None, None)
    assert cause_of(I, H @ I @ H) is None


def test_a_tensor_that_is_wrong_in_two_ways_has_no_cause() -> None:
    I = tensors()[0]
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


def test_the_shapes_name_a_cause_of_an_impossible_tensor_and_undo_it() -> None:
    bar = np.diag((0.0033, 0.168, 0.168))
    wrong = bar - parallel_axis(np.zeros((3, 3)), 2.0, np.array((0.5, 0, 0)))
    inertial = f'<inertial><origin xyz="0.5 0 0"/><mass value="2"/>{entries(wrong)}</inertial>'
    data = f'<robot name="r"><link name="bar">{inertial}{BOX}</link></robot>'.encode()
    (one,) = [one for one in check_one(data) if one.code in ("RD206", "RD207")]
    assert one.cause is not None
    assert one.cause.endswith("(RD308)")
    assert one.fix is not None
    assert not one.fix.safe
    for edit in sorted(one.fix.edits, key=lambda edit: -edit.start):
        data = data[: edit.start] + edit.text.encode() + data[edit.end :]
    assert not [one for one in check_one(data) if one.code in ("RD206", "RD207", "RD301")]


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


@pytest.mark.parametrize("beyond", [False, True])
def test_the_nearest_tensor_is_no_fix_where_it_is_beyond_the_shapes(beyond: bool) -> None:
    """A negative moment of a bar, and the same beside products that only a body ten times as thick can have."""
    wrong = np.diag((-0.001, 0.168, 0.168)) + (0.3 * (np.eye(3)[[1, 0, 2]] - np.diag((0, 0, 1))) if beyond else 0.0)
    inertial = f'<inertial><origin xyz="0.5 0 0"/><mass value="2"/>{entries(wrong)}</inertial>'
    (one,) = [
        one
        for one in check_one(f'<robot name="r"><link name="bar">{inertial}{BOX}</link></robot>'.encode())
        if one.code in ("RD206", "RD207")
    ]
    assert (one.fix is None) == beyond


def test_a_fix_leaves_nothing_to_find() -> None:
    """TALOS's arm and gripper have products of the wrong sign, by their meshes."""
    path = path_of("talos_left_arm")
    found = Context(read(path)).once(causes)
    assert {cause.code for cause in found.values()} == {"RD306"}
    assert len(found) >= 4
    data = path.read_bytes()
    edits = [edit for cause in found.values() if cause.fix for edit in cause.fix.edits]
    for edit in sorted(edits, key=lambda edit: -edit.start):
        data = data[: edit.start] + edit.text.encode() + data[edit.end :]
    left = [
        one for one in check_one(data, Options(package_path=(str(path.parents[2]),)), str(path)) if one.code == "RD306"
    ]
    assert not left


def test_of_two_twins_the_one_is_wrong_that_its_shapes_disagree_with() -> None:
    """Two products of TIAGo's left arm have the wrong sign; as its mirror image the right one would be wrong, too."""
    found = Context(read(path_of("tiago_dual"))).once(causes)
    wrong = found["arm_left_3_link"]
    assert (wrong.code, wrong.by_image) == ("RD306", True)
    assert "arm_right_3_link" not in found
    assert found["arm_right_4_link"].by_image


def test_a_forearm_in_other_axes_is_one_finding() -> None:
    """iCub's forearms are drawn along x, and have centre and tensor along y; of several orders it may be any."""
    found = found_in(str(path_of("icub"))).shown
    (forearms,) = [one for one in found if one.code == "RD312"]
    assert [one.subject.name for one in forearms.places if one.subject] == ["l_forearm", "r_forearm"]
    assert forearms.message.count(" or ") == 1
    assert forearms.remedy == "write it in the axes of the link"
    outside = {place.subject.name for one in found for place in one.places if place.subject and one.code == "RD302"}
    assert "l_upper_arm" in outside
    assert not {"l_forearm", "r_forearm"} & outside


def test_every_cause_has_a_rule() -> None:
    slips, _ = corrections(Given(MASS, C, rotation_from_rpy(*RPY), tuple(tensors()[0][UPPER].tolist())))
    assert sorted({slip.code for slip in slips}) == [f"RD{number}" for number in range(306, 313)]
