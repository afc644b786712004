"""SDF against Drake's parser: masses, centres and tensors, placements and axes, mass matrix and gravity, at 1e-12."""

from __future__ import annotations

import importlib.metadata
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from helpers.sampled import sampled

import robodyn
from robodyn.programs.vectors import rotation_about
from robodyn.robot.kinematics import body_poses, link_poses
from robodyn.robot.load import assemble, load_description
from robodyn.robot.masses.declared import declared

DRAKE = pytest.importorskip("pydrake", reason="Drake is not installed").__file__.rpartition("/")[0]
from pydrake.math import RigidTransform, RotationMatrix  # noqa: E402
from pydrake.multibody.parsing import Parser  # noqa: E402
from pydrake.multibody.plant import MultibodyPlant  # noqa: E402

EPS = 1e-12


def sdf(inside: str, version: str = "1.10", more: str = "") -> str:
    return f"<sdf version='{version}'><model name='m' {more}>{inside}</model></sdf>"


def inertial(k: float, pose: str = "") -> str:
    """An <inertial> whose centre and axes are off those of the link."""
    where = pose or f"<pose>{0.1 * k} {0.2 - 0.03 * k} {0.05 * k * k} {0.3 * k} {-0.2 * k} {0.7 + k}</pose>"
    tensor = {"ixx": 0.3, "iyy": 0.4, "izz": 0.5 + 0.01 * k, "ixy": 0.02, "ixz": -0.03, "iyz": 0.04}
    entries = "".join(f"<{key}>{value}</{key}>" for key, value in tensor.items())
    return f"<inertial>{where}<mass>{1.0 + 0.3 * k}</mass><inertia>{entries}</inertia></inertial>"


def link(name: str, pose: str = "", k: float = 1.0, more: str = "") -> str:
    return f"<link name='{name}'>{pose}{inertial(k)}{more}</link>"


def joint(
    name: str, kind: str, parent: str, child: str, axis: str = "<axis><xyz>0 0.6 0.8</xyz></axis>", pose: str = ""
):
    ends = f"<parent>{parent}</parent><child>{child}</child>"
    return f"<joint name='{name}' type='{kind}'>{pose}{ends}{axis}</joint>"


GROUNDED = joint("base", "fixed", "world", "a", "") + link("a", "<pose>0.1 0.2 0.3 0.4 -0.5 0.6</pose>", 0.5)
B, C = (f"<pose>{at}</pose>" for at in ("0.5 -0.1 0.4 0.7 0.2 -0.9", "-0.3 0.6 0.9 -1.2 0.5 0.4"))


