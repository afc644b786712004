"""Robots that stand on legs or wheels, or fly, while their base is taken as held: recognised, and said so."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from helpers.command_line import ROBOTS, run
from helpers.example_robots import PATHS, path_of
from helpers.other_robots import other_paths
from helpers.small_robots import built, joint, link, urdf

import robodyn
from robodyn.report.limits import limits_verdict
from robodyn.robot.base_guess import untouched
from robodyn.robot.kinematics import link_poses

FEET, WHEELS, FLIES, STIFF = "feet", "wheels", "thrust", "no joint"
WARNED = {
    FEET: "a1 alexander_v1.lowerBodyOnly anymal anymal-kinova b1 b1-z1 bolt centauro g1_29dof_rev_1_0 "
    "g1_29dof_with_hand_rev_1_0 go1 go2 human hyq_no_sensors icub icub_reduced laikago quadruped romeo "
    "romeo_laas_small romeo_small simple_humanoid simple_humanoid_classical solo solo12 talos_full_v2 "
    "talos_full_v2_box talos_reduced talos_reduced_box talos_reduced_corrected jvrc1 iCub",
    WHEELS: "pr2 tiago tiago_dual tiago_no_hand tiago_pro",
    FLIES: "borinot_flying_arm_2 hextilt_flying_arm_5 iris",
    STIFF: "quadrotor_base iris_simple composite",
}
HELD = (
    "alex_nub_hands alex_sake_hands allegro_left_hand allegro_right_hand TwoDofs baxter double_pendulum "
    "double_pendulum_continuous double_pendulum_simple finger_edu kinova panda panda_collision so100 so101 "
    "talos_left_arm ur10_joint_limited_robot ur10_robot ur3_gripper ur3_joint_limited_robot ur3_robot ur5_gripper "
    "ur5_joint_limited_robot ur5_robot xarm7 z1 iCub-part crank_slider cylindrical delta five_bar four_bar four_bars "
    "gripper heavy_top meshed_arm pendulum planar_3rrr puma puma560 rigid_body satellite scara two_link_planar "
    "two_link_spatial"
)
"""Arms, hands and mechanisms; rigid_body floats by its own description and satellite by its scene."""


def called(path: Path) -> str:
    """The name in the tables above; models of iCub but for two are whole ones."""
    if path.stem != "model":
        return path.stem
    return "iCub-part" if path.parent.name.startswith("left_") else "iCub"


@pytest.mark.parametrize("every", [5, pytest.param(1, marks=pytest.mark.slow)])
def test_which_robots_stand_or_fly_and_which_are_bolted_down(every: int) -> None:
    expected = {name: kind for kind, names in WARNED.items() for name in names.split()}
    expected |= dict.fromkeys(HELD.split(), "")
    paths = [*PATHS, *other_paths(), *ROBOTS.glob("*.urdf")]
    wrong = {}
    for path in paths[::every]:
        found = untouched(robodyn.load(path))
        kind = expected[called(path)]
        if (kind not in found) if kind else found:
            wrong[str(path)] = found
    assert not wrong
    assert {called(path) for path in paths} == expected.keys()


HEADLINE = "No limit is exceeded as long as the base is held (assumed)"
FEET_OF_ANYMAL = tuple(f"{leg}_FOOT" for leg in ("LF", "RF", "LH", "RH"))
BENT = {"HAA": 0.0, "HFE": 0.4, "KFE": -0.8}


def standing(contacts: bool, moving: bool, held: bool = False, share: float = 1.0) -> robodyn.Result:
    """ANYmal with bent knees, with the forces at its feet that carry this share of its weight."""
    model = robodyn.load(path_of("anymal"), moving_base=moving)
    q = np.zeros(model.nq)
    if moving:
        q[6] = 1.0
    for k, name in enumerate(model.coordinates):
        if (kind := name.partition("_")[2]) in BENT:
            q[k] = BENT[kind] * (-1.0 if "H_" in name else 1.0)
    feet = [link_poses(model, q)[name].p for name in FEET_OF_ANYMAL]
    com, weight = robodyn.momenta(model, q).com, 9.81 * model.total_mass
    arms = np.array([(1.0, x, y) for x, y, _ in feet]).T
    forces, *_ = np.linalg.lstsq(arms, share * weight * np.array((1.0, com[0], com[1])), rcond=None)
    wrenches = tuple(
        robodyn.ExternalWrench(name, (0.0, 0.0, float(force)), frame="world")
        for name, force in zip(FEET_OF_ANYMAL, forces, strict=True)
    )
    scene = robodyn.Scene(wrenches=wrenches if contacts else (), moving_base=moving, held=held)
    time, zero = np.linspace(0.0, 1.0, 5), np.zeros((5, model.n))
    return robodyn.torques(model, robodyn.motion(model, time, np.tile(q, (5, 1)), zero, zero), scene)


def knee(result: robodyn.Result) -> float:
    return max(abs(joint.peak) for joint in result.joints if joint.name.endswith("KFE"))


def test_a_quadruped_whose_base_hangs_is_not_green() -> None:
    result = standing(contacts=False, moving=False)
    (caveat,) = result.caveats
    weight = f"{9.81 * robodyn.load(path_of('anymal')).total_mass:.3g} N"
    assert caveat.text.startswith(f"the ground holds the base with {weight} and ")
    assert "there is no contact at its feet ('LF_FOOT', 'RF_FOOT', 'LH_FOOT', 'RH_FOOT')" in caveat.text
    ways = ("--base-held", "[base] held = true", '[base] motion = "moving"', "[[contact]]")
    assert all(way in caveat.text for way in ways)
    assert result.warnings[0] == caveat.text
    assert result.within_limits is None
    verdict = limits_verdict(result)
    assert (verdict.level, verdict.headline) == ("doubtful", HEADLINE)
    assert knee(standing(contacts=True, moving=True)) > 10 * knee(result)


@pytest.mark.parametrize("moving", [True, False])
def test_feet_that_carry_the_weight_or_a_held_base_leave_nothing_in_doubt(moving: bool) -> None:
    for contacts, held in ((True, False), (False, True)):
        result = standing(contacts=contacts, moving=moving, held=held)
        assert not result.caveats
        assert limits_verdict(result).headline == "No limit is exceeded"


@pytest.mark.parametrize(
    ("contacts", "share", "why"), [(False, 0.0, "no contact that carries it"), (True, 0.5, "do not carry it")]
)
def test_a_moving_base_that_nothing_carries_says_so(contacts: bool, share: float, why: str) -> None:
    (caveat,) = standing(contacts=contacts, moving=True, share=share).caveats
    left = (1.0 - share) * 9.81 * robodyn.load(path_of("anymal")).total_mass
    assert caveat.text.startswith(f"the ground holds the base with {left:.3g} N and ")
    assert why in caveat.text


def legged(root="trunk", foot="end", drop=(0, 0, -0.3)) -> bytes:
    """A trunk with two legs of two joints each, which point down, or sideways; all names can be changed."""
    parts = [link(root, 5.0, inertia=(0.1, 0, 0, 0.1, 0, 0.1))]
    for side, y in (("left", 0.1), ("right", -0.1)):
        parent, place = root, (0, y, -0.1)
        for part in ("upper", f"lower_{foot}"):
            child = f"{side}_{part}"
            parts += [link(child, 1.0, inertia=(0.01, 0, 0, 0.01, 0, 0.01))]
            parts += [joint(f"{child}_joint", parent, child, axis=(0, 1, 0), xyz=place)]
            parent, place = child, drop
    return urdf(*parts)


@pytest.mark.parametrize(
    ("names", "stands"),
    [
        ({}, True),
        ({"root": "world"}, False),
        ({"root": "base_link", "drop": (0, 0, 0.3)}, False),
        ({"drop": (0.3, 0, 0)}, False),
        ({"drop": (0.3, 0, 0), "foot": "foot"}, True),
        ({"root": "ground_robot"}, True),
    ],
)
def test_legs_by_where_they_end_or_by_their_names(names: dict, stands: bool) -> None:
    assert bool(untouched(robodyn.load(legged(**names)))) is stands


@pytest.fixture
def files(tmp_path: Path) -> tuple[str, str]:
    (tmp_path / "two.urdf").write_bytes(legged())
    model = robodyn.load(tmp_path / "two.urdf")
    columns = [f"{kind}_{name}" for kind in ("q", "qd", "qdd") for name in model.coordinates]
    rows = [",".join((f"{t / 10}", *["0"] * len(columns))) for t in range(5)]
    (tmp_path / "two.csv").write_text("\n".join([",".join(("time", *columns)), *rows, ""]))
    return str(tmp_path / "two.urdf"), str(tmp_path / "two.csv")


@pytest.mark.parametrize("form", ["text", "json"])
def test_what_is_assumed_is_in_every_report(form: str, files: tuple[str, str]) -> None:
    outcome = run("torques", *files, "--fail-on-limits", "--format", form)
    assert (outcome.status, outcome.err) == (0, "")
    shown = outcome.out
    assert HEADLINE in shown
    assert "the ground holds the base with 88.3 N" in shown
    if form == "json":
        found = json.loads(shown)
        assert found["warnings"] == [found["doubts"][0]["said"]] == found["verdict"]["reasons"][:1]
        assert (found["verdict"]["level"], found["within_limits"]) == ("doubtful", None)
    if form == "text":
        held = run("torques", *files, "--base-held")
        assert "holds the base" not in held.out
        assert HEADLINE not in held.out


def test_a_scene_says_that_the_base_is_held(files: tuple[str, str], tmp_path: Path) -> None:
    scene = tmp_path / "bolts.toml"
    scene.write_text("[base]\nheld = true\n")
    assert "\nNo limit is exceeded.\n" in run("torques", *files, "--scene", str(scene)).out
    scene.write_text('[base]\nheld = "yes"\n')
    outcome = run("torques", *files, "--scene", str(scene))
    assert outcome.status == 2
    assert "\"held\" is 'yes', not true or false" in outcome.err


def test_batches_say_what_is_assumed(files: tuple[str, str], tmp_path: Path) -> None:
    (tmp_path / "more.csv").write_text((tmp_path / "two.csv").read_text())
    call = ("torques", *files, str(tmp_path / "more.csv"), "--out", f"{tmp_path}/out/", "--jobs", "1")
    outcome = run(*call, "--executor", "numpy", "--fail-on-limits")
    assert outcome.status == 0
    said = outcome.out.splitlines()
    assert said[-1] == f"{HEADLINE}."
    assert said[-2].startswith(f"warning: {files[1]} and 1 more: the ground holds the base with 88.3 N and ")
    outcome = run(*call, "--executor", "numpy", "--base-held", "--format", "json")
    assert json.loads(outcome.out)["within_limits"] is True, "results of another assumption are not finished"


def test_a_floating_joint_that_nothing_drives() -> None:
    body = link("body", 2.0, inertia=(1, 0, 0, 1, 0, 1))
    model = built(link("base", 1.0), body, joint("free", "base", "body", "floating"))
    q = np.zeros((3, model.nq))
    q[:, 6] = 1.0
    zero = np.zeros((3, model.n))
    result = robodyn.torques(model, robodyn.motion(model, [0.0, 0.5, 1.0], q, zero, zero))
    (caveat,) = result.caveats
    assert caveat.text.startswith("nothing drives the floating joint 'free', whose motion takes 19.6 N and 0 N m (RMS)")
    fall = zero.copy()
    fall[:, 5] = -9.81
    assert not robodyn.torques(model, robodyn.motion(model, [0.0, 0.5, 1.0], q, zero, fall)).caveats
