"""Rules that hold inertials against shapes, and efforts against the most that gravity asks of joints."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from helpers.example_robots import path_of
from helpers.mesh_samples import binary_stl, box, uv_sphere
from helpers.sampled import sampled

import robodyn
from robodyn.checks.check import Options, check_one
from robodyn.checks.context import Context
from robodyn.checks.examples import INERTIA, LIMIT, a_joint, a_link, a_shaped_link, arm, longer_arm
from robodyn.checks.rule import Finding, Severity
from robodyn.checks.rules.loads import (
    gravity_bounds,
    inverse_of_definite,
    joint_space_inertia,
    position_ranges,
    static_torques,
)
from robodyn.robot.urdf.document import read
from robodyn.solids.inertia import solids

E, W, I = Severity.ERROR, Severity.WARNING, Severity.NOTE
SHAPE = ("RD301", "RD302", "RD303", "RD304", "RD305")


def findings(source: str | bytes) -> list[Finding]:
    return list(check_one(source, Options(select=SHAPE)))


def found(source: str | bytes) -> list[tuple[str, Severity]]:
    return [(one.code, one.severity) for one in findings(source)]


def tensor(xx: float, yy: float, zz: float) -> str:
    return f'<inertia ixx="{xx!r}" ixy="0" ixz="0" iyy="{yy!r}" iyz="0" izz="{zz!r}"/>'


def scaled(factor: float) -> str:
    return tensor(0.0126 * factor, 0.0124 * factor, 0.0032 * factor)


def rod(mass: float, apart: float) -> str:
    """A tensor of two points on the z axis, with a little thickness."""
    along = mass * apart**2 / 4
    return tensor(along + 1e-9, along + 1e-9, 2e-9)


@pytest.mark.parametrize(
    ("apart", "expected"),
    [(0.24, []), (0.2499, []), (0.27, [("RD301", I)]), (0.31, [("RD301", W)]), (0.59, [("RD301", E)])],
)
def test_two_points_within_and_beyond_the_box(apart: float, expected: list[tuple[str, Severity]]) -> None:
    """The box is 0.1 x 0.1 x 0.25; its corners are 0.1436 from the middle. Points on its faces reach the bound."""
    given = findings(a_shaped_link(inertia=rod(2.0, apart), centre="0 0 0.125").encode())
    beyond = [one for one in given if one.code == "RD301"]
    assert [(one.code, one.severity) for one in beyond] == expected
    assert ("RD303", W) in [(one.code, one.severity) for one in given], "all of its mass is on a line"
    for one in beyond if apart > 0.5 else ():
        assert one.measured == pytest.approx(2 * apart**2 / 4, rel=1e-6)
        assert one.bound == pytest.approx(2 * (0.125**2 + 2 * 0.05**2), rel=1e-12)


@pytest.mark.parametrize(
    ("z", "expected"), [(0.25, []), (0.278, []), (0.28, [("RD302", W)]), (0.53, [("RD302", W)]), (0.55, [("RD302", E)])]
)
def test_a_centre_outside_the_box(z: float, expected: list[tuple[str, Severity]]) -> None:
    """The diagonal of the box is 0.287."""
    assert found(a_shaped_link(centre=f"0 0 {z}").encode()) == expected


@pytest.mark.parametrize(("z", "cause"), [(-0.12, "it may be that z has the wrong sign"), (-0.05, None), (0.3, None)])
def test_a_sign_of_the_centre(z: float, cause: str | None) -> None:
    """The palm of Allegro is drawn below its frame, and has its centre above. With 0.05, 0.075 from the middle, it may
    as well be something else."""
    (one,) = [one for one in findings(a_shaped_link(centre=f"0 0 {z}").encode()) if one.code == "RD302"]
    assert one.cause == cause


@pytest.mark.parametrize("factor", [1e3, 1e6, 1e9, 25.4, 1e-3, 1e-6])
def test_factors_between_units(factor: float) -> None:
    for what, changed, known in (
        ("mass", {"mass": repr(2 * factor)}, (1e3, 1e6, 1e-3)),
        ("inertia", {"inertia": scaled(factor)}, (1e3, 1e6, 1e9, 1e-3, 1e-6)),
        ("centre of mass", {"centre": f"0 0 {0.12 * factor!r}"}, (1e3,)),
    ):
        results = findings(a_shaped_link(**changed).encode())
        if factor in known:
            assert [(one.code, one.severity, one.measured) for one in results] == [("RD305", E, pytest.approx(factor))]
            assert f"the {what} is" in results[0].message
        else:
            assert "RD305" not in {one.code for one in results}


def test_a_factor_is_not_named_where_its_neighbours_are_as_good() -> None:
    """A centre 0.12 m from the origin of a box 0.25 m long may be anywhere in it: 16.7 times is as good as 25.4."""
    for factor in (16.7, 25.4):
        (one,) = findings(a_shaped_link(centre=f"0 0 {0.12 * factor!r}").encode())
        assert (one.code, one.severity) in [("RD302", E), ("RD305", W)]


def test_tensors_that_were_made_up_are_no_slip() -> None:
    """Nor are those that were raised to a floor for the sake of a simulator, as in iCubGazeboV2_5."""
    raised = '<inertia ixx="10" ixy="1e-5" ixz="-3e-3" iyy="10" iyz="6e-5" izz="10.01"/>'
    for inertia in (tensor(10.0, 10.0, 10.0), raised):
        (one,) = findings(a_shaped_link(inertia=inertia).encode())
        assert (one.code, one.severity) == ("RD301", E)
        floor = "it may be that its moments were raised to 10 kg m^2, as simulators are helped"
        assert one.cause == (floor if inertia == raised else None)
    (one,) = findings(a_shaped_link(inertia=tensor(10.0, 11.0, 10.0)).encode())
    assert "raised" not in (one.cause or "")


@pytest.mark.parametrize(("factor", "expected"), [(1.01, []), (0.99, [("RD303", W)]), (0.009, [])])
def test_a_link_without_shapes_is_no_denser_than_tungsten(factor: float, expected: list[tuple[str, Severity]]) -> None:
    """TIAGo's camera was held against the shapes of the head that it is fixed to; they say nothing of the least."""
    ball = float(solids.sphere((3 / (4 * np.pi * 19300)) ** (1 / 3), mass=1.0).inertia[0, 0]) * factor
    link = f'<link name="camera"><inertial><mass value="1"/>{tensor(ball, ball, ball)}</inertial></link>'
    joint = '<joint name="mount" type="fixed"><parent link="upper"/><child link="camera"/></joint></robot>'
    assert found(a_shaped_link().replace("</robot>", link + joint).encode()) == expected


