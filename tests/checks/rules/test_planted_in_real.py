"""Each defect or slip in a published robot is named by its rule, at its place, and by no other rule."""

from __future__ import annotations

import re
from collections import Counter
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np
import pytest
from helpers.example_robots import path_of
from helpers.git_repository import committed
from helpers.planted_defects import DEFECTS
from helpers.planted_ros import (
    ARMS,
    FOLLOWERS,
    FOLLOWING,
    HEALTHY,
    NEIGHBOURS,
    PLANTED,
    Edit,
    Planted,
    Texts,
    texts_of,
    write,
)
from helpers.planted_slips import FILE, HARMLESS, NAMED, Slip, by_its_rule, outcome, slips
from helpers.sampled import sampled
from pinned_findings import pinned

import robodyn
from robodyn.checks.catalogue import BY_CODE, CODES
from robodyn.checks.check import Options, check_one, select_findings
from robodyn.checks.context import Asked, Context
from robodyn.checks.groups import deduplicate
from robodyn.checks.rule import Finding
from robodyn.robot.masses.mistakes import UPPER
from robodyn.robot.urdf.document import read
from robodyn.robot.urdf.parts import INERTIA
from robodyn.solids.inertia.laws import parallel_axis, symmetric
from robodyn.support.floats import Floats


class Plant(NamedTuple):
    """In a robot's link or joint, `old`, a pattern that is in it once, is replaced by `new`; it must be found as
    `code`, at that link or joint or at `found_at`, in words that have `words` in them."""

    code: str
    robot: str
    part: str
    old: str
    new: str
    words: str = ""
    found_at: str = ""

    @property
    def path(self) -> Path:
        return path_of(self.robot)

    @property
    def name(self) -> str:
        return self.found_at or self.part.split()[1]

    @property
    def text(self) -> str:
        return planted_text(self.path.read_text(encoding="utf-8"), self.part, self.old, self.new)


def planted_text(text: str, part: str, old: str, new: str) -> str:
    """The description with `old` replaced in a part, "link NAME" or "joint NAME"."""
    kind, name = part.split()
    elements = re.finditer(rf"<{kind}\s[^>]*?/>|<{kind}\s.*?</{kind}>", text, re.DOTALL)
    named = re.compile(rf"<{kind}\s[^>]*\bname\s*=\s*[\"']{re.escape(name)}[\"']")
    element = next(found for found in elements if named.match(found[0]) and "interface" not in found[0])
    changed, count = re.subn(old, new, element[0], flags=re.DOTALL)
    assert count == 1, f"{old} is {count} times in {part}"
    return text[: element.start()] + changed + text[element.end() :]


def fresh(plant: Plant) -> list[Finding]:
    """The findings that are there with the defect and not without it, by their code and what they are about.

    Left out is what programs make of it (RD901), which is a consequence and no other finding, and what another of them
    explains.
    """
    before = Counter(map(_key, _known(plant.path)))
    found = []
    for finding in check_one(plant.text.encode(), name=str(plant.path)):
        if before[_key(finding)]:
            before[_key(finding)] -= 1
        elif finding.code != "RD901":
            found.append(finding)
    return deduplicate(found, BY_CODE)


@cache
def _known(path: Path) -> tuple[Finding, ...]:
    return check_one(str(path))


def _key(finding: Finding) -> tuple[str, str]:
    return finding.code, finding.subject.name if finding.subject else ""