class Pair:
    """A model as Drake and as robodyn have it; `v = E qd` maps rates."""

    def __init__(self, source: str, packages: dict[str, str] | None = None) -> None:
        description = load_description(
            source.encode() if source.startswith("<") else source, package_paths=[*(packages or {}).values()]
        )
        self.description = description
        # What floats is held where it stands at rest, by both.
        held = tuple(replace(j, type="fixed") if j.type == "floating" else j for j in description.joints)
        self.ours = assemble(replace(description, joints=held))
        self.plant = plant = MultibodyPlant(0.0)
        parser = Parser(plant)
        for name, folder in (packages or {}).items():
            parser.package_map().Add(name, folder)
        for i in parser.AddModelsFromString(source, "sdf") if source.startswith("<") else parser.AddModels(source):
            assert plant.GetModelInstanceName(i)
        rest = link_poses(self.ours, np.zeros(self.ours.nq))
        floating = [j.child for j in description.joints if j.type == "floating"]
        floating += [description.root] if description.root != "world" else []
        floating += [j.child for j in description.joints if j.name.endswith("_fixed") and j.parent == "world"]
        for name in floating:
            body = self.body(name)
            if not [j for j in self.plant_joints() if j.child_body() is body]:
                R, p = rest[name]
                plant.WeldFrames(plant.world_frame(), body.body_frame(), RigidTransform(RotationMatrix(R), p))
        plant.Finalize()
        self.context = plant.CreateDefaultContext()
        self.joints = {body.joint.name: body.joint for body in self.ours.bodies}

    def plant_joints(self):
        return [self.plant.get_joint(i) for i in self.plant.GetJointIndices()]

    def body(self, name: str):
        """The body that we call `model::link`; Drake has a model instance for each model."""
        *models, last = name.split("::")
        found = []
        for index in self.plant.GetBodyIndices(self.instance(models)) if models else ():
            found += [b for b in [self.plant.get_body(index)] if b.name() == last]
        if not models:
            outer = [i for i in self.instances() if "::" not in self.plant.GetModelInstanceName(i).removeprefix("w::")]
            found = [self.plant.get_body(b) for i in outer for b in self.plant.GetBodyIndices(i)]
            found = [b for b in found if b.name() == last and b.name() != "world"]
        assert len(found) == 1, (name, found)
        return found[0]

    def instances(self):
        from pydrake.multibody.tree import ModelInstanceIndex

        return [ModelInstanceIndex(i) for i in range(self.plant.num_model_instances())]

    def instance(self, models: list[str]):
        names = {i: self.plant.GetModelInstanceName(i) for i in self.instances()}
        (found,) = [i for i, name in names.items() if name.split("::")[-len(models) :] == models and "::" in name]
        return found

    def set(self, q: np.ndarray, qd: np.ndarray) -> np.ndarray:
        """Set Drake's state, and return E."""
        E = np.zeros((self.plant.num_velocities(), self.ours.n))
        positions = np.zeros(self.plant.num_positions())
        for theirs in self.plant_joints():
            name, first, at = self.name(theirs), theirs.velocity_start(), theirs.position_start()
            if theirs.num_velocities() == 0:
                continue
            if theirs.num_velocities() == 3:
                own = [self.joints[f"{name}_{letter}"] for letter in "xyz"]
                turns = [rotation_about(np.eye(3)[k], q[each.coordinate]) for k, each in enumerate(own)]
                rpy = RotationMatrix(turns[0] @ turns[1] @ turns[2]).ToRollPitchYaw().vector()
                positions[at : at + 3] = rpy
                before = np.eye(3)
                for k, each in enumerate(own):
                    E[first : first + 3, each.rate] = before @ np.eye(3)[k]
                    before = before @ turns[k]
                continue
            names = [name] if theirs.num_velocities() == 1 else [f"{name}_1", f"{name}_2"]
            for k, each in enumerate(names):
                our = self.joints[each]
                positions[at + k] = our.multiplier * q[our.coordinate] + our.offset
                E[first + k, our.rate] = our.multiplier
        self.plant.SetPositions(self.context, positions)
        self.plant.SetVelocities(self.context, E @ qd)
        return E

    def name(self, theirs) -> str:
        model = self.plant.GetModelInstanceName(theirs.model_instance()).split("::")
        # Drake counts a joint as one of its child's model.
        parts = [model[k:end] for end in range(len(model), -1, -1) for k in range(end + 1)]
        names = ["::".join([*part, theirs.name()]) for part in parts]
        return next((n for n in names if n in self.joints or f"{n}_x" in self.joints or f"{n}_1" in self.joints), "")

    def check(self, samples: int = 3) -> None:
        plant, ours, description = self.plant, self.ours, self.description
        assert not list(plant.GetFloatingBaseBodies())
        assert plant.num_velocities() >= ours.n
        our_child = {each.name: each.child for each in description.joints}
        rng = np.random.default_rng(1)
        for k in range(samples):
            q, qd = rng.uniform(-1, 1, ours.nq) * (k > 0), rng.uniform(-1, 1, ours.n)
            E = self.set(q, qd)
            where = link_poses(ours, q)
            for each in description.links:
                if each.inertial is None:
                    continue
                body, given = self.body(each.name), declared(each).body
                X = plant.EvalBodyPoseInWorld(self.context, body)
                R, p = where[each.name]
                near(R, X.rotation().matrix(), 1.0)
                theirs = body.CalcSpatialInertiaInBodyFrame(self.context)
                assert given.mass == pytest.approx(theirs.get_mass(), rel=EPS, abs=0)
                size = 1.0 + np.abs(p).max()
                near(R.T @ (p - X.translation()) + given.com, theirs.get_com(), size)
                about = theirs.Shift(theirs.get_com()).CalcRotationalInertia().CopyToFullMatrix3()
                near(given.inertia, about, np.abs(about).max())
            for theirs in self.plant_joints():
                our = self.joints.get(self.name(theirs))
                if our is None or theirs.type_name() not in ("revolute", "prismatic"):
                    continue
                X = theirs.frame_on_child().CalcPoseInWorld(self.context)
                R, p = body_poses(ours, q)[[body.joint for body in ours.bodies].index(our)]
                axis = theirs.revolute_axis() if our.kind == "revolute" else theirs.translation_axis()
                backwards = self.body(our_child[our.name]) is not theirs.child_body()
                near(R @ our.axis, X.rotation().matrix() @ axis * (-1 if backwards else 1), 1.0)
                if our.kind == "revolute":
                    near(np.cross(R @ our.axis, p - X.translation()), np.zeros(3), 1.0 + np.abs(p).max())
            M = plant.CalcMassMatrix(self.context)
            near(robodyn.mass_matrix(ours, q), E.T @ M @ E, np.abs(M).max(initial=0.0))
            g = plant.CalcGravityGeneralizedForces(self.context)
            weight = 9.81 * ours.total_mass * (1.0 + max(np.abs(p).max() for _, p in where.values()))
            near(robodyn.bias_forces(ours, q, np.zeros(ours.n)), -E.T @ g, weight)


