"""MJCF against MuJoCo itself: `mj_inverse` and `mj_fullM` at random states, of every feature and of random models."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh

import robodyn
from robodyn.cli.files import robot_in_scene
from robodyn.cli.options import Call
from robodyn.programs.vectors import rotation_about, rotation_from_rpy
from robodyn.robot.kinematics import body_poses
from robodyn.robot.mjcf import compiler, read
from robodyn.robot.urdf.parts import Limit, Mimic
from robodyn.scene.scene import Spring

mujoco = pytest.importorskip("mujoco")
TESTDATA = mujoco.__file__.rpartition("/")[0] + "/testdata"


@pytest.fixture(autouse=True)
def here(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Compile in this process, which leaves a log: `test_compiler` starts others."""
    monkeypatch.chdir(tmp_path)

    def compiled(data: bytes, file: str):
        return compiler._extracted("" if file.startswith("<") else file, data.decode(), ".")

    monkeypatch.setattr(read, "compiled", compiled)


def mjcf(body: str, more: str = "") -> bytes:
    return f"<mujoco model='m'>{more}<worldbody>{body}</worldbody></mujoco>".encode()


ARM = "<geom type='capsule' size='.05' fromto='0 0 0 .3 .1 .05'/>"


class Pair:
    """A model as MuJoCo and as robodyn have it, and maps between their states: `qvel = E qd`."""

    def __init__(self, text: bytes | str) -> None:
        if isinstance(text, bytes):
            self.theirs = mujoco.MjModel.from_xml_string(text.decode())
        else:
            self.theirs = mujoco.MjModel.from_xml_path(text)
        self.theirs.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT  # friction, which is soft there, too
        self.data = mujoco.MjData(self.theirs)
        self.ours = robodyn.load(text)
        scene = robodyn.scene_of(self.ours)
        self.loops = scene.loops
        self.scene = replace(scene, loops=())
        self.names = [mujoco.mj_id2name(self.theirs, mujoco.mjtObj.mjOBJ_JOINT, j) for j in range(self.theirs.njnt)]
        self.joints = {body.joint.name: body.joint for body in self.ours.bodies}
        moving = "base" if self.ours.floating else None
        found = self.ours.description.joints
        self.free = [moving or each.name for each in found if each.type == "floating"]

    def value(self, q, name):
        joint = self.joints[name]
        return joint.multiplier * q[joint.coordinate] + joint.offset

    def state(self, q, qd, qdd):
        """Set MuJoCo's state, and return E."""
        m, d = self.theirs, self.data
        E, rates, free = np.zeros((m.nv, self.ours.n)), np.zeros((m.nv, self.ours.n)), iter(self.free)
        named = read._distinct([name or "" for name in self.names], self._usual())
        for j, name in enumerate(named):
            at, dof, kind = m.jnt_qposadr[j], m.jnt_dofadr[j], m.jnt_type[j]
            if kind == mujoco.mjtJoint.mjJNT_FREE:
                joint = self.joints[next(free)]
                k, i = joint.coordinate, joint.rate
                x, y, z, w = q[k + 3 : k + 7]
                d.qpos[at : at + 7] = [*q[k : k + 3], w, x, y, z]
                E[dof : dof + 6, i : i + 6] = np.roll(np.eye(6), 3, axis=0)
            elif kind == mujoco.mjtJoint.mjJNT_BALL:
                own = [self.joints[f"{name}_{letter}"] for letter in "xyz"]
                turns = [rotation_about(np.eye(3)[k], q[each.coordinate]) for k, each in enumerate(own)]
                quat = np.zeros(4)
                mujoco.mju_mat2Quat(quat, (turns[0] @ turns[1] @ turns[2]).ravel())
                d.qpos[at : at + 4] = quat
                after, w = np.eye(3), np.zeros(3)
                for k in (2, 1, 0):
                    column = after.T @ np.eye(3)[k]
                    E[dof : dof + 3, own[k].rate] = column
                    rates[dof : dof + 3, own[k].rate] = -np.cross(w, column)
                    w = w + column * qd[own[k].rate]
                    after = turns[k] @ after
            else:
                joint = self.joints[name]
                d.qpos[at] = self.value(q, name)
                E[dof, joint.rate] = joint.multiplier
        d.qvel[:] = E @ qd
        d.qacc[:] = E @ qdd + rates @ qd
        return E

    def _usual(self):
        m = self.theirs
        bodies = read._distinct(
            [mujoco.mj_id2name(m, mujoco.mjtObj.mjOBJ_BODY, b) or "" for b in range(m.nbody)],
            [f"body{b}" for b in range(m.nbody)],
        )
        return [f"{bodies[b]}_joint" for b in m.jnt_bodyid]

    def sample(self, rng):
        q = rng.uniform(-1, 1, self.ours.nq)
        for _, first in self.ours.quaternions:
            q[first : first + 4] /= np.linalg.norm(q[first : first + 4])
        return q, rng.uniform(-1, 1, self.ours.n), rng.uniform(-1, 1, self.ours.n)

    def worst(self, samples: int = 3) -> float:
        """The largest difference of torques and mass matrix, relative to the largest entry."""
        rng, worst = np.random.default_rng(0), 0.0
        m, d = self.theirs, self.data
        for _ in range(samples):
            q, qd, qdd = self.sample(rng)
            E = self.state(q, qd, qdd)
            mujoco.mj_inverse(m, d)
            theirs = E.T @ d.qfrc_inverse
            ours = robodyn.inverse_dynamics(self.ours, q, qd, qdd, scene=self.scene, executor="numpy")
            for joint in self.joints.values():
                if joint.friction:
                    speed = joint.multiplier * qd[joint.rate]
                    ours[joint.rate] -= joint.multiplier * joint.friction * np.sign(speed)
            M = np.zeros((m.nv, m.nv))
            mujoco.mj_fullM(m, d, M)
            theirs_M, ours_M = E.T @ M @ E, robodyn.mass_matrix(self.ours, q, scene=self.scene)
            for a, b in ((ours, theirs), (ours_M, theirs_M)):
                worst = max(worst, np.abs(a - b).max() / max(np.abs(b).max(), 1e-12))
        return worst