LIMITS = (
    Plant("RD513", "panda", "joint panda_joint2", 'type="revolute"', 'type="continuous"', "from -1.7628 to 1.7628 rad"),
    Plant("RD513", "xarm7", "joint joint6", 'type="revolute"', 'type="continuous"', "less than a turn"),
    Plant("RD514", "panda", "joint panda_joint4", "<axis [^>]*>", "", "it is revolute and has no <axis>"),
    Plant("RD514", "ur5_robot", "joint elbow_joint", "<axis [^>]*>", ""),
    Plant("RD514", "tiago_no_hand", "joint torso_lift_joint", "<axis [^>]*>", "", "it is prismatic"),
    Plant("RD515", "panda", "joint panda_joint4", 'velocity="2.175"', 'velocity="124.62"', "deg/s"),
    Plant("RD515", "ur5_robot", "joint elbow_joint", 'velocity="3.15"', 'velocity="180"', "deg/s"),
    Plant("RD515", "xarm7", "joint joint3", 'velocity="3.14"', 'velocity="180"', "those of the other joints are 3.14"),
    Plant("RD515", "panda", "joint panda_joint4", 'effort="87.0"', 'effort="87000"', "N mm"),
    Plant("RD515", "ur5_robot", "joint wrist_1_joint", 'effort="28.0"', 'effort="28000"', "N mm"),
    Plant("RD515", "pr2", "joint torso_lift_joint", 'upper="0.31"', 'upper="310"', "upper is 310 m"),
    Plant("RD515", "tiago_no_hand", "joint torso_lift_joint", 'upper="0.35"', 'upper="350"', "upper is 350 m"),
    Plant("RD515", "panda", "joint panda_finger_joint1", 'velocity="0.2"', 'velocity="200"', "mm/s"),
    Plant("RD515", "ur3_robot", "joint shoulder_lift_joint", 'effort="330.0"', 'effort="330000"', "N mm"),
    Plant("RD516", "panda", "joint panda_finger_joint2", 'type="prismatic"', 'type="revolute"', "0 to 0.04 at 0.2"),
    Plant("RD516", "tiago_no_hand", "joint torso_lift_joint", 'type="prismatic"', 'type="revolute"', "20.1 degrees"),
)
_FLAT = 'scale="1 1 1e-9"'
_FELT = "<collision>(.*?)"
FITS = (
    Plant("RD611", "panda", "link panda_link4", "collision/link4.stl\"", rf"\g<0> {_FLAT}", "along its z axis"),
    Plant("RD611", "z1", "link link02", 'length="0.102"', 'length="1e-7"', "the collision cylinder is flat: 1e-07 m"),
    Plant("RD609", "panda", "link panda_link4", "<collision>", r'\g<0><origin xyz="0 0 0.3"/>', "up to 0.3 m"),
    Plant("RD609", "hyq_no_sensors", "link lf_lowerleg", 'xyz="0.173 0 0"', 'xyz="0.173 0 1.5"', "between"),
    Plant("RD609", "xarm7", "link link4", f'{_FELT}rpy="0 0 0"', r'<collision>\1rpy="0 1.5708 0"', "is not where"),
    Plant("RD609", "panda", "link panda_link4", 'collision/link4.stl"', r'\g<0> scale="2 2 2"', "mesh is 2 times"),
    Plant("RD609", "ur5_robot", "link forearm_link", 'collision/forearm.stl"', r'\g<0> scale="0.5 0.5 0.5"', "0.501"),
    Plant("RD609", "tiago_no_hand", "link caster_front_right_2_link", '="0.025"', '="25"', "sphere is 1.18e+03 times"),
    Plant("RD609", "g1_29dof_rev_1_0", "link left_shoulder_pitch_link", '="0.05"', '="50"', "what is seen"),
    Plant("RD609", "anymal-kinova", "link RH_SHANK", 'size="0.08 0.07 0.13"', 'size="80 70 130"', "as large as what"),
    Plant("RD609", "quadruped", "link BL_shank", '="0.16" radius="0.025"', '="0.025" radius="0.16"', "exchanged"),
    Plant("RD609", "panda", "link panda_link4", "collision/link4.stl", "collision/link6.stl",  "link 'panda_link6'"),
    Plant("RD609", "go2", "link FL_thigh", "collisions/thigh_convex.stl", "collisions/hip_convex.stl", "that of link"),
    Plant("RD609", "ur10_robot", "link upper_arm_link", f"{_FELT}<geom", r'<collision><origin rpy="1.6 0 0"/><geom'),
    Plant("RD609", "xarm7", "link link6", "<visual>(.*?)link6.stl", r"<visual>\1link2.stl", "not the part that its"),
    Plant("RD605", "talos_full_v2_box", "link torso_2_link", '(n.STL" scale=).1 1 1', r'\1"1e3 1e3 1e3', "kilometres"),
)  # fmt: skip
TREE = (
    Plant("RD111", "panda", "joint panda_joint4", 'xyz="0.0825 0 0"', 'xyz="82.5 0 0"', "from those of 'panda_link3'"),
    Plant("RD111", "ur5_robot", "joint elbow_joint", 'xyz="0.0 -0.1197 0.425"', 'xyz="0.0 -0.1197 425"', "from those"),
    Plant("RD111", "z1", "joint joint2", 'xyz="0 0 0.045"', 'xyz="0 0 45"'),
    Plant("RD111", "go2", "joint FL_calf_joint", 'xyz="0 0 -0.213"', 'xyz="0 0 -213"'),
    Plant("RD111", "panda", "joint panda_joint4", 'xyz="0.0825 0 0"', 'xyz="0.825 0 0"'),
    Plant("RD111", "ur5_robot", "joint elbow_joint", 'xyz="0.0 -0.1197 0.425"', 'xyz="0.0 -0.1197 1.425"'),
    Plant("RD111", "tiago_no_hand", "joint torso_lift_joint", 'xyz="0.0 0.0 0.597"', 'xyz="0.0 5.97 0.0"'),
    Plant("RD111", "ur5_robot", "joint wrist_1_joint", 'link="forearm_link"', 'link="base_link"'),
    Plant("RD112", "hyq_no_sensors", "joint rf_kfe_joint", 'parent link="[^"]*"', 'parent link="lh_upperleg"', "lf_"),
    Plant("RD112", "b1", "joint FL_calf_joint", 'parent link="[^"]*"', 'parent link="RL_hip"', "'FR_calf'"),
    Plant("RD112", "solo12", "joint FL_KFE", 'parent link="[^"]*"', 'parent link="HR_SHOULDER"'),
    Plant("RD111", "xarm7", "joint joint5", 'parent link="[^"]*"', 'parent link="link_base"'),
)  # fmt: skip
_LINK7 = (
    '<inertial><origin rpy="0 0 0" xyz="1.0517e-02 -4.252e-03 6.1597e-02"/><mass value="0.735522"/><inertia '
    'ixx="0.012516" ixy="-0.000428" ixz="-0.001196" iyy="0.010027" iyz="-0.000741" izz="0.004815"/></inertial>'
)
_WRIST = (
    '<inertial><mass value="0.99"/><origin xyz="0 0 -0.06"/><inertia ixx="0.0003453236187" ixy="0" ixz="0" '
    'iyy="0.0003453236187" iyz="0" izz="0.0005816"/></inertial>'
)
_FLANGE = (
    '<inertial><origin xyz="0 -0.00677 -0.01098"/><mass value="0.17"/><inertia ixx="9.3e-05" ixy="-0.0" ixz="-0.0" '
    'iyy="5.87e-05" iyz="-3.6e-06" izz="0.000132"/></inertial>'
)
_INERTIAL = "<inertial>.*</inertial>"
MASSES = (
    Plant("RD213", "panda", "link panda_link8", _INERTIAL, _LINK7, "its mass of 0.735522 kg is that of link"),
    Plant("RD213", "kinova", "link j2s6s200_end_effector", _INERTIAL, _WRIST, "to which it is fixed, again"),
    Plant("RD214", "go2", "link FL_thigh", _INERTIAL, "", "what moves with it weighs 0.089 kg without it"),
    Plant("RD214", "panda", "link panda_link7", _INERTIAL, "", "it has shapes and no <inertial>"),
    Plant("RD214", "anymal", "link LF_SHANK", _INERTIAL, ""),
    Plant("RD213", "xarm7", "link link_eef", "/>", f">{_FLANGE}</link>", "its mass of 0.17 kg"),
)
_MASS, _TURN = r'(<mass\s+value=")[^"]*', r'(<inertial>.*?<origin[^>]*?)rpy\s*=\s*"[^"]*"'
TWINS = (
    Plant("RD517", "xarm7", "joint joint4", '<axis xyz="[^"]*"', '<axis xyz="0 1 0"', "all 6 other joints about 0 0 1"),
    Plant("RD506", "panda", "joint panda_joint4", 'velocity="2.175"', 'velocity="0.02175"', "every other joint 2.175"),
    Plant("RD112", "panda", "joint panda_joint5", 'parent link="panda_link4"', 'parent link="panda_link3"', "beside"),
    Plant("RD406", "go2", "link FR_calf", "<collision.*</collision>", "", "its mirror twin 'FL_calf'"),
    Plant("RD517", "panda", "joint panda_joint2", 'rpy="[^"]*"', 'rpy="0 0 0"', "turns about the line of joint"),
    Plant("RD401", "hyq_no_sensors", "link lf_upperleg", _MASS, r"\g<1>1.5"),
    Plant("RD401", "anymal", "link LF_THIGH", _MASS, r"\g<1>1.5"),
    Plant("RD309", "go2", "link FL_thigh", _TURN, r'\1rpy="0.9 1.2 0.3"'),
    Plant("RD309", "solo12", "link FL_UPPER_LEG", _TURN, r'\1rpy="0.9 1.2 0.3"'),
    Plant("RD602", "panda", "link panda_link4", "collision/link4.stl", "collision/Link4.stl"),
)
_AT = r"(<origin[^>]*?)xyz=\"[^\"]*\""
OVERLAPS = (
    Plant("RD610", "ur5_robot", "joint elbow_joint", _AT, r'\1xyz="0 -0.1197 0"', "into link", "forearm_link"),
    Plant("RD610", "kinova", "joint j2s6s200_joint_3", _AT, r'\1xyz="0 0 0"', "j2s6s200_link_1'", "j2s6s200_link_3"),
    Plant("RD610", "so101", "joint elbow_flex", _AT, r'\1xyz="0 0 0"', "no neighbour of it", "lower_arm_link"),
    Plant("RD610", "panda", "joint panda_joint6", _AT, r'\1xyz="-0.0825 0 0"', "so do", "panda_rightfinger"),
)  # fmt: skip