def near(found, expected, scale: float) -> None:
    assert np.abs(np.asarray(found) - np.asarray(expected)).max(initial=0.0) <= EPS * scale


def two(
    kind: str = "revolute", axis: str = "<axis><xyz>0 0.6 0.8</xyz></axis>", pose: str = "", at: str = B, more: str = ""
) -> str:
    """Link a on the ground, b on a, and more."""
    return GROUNDED + link("b", at) + joint("j", kind, "a", "b", axis, pose) + more


def quaternion(numbers: str) -> str:
    return f"<pose rotation_format='quat_xyzw'>{numbers}</pose>"


def rotor(inertia: float, gear: float) -> str:
    parts = {"rotor_inertia": inertia, "gear_ratio": gear}
    return "<axis/>" + "".join(f"<drake:{key} xmlns:drake='d'>{value}</drake:{key}>" for key, value in parts.items())


TURNED, POSED = "<pose>0.4 -0.2 0.3 0.1 0.2 0.3</pose>", "<pose>0.1 0.2 0.3 0.4 0.5 0.6</pose>"
AXIS, TWO_AXES = "<axis><xyz>0 0.6 0.8</xyz></axis>", "<axis><xyz>1 0 0</xyz></axis><axis2><xyz>0 1 0</xyz></axis2>"
LINK_C, LINK_D = link("c", C, 2), link("d", B, 3)
ON_A = joint("k", "revolute", "a", "n")
"""What ties a model n to a."""
FEATURES = {
    "poses in degrees": two(
        pose="<pose degrees='true'>0.1 0.2 0.3 -40 50 60</pose>", at="<pose degrees='true'>1 2 3 10 20 30</pose>"
    ),
    "quaternions": two(
        "continuous", pose=quaternion("0.1 0.2 0.3 0.5 0.5 -0.5 0.5"), at=quaternion("1 2 3 0.1 -0.5 0.7 0.5")
    ),
    "empty poses": two(at="<pose relative_to='a'/>"),
    "relative to links, joints and frames": GROUNDED
    + link("b", "<pose relative_to='f'>0.1 0 0 0.3 0 0</pose>")
    + "<frame name='f' attached_to='a'><pose relative_to='g'>0 1 0 0 0.2 0</pose></frame>"
    + "<frame name='g'><pose relative_to='a'>0 0 1 0 0 0.4</pose></frame>"
    + joint("j", "revolute", "f", "b", pose="<pose relative_to='g'>1 1 1 0.1 0.2 0.3</pose>")
    + link("c", "<pose relative_to='j'>0.2 0 0.1 0 0.4 0</pose>", 2)
    + joint("k", "prismatic", "j", "c"),
    "ends that are frames": GROUNDED
    + link("b", B)
    + "<frame name='e' attached_to='b'><pose>0.3 0.2 0.1 0.5 0.6 0.7</pose></frame>"
    + "<frame name='ee' attached_to='e'><pose>0.3 0.2 0.1 0.5 0.6 0.7</pose></frame>"
    + joint("j", "revolute", "a", "ee", pose="<pose>0.1 0 0 0 0 0.2</pose>"),
    "axes in other frames": two(axis="<axis><xyz expressed_in='__model__'>1 2 3</xyz></axis>", more=LINK_C)
    + joint(
        "k", "prismatic", "b", "c", "<axis><xyz expressed_in='a'>-1 2 0.5</xyz></axis>", "<pose>1 1 1 1 1 1</pose>"
    ),
    "the usual axis": two(axis="<axis/>"),
    "a branched tree": two(more=LINK_C + LINK_D)
    + joint("k", "prismatic", "a", "c")
    + joint("n", "revolute", "c", "d", pose=TURNED),
    "backwards": f"<frame name='z'/>{link('b', B)}{GROUNDED}{joint('j', 'fixed', 'a', 'b')}{LINK_C}{LINK_D}"
    + joint("k", "revolute", "c", "b", pose=TURNED)
    + joint("n", "prismatic", "d", "c"),
    "ball": two("ball", "", POSED),
    "universal": two("universal", TWO_AXES, POSED, more=LINK_C + joint("k", "revolute", "b", "c")),
    "screw": two("screw", f"<screw_thread_pitch>0.3</screw_thread_pitch>{AXIS}", "<pose>0.1 0.2 0 0.4 0 0</pose>"),
    "screw, old pitch": two("screw", f"<thread_pitch>7</thread_pitch>{AXIS}"),
    "nested models": GROUNDED
    + f"<model name='n'><pose relative_to='a'>1 0 0 0 0.5 0</pose>{link('b', B)}"
    + "<frame name='f'><pose>0 0 2 0 0 1</pose></frame>"
    + f"<model name='o'><pose>0 1 0 0.3 0 0</pose>{LINK_C}</model>{joint('j', 'revolute', 'o::c', 'b')}</model>"
    + joint("k", "revolute", "a", "n::b", "<axis><xyz expressed_in='n::f'>1 0 1</xyz></axis>")
    + link("d", "<pose relative_to='n::o::c'>1 2 3 0 0 1</pose>", 3)
    + joint("h", "prismatic", "n::o", "d"),
    "placement frames": f"{GROUNDED}{ON_A}<model name='n' placement_frame='f'>"
    + f"<pose relative_to='a'>1 0 0 0 0.5 0</pose>{link('b', B)}"
    + "<frame name='f' attached_to='b'><pose>0 0 2 0 0 1</pose></frame></model>",
    "canonical links": f"{GROUNDED}{ON_A}<model name='n' canonical_link='c'>{link('b', B)}{LINK_C}"
    + joint("j", "revolute", "b", "c")
    + "</model>",
    "canonical links behind models": f"{GROUNDED}{ON_A}<model name='n'><model name='o'>{LINK_C}</model>{link('b', B)}"
    + joint("j", "revolute", "b", "o::c")
    + "</model>",
    "models of models": GROUNDED
    + f"<model name='n'><model name='o'><pose>1 0 0 0 1 0</pose>{LINK_C}</model></model>{ON_A}",
    "links without mass": GROUNDED + "<link name='b'/>" + joint("j", "revolute", "a", "b"),
    "inertials with parts": GROUNDED
    + "<link name='b'><inertial><mass>3</mass></inertial></link>"
    + joint("j", "revolute", "a", "b")
    + "<link name='c'><inertial><inertia><ixy>0.1</ixy></inertia></inertial></link>"
    + joint("k", "revolute", "b", "c"),
    "rotors": two(axis=rotor(0.02, 7)),
    "floating": link("a", "<pose>0.1 0.2 0.3 0.4 -0.5 0.6</pose>") + link("b", B) + joint("j", "revolute", "a", "b"),
    "several floating": link("a", B)
    + link("b", B)
    + LINK_C
    + LINK_D
    + joint("j", "revolute", "a", "b")
    + joint("k", "revolute", "d", "c"),
}