FEATURES = {
    "ref, pos, armature": mjcf(
        f"""<body name='a' pos='.1 0 .2' euler='20 0 0'><joint name='j' axis='1 2 -1' pos='.1 -.2 .05' ref='35'
        armature='.02' damping='.1' frictionloss='.3' stiffness='4' springref='25'/>{ARM}
        <body pos='.3 0 0'><joint type='slide' axis='0 1 1' ref='.2' pos='9 9 9' armature='.5' stiffness='7'
        springref='-.1' frictionloss='2'/>{ARM}<body pos='0 .1 0'><joint axis='0 0 1' pos='-.1 0 0'/>{ARM}</body>
        <body pos='0 .2 .1' euler='0 90 0'>{ARM}</body></body></body>"""
    ),
    "free": mjcf(
        f"<body name='b' pos='0 0 1' euler='0 30 0'><freejoint/>{ARM}<body><joint axis='0 1 0' pos='.1 0 0'/>"
        f"{ARM}</body></body>"
    ),
    "two free": mjcf(
        f"<body name='b' pos='0 0 1'><freejoint/>{ARM}</body><body name='c'><freejoint name='f'/>{ARM}</body>"
    ),
    "ball": mjcf(
        f"""<body pos='0 0 1' euler='0 30 0'><joint name='b' type='ball' pos='.1 .2 0'/>{ARM}<body pos='.2 0 0'>
        <joint axis='0 1 0' ref='10'/>{ARM}<body pos='.1 0 0'><joint name='c' type='ball'/>{ARM}</body></body></body>"""
    ),
    "inertias": mjcf(
        """<body><joint axis='0 1 0'/><inertial pos='.1 .2 .3' mass='2' fullinertia='.3 .4 .5 .01 .02 -.03'/>
        <body pos='0 0 1'><joint axis='1 0 0'/><inertial pos='.1 0 0' euler='10 20 30' mass='1' diaginertia='.1 .2
        .25'/><body><joint axis='0 0 1'/><inertial pos='0 0 0' mass='1e-9' diaginertia='1e-9 1e-9 9e-3'/>
        <geom size='.1'/></body></body></body>""",
        "<compiler balanceinertia='true' boundmass='.01' boundinertia='1e-4'/>",
    ),
    "from geoms": mjcf(
        f"""<body><joint axis='0 1 0'/><inertial pos='.1 .2 .3' mass='2' diaginertia='.3 .4 .5'/>{ARM}
        <body childclass='thin'><joint/><geom/></body></body>""",
        """<compiler inertiafromgeom='true' angle='radian' settotalmass='7'/><default><default class='thin'>
        <joint axis='1 1 0' ref='.4' armature='.3'/><geom type='box' size='.1 .02 .3' density='500'/></default>
        </default>""",
    ),
    "mimic": mjcf(
        f"""<body><joint name='a' axis='0 1 0' ref='30' armature='.1'/>{ARM}<body pos='.3 0 0'><joint name='b'
        axis='0 0 1' ref='-20' armature='.2' damping='.4'/>{ARM}<body pos='.3 0 0'><joint name='c' axis='1 0 0'/>
        {ARM}</body></body></body>""",
        "<equality><joint joint1='b' joint2='a' polycoef='.1 -2 0 0 0'/><joint joint1='c' joint2='b' "
        "polycoef='0 .5 0 0 0'/></equality>",
    ),
    "gravity, actuators": mjcf(
        f"<body><joint name='a' axis='0 1 0' armature='.1'/>{ARM}<body><joint name='b' type='slide'/>{ARM}</body>"
        "</body>",
        """<option gravity='1 2 -3'/><actuator><motor joint='a' gear='3' armature='.2' damping='.5'/><position joint='b'
        kp='7' gear='-4' armature='.3'/></actuator>""",
    ),
    "no gravity, no springs": mjcf(
        f"<body><joint axis='0 1 0' stiffness='3' damping='2' frictionloss='1'/>{ARM}</body>",
        "<option><flag gravity='disable' spring='disable' damper='disable' frictionloss='disable'/></option>",
    ),
    "air": mjcf(
        f"""<body euler='10 20 30'><joint type='slide' axis='1 2 3'/><inertial pos='.1 0 .2' mass='2' diaginertia='.3 .4
        .5'/><body euler='0 0 90'><joint type='slide' axis='1 1 1'/><inertial pos='.1 0 .2' euler='0 90 0' mass='3'
        diaginertia='.3 .4 .2'/>{ARM}
        </body></body>""",
        "<option density='1.2' wind='3 2 1'/>",
    ),
}


