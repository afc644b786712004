"""MJCF that is written: MuJoCo loads it, and its mass matrix and bias are robodyn's."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from helpers.example_robots import PATHS, path_of

import robodyn
from robodyn.comparison.compare import compare
from robodyn.errors import DescriptionError
from robodyn.robot.kinematics import link_poses
from robodyn.robot.load import load, load_description
from robodyn.robot.write.mjcf import write_mjcf
from robodyn.scene.described import described
from robodyn.scene.read import parse_scene

mujoco = pytest.importorskip("mujoco")
ROBOTS = Path(__file__).parents[3] / "robots"
REFUSED = {
    **dict.fromkeys(
        ("allegro_right_hand", "allegro_left_hand", "anymal", "romeo_small", "b1", "hyq_no_sensors"), "RD207"
    ),
    **dict.fromkeys(("b1-z1", "romeo_laas_small", "anymal-kinova", "go1", "pr2"), "RD207"),
    **dict.fromkeys(("tiago", "tiago_no_hand", "tiago_dual", "icub", "icub_reduced"), "RD206"),
    "romeo": "RD202",
}
"""Robots that cannot be, and the rule that tells why."""
POSSIBLE = [path for path in PATHS if path.stem not in REFUSED]
BY_DEFAULT = ("iris", "panda")


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    """Where MuJoCo writes its log."""
    monkeypatch.chdir(tmp_path)


def state(m, d, model, q, qd):
    """Set MuJoCo's state to that of robodyn and return E, `qvel = E qd`."""
    E, joints = np.zeros((m.nv, model.n)), {body.joint.name: body.joint for body in model.bodies}
    for j in range(m.njnt):
        name, at, dof = mujoco.mj_id2name(m, mujoco.mjtObj.mjOBJ_JOINT, j), m.jnt_qposadr[j], m.jnt_dofadr[j]
        joint = joints["base" if model.floating and m.jnt_type[j] == mujoco.mjtJoint.mjJNT_FREE else name]
        if m.jnt_type[j] == mujoco.mjtJoint.mjJNT_FREE:
            k, i = joint.coordinate, joint.rate
            d.qpos[at : at + 7] = [*q[k : k + 3], q[k + 6], *q[k + 3 : k + 6]]
            E[dof : dof + 6, i : i + 6] = np.roll(np.eye(6), 3, axis=0)
        else:
            d.qpos[at] = joint.multiplier * q[joint.coordinate] + joint.offset
            E[dof, joint.rate] = joint.multiplier
    d.qvel[:] = E @ qd
    return E


def worst(m, model, scene, samples=3):
    """The largest difference of mass matrix and bias, relative to the largest entry."""
    rng, d, found = np.random.default_rng(0), mujoco.MjData(m), [0.0]
    quiet = {body.joint.name: robodyn.Friction() for body in model.bodies[1:]}
    bare = replace(scene, friction=quiet, loops=(), spring={})
    for _ in range(samples if model.n else 0):
        q, qd = rng.uniform(-1, 1, model.nq), rng.uniform(-1, 1, model.n)
        for _, first in model.quaternions:
            q[first : first + 4] /= np.linalg.norm(q[first : first + 4])
        E = state(m, d, model, q, qd)
        mujoco.mj_forward(m, d)
        M = np.zeros((m.nv, m.nv))
        mujoco.mj_fullM(m, d, M)
        bias = robodyn.inverse_dynamics(model, q, qd, 0, scene=bare, executor="numpy")
        still = robodyn.inverse_dynamics(model, q, 0, 0, scene=bare, executor="numpy")
        pairs = [(robodyn.mass_matrix(model, q, scene=bare), E.T @ M @ E), (bias, E.T @ d.qfrc_bias)]
        d.qvel[:] = 0
        mujoco.mj_forward(m, d)
        pairs.append((still, E.T @ d.qfrc_bias))
        found += [np.abs(a - b).max() / max(np.abs(b).max(), 1e-9) for a, b in pairs]
    return max(found)


def without_shapes(description):
    return replace(description, links=tuple(replace(link, geometries=()) for link in description.links))


def compiled(data, folder):
    (folder / "robot.xml").write_bytes(data)
    return mujoco.MjModel.from_xml_path(str(folder / "robot.xml"))


def check(path, folder, moving=False):
    """Return the robot and, without shapes, what is written of it."""
    model = load(path, moving_base=moving)
    scene = replace(robodyn.scene_of(model), moving_base=moving)
    description, lost = described(model.description, scene)
    assert not lost
    for each in (description, without_shapes(description)):
        written = write_mjcf(each, str(folder / "robot.xml"))
        assert worst(compiled(written.data, folder), model, scene) < 1e-12
    return model, written