PLANTS = (*LIMITS, *FITS, *TREE, *MASSES, *TWINS, *OVERLAPS)
OF_TWO = ("RD401", "RD406", "RD517")
"""Of these rules both places are named where it is not known which is wrong."""


@pytest.mark.parametrize("plant", sampled(PLANTS, 20), ids=lambda plant: f"{plant.code}-{plant.robot}-{plant.part}")
def test_named_and_nothing_else(plant: Plant) -> None:
    beside = ("RD901", "RD517") if plant.code == "RD610" else ("RD901",)  # two joints in one place turn about one line
    found = [one for one in fresh(plant) if one.code not in beside]  # MuJoCo refuses flat meshes, too
    names = [one.subject.name for one in found if one.subject is not None]
    assert {one.code for one in found} == {plant.code}
    assert plant.name in names
    assert len(names) == len(found) <= (2 if plant.code in OF_TWO else 1)
    assert plant.words in found[0].message


def test_millimetres_in_an_origin_are_named() -> None:
    causes = {plant.robot: [one.cause for one in fresh(plant)] for plant in TREE[:3:2]}
    x, z = "entry x of its origin is in millimetres", "entry z of its origin is in millimetres"
    assert causes == {"panda": [x], "z1": [z]}


CASES = [pytest.param(each, stem, id=f"{each.kind}-{stem}") for each in PLANTED for stem in each.robots]
SOUND = [
    *((edit, stem) for edit in HEALTHY for stem in ARMS),
    *((edit, stem) for edit in FOLLOWING for stem in FOLLOWERS),
]
OPTIONS = Options(ignore=("RD901",))
"""Without what single programs make of it."""