OLD_AXIS = "<axis><xyz>1 2 -1</xyz>{}</axis>"
OLD = {
    ("1.6", "joint"): OLD_AXIS.format(""),
    ("1.6", "model"): OLD_AXIS.format("<use_parent_model_frame>1</use_parent_model_frame>"),
    ("1.5", "joint"): OLD_AXIS.format("<use_parent_model_frame>0</use_parent_model_frame>"),
    ("1.4", "model"): OLD_AXIS.format(""),
}


@pytest.mark.parametrize("version", OLD)
def test_versions_before_frames(version: tuple[str, str]) -> None:
    Pair(sdf(two("revolute", OLD[version], POSED), version[0])).check()


CASSIE = [f"cassie_{name}.sdf" for name in ("v2", "reduced", "simple", "wo_gearbox_spring")]


@pytest.mark.parametrize("name", sampled(CASSIE, 2))
def test_cassie_without_its_loops(name: str, tmp_path: Path) -> None:
    """Drake knows no loops: without the joints that close them, both have the tree; before they are the same tree."""
    files = importlib.metadata.files("example-robot-data") or []
    source = Path(next(file for file in files if file.name == name).locate())
    text, whole = source.read_text(), load_description(source)
    loops = [loop["name"] for loop in whole.scene["loop"]]
    assert len(loops) == 4
    for loop in loops:
        text, found = re.subn(rf"<joint name=.{loop}..*?</joint>", "", text, flags=re.DOTALL)
        assert found == 1
    text = re.sub(r"<(visual|collision) .*?</\1>|<plugin.*?</plugin>|^<!--.*?-->", "", text, flags=re.DOTALL)
    pair = Pair(text.strip())
    pair.check(2)
    assert [replace(link, geometries=(), line=0) for link in whole.links] == [
        replace(link, line=0) for link in pair.description.links
    ]