@pytest.mark.filterwarnings("ignore:compiler attribute 'settotalmass'")
@pytest.mark.parametrize("name", FEATURES)
def test_a_feature_moves_as_in_mujoco(name: str) -> None:
    assert Pair(FEATURES[name]).worst() < 1e-10


def random_model(seed: int) -> bytes:
    """A tree of up to 7 bodies with up to 3 joints of all kinds each, anchors, references and armature at random."""
    rng = np.random.default_rng(seed)

    def vector(scale: float = 1.0, n: int = 3) -> str:
        return " ".join(f"{x:.6f}" for x in rng.uniform(-scale, scale, n))

    def body(depth: int) -> str:
        joints = ""
        for _ in range(rng.integers(0, 4)):
            kind = rng.choice(["hinge", "hinge", "slide", "ball"])
            if kind == "ball":
                joints += f"<joint type='ball' pos='{vector(0.2)}'/>"
                break
            joints += (
                f"<joint type='{kind}' axis='{vector()}' pos='{vector(0.2)}' ref='{rng.uniform(-1, 1):.3f}' "
                f"armature='{rng.uniform(0, 0.3):.3f}' damping='{rng.uniform(0, 0.3):.3f}' "
                f"stiffness='{rng.uniform(0, 3):.3f}' springref='{rng.uniform(-1, 1):.3f}' frictionloss='.1'/>"
            )
        if depth == 0 and rng.random() < 0.4:
            joints = "<freejoint/>"
        more = "".join(body(depth + 1) for _ in range(rng.integers(0, 3))) if depth < 3 else ""
        geom = f"<geom type='box' size='.1 .2 .05' pos='{vector(0.2)}' quat='{vector(1.0, 4)}'/>"
        return f"<body pos='{vector()}' quat='{vector(1.0, 4)}'>{joints}{geom}{more}</body>"

    return mjcf(
        body(0), f"<compiler angle='radian'/><option gravity='{vector(9)}'/><default><geom contype='0'/></default>"
    )


@pytest.mark.parametrize("seed", range(12))
def test_a_random_model_moves_as_in_mujoco(seed: int) -> None:
    pair = Pair(random_model(seed))
    if pair.ours.n:
        assert pair.worst(2) < 1e-10