def found(texts: Texts, options: Options = OPTIONS) -> tuple[Finding, ...]:
    with TemporaryDirectory() as folder:
        return check_one(str(write(Path(folder), texts)), options)


@cache
def codes(stem: str) -> Counter[str]:
    return Counter(one.code for one in found(texts_of(stem)))


@pytest.mark.parametrize(("planted", "stem"), sampled(CASES, 14))
def test_found_once_and_nothing_else(planted: Planted, stem: str) -> None:
    texts = planted.edit(*texts_of(stem))
    assert texts != texts_of(stem)
    new = found(texts)
    assert Counter(one.code for one in new) - codes(stem) == {planted.code: 1}


@pytest.mark.parametrize(("edit", "stem"), sampled([pytest.param(*each) for each in SOUND], 10))
def test_what_is_sound_stays_unfound(edit: Edit, stem: str) -> None:
    assert not Counter(one.code for one in found(edit(*texts_of(stem)))) - codes(stem)


@pytest.mark.parametrize("stem", sampled(NEIGHBOURS.robots, 4))
def test_neighbours_that_touch(stem: str) -> None:
    """Where their meshes are is said: what touches is known by these."""
    options = Options(select=("RD709",), package_path=(str(path_of(stem).parents[4]),))
    assert not found(texts_of(stem), options)
    (one,) = found(NEIGHBOURS.edit(*texts_of(stem)), options)
    assert one.file.endswith(".srdf")