SAID = {"order": "the order of the file in q", "limit": "ranges with one end, or without room between the ends"}


@pytest.mark.parametrize(
    "path",
    [pytest.param(path, id=path.stem, marks=[pytest.mark.slow] * (path.stem not in BY_DEFAULT)) for path in POSSIBLE],
)
def test_robots_that_are_possible(path, tmp_path):
    """Of example-robot-data, without shapes and with those that MuJoCo reads; nothing differs but what is said."""
    model, written = check(path, tmp_path)
    kinds = {each.kind for each in compare(model, load(tmp_path / "robot.xml")).differences}
    said = {kind for kind, what in SAID.items() if any(line.startswith(what) for line in written.lost)}
    assert kinds <= said | {"limit" for line in written.lost if line.startswith("effort limits of 0 or less")}


@pytest.mark.parametrize("stem", ["iris", "quadruped", pytest.param("human", marks=pytest.mark.slow)])
def test_a_base_that_moves(stem, tmp_path):
    check(path_of(stem), tmp_path, moving=True)


@pytest.mark.parametrize("stem", REFUSED)
def test_impossible_robots_are_refused_by_name(stem):
    model = load(path_of(stem))
    with pytest.raises(DescriptionError, match=rf":\d+: link '[\w.]+' .*robodyn rule {REFUSED[stem]}"):
        write_mjcf(model.description, "robot.xml")


BOB = "<inertial><mass value='{}'/><inertia ixx='{}' ixy='0' ixz='0' iyy='{}' iyz='0' izz='{}'/></inertial>"
ARM = """<robot name='r'><link name='base'/><link name='bob'>{}</link>
<joint name='j' type='{}'><parent link='base'/><child link='bob'/><axis xyz='0 1 0'/></joint></robot>"""


@pytest.mark.parametrize(
    ("inertial", "kind", "why"),
    [
        (BOB.format(-1, 1, 1, 1), "continuous", "its mass is -1 kg .*RD201"),
        (BOB.format(1, 1, 1, -1), "continuous", "moment of inertia is negative .*RD206"),
        (BOB.format(1, 1, 1, 3), "continuous", "triangle inequality .*RD207"),
        (BOB.format(1, 0, 0, 0), "continuous", "MJCF has no masses without moments of inertia that move .*RD204"),
        ("", "continuous", "it moves without mass .*RD202"),
    ],
)
def test_what_cannot_be_is_refused(inertial, kind, why):
    description = load_description(ARM.format(inertial, kind).encode())
    with pytest.raises(DescriptionError, match=f":1: link 'bob' .*{why}"):
        write_mjcf(description, "robot.xml")


def test_a_point_mass_that_does_not_move_is_no_point_to_refuse(tmp_path):
    description = load_description(ARM.format(BOB.format(1, 0, 0, 0), "fixed").encode())
    assert compiled(write_mjcf(description, "robot.xml").data, tmp_path).nbody == 3


JOINTS = b"""<mujoco model='m'><option gravity='1 2 -3'/><worldbody>
<body name='a' pos='.1 .2 .3' euler='10 20 30'>
  <joint name='s' type='slide' axis='1 0 1' stiffness='3' springref='.2'/>
  <joint name='h' axis='0 1 2' pos='.1 -.2 .3' ref='20' armature='.02' damping='.3' frictionloss='.1'/>
  <inertial pos='.1 .2 .3' mass='2' fullinertia='.03 .04 .05 .001 -.002 .003'/>
  <body name='b' pos='.3 0 0'><joint name='ball' type='ball'/>
  <inertial pos='.1 0 0' mass='1' diaginertia='.01 .02 .03'/>
    <body name='c' pos='.3 0 .1'><joint name='k' range='-90 45'/>
    <inertial pos='0 .1 0' mass='1' diaginertia='.01 .01 .01'/>
    </body></body></body>
<body name='d' pos='0 1 0'><joint name='f'/><inertial pos='.1 0 0' mass='1' diaginertia='.01 .02 .03'/></body>
</worldbody><equality><connect body1='c' body2='world' anchor='.1 .2 .3'/><weld body1='b' body2='d'/>
<joint joint1='f' joint2='h' polycoef='.1 2 0 0 0'/></equality>
<actuator><motor joint='h' gear='20' forcerange='-2 2'/></actuator></mujoco>"""