def test_shapes_of_links_that_are_fixed_count() -> None:
    """A tensor too large for its own shape fits that of its rigid group."""
    large = '<collision><geometry><box size="2 2 2"/></geometry></collision>'
    text = a_shaped_link(inertia=tensor(0.3, 0.32, 0.28))
    assert found(text.encode()) == [("RD301", E)]
    more = f"""<link name="cover">{large}</link>
  <joint name="glue" type="fixed"><parent link="upper"/><child link="cover"/></joint>"""
    assert [severity for _, severity in found(text.replace("</robot>", more + "</robot>").encode())] == [W]


@pytest.mark.parametrize(("radius", "expected"), [(0.05, []), (0.1, ["RD208"])])
def test_a_solid_ball_is_no_stand_in(radius: float, expected: list[str]) -> None:
    """1 kg of 5 cm radius have 0.001 kg m^2 in all directions."""
    text = a_shaped_link("1", tensor(0.001, 0.001, 0.001), "0 0 0.125", f'<sphere radius="{radius}"/>')
    assert [one.code for one in check_one(text.encode(), Options(select=("RD208",)))] == expected


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


SLIDE = 'type="revolute"', 'type="prismatic"'
OUT = '<axis xyz="0 1 0"/>\n        <limit lower="-0.25"', '<axis xyz="1 0 0"/>\n        <limit lower="-0.25"'


@pytest.mark.parametrize(
    ("text", "first", "second"),
    [
        (planar(-2.0, 2.0), G * (3 * 1 + 2 * 2), G * 2),
        (planar(-2.0, 2.0, axis="0 0 1"), 0.0, 0.0),
        (planar(-2.0, 2.0, axis="0 0 1").replace(*SLIDE, 1), G * 5, None),
        (planar(-0.25, 0.5).replace(f'name="j2" {SLIDE[0]}', f'name="j2" {SLIDE[1]}').replace(*OUT), G * 8, None),
        (planar(-1e16, 1e16), G * 7, G * 2),
    ],
    ids=["stretched", "upright axes", "a lift", "a slide that reaches out", "sentinel limits"],
)
def test_closed_forms(text: str, first: float, second: float | None) -> None:
    """Bent by q2 = b at least, |3 e(q1) + 2 (e(q1) + e(q1 + q2))| is largest at q2 = b."""

    def found(text: str) -> dict[str, float]:
        return {joint.name: abs(torque) for joint, torque, _ in context(text).once(static_torques)}

    assert found(text).get("j1", 0.0) == pytest.approx(first, rel=1e-9)
    assert second is None or found(text).get("j2", 0.0) == pytest.approx(second, rel=1e-9)
    assert found(planar(1.2, 2.0))["j1"] == pytest.approx(G * abs(5 + 2 * np.exp(1.2j)), rel=2e-3)