@pytest.mark.parametrize("name", FEATURES)
def test_features(name: str) -> None:
    Pair(sdf(FEATURES[name])).check()


@pytest.mark.parametrize("path", sorted(str(path) for path in Path(DRAKE).rglob("*.sdf")), ids=lambda p: p[-30:])
def test_files_of_drake(path: str) -> None:
    Pair(path).check()


def test_included_models(tmp_path: Path) -> None:
    hand = "<pose>5 5 5 0 0 0</pose>" + link("x", B, 2) + "<frame name='f'><pose>0 0 1 0 1 0</pose></frame>"
    things = tmp_path / "things"
    things.mkdir()
    (things / "hand.sdf").write_text(sdf(hand))
    (things / "placed.sdf").write_text(sdf(hand, more="placement_frame='f'"))
    text, uri = GROUNDED, "<uri>package://things/hand.sdf</uri>"
    for k, more in enumerate(
        ("", "<pose relative_to='a'>1 0 0 0 1 0</pose>", "<placement_frame>f</placement_frame><pose>0 1 0 2 0 0</pose>")
    ):
        text += f"<include>{uri}<name>n{k}</name>{more}</include>" + joint(f"j{k}", "revolute", "a", f"n{k}::x")
    placed = "<uri>package://things/placed.sdf</uri>"
    for k, more in ((5, ""), (6, "<pose>1 0 2 0 1 0</pose>")):
        text += f"<include>{placed}<name>n{k}</name>{more}</include>" + joint(f"j{k}", "revolute", "a", f"n{k}::x")
    text += f"<include merge='true'><name>n9</name>{uri}<pose>0 1 0 2 0 0</pose></include>"
    text += joint("j9", "prismatic", "n0", "x", pose="<pose relative_to='f'>1 1 1 0 0 0</pose>")
    Pair(sdf(text), {"things": str(things)}).check()