def test_mujocos_own_model() -> None:
    text = Path(TESTDATA, "model.xml").read_text()
    for old, new in (
        ('density="1.225" viscosity="1.8e-5" wind="0 0 1"', ""),
        ('gravcomp="0.5"', ""),
        ('damping=".1" armature=".1"', 'damping="0" armature="0"'),  # of the ball, which has other rates here
    ):
        assert old in text
        text = text.replace(old, new)
    pair = Pair(text.encode())
    assert pair.worst() < 1e-10
    assert pair.ours.n == pair.theirs.nv


def described(body: str, more: str = ""):
    return robodyn.load(mjcf(body, more)).description


def test_drag_that_cannot_be_said_is_not() -> None:
    """Of a body whose inertia is along other axes than the link's."""
    text = FEATURES["air"].replace(b"euler='0 90 0'", b"euler='0 80 0'")
    assert [each.link for each in robodyn.scene_of(robodyn.load(text)).immersed] == ["body1"]


def test_what_flags_disable() -> None:
    text = FEATURES["no gravity, no springs"].replace(b"axis='0 1 0'", b"axis='0 1 0' range='0 90'")
    joint = robodyn.load(text).description.joints[0]
    assert (joint.friction, joint.damping, joint.type) == (0.0, 0.0, "revolute")
    text = text.replace(b"<flag", b"<flag constraint='disable'")
    assert robodyn.load(text).description.joints[0].type == "continuous"


def test_limits_and_efforts() -> None:
    joints = {
        joint.name: joint
        for joint in described(
            f"""<body><joint name='a' range='-90 45' axis='0 1 0'/>{ARM}<body><joint name='b' type='slide' range='-1
            2'/>{ARM}<body><joint name='c' actuatorfrcrange='-5 4'/>{ARM}<body><joint name='d' limited='false'
            range='0 1'/>{ARM}<body><joint name='e' ref='90' range='0 180'/>{ARM}</body></body></body></body></body>""",
            """<actuator><motor joint='a' gear='-3' forcerange='-2 1'/><motor joint='a' ctrlrange='-1 1' gear='10'/>
            <general joint='b' gainprm='7' ctrlrange='-1 2' gear='2' forcerange='-100 100'/><motor joint='c'/>
            <position joint='d' kp='100' ctrlrange='-1 1'/><position joint='e' kp='9' forcerange='-4 4'/></actuator>""",
        ).joints
    }
    assert joints["a"].type == "revolute"
    assert joints["a"].limit == Limit(-np.pi / 2, np.pi / 4, 16.0)
    assert (joints["b"].type, joints["b"].limit) == ("prismatic", Limit(-1.0, 2.0, 28.0))
    assert (joints["c"].type, joints["c"].limit) == ("continuous", Limit(None, None, 5.0))
    assert (joints["d"].type, joints["d"].limit) == ("continuous", None)
    assert joints["e"].limit == Limit(0.0, np.pi, 4.0)


def test_mimic_rules_are_where_the_references_are() -> None:
    text = FEATURES["mimic"].decode()
    joints = {joint.name: joint.mimic for joint in robodyn.load(text.encode()).description.joints}
    degrees = np.pi / 180
    assert joints["a"] is None
    assert (joints["b"].joint, joints["b"].multiplier) == ("a", -2.0)
    assert joints["b"].offset == pytest.approx((-20 + 2 * 30) * degrees + 0.1, abs=1e-15)
    assert joints["c"] == Mimic("b", 0.5, pytest.approx(10 * degrees, abs=1e-15))
    text = text.replace("-2 0 0 0", "-2 1 0 0").replace("joint1='c' joint2='b'", "joint1='c'")
    words = "'b', which is not a straight line; the constraint of joint 'c', which holds it"
    assert any(words in note for note in robodyn.load(text.encode()).notes)


def test_mimic_rules_that_contradict() -> None:
    text = FEATURES["mimic"].decode()
    rules = "<joint joint1='b' joint2='c'/><joint joint1='a' joint2='c'/></equality>"
    (note,) = robodyn.load(text.replace("</equality>", rules).encode()).notes
    assert "joint 'b', which is a second one; the constraint of joint 'a', which closes a circle" in note