@pytest.mark.parametrize(
    "stem", sampled(["pr2", "talos_reduced", "human", "baxter", "panda", "tiago_no_hand", "g1_29dof_rev_1_0"], 4)
)
def test_torques_are_those_of_the_recursion_and_no_random_pose_within_limits_asks_for_more(stem: str) -> None:
    """Nor for more than the bound, which also holds for joints that are not looked at."""
    one = context(path_of(stem))
    model, results, bounds = one.model, one.once(static_torques), one.once(gravity_bounds)
    assert results or stem in ("panda", "human", "tiago_no_hand", "g1_29dof_rev_1_0")  # which bear their weight
    low, high = position_ranges(model)
    poses = np.array([q for _, _, q in results]).reshape(-1, model.n)
    assert ((low <= poses) & (poses <= high)).all()
    tau = robodyn.bias_forces(model, poses, 0.0, executor="numpy") if results else poses
    q = low + np.random.default_rng(1).random((2000, model.n)) * (high - low)
    most = np.abs(robodyn.bias_forces(model, q, 0.0)).max(axis=0)
    for k, (joint, torque, _) in enumerate(results):
        bound, _ = bounds[joint.name]
        assert abs(tau[k, joint.rate] - torque) <= 1e-12 * max(bound, 1.0)
        assert abs(torque) <= bound * (1 + 1e-12)
        assert most[joint.rate] <= 1.001 * abs(torque) + 1e-9
    named, followed = {joint.name for joint, _, _ in results}, {body.joint.mimics for body in model.bodies}
    for joint in model.independent:
        if joint.effort and joint.name not in named | followed:
            assert most[joint.rate] <= joint.effort
    single = [joint for joint in model.independent if not any(b.joint.mimics == joint.name for b in model.bodies)]
    assert all(most[joint.rate] <= bounds[joint.name][0] * (1 + 1e-12) + 1e-12 for joint in single)


