"""What SDF says beyond a tree of links: loops, gravity, springs, followers, limits, masses by density; notes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import trimesh

import robodyn
from robodyn.errors import DescriptionError
from robodyn.programs.vectors import rotation_from_rpy
from robodyn.robot.kinematics import link_poses
from robodyn.robot.load import load_description
from robodyn.robot.masses.declared import declared
from robodyn.robot.urdf.parts import Limit, Mimic
from robodyn.robot.write.urdf import write_urdf

TENSOR = "<inertia><ixx>0.3</ixx><iyy>0.4</iyy><izz>0.5</izz></inertia>"


def body(name: str, at: str, more: str = "", mass: float = 2.0) -> str:
    where = "<pose>0.1 0.2 0.3 0.1 0.2 0.3</pose>"
    return f"<link name='{name}'><pose>{at}</pose><inertial>{where}<mass>{mass}</mass>{TENSOR}</inertial>{more}</link>"


def joint(name: str, kind: str, parent: str, child: str, inside: str = "<axis><xyz>0 0 1</xyz></axis>") -> str:
    return f"<joint name='{name}' type='{kind}'><parent>{parent}</parent><child>{child}</child>{inside}</joint>"


def described(inside: str, version: str = "1.10"):
    return load_description(f"<sdf version='{version}'><model name='m'>{inside}</model></sdf>".encode())


def loaded(inside: str, version: str = "1.10"):
    return robodyn.load(f"<sdf version='{version}'><model name='m'>{inside}</model></sdf>".encode())


PAIR = joint("j0", "fixed", "world", "a", "") + body("a", "0 0 1 0.3 0 0") + body("b", "1 0 1 0 0.2 0")
FOUR_BAR = (
    joint("j0", "fixed", "world", "a", "")
    + body("a", "0 0 0 0 0 0")
    + body("b", "0 0 0 0 0 0.9")
    + body("c", "1 0.5 0 0 0 0.1")
    + body("d", "2 0 0 0 0 1.2")
    + joint("ab", "revolute", "a", "b")
    + joint("bc", "revolute", "b", "c")
    + joint("ad", "revolute", "a", "d")
)
CLOSE = "<pose relative_to='a'>2.3 0.6 0 0 0 0.3</pose><axis><xyz>0 0 1</xyz></axis>"


def numbers(values) -> str:
    return " ".join(map(repr, values))


@pytest.mark.parametrize("kind", ["revolute", "ball"])
def test_a_joint_that_closes_a_loop_is_the_constraint_of_a_urdf(kind):
    order = FOUR_BAR + joint("cd", kind, "c", "d", CLOSE if kind == "revolute" else CLOSE.partition("<axis>")[0])
    found = described(order)
    (loop,) = found.scene["loop"]
    assert (loop["name"], loop["link"], loop["to"], loop["kind"]) == (
        "cd",
        "d",
        "c",
        {"ball": "point"}.get(kind, "hinge"),
    )
    model = loaded(order)
    poses = link_poses(model, np.zeros(model.nq))
    points = [poses[loop[end]].R @ loop[at] + poses[loop[end]].p for end, at in (("link", "point"), ("to", "to_point"))]
    np.testing.assert_allclose(points, [[2.3, 0.6, 0.0]] * 2, atol=1e-14)
    text = "".join(
        f"<{role}_origin xyz='{numbers(loop[at])}'/><{role}_axis xyz='0 0 1'/>"
        for role, at in (("child", "point"), ("parent", "to_point"))
    )
    text = f"<constraint name='cd' type='{kind}'><parent link='c'/><child link='d'/>{text}</constraint>"
    tree = write_urdf(replace(found, format="mjcf", scene={}), "m.urdf").data.decode()
    other = robodyn.load(tree.replace("</robot>", f"{text}</robot>").encode())
    ours, theirs = robodyn.scene_of(model).loops[0], robodyn.scene_of(other).loops[0]
    assert ours == replace(theirs, axis=ours.axis, to_axis=ours.to_axis)
    np.testing.assert_allclose([ours.axis, ours.to_axis], [theirs.axis, theirs.to_axis], atol=1e-14)


def test_welds_and_loops_of_other_kinds():
    twice = described(PAIR + joint("j", "fixed", "a", "b", "") + joint("w", "fixed", "a", "b", ""))
    assert not twice.scene
    assert "joint 'w', whose links are fixed to each other" in twice.notes[0][1]
    text = PAIR + joint("w", "fixed", "a", "b", "") + joint("j", "prismatic", "a", "b")
    (loop,), poses = described(text).scene["loop"], link_poses(loaded(text), np.zeros(1))
    assert (loop["name"], loop["link"], loop["to"], loop["kind"]) == ("w", "b", "a", "weld")
    held = poses["a"].R @ loop["to_point"] + poses["a"].p
    np.testing.assert_allclose(held, poses["b"].R @ loop["point"] + poses["b"].p, atol=1e-15)
    np.testing.assert_allclose(poses["a"].R @ rotation_from_rpy(*loop["rpy"]), poses["b"].R, atol=1e-15)
    found = described(FOUR_BAR + joint("u", "prismatic", "c", "d") + joint("v", "prismatic", "b", "d"))
    assert {loop["name"] for loop in found.scene["loop"]} <= {"ab", "bc", "ad"}
    both = described(PAIR + joint("u", "prismatic", "a", "b") + joint("v", "prismatic", "a", "b"))
    assert [what for _, what in both.notes] == [
        "left out, as nothing here is like it: joint 'v' (prismatic), which closes a loop"
    ]
    stiff = "<axis><dynamics><damping>1</damping></dynamics></axis>"
    damped = described(PAIR + joint("u", "revolute", "a", "b") + joint("v", "revolute", "a", "b", stiff))
    assert "limits, friction and springs of joint 'v', which closes a loop" in damped.notes[0][1]


def test_a_closed_chain_against_its_closed_form():
    """A parallelogram with cranks of length r, the coupler of mass m: M = I_b + I_d + m r^2, and dV/dq of heights."""

    def rod(name: str, at: str, centre: str) -> str:
        inertia = "<inertia><ixx>0.01</ixx><iyy>0.01</iyy><izz>0.01</izz></inertia>"
        inertial = f"<inertial><pose>{centre} 0 0 0</pose><mass>1</mass>{inertia}</inertial>"
        return f"<link name='{name}'><pose>{at} 0 0 0</pose>{inertial}</link>"

    axis = "<axis><xyz>0 1 0</xyz></axis>"
    text = joint("j0", "fixed", "world", "a", "") + rod("a", "0 0 0", "0 0 0") + rod("b", "0 0 0", "0.1 0 0")
    text += rod("c", "0 0 0.2", "0.3 0 0") + rod("d", "0.6 0 0", "0 0 0.1") + joint("drive", "revolute", "a", "b", axis)
    text += joint("bc", "revolute", "b", "c", axis) + joint("ad", "revolute", "a", "d", axis)
    model = loaded(text + joint("close", "revolute", "c", "d", "<pose relative_to='d'>0 0 0.2 0 0 0</pose>" + axis))
    scene = replace(robodyn.scene_of(model), actuated=("drive",))
    q, qd, qdd = 0.4, 0.7, -1.3
    shape = np.array([1.0, -1.0, 1.0])
    tau = robodyn.inverse_dynamics(model, q * shape, qd * shape, qdd * shape, scene=scene)
    M = 2 * (0.01 + 0.1**2) + 0.2**2
    dV = -9.81 * (0.1 * np.cos(q) + 0.2 * np.sin(q) + 0.1 * np.sin(q))
    np.testing.assert_allclose(tau, [M * qdd + dV, 0.0, 0.0], atol=1e-12)


def test_limits_that_are_none():
    def limits(kind, **given):
        text = "".join(f"<{key}>{value}</{key}>" for key, value in given.items())
        inside = f"<axis><xyz>0 0 1</xyz><limit>{text}</limit></axis>"
        return described(PAIR + joint("j", kind, "a", "b", inside)).joints[1]

    assert limits("revolute", lower="-inf", upper="inf").type == "continuous"
    assert limits("revolute", lower="-1e16", upper="1e+16", effort="-1", velocity="-1").limit is None
    assert limits("revolute", lower="-1.79769e+308", upper="1.79769e+308").limit is None
    found = limits("revolute", lower="-1", upper="2", effort="3", velocity="4")
    assert (found.type, found.limit) == ("revolute", Limit(-1.0, 2.0, 3.0, 4.0))
    assert limits("prismatic", lower="-1", upper="1e16").limit == Limit(-1.0)
    assert limits("continuous", lower="-1", upper="1", effort="5").limit == Limit(effort=5.0)
    with pytest.raises(DescriptionError, match="<lower> of joint 'j' is not finite"):
        limits("revolute", lower="nan")


def test_friction_and_springs():
    dynamics = "<damping>0.3</damping><friction>0.4</friction><spring_stiffness>5</spring_stiffness>"
    inside = f"<axis><dynamics>{dynamics}<spring_reference>0.2</spring_reference></dynamics></axis>"
    found = described(PAIR + joint("j", "revolute", "a", "b", inside))
    assert (found.joints[1].damping, found.joints[1].friction) == (0.3, 0.4)
    assert found.scene == {"spring": {"j": {"stiffness": 5.0, "rest": 0.2}}}
    model = loaded(PAIR + joint("j", "revolute", "a", "b", inside))
    tau = [
        robodyn.inverse_dynamics(model, [0.5], [0.0], [0.0], scene=scene)
        for scene in (robodyn.Scene(), robodyn.scene_of(model))
    ]
    assert float((tau[1] - tau[0])[0]) == pytest.approx(5.0 * 0.3, abs=1e-12)
    ball = described(PAIR + joint("j", "ball", "a", "b", inside))
    assert [each.damping for each in ball.joints[1:]] == [0.3] * 3
    assert "friction and springs act on their angles" in ball.notes[0][1]


def test_rows_of_hinges_backwards():
    """A joint whose child is nearer to the root: the same coordinates, in the other order, about opposite axes."""
    two = "<pose>0.1 0.2 0.3 0.4 0.5 0.6</pose><axis><xyz>1 0 0</xyz></axis><axis2><xyz>0 1 0</xyz></axis2>"
    model = loaded(PAIR + joint("j", "universal", "b", "a", two))
    tiny = "<mass>0</mass><inertia><ixx>0</ixx><iyy>0</iyy><izz>0</izz></inertia>"
    tiny = f"<link name='i'><pose relative_to='a'/><inertial>{tiny}</inertial></link>"
    place = "<pose relative_to='a'>0.1 0.2 0.3 0.4 0.5 0.6</pose>"
    row = joint("j_1", "revolute", "b", "i", place + "<axis><xyz>1 0 0</xyz></axis>")
    other = loaded(PAIR + tiny + row + joint("j_2", "revolute", "i", "a", place + "<axis><xyz>0 1 0</xyz></axis>"))
    assert set(model.joint_names) == {"j_1", "j_2"}
    mine, theirs = (
        robodyn.mass_matrix(each, [{"j_1": 0.4, "j_2": -0.9}[name] for name in each.joint_names])[
            np.ix_(*[[each.joint_names.index(name) for name in ("j_1", "j_2")]] * 2)
        ]
        for each in (model, other)
    )
    np.testing.assert_allclose(mine, theirs, atol=1e-13)


def test_which_joints_close_loops():
    """Welds and hinges are joints before ball joints are, wherever they stand in the file."""
    ball = joint("ball", "ball", "b", "a", "")
    hinges = joint("ad", "revolute", "a", "d") + joint("bd", "revolute", "b", "d")
    bodies = joint("j0", "fixed", "world", "a", "") + "".join(body(name, "0 0 0 0 0 0") for name in "abd")
    assert [loop["name"] for loop in described(bodies + ball + hinges).scene["loop"]] == ["ball"]
    weld = joint("weld", "fixed", "b", "a", "")
    assert [loop["name"] for loop in described(bodies + hinges + weld).scene["loop"]] == ["bd"]


def test_shapes_stand_where_they_do():
    shape = "<geometry><box><size>1 2 3</size></box></geometry>"
    inside = f"<visual name='v'><pose relative_to='f'>0 0 1 0 0 0</pose>{shape}</visual>"
    inside += f"<collision name='c'><pose>0 0 1 0 0 0</pose>{shape}</collision>"
    frame = "<frame name='f'><pose>5 6 7 0.1 0.2 0.3</pose></frame>"
    text = PAIR.replace("</link>", inside + "</link>", 1) + frame
    turned = PAIR.replace(
        "<link name='b'><pose>1 0 1 0 0.2 0</pose>", f"<link name='b'><pose>1 0 1 0 0.2 0</pose>{inside}"
    )
    hinge = "<pose>0.5 0.4 0.3 0 0 0</pose><axis/>"
    for found, name in (
        (text + joint("j", "fixed", "a", "b", ""), "a"),
        (turned + frame + joint("j", "revolute", "a", "b", hinge), "b"),
    ):
        model = loaded(found)
        where = link_poses(model, np.zeros(model.nq))[name]
        (link,) = [each for each in model.description.links if each.name == name]
        places = [where.R @ each.origin.xyz + where.p for each in link.geometries]
        turn = {"a": rotation_from_rpy(0.3, 0, 0), "b": rotation_from_rpy(0, 0.2, 0)}[name]
        at = {"a": (0, 0, 1), "b": (1, 0, 1)}[name]
        expected = [np.add((5, 6, 7), rotation_from_rpy(0.1, 0.2, 0.3)[:, 2]), at + turn[:, 2]]
        np.testing.assert_allclose(places, expected, atol=1e-14)
        np.testing.assert_allclose(
            where.R @ rotation_from_rpy(*link.geometries[0].origin.rpy), rotation_from_rpy(0.1, 0.2, 0.3), atol=1e-14
        )


def test_revolute2_is_two_hinges():
    two = "<axis><xyz>1 0 0</xyz></axis><axis2><xyz>0.6 0.8 0</xyz></axis2>"
    model, named = loaded(PAIR + joint("j", "revolute2", "a", "b", two)), ("j_1", "j_2")
    assert model.joint_names == named
    row = joint("j_1", "revolute", "a", "i", "<axis><xyz>1 0 0</xyz></axis>")
    row += joint("j_2", "revolute", "i", "b", "<axis><xyz>0.6 0.8 0</xyz></axis>")
    tiny = "<mass>0</mass><inertia><ixx>0</ixx><iyy>0</iyy><izz>0</izz></inertia>"
    tiny = f"<link name='i'><pose relative_to='b'/><inertial>{tiny}</inertial></link>"
    other, q = loaded(PAIR + tiny + row), np.array([0.4, -0.9])
    np.testing.assert_allclose(robodyn.mass_matrix(model, q), robodyn.mass_matrix(other, q), atol=1e-14)


CHAIN = PAIR + body("c", "1 1 1 0 0 0") + joint("j", "revolute", "a", "b") + joint("k", "revolute", "a", "c")


def test_mimic():
    mimic = "<mimic joint='j'><multiplier>-2</multiplier><offset>0.5</offset><reference>0.1</reference></mimic>"
    inside = f"<axis><xyz>0 0 1</xyz>{mimic}</axis>"
    found = described(
        PAIR + body("c", "1 1 1 0 0 0") + joint("j", "revolute", "a", "b") + joint("k", "revolute", "a", "c", inside)
    )
    assert found.joints[2].mimic == Mimic("j", -2.0, 0.5 + 2 * 0.1)
    with pytest.raises(DescriptionError, match="joint 'j' mimics itself"):
        described(PAIR + joint("j", "revolute", "a", "b", inside))
    with pytest.raises(DescriptionError, match="joint 'k' names 'x', which does not exist"):
        described(PAIR + joint("k", "revolute", "a", "b", inside.replace("'j'", "'x'")))


@pytest.mark.parametrize(
    ("axis", "turned", "factor"), [("0 0 1", False, -3.0), ("0 0 -1", False, 3.0), ("0 0 1", True, 3.0)]
)
def test_a_gearbox_is_a_follower(axis, turned, factor):
    """theta_2 = -ratio theta_1, angles against the reference body; in the frame of the child, b is turned by 0.2."""
    common = "<axis><xyz expressed_in='a'>0 0 1</xyz></axis>"
    hinges = joint("j", "revolute", "a", "b", common) + joint(
        "k", "revolute", *(("c", "a") if turned else ("a", "c")), common
    )
    gears = "<gearbox_ratio>3</gearbox_ratio><gearbox_reference_body>a</gearbox_reference_body>" + common
    gears += f"<axis2><xyz expressed_in='a'>{axis}</xyz></axis2>"
    found = described(PAIR + body("c", "1 1 1 0 0 0") + hinges + joint("g", "gearbox", "b", "c", gears))
    assert {each.name: each.mimic for each in found.joints} == {"j0": None, "j": None, "k": Mimic("j", factor)}
    lost = described(CHAIN + joint("g", "gearbox", "b", "c", gears))
    assert "gearbox 'g', whose links do not turn about its reference body" in lost.notes[0][1]


def test_gravity_of_links_and_worlds():
    light = PAIR.replace("<link name='b'>", "<link name='b'><gravity>0</gravity>") + joint("j", "revolute", "a", "b")
    model, q = loaded(light), np.array([0.7])
    held = robodyn.bias_forces(model, q, [0.0], scene=robodyn.scene_of(model))
    np.testing.assert_allclose(held, 0.0, atol=1e-12)
    assert abs(robodyn.bias_forces(model, q, [0.0])[0]) > 0.1
    assert "gravity is off for 'b'" in model.notes[0]
    assert described(light.replace("name='a'>", "name='a'><gravity>false</gravity>")).scene == {"gravity": [0.0] * 3}
    assert described("<gravity>0</gravity>" + PAIR + joint("j", "revolute", "a", "b")).scene == {"gravity": [0.0] * 3}
    nested = "<link name='a'/><model name='n'><gravity>0</gravity><model name='o'><link name='b'/></model></model>"
    weld = joint("j", "fixed", "a", "n::o::b", "")
    assert [each["link"] for each in described(nested + weld).scene["wrench"]] == ["n::o::b"]
    world = f"<sdf version='1.10'><world name='w'><gravity>0 1 -3</gravity><model name='m'>{PAIR}</model></world></sdf>"
    found = load_description(world.encode())
    assert (found.name, found.root, found.scene) == ("m", "world", {"gravity": [0.0, 1.0, -3.0]})


def test_a_model_that_nothing_fixes_stands_as_that_of_a_urdf():
    free = body("a", "0 0 1 0 0 0") + body("b", "1 0 1 0 0.2 0") + joint("j", "revolute", "a", "b")
    found = described(free)
    assert (found.root, len(found.joints)) == ("a", 1)
    assert "nothing fixes 'a' to the world: SDF lets it move, and it stands fixed here" in found.notes[0][1]
    assert not described("<static>1</static>" + free).notes
    turned = described("<pose>0 0 1 1 0 0</pose>" + free)
    assert (turned.root, turned.joints[0].type, turned.joints[0].origin.rpy[0]) == (
        "world",
        "fixed",
        pytest.approx(1.0),
    )
    several = described(free + body("c", "0 0 0 0 0 0"))
    assert [each.type for each in several.joints] == ["floating", "floating", "continuous"]
    model = loaded(free + body("c", "0 0 0 0 0 0"))
    assert model.n == 13
    assert np.isfinite(robodyn.mass_matrix(model, robodyn.robot.kinematics.configuration(model))).all()


def test_masses_by_density(tmp_path):
    trimesh.creation.box((1, 2, 3)).export(tmp_path / "box.stl")
    box = "<geometry><box><size>1 2 3</size></box></geometry>"
    mesh = "<geometry><mesh><uri>box.stl</uri><scale>2 1 1</scale></mesh></geometry>"
    (tmp_path / "m.sdf").write_text(
        "<sdf version='1.12'><model name='m'><link name='a'><inertial auto='true'><density>500</density></inertial>"
        f"<collision name='c'><pose>1 0 0 0 0 0.3</pose>{box}</collision>"
        f"<collision name='d'><density>200</density><pose>-1 0 0 0.2 0 0</pose>{mesh}</collision></link></model></sdf>"
    )
    found = declared(load_description(tmp_path / "m.sdf").links[0]).body
    one, two = (trimesh.creation.box(size) for size in ((1, 2, 3), (2, 2, 3)))
    one.density, two.density = 500, 200
    one.apply_transform(trimesh.transformations.compose_matrix(translate=(1, 0, 0), angles=(0, 0, 0.3)))
    two.apply_transform(trimesh.transformations.compose_matrix(translate=(-1, 0, 0), angles=(0.2, 0, 0)))
    assert found.mass == pytest.approx(one.mass + two.mass, rel=1e-12)
    centre = (one.mass * one.center_mass + two.mass * two.center_mass) / found.mass
    np.testing.assert_allclose(found.com, centre, atol=1e-12)
    inertia = sum(
        each.moment_inertia + each.mass * ((d := each.center_mass - centre) @ d * np.eye(3) - np.outer(d, d))
        for each in (one, two)
    )
    np.testing.assert_allclose(found.inertia, inertia, rtol=1e-12, atol=1e-9)
    with pytest.raises(DescriptionError, match="a <collision> of link 'a' gives no mass: is of a shape"):
        described(
            "<link name='a'><inertial auto='1'/><collision name='c'><geometry><plane/></geometry></collision></link>"
        )
    with pytest.raises(DescriptionError, match='has <inertial auto="true"> and no <collision>'):
        described("<link name='a'><inertial auto='1'/></link>")


def test_what_is_left_out_is_one_note():
    left = described(
        PAIR
        + joint("j", "fixed", "a", "b", "")
        + "<plugin/><plugin/><gripper/>"
        + "<link name='c'><visual><geometry><plane/></geometry></visual></link>"
    )
    assert [what for _, what in left.notes] == [
        "nothing fixes 'c' to the world: SDF lets it move, and it moves here, too",
        "no <inertial> in 'c': SDF makes it 1 kg, and 1 kg m^2 about each axis",
        "left out, as nothing here is like it: 2 <plugin>; 1 <gripper>; 1 <plane> of a visual",
    ]