def test_a_loop_to_the_ground() -> None:
    text = FEATURES["free"].replace(b"</worldbody>", b"</worldbody><equality><weld body1='b'/></equality>")
    (loop,) = robodyn.scene_of(robodyn.load(text)).loops
    assert (loop.link, loop.to, loop.to_point) == ("b", "ground", (0.0, 0.0, 0.0))
    assert loop.point == pytest.approx((0.5, 0.0, -np.sqrt(0.75)))


LOOPS = mjcf(
    f"""<body name='a' pos='0 0 .1'><joint axis='0 1 0' pos='.05 0 0'/>{ARM}<site name='s' pos='.1 .2 .3' euler='10 0
    0'/><body name='b' pos='.3 0 0'><joint axis='0 0 1' pos='.02 0 0'/>{ARM}</body></body><body name='c' pos='0 1 0'>
    <joint type='ball' pos='0 0 .03'/>{ARM}<site name='t' pos='.3 .2 .1' euler='0 20 0'/></body>""",
    """<equality><connect name='p' body1='b' body2='c' anchor='.3 .1 0'/><connect body1='b' anchor='.1 0 0'/>
    <weld name='w' body1='a' body2='c' anchor='.1 .2 .3' relpose='.1 0 0 .9 .1 .2 .3'/><weld body1='b' anchor='0 0 1'/>
    <weld site1='s' site2='t'/><weld name='n' body1='a' body2='c' torquescale='0'/>
    <connect site1='t' site2='s'/></equality>""",
)


def test_loops_are_as_far_from_closed() -> None:
    pair = Pair(LOOPS)
    assert [(loop.name, loop.kind, loop.link, loop.to) for loop in pair.loops] == [
        ("p", "point", "c", "b"),
        ("connect b world", "point", "b", "world"),
        ("w", "weld", "c", "a"),
        ("weld b world", "weld", "b", "world"),
        ("weld c a", "weld", "c", "a"),
        ("n", "point", "c", "a"),
        ("connect a c", "point", "a", "c"),
    ]
    pair.theirs.opt.disableflags = 0
    rng = np.random.default_rng(1)
    for _ in range(3):
        q, qd, qdd = pair.sample(rng)
        pair.state(q, qd, qdd)
        mujoco.mj_forward(pair.theirs, pair.data)
        poses, row = list(body_poses(pair.ours, q)), 0
        for loop in pair.loops:
            (R, p), (R_to, p_to) = (_link(pair.ours, poses, name) for name in (loop.link, loop.to))
            apart = R @ loop.point + p - R_to @ loop.to_point - p_to
            theirs = pair.data.efc_pos[row : row + 3]
            assert np.linalg.norm(apart) == pytest.approx(np.linalg.norm(theirs), abs=1e-12)
            row += 3
            if loop.name == "n":
                row += 3
            if loop.kind == "weld":
                turn = (R_to @ rotation_from_rpy(*loop.rpy)).T @ R
                sine = np.sqrt(max(3.0 - np.trace(turn), 0.0)) / 2.0  # of half of the angle
                assert sine == pytest.approx(np.linalg.norm(pair.data.efc_pos[row : row + 3]), abs=1e-9)
                row += 3


def _link(model, poses, name):
    frame = model.links[name]
    pose = poses[frame.body]
    return pose.R @ frame.R, pose.R @ frame.p + pose.p