@pytest.mark.parametrize("kind", ["box", "sphere", "cylinder", "capsule"])
@pytest.mark.parametrize("mass", ["", "<mass>7</mass>"])
def test_masses_by_density(kind: str, mass: str) -> None:
    sizes = {"box": "<size>1 2 3</size>", "sphere": "<radius>0.7</radius>"}
    size = sizes.get(kind, "<radius>0.7</radius><length>2</length>")
    shape = f"<geometry><{kind}>{size}</{kind}></geometry>"
    other = "<geometry><box><size>0.5 0.4 0.3</size></box></geometry>"
    inside = f"<inertial auto='true'><density>300</density>{mass}</inertial>"
    inside += f"<collision name='c'><pose>1 2 3 0.1 0.2 0.3</pose>{shape}</collision>"
    inside += f"<collision name='d'><density>2000</density>{other}</collision>"
    text = GROUNDED + f"<link name='b'>{B}{inside}</link>" + joint("j", "revolute", "a", "b")
    Pair(sdf(text, "1.12")).check()


def random_model(rng: np.random.Generator) -> str:
    """A tree of links, some in nested models, with poses of all kinds that hang on links, joints and frames before."""

    def pose(bases: list[str]) -> str:
        x, y, z, roll, pitch, yaw = rng.uniform(-1, 1, 6)
        base = f"relative_to='{rng.choice(bases)}'" if bases and rng.random() < 0.7 else ""
        kind = rng.integers(3)
        if kind == 0:
            return f"<pose {base}>{x} {y} {z} {roll} {pitch} {yaw}</pose>"
        if kind == 1:
            return f"<pose {base} degrees='1'>{x} {y} {z} {90 * roll} {90 * pitch} {90 * yaw}</pose>"
        quat = rng.normal(size=4)
        turn = " ".join(map(str, quat / np.linalg.norm(quat)))
        return f"<pose {base} rotation_format='quat_xyzw'>{x} {y} {z} {turn}</pose>"

    links, frames, text = ["l0"], ["l0"], link("l0", pose([]), 0.3)
    text += joint("j0", str(rng.choice(["fixed", "revolute"])), "world", "l0")
    for k in range(1, int(rng.integers(4, 9))):
        if rng.random() < 0.3:
            inside = link("x", pose([]), 0.2 * k) + f"<frame name='f'>{pose(['x'])}</frame>"
            text += f"<model name='n{k}'>{pose(frames)}{inside}</model>"
            name = f"n{k}::x"
            frames += [name, f"n{k}", f"n{k}::f"]
        else:
            name = f"l{k}"
            text += link(name, pose(frames), 0.2 * k)
            frames.append(name)
        if rng.random() < 0.4:
            text += f"<frame name='g{k}' attached_to='{rng.choice(frames)}'>{pose(frames)}</frame>"
        ends = [str(rng.choice(links)), name]
        if rng.random() < 0.25:
            ends.reverse()
        x, y, z = rng.uniform(-1, 1, 3)
        axis = f"<axis><xyz expressed_in='{rng.choice(['', '__model__', *frames])}'>{x} {y} {z}</xyz></axis>"
        kind = str(rng.choice(["revolute", "continuous", "prismatic", "fixed", "ball", "universal", "screw"]))
        if kind in ("ball", "universal", "screw") and ends[0] == name:
            kind = "revolute"
        pitch = "<screw_thread_pitch>0.4</screw_thread_pitch>" if kind == "screw" else ""
        if kind == "universal":
            axis = "<axis><xyz>0 1 0</xyz></axis><axis2><xyz>0 0 -1</xyz></axis2>"
        text += joint(f"j{k}", kind, *ends, "" if kind in ("ball", "fixed") else pitch + axis, pose(frames))
        frames.append(f"j{k}")
        links.append(name)
    return sdf(text)


@pytest.mark.parametrize("seed", sampled(range(16), 2))
def test_random_models(seed: int) -> None:
    Pair(random_model(np.random.default_rng(seed))).check(2)