def test_what_was_mjcf_is_the_same_again(tmp_path):
    (tmp_path / "first.xml").write_bytes(JOINTS)
    first = load(tmp_path / "first.xml")
    scene = robodyn.scene_of(first)
    written = write_mjcf(described(first.description, scene)[0], "again.xml")
    (tmp_path / "again.xml").write_bytes(written.data)
    again = load(tmp_path / "again.xml")
    assert (first.coordinates, first.total_mass) == (again.coordinates, again.total_mass)
    other = robodyn.scene_of(again)
    assert (scene.gravity, scene.spring) == (other.gravity, other.spring)
    for one, two in zip(scene.loops, other.loops, strict=True):
        assert (one.link, one.to, one.kind) == (two.link, two.to, two.kind)
        for key in ("point", "to_point", "rpy"):
            np.testing.assert_allclose(getattr(one, key), getattr(two, key), atol=1e-12)
    rng = np.random.default_rng(0)
    for _ in range(3):
        q, qd, qdd = rng.uniform(-1, 1, (3, first.n))
        ours, theirs = (
            robodyn.inverse_dynamics(model, q, qd, qdd, scene=replace(each, loops=()), executor="numpy")
            for model, each in ((first, scene), (again, other))
        )
        np.testing.assert_allclose(ours, theirs, atol=1e-12 * np.abs(ours).max())
    for one, two in zip(first.bodies, again.bodies, strict=True):
        for key in ("lower", "upper", "effort", "damping", "friction", "rotor_inertia", "mimics"):
            a, b = getattr(one.joint, key), getattr(two.joint, key)
            assert a == b or abs(a - b) < 1e-12, (one.joint.name, key)


SCENE = """
[friction]
shoulder = {viscous = 0.5, coulomb = [1.0, -2.0], stribeck = 3.0}
elbow = {viscous = 0.25, coulomb = 1.5}
[rotor]
shoulder = {inertia = 1e-4, gear = 100}
[spring]
elbow = {stiffness = 3.0, rest = 0.2}
[[payload]]
link = "spindle"
mass = 2.0
com = [0.1, 0, 0]
"""


def test_what_a_scene_says_goes_along(tmp_path):
    model = load(ROBOTS / "scara.urdf")
    scene = replace(parse_scene(SCENE.encode()), gravity=(0.0, 1.0, -3.0), slip_speed=0.01)
    description, lost = described(model.description, scene)
    assert lost == [
        "friction that differs by direction, of which the mean is written: 'shoulder'",
        "friction of breakaway and friction that grows with load: 'shoulder'",
        "of the scene: 'slip speed'",
    ]
    m = compiled(write_mjcf(description, "robot.xml").data, tmp_path)
    assert m.opt.gravity.tolist() == [0, 1, -3]
    assert m.dof_damping.tolist() == [0.5, 0.25, 0]
    assert m.dof_frictionloss.tolist() == [1.5, 1.5, 0]
    np.testing.assert_allclose(m.dof_armature, [1, 0, 0], rtol=1e-15)
    assert (m.jnt_stiffness.tolist(), m.qpos_spring.tolist()) == ([0, 3, 0], [0, 0.2, 0])
    assert m.jnt_actfrcrange.tolist() == [[-150, 150], [-60, 60], [-150, 150]]
    assert m.body("spindle_payload").mass.item() == 2.0
    assert worst(m, model, scene) < 1e-12


def test_the_ground_of_mjcf_has_no_mass_and_free_joints_no_other_parent():
    text = ARM.format(BOB.format(1, 1, 1, 1), "floating")
    heavy = text.replace("<link name='base'/>", f"<link name='base'>{BOB.format(1, 1, 1, 1)}</link>")
    with pytest.raises(DescriptionError, match="joint 'j' floats on link 'base'"):
        write_mjcf(load_description(heavy.encode()), "robot.xml")
    with pytest.raises(DescriptionError, match="link 'world' has mass or moves, and is the ground in MJCF"):
        write_mjcf(load_description(heavy.replace("base", "world").encode()), "robot.xml")
    with pytest.raises(DescriptionError, match="link 'world' has mass or moves, and is the ground in MJCF"):
        write_mjcf(load_description(text.replace("bob", "world").encode()), "robot.xml")
    written = write_mjcf(load_description(text.encode()), "robot.xml")
    assert "names of links that are the world: 'base'" in written.lost


