"""Why tensors are wrong: planted causes are named and undone, real ones found, clean robots left alone."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from helpers.example_robots import path_of

from robodyn.checks.bodies.masses import principal_moments
from robodyn.checks.causes.causes import Cause, causes
from robodyn.checks.causes.evidence import UPPER, clearly_possible
from robodyn.checks.causes.forms import FORMS
from robodyn.checks.context import Context
from robodyn.checks.examples import ORIGIN, two_arms
from robodyn.checks.run import check_one
from robodyn.programs.vectors import rotation_from_rpy
from robodyn.robot.urdf.document import read
from robodyn.solids.inertia.laws import inertia_matrix, parallel_axis

C = np.array((0.1, -0.05, 0.2))
MASS = 2.0
RPY = (0.3, -0.4, 0.5)
H = np.diag((1.0, -1.0, 1.0))
STEINER = parallel_axis(np.zeros((3, 3)), MASS, C)


def tensors(count: int = 8) -> list[np.ndarray]:
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
@pytest.mark.parametrize("I", tensors(), ids=range(8))
def test_a_planted_cause_is_named_and_undone(code: str, I: np.ndarray) -> None:
    cause = cause_of(I, PLANTED[code](H @ I @ H))
    assert cause is not None
    assert cause.code == code
    assert cause.tensor is not None
    expected = (H @ I @ H)[UPPER]
    assert np.abs(np.array(cause.tensor) - expected).max() <= 1e-11 * np.abs(STEINER).max()


@pytest.mark.parametrize("I", tensors(), ids=range(8))
def test_rotation_that_is_not_applied(I: np.ndarray) -> None:
    R = rotation_from_rpy(*RPY)
    cause = cause_of(I, H @ I @ H, RPY)
    assert cause is not None
    assert cause.code == "RD309"
    assert np.abs(np.array(cause.tensor) - (R.T @ H @ I @ H @ R)[UPPER]).max() <= 1e-11 * np.abs(I).max()


@pytest.mark.parametrize("I", tensors(), ids=range(8))
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


def test_mujoco_s_order_needs_no_twin_but_is_voigt_s_as_well() -> None:
    """Its six numbers with names of URDF: iyy and izz hold products. Which product is which, only a twin tells."""
    I = tensors()[0]
    xx, xy, xz, yy, yz, zz = I[UPPER]
    wrong = np.array(((xx, yy, zz), (yy, xy, xz), (zz, xz, yz)))
    text = two_arms(right=f'<mass value="2"/>{entries(wrong)}').replace("left_arm", "other").replace("left_s", "s")
    cause = Context(read(text.encode())).once(causes).get("right_arm")
    assert cause is not None
    assert cause.code == "RD310"
    assert "MuJoCo" in cause.what
    assert (cause.physical, cause.tensor, cause.fix) == (False, None, None)
    told = cause_of(H @ I @ H, wrong)
    assert told is not None
    assert told.code == "RD310"
    assert told.tensor == pytest.approx(I[UPPER], rel=1e-11)


@pytest.mark.parametrize("stem", ["allegro_left_hand", "allegro_right_hand"])
def test_flipping_three_signs_makes_the_allegro_hand_physical(stem: str) -> None:
    found = Context(read(path_of(stem))).once(causes)
    assert len(found) == 4
    for cause in found.values():
        assert (cause.code, cause.physical) == ("RD306", False)
        small, middle, large = principal_moments(cause.tensor or ())
        assert small + middle > 1.05 * large


def test_the_parallel_axis_term_makes_romeo_physical() -> None:
    found = Context(read(path_of("romeo_laas_small"))).once(causes)
    assert {name: cause.code for name, cause in found.items()} == dict.fromkeys(
        ("LShoulderYaw_link", "LElbowYaw_link", "body", "LHipPitch_link", "RHipPitch_link"), "RD308"
    )


def test_a_fix_leaves_nothing_to_find() -> None:
    data = path_of("allegro_left_hand").read_bytes()
    edits = [edit for cause in Context(read(data)).once(causes).values() if cause.fix for edit in cause.fix.edits]
    for edit in sorted(edits, key=lambda edit: -edit.start):
        data = data[: edit.start] + edit.text.encode() + data[edit.end :]
    assert not Context(read(data)).once(causes)
    assert not [one for one in check_one(data) if one.code in ("RD206", "RD207")]


@pytest.mark.parametrize("stem", ["go2", "g1_29dof_rev_1_0", "solo12", "xarm7", "kinova", "talos_left_arm", "panda"])
def test_clean_robots_have_no_cause(stem: str) -> None:
    assert not Context(read(path_of(stem))).once(causes)


def test_the_quick_verdict_never_contradicts_the_moments() -> None:
    rng = np.random.default_rng(5)
    clear = 0
    for _ in range(300):
        A = rng.normal(size=(3, 3))
        six = inertia_matrix(A @ np.diag(rng.uniform(-0.2, 1.0, 3)) @ A.T)[UPPER].tolist()
        if clearly_possible(*six):
            clear += 1
            small, middle, large = principal_moments(tuple(six))
            assert small > 1e-9 * large
            assert small + middle >= large
    assert 50 < clear < 250


def test_every_cause_has_a_rule() -> None:
    assert sorted(FORMS) == [f"RD{number}" for number in range(306, 314)]


@pytest.mark.parametrize(("stem", "code"), [("allegro_left_hand", "RD306"), ("romeo_laas_small", "RD308")])
def test_the_finding_of_an_impossible_tensor_has_its_cause_and_fix(stem: str, code: str) -> None:
    found = [one for one in check_one(str(path_of(stem))) if one.code in ("RD206", "RD207")]
    assert found
    for one in found:
        assert one.cause is not None
        assert one.cause.endswith(f"({code})")
        assert one.fix is not None
        assert not one.fix.safe