@pytest.mark.parametrize("count", [40, pytest.param(100, marks=pytest.mark.slow)])
def test_long_rows_of_oblique_hinges_ask_for_no_more_than_the_bound(count: int) -> None:
    """Nor for what is no number: nothing drifts from sweep to sweep."""
    links, joints = ['<link name="l0"/>'], []
    for k in range(1, count + 1):
        hinge = f'<joint name="j{k}" type="revolute"><parent link="l{k - 1}"/><child link="l{k}"/>'
        where = '<origin xyz="0.1 0 0.02" rpy="0.1 0.2 0.3"/><limit lower="-2" upper="2" effort="5" velocity="3"/>'
        links.append(f'<link name="l{k}"><inertial><mass value="1"/>{INERTIA}</inertial></link>')
        joints.append(f'{hinge}{where}<axis xyz="{("0 0 1", "1 0 0", "0 1 0")[k % 3]}"/></joint>')
    one = context(f'<robot name="row">{"".join(links + joints)}</robot>')
    results, bounds = one.once(static_torques), one.once(gravity_bounds)
    assert len(results) > 0.9 * count
    assert all(5.0 < abs(torque) <= bounds[joint.name][0] for joint, torque, _ in results[: count * 9 // 10])


@pytest.mark.parametrize(
    ("effort", "severity"), [("34", Severity.WARNING), ("35", Severity.NOTE), ("68", Severity.NOTE)]
)
def test_less_than_twice_the_limit_is_a_remark(effort: str, severity: Severity) -> None:
    """Springs may hold a part of the weight, as PR2's do; the joint carries 68.6 N m."""
    text = planar(-2.0, 2.0).replace('effort="0.1"', f'effort="{effort}"', 1)
    (finding,) = (
        one for one in check_one(text.encode()) if one.code == "RD801" and one.subject and one.subject.name == "j1"
    )
    assert (finding.severity, finding.bound) == (severity, float(effort))
    assert finding.measured == pytest.approx(G * 7, rel=1e-9)
    assert text.encode()[finding.start : finding.end] == effort.encode()


@pytest.mark.parametrize("stem", sampled(["baxter", "pr2", "tiago", "g1_29dof_rev_1_0"]))
def test_joint_space_inertia_is_the_mass_matrix(stem: str) -> None:
    """With mimic joints, slides and rotors of transmissions."""
    model = robodyn.load(path_of(stem))
    low, high = position_ranges(model)
    for q in (0.5 * (low + high), 0.8 * low + 0.2 * high):
        expected = robodyn.mass_matrix(model, q)
        assert np.abs(joint_space_inertia(model, q) - expected).max() <= 1e-12 * np.abs(expected).max()
    A = np.random.default_rng(0).normal(size=(30, 40))
    inverse = inverse_of_definite(A @ A.T)
    assert inverse is not None
    assert np.abs(inverse @ A @ A.T - np.eye(30)).max() <= 1e-12 * np.linalg.cond(A @ A.T)
    assert inverse_of_definite(A @ A.T - 200 * np.eye(30)) is None


@pytest.mark.parametrize(("damping", "warned"), [(9.9, False), (10.1, True)])
def test_damping_is_measured_against_the_step(damping: float, warned: bool) -> None:
    """Two bodies of 0.01 kg m^2 in a row about x: J = 0.005 kg m^2 between them while both are free, 2 J / b = 1 ms."""
    text = planar(-2.0, 2.0, axis="1 0 0").replace(
        'velocity="1"/></joint></robot>', f'velocity="1"/><dynamics damping="{damping}"/></joint></robot>'
    )
    results = [one for one in check_one(text.encode()) if one.code == "RD804"]
    assert bool(results) == warned
    assert [one.measured for one in results] == pytest.approx([2 * 0.005 / damping] * warned, rel=1e-9)


WHEEL = '<cylinder radius="0.1" length="0.04"/>'


@pytest.mark.parametrize(
    ("shape", "axis", "centre", "expected"),
    [
        (WHEEL, "0 0 1", "0 0 0", False),
        (WHEEL, "0 1 0", "0 0 0", True),
        (WHEEL, "0 1 1", "0 0 0", False),
        (WHEEL, "0 1 0", "0 0.05 0", False),
        ('<cylinder radius="0.1" length="0.3"/>', "0 1 0", "0 0 0", False),
        ('<box size="0.2 0.3 0.04"/>', "0 1 0", "0 0 0", False),
    ],
    ids=["right", "across", "oblique", "off the middle", "a rod", "a plate"],
)
def test_a_disc_turns_about_its_own_axis(shape: str, axis: str, centre: str, expected: bool) -> None:
    """A part that turns across its disc is a wheel on its side; others say nothing."""
    text = a_shaped_link(shape=shape).replace('xyz="0 0 0.125"', f'xyz="{centre}"')
    text = text.replace('<axis xyz="0 1 0"/>', f'<axis xyz="{axis}"/>')
    given = [one for one in check_one(text.encode()) if one.code == "RD517"]
    assert bool(given) is expected
    assert all(one.remedy.startswith('write <axis xyz="0 0 1"/>') for one in given)


def test_a_disc_without_an_axis_is_told_of_its_axis_alone() -> None:
    text = a_shaped_link(shape=WHEEL).replace('<axis xyz="0 1 0"/>', "").replace('xyz="0 0 0.125"', 'xyz="0 0 0"')
    assert {one.code for one in check_one(text.encode())} & {"RD514", "RD517"} == {"RD514"}


@pytest.mark.parametrize(
    ("origin", "other", "expected"),
    [("0 0.2 0", "", 2), ("0 0.2 0.002", "", 0), ("0 0.2 0", a_joint("neck", "upper", "head", LIMIT), 0)],
)
def test_two_joints_in_a_row_turn_about_two_lines(origin: str, other: str, expected: int) -> None:
    """Unless something else hangs between them, as arms between a waist and a neck."""
    text = longer_arm(inside=f'<origin xyz="{origin}"/><axis xyz="0 -1 0"/>{LIMIT}')
    text = text.replace("</robot>", (a_link("head") + other if other else "") + "</robot>")
    assert [one.code for one in check_one(text.encode())].count("RD517") == expected


@pytest.mark.parametrize(("upper", "joints", "expected"), [("15", 2, 0), ("60", 2, 1), ("15", 1, 1)])
def test_a_track_that_carries_the_robot_may_be_long(upper: str, joints: int, expected: int) -> None:
    text = longer_arm() if joints == 2 else arm()
    text = text.replace('type="revolute"', 'type="prismatic"', 1).replace('upper="2"', f'upper="{upper}"', 1)
    assert [one.code for one in check_one(text.encode())].count("RD515") == expected


@pytest.mark.parametrize(("long", "expected"), [(0.25, 0), (0.4, 1)])
def test_an_inertial_that_was_pasted(long: float, expected: int) -> None:
    """All ten numbers of another link are none of a link with other shapes; of a like part they are."""
    numbers = '<origin xyz="0.001 0 0.12"/><mass value="2"/><inertia ixx="0.012" ixy="1e-5" ixz="2e-5" iyy="0.0124" '
    numbers += 'iyz="3e-5" izz="0.004"/>'
    shape = f'<visual><origin xyz="0 0 {long / 2}"/><geometry><box size="0.1 0.1 {long}"/></geometry></visual>'
    text = a_shaped_link().replace("<inertial>", "<inertial>@")
    text = text[: text.index("@")] + numbers + text[text.index("</inertial>") :]
    text = text.replace(
        "</robot>", a_link("fore", numbers, shape) + a_joint("elbow", "upper", "fore", LIMIT) + "</robot>"
    )
    found = [one for one in check_one(text.encode()) if one.code == "RD208"]
    assert [one.subject.name for one in found if one.subject] == ["fore"] * expected


@pytest.mark.parametrize(("felt", "expected"), [("0 0 0", 0), ("0.02 0 0", 1), ("0.004 0 0", 0)])
def test_a_collision_mesh_that_lost_its_origin(tmp_path: Path, felt: str, expected: int) -> None:
    """Of two meshes that fit each other with one origin, one that stands 2 cm off is no simpler shape."""
    for name, size in (("seen", 0.5), ("felt", 0.498)):
        (tmp_path / f"{name}.stl").write_bytes(binary_stl(box((size, size, 0.5))))
    kinds = (("visual", "seen", "0 0 0"), ("collision", "felt", felt))
    shapes = "".join(
        f'<{kind}><origin xyz="{xyz}"/><geometry><mesh filename="{mesh}.stl"/></geometry></{kind}>'
        for kind, mesh, xyz in kinds
    )
    file = tmp_path / "arm.urdf"
    file.write_text(arm().replace('<link name="upper">', f'<link name="upper">{shapes}'))
    assert [one.code for one in check_one(str(file))].count("RD609") == expected


def of_links(*shapes: tuple[str, str]) -> str:
    """A robot whose links have a visual and a collision shape each, no shape where the text is empty."""
    kinds = ("visual", "collision")
    inside = (
        "".join(f"<{kind}><geometry>{one}</geometry></{kind}>" for kind, one in zip(kinds, each, strict=True) if one)
        for each in shapes
    )
    links = "".join(
        a_link(f"part{k}", more=each) + a_joint(f"turn{k}", "upper", f"part{k}") for k, each in enumerate(inside)
    )
    return arm(more=links)


def exchanged(source: str) -> list[str]:
    found = [one for one in check_one(source) if one.cause == "visual and collision are exchanged"]
    assert {(one.code, one.severity) for one in found} <= {("RD609", W)}
    return [one.subject.name for one in found if one.subject]


SEEN, FELT = (f'<mesh filename="package://a/{kind}/p.stl"/>' for kind in ("visual", "collision"))
PLAIN, SIMPLE = '<mesh filename="package://a/p.stl"/>', '<mesh filename="package://a/p_Collision.stl"/>'


@pytest.mark.parametrize(
    ("shapes", "expected"),
    [
        ([(SEEN, FELT), (FELT, SEEN), (SEEN, FELT)], ["part1"]),
        ([(PLAIN, SIMPLE), (PLAIN, SIMPLE), (SIMPLE, PLAIN)], ["part2"]),
        ([(SEEN, PLAIN), (PLAIN, SEEN), (PLAIN, SIMPLE)], ["part1"]),
        ([(SEEN, FELT), (FELT, SEEN)], []),
        ([(SEEN, FELT), (FELT, SEEN), (FELT, SEEN), (SEEN, FELT), (SEEN, FELT)], []),
        ([(SEEN, FELT), (SEEN, FELT), (SEEN, SEEN), (FELT, FELT)], []),
        ([(SEEN, FELT), (SEEN, FELT), ("", SEEN)], []),
        ([(SEEN, FELT), (SEEN, FELT), (FELT, "")], []),
    ],
)
def test_visual_and_collision_that_are_exchanged(
    tmp_path: Path, shapes: list[tuple[str, str]], expected: list[str]
) -> None:
    """By the words in the names of files, at one link of three that have both shapes at most."""
    file = tmp_path / "named.urdf"
    file.write_text(of_links(*shapes))
    assert exchanged(str(file)) == expected


@pytest.mark.parametrize(
    ("simple", "rings", "expected"),
    [
        ('<box size="0.2 0.2 0.2"/>', 6, ["part2"]),
        ('<sphere radius="0.1"/>', 16, ["part2"]),
        ('<mesh filename="box.stl"/>', 6, ["part2"]),
        ('<mesh filename="box.stl"/>', 5, []),
        ('<box size="0.02 0.02 0.02"/>', 16, []),
    ],
)
def test_or_by_ten_times_the_faces(tmp_path: Path, simple: str, rings: int, expected: list[str]) -> None:
    """Of shapes of one place: a ball of 2 x 12 (rings - 1) triangles, and 12 of a box."""
    for name, count in (("ball", rings), ("fine", 16)):
        (tmp_path / f"{name}.stl").write_bytes(binary_stl(uv_sphere(0.1, count, 12)))
    (tmp_path / "box.stl").write_bytes(binary_stl(box((0.2, 0.2, 0.2))))
    ball, fine = '<mesh filename="ball.stl"/>', '<mesh filename="fine.stl"/>'
    file = tmp_path / "drawn.urdf"
    file.write_text(of_links((fine, simple), (fine, simple), (simple, ball)))
    assert exchanged(str(file)) == expected


def finger(number: int, leader: str, more: str = "") -> str:
    follows = f'<axis xyz="0 1 0"/>{LIMIT}<mimic joint="{leader}"/>'
    inner = a_link(f"inner{number}") + a_joint(f"near{number}", "upper", f"inner{number}")
    return (
        inner + a_link(f"outer{number}") + a_joint(f"far{number}", f"inner{number}", f"outer{number}", follows) + more
    )


def beside(number: int) -> str:
    return a_link("beside") + a_joint("beside", f"inner{number}", "beside")


@pytest.mark.parametrize(
    ("leaders", "more", "expected"),
    [
        (["near0", "near1", "near1"], "", ["far2"]),
        (["near0", "near1", "near2"], "", []),
        (["near0", "near0"], "", []),
        (["near0", "near1", "near0", "near1"], "", []),
        (["near0", "near1", "near2", "near3", "near0", "near1"], "", ["far4", "far5"]),
        (["near0", "near1", "shoulder"], "", []),
        (["near0", "near1", "near1", "near2"], "", []),  # what is before far2 leads another finger itself
        (["near0", "near1", "near1"], beside(2), []),  # and here it is no part of one finger
        (["near0", "near1", "near1"], beside(1), ["far2"]),
    ],
)
def test_a_finger_that_follows_another_one(leaders: list[str], more: str, expected: list[str]) -> None:
    """The last joint of a finger whose own one is free follows that of a finger which has a follower of its own."""
    text = arm(more="".join(finger(k, leader) for k, leader in enumerate(leaders)) + more)
    found = [one for one in check_one(text.encode()) if one.code == "RD510"]
    assert [one.subject.name for one in found if one.subject] == expected
    assert {one.severity for one in found} <= {W}
    for one in found:
        assert one.remedy == f"mimic joint 'near{one.message.split(chr(39))[1][3:]}', which leads none"
        assert text.encode()[one.start : one.end].decode() in leaders


@pytest.mark.parametrize(
    ("leaders", "expected"), [(["near0", "near1", "near2"], []), (["near0", "near0", "near2"], ["far1"])]
)
def test_a_joint_between_leader_and_follower_is_no_other_finger(leaders: list[str], expected: list[str]) -> None:
    """The tip of a finger of three joints may follow the first of them, which is one more finger by its own joint."""
    between = a_link("middle") + a_joint("between", "inner2", "middle")
    text = arm(more="".join(finger(k, leader) for k, leader in enumerate(leaders)) + between)
    text = text.replace(
        '<parent link="inner2"/><child link="outer2"/>', '<parent link="middle"/><child link="outer2"/>'
    )
    assert 'parent link="middle"' in text
    found = [one for one in check_one(text.encode()) if one.code == "RD510"]
    assert [one.subject.name for one in found if one.subject] == expected