def test_each_kind_is_planted_in_three_robots() -> None:
    kinds = (*PLANTED, NEIGHBOURS)
    assert len({each.kind for each in kinds}) == len(kinds) >= 40
    assert all(len(set(each.robots)) >= 3 for each in kinds)


UNSEEN = (FILE.parent / "unseen_slips.txt").read_text(encoding="utf-8").splitlines()
"""Slips that are not named so far; `benchmarks.bench_slips --unseen 1` writes them."""
ALL = slips()


@pytest.mark.parametrize("slip", sampled([slip for slip in ALL[::-1] if str(slip) not in UNSEEN], 170), ids=str)
def test_named(slip: Slip) -> None:
    if slip.group == HARMLESS:
        assert not outcome(slip).elsewhere
    else:
        assert by_its_rule(slip).verdict == NAMED


def test_many_kinds_in_three_robots_and_most_named() -> None:
    kinds = {slip.kind for slip in ALL if slip.group != HARMLESS}
    robots = {kind: {slip.robot for slip in ALL if slip.kind == kind} for kind in kinds}
    assert sum(len(each) >= 3 for each in robots.values()) >= 160
    assert len(UNSEEN) < 0.12 * len(ALL)
    assert set(UNSEEN) <= {str(slip) for slip in ALL}


OTHER_UNIT = ("z1", "panda", "go2", "solo12")
UNITS = {1000.0: "in millimetres", 0.001: "a thousandth of metres"}
LENGTHS = re.compile(r'<axis\b[^>]*>|\b(xyz|size|radius|length)="([^"]*)"')
MESH = re.compile(r"<mesh\b[^>]*?/?>")


def drawn(text: str, times: float) -> str:
    """The description with all its lengths multiplied, but for axes."""

    def scaled(found: re.Match[str]) -> str:
        if found[1] is None:
            return found[0]
        return f'{found[1]}="{" ".join(repr(times * float(number)) for number in found[2].split())}"'

    def mesh(found: re.Match[str]) -> str:
        given = re.search(r'scale="([^"]*)"', found[0])
        old = [float(number) for number in given[1].split()] if given else [1.0] * 3
        scale = f'scale="{" ".join(repr(times * factor) for factor in old)}"'
        return found[0].replace(given[0], scale) if given else found[0].replace("<mesh", f"<mesh {scale}")

    return MESH.sub(mesh, LENGTHS.sub(scaled, text))


def severe(stem: str, times: float) -> list[Finding]:
    path = path_of(stem)
    text = drawn(path.read_text(encoding="utf-8"), times)
    found = select_findings(check_one(text.encode(), name=str(path)), Options()).shown
    return [one for one in found if one.code != "RD403"]