def test_shapes_and_meshes(tmp_path: Path) -> None:
    """A mesh is where its file has it, though MuJoCo turns it to its own axes."""
    rng = np.random.default_rng(0)
    corners = rng.uniform(-1, 1, (8, 3)) * (1.0, 0.5, 0.2) + 0.3
    (tmp_path / "m").mkdir()
    faces = trimesh.convex.convex_hull(corners).export(str(tmp_path / "m" / "part.obj"))
    assert faces is not None
    (tmp_path / "r.xml").write_text(
        mjcf(
            """<body name='a'><joint pos='.1 0 0'/><geom size='.1'/><geom type='box' size='.1 .2 .3' pos='1 0 0'
            euler='0 0 90' contype='0' conaffinity='0' group='3'/><geom type='cylinder' size='.1 .2' group='3'/>
            <geom type='ellipsoid' size='.1 .2 .3'/><geom type='mesh' mesh='part' pos='.1 .2 .3' euler='10 20 30'/>
            </body>""",
            "<compiler meshdir='m'/><asset><mesh name='part' file='part.obj' scale='1 2 .5'/></asset>",
        ).decode()
    )
    pair = Pair(str(tmp_path / "r.xml"))
    link = next(link for link in pair.ours.description.links if link.name == "a")
    assert [(one.kind, one.shape, one.size, one.filename) for one in link.geometries] == [
        ("collision", "sphere", (0.1,), None),
        ("visual", "sphere", (0.1,), None),
        ("visual", "box", (0.2, 0.4, 0.6), None),
        ("collision", "cylinder", (0.1, 0.4), None),
        ("collision", "mesh", (), "m/part.obj"),
        ("visual", "mesh", (), "m/part.obj"),
    ]
    assert link.geometries[2].origin.xyz == (0.9, 0.0, 0.0)
    assert link.geometries[2].origin.rpy == pytest.approx((0.0, 0.0, np.pi / 2))
    mesh, m = link.geometries[-1], pair.theirs
    ours = corners * mesh.scale @ rotation_from_rpy(*mesh.origin.rpy).T + mesh.origin.xyz + (0.1, 0.0, 0.0)
    g = m.ngeom - 1
    R = np.zeros(9)
    mujoco.mju_quat2Mat(R, m.geom_quat[g])
    theirs = m.mesh_vert[: m.mesh_vertnum[0]] @ R.reshape(3, 3).T + m.geom_pos[g]
    assert np.abs(np.sort(ours, axis=0) - np.sort(theirs, axis=0)).max() < 1e-6, "their vertices are float32"
    assert any("1 shape (ellipsoid)" in note for note in pair.ours.notes)


def test_what_has_no_counterpart_is_said_once() -> None:
    model = robodyn.load(
        mjcf(
            f"""<body gravcomp='1'><joint name='a'/>{ARM}<site name='s'/></body><body mocap='true'>{ARM}</body>
            <body pos='0 0 1'><freejoint/>{ARM}</body>""",
            """<option viscosity='.1'/><tendon><fixed name='t'><joint joint='a' coef='2'/></fixed></tendon><actuator>
            <muscle joint='a' lengthrange='0 1'/><motor tendon='t'/><motor site='s'/></actuator>""",
        )
    )
    (note,) = [note for note in model.notes if note.startswith("left out")]
    assert note == (
        "left out, as nothing here is like it: contacts; 1 tendon; 1 muscle; 2 actuators of no single joint; "
        "1 gravcomp of bodies; 1 frame of mocap; the viscosity 0.1"
    )


def test_a_scene_says_otherwise(tmp_path: Path) -> None:
    """What a file says of gravity and springs holds, unless the scene of a call says it, the default, too."""
    text = FEATURES["ref, pos, armature"].decode().replace("<worldbody>", "<option gravity='0 0 -1'/><worldbody>")
    model = robodyn.load(text.encode())
    scene = robodyn.scene_of(model)
    assert scene.gravity == (0.0, 0.0, -1.0)
    assert dict(scene.spring) == {"j": Spring(4.0, 25 * np.pi / 180), "body2_joint": Spring(7.0, -0.1)}
    assert dict(scene.initial_q) == {"j": pytest.approx(35 * np.pi / 180), "body2_joint": 0.2}
    own = robodyn.Scene(gravity=(0, 0, -3), spring={"j": Spring(1.0)})
    mixed = robodyn.scene_of(model, own)
    assert (mixed.gravity, mixed.spring["j"], mixed.spring["body2_joint"]) == (
        own.gravity,
        Spring(1.0),
        Spring(7.0, -0.1),
    )
    assert robodyn.scene_of(model, given=("gravity",)).gravity == robodyn.Scene().gravity
    (tmp_path / "r.xml").write_text(text)
    (tmp_path / "s.toml").write_text("gravity = [0, 0, -9.81]\n")
    for scene_file, gravity in ((None, -1.0), (str(tmp_path / "s.toml"), -9.81)):
        call = Call(scene_files=(scene_file,) if scene_file else ())
        assert robot_in_scene(call, str(tmp_path / "r.xml"))[1].gravity == (0.0, 0.0, gravity)
    asked = Call(gravity=(0.0, 0.0, -9.81))
    assert robot_in_scene(asked, str(tmp_path / "r.xml"))[1].gravity == (0.0, 0.0, -9.81)