def test_what_cannot_be_said_is_listed():
    model = load(ROBOTS / "gripper.urdf")
    written = write_mjcf(model.description, "robot.xml")
    assert written.lost == [
        "velocity limits: 'lift', 'wrist', 'jaw', 'right_jaw', 'pinion'",
        "exact mimic rules and loops: MuJoCo's equality constraints are soft",
        "materials",
    ]
    order = write_mjcf(load(ROBOTS / "four_bar.urdf").description, "robot.xml").lost
    assert "the order of the file in q, which is that of the tree: 'left', 'top', 'right'" in order
    floats = load_description(ARM.replace("<link name='base'/>", "<link name='base'/><link name='more'/>").replace(
        "</robot>", "<joint name='k' type='floating'><parent link='bob'/><child link='more'/></joint></robot>"
    ).format(BOB.format(1, 1, 1, 1), "continuous").encode())  # fmt: skip
    with pytest.raises(
        DescriptionError, match=r":2: joint 'k' floats on link 'bob'; MJCF has free joints of the world"
    ):
        write_mjcf(floats, "robot.xml")


@pytest.mark.parametrize("name", ["four_bar_lift", "planar_3rrr_circle", "delta_pick"])
def test_loops_hold_the_same_points(name, tmp_path):
    model = load(ROBOTS / f"{name.rpartition('_')[0]}.urdf")
    scene = robodyn.scene_of(model, robodyn.load_scene(ROBOTS / f"{name}.toml"))
    m = compiled(write_mjcf(described(model.description, scene)[0], "robot.xml").data, tmp_path)
    assert m.neq == sum(1 + (loop.kind == "hinge") for loop in scene.loops) > 0
    d, q = mujoco.MjData(m), np.random.default_rng(0).uniform(-1, 1, model.nq)
    state(m, d, model, q, np.zeros(model.n))
    mujoco.mj_kinematics(m, d)
    poses = link_poses(model, q)
    for loop in scene.loops:
        for link, point, end in ((loop.link, loop.point, "link"), (loop.to, loop.to_point, "to")):
            here = poses[link].R @ point + poses[link].p if link in poses else np.array(point)
            np.testing.assert_allclose(d.site(f"{loop.name}_{end}").xpos, here, atol=1e-12)


def test_comments_and_names_of_links_are_kept():
    text = ARM.format("<!-- in it -->" + BOB.format(1, 1, 1, 1), "continuous")
    text = text.replace("<link name='bob'>", "<!-- before it & so on --><link name='bob'>").replace(
        "<joint", "<!-- of j --><joint"
    )
    lines = [line.strip() for line in write_mjcf(load_description(text.encode()), "x.xml").data.decode().splitlines()]
    k = lines.index('<body name="bob">')
    assert lines[k + 1] == "<!-- of j -->"
    assert lines[k + 3 : k + 5] == ["<!-- before it & so on -->", "<!-- in it -->"]


def test_meshes_are_named_from_the_output_and_converted_on_demand(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    (tmp_path / "meshes").mkdir()
    box = trimesh.creation.box((0.1, 0.2, 0.3))
    for suffix in ("stl", "ply", "obj"):
        box.export(tmp_path / "meshes" / f"part.{suffix}")
    shapes = "".join(
        f"<visual><geometry><mesh filename='meshes/part.{suffix}' scale='2 2 2'/></geometry></visual>"
        for suffix in ("stl", "ply", "obj", "dae")
    )
    text = ARM.format(BOB.format(1, 1, 1, 1) + shapes, "continuous")
    (tmp_path / "arm.urdf").write_text(text)
    description = load_description(tmp_path / "arm.urdf")
    (tmp_path / "out").mkdir()
    out = str(tmp_path / "out" / "arm.xml")
    written = write_mjcf(description, out)
    assert [line for line in written.lost if line.startswith("meshes")] == [
        "meshes that MuJoCo does not read, which --meshes writes as STL: 'meshes/part.ply'",
        "meshes that are not found: 'meshes/part.dae'",
    ]
    (tmp_path / "out" / "arm.xml").write_bytes(written.data)
    m = mujoco.MjModel.from_xml_path(out)
    assert (m.nmesh, m.ngeom) == (2, 2)
    assert b'file="../meshes/part.stl"' in written.data
    converted = write_mjcf(description, out, convert_meshes=True)
    assert list(converted.files) == ["arm_meshes/part.stl"]
    (tmp_path / "out" / "arm_meshes").mkdir()
    for name, data in converted.files.items():
        (tmp_path / "out" / name).write_bytes(data)
    (tmp_path / "out" / "arm.xml").write_bytes(converted.data)
    m = mujoco.MjModel.from_xml_path(out)
    assert (m.nmesh, m.ngeom) == (3, 3)
    np.testing.assert_allclose(np.ptp(m.mesh_vert, axis=0), (0.2, 0.4, 0.6), rtol=1e-6)