@pytest.mark.parametrize("stem", sampled(OTHER_UNIT, 4))
@pytest.mark.parametrize("times", UNITS)
def test_it_is_named_once(stem: str, times: float) -> None:
    known = {one.code for one in severe(stem, 1.0)}
    assert "RD113" not in known
    found = [one for one in severe(stem, times) if one.code not in known]
    assert [one.code for one in found] == ["RD113"]
    assert UNITS[times] in found[0].message


@pytest.mark.parametrize("times", sampled([0.1, 10.0, 39.37, 100.0], 4))
def test_another_factor_is_not_named(times: float) -> None:
    assert "RD113" not in {one.code for one in severe("z1", times)}


def less_steiner(I: Floats, mass: float, centre: Floats) -> Floats:
    return I - parallel_axis(np.zeros((3, 3)), mass, centre)


def products_turned(I: Floats, _: float, __: Floats) -> Floats:
    return np.array([[I[0, 0], I[1, 2], I[0, 1]], [I[1, 2], I[1, 1], I[0, 2]], [I[0, 1], I[0, 2], I[2, 2]]])


CAUSES = {"RD308": less_steiner, "RD310": products_turned}


@pytest.mark.parametrize(
    ("robot", "link"),
    [("go2", "FL_thigh"), pytest.param("b1", "FR_thigh", marks=pytest.mark.slow), ("solo12", "FL_UPPER_LEG")],
)
@pytest.mark.parametrize("code", CAUSES)
def test_causes_of_tensors_that_no_body_has(code: str, robot: str, link: str) -> None:
    view = Context(read(str(path_of(robot)))).view.link[link]
    assert view.inertial is not None
    assert view.tensor is not None
    centre = np.array(view.inertial.origin.xyz.or_default(0.0, 0.0, 0.0))
    wrong = CAUSES[code](symmetric(view.tensor), view.mass or 0.0, centre)[UPPER].tolist()
    new = "<inertia " + " ".join(f'{name}="{x!r}"' for name, x in zip(INERTIA, wrong, strict=True)) + "/>"
    (one,) = fresh(Plant(code, robot, f"link {link}", r"<inertia\b[^>]*?/>", new))
    assert (one.code in ("RD206", "RD207"), one.subject and one.subject.name) == (True, link)
    assert (one.cause or "").endswith(f"({code})")


def test_what_is_asked_of_published_robots(tmp_path: Path) -> None:
    """A format that MuJoCo does not read, a motion, an earlier version."""
    motion, version = tmp_path / "motion.csv", tmp_path / "panda.urdf"
    names = robodyn.load(path_of("panda")).joint_names
    rows = (",".join(str(-k / 10 * (name == "panda_joint4")) for name in names) for k in range(40))
    lines = [f"{k / 10},{row}\n" for k, row in enumerate(rows)]
    motion.write_text(f"time,{','.join(f'q_{name}' for name in names)}\n{''.join(lines)}")
    version.write_text(path_of("panda").read_text())
    committed(tmp_path)
    version.write_text(Plant("RD902", "panda", "link panda_link4", _MASS, r"\g<1>1.5").text)
    for code, file, asked, name in (
        ("RD607", path_of("kinova"), Asked(targets=("mujoco",)), "j2s6s200_link_base"),
        ("RD802", path_of("panda"), Asked(trajectory=str(motion)), "panda_joint4"),
        ("RD902", version, Asked(against="HEAD"), "panda_link4"),
    ):
        found = check_one(str(file), Options(select=(code,), asked=asked))
        assert {one.code for one in found} == {code}
        assert name in {one.subject and one.subject.name for one in found}


def test_every_rule_speaks_of_a_published_robot_or_of_a_defect_that_is_planted() -> None:
    """Those of units are planted in whole robots."""
    real = {key.split()[0] for counts in pinned().values() for key in counts}
    planted = {one.code for one in (*PLANTS, *PLANTED, *DEFECTS)} | {*CAUSES, "RD113", "RD607", "RD802", "RD902"}
    assert {*CODES} - real == planted - real
