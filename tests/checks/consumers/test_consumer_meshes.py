"""What MuJoCo, Drake and Pinocchio do with meshes, held against what the rules say of it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from helpers.mesh_files import dae, obj
from helpers.mesh_samples import binary_stl
from helpers.peers import mujoco, peer, pin

from robodyn.checks.check import Options, check_one
from robodyn.checks.context import Asked
from robodyn.checks.examples import a_joint, a_link, arm

CORNERS = np.array([(0.0, 0.0, 0.0), (0.3, 0.0, 0.0), (0.0, 0.2, 0.0), (0.0, 0.0, 0.1)])
TETRAHEDRON = CORNERS[np.array([(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)])]
VOLUME = 0.001
STRIPPED = '<mujoco><compiler strippath="true" meshdir="meshes"/></mujoco>'


def described(name: str, kind: str = "collision", scale: str = "1 1 1", extension: str = "") -> str:
    """An arm whose tip has one mesh."""
    shape = f'<{kind}><geometry><mesh filename="{name}" scale="{scale}"/></geometry></{kind}>'
    text = arm(more=a_link("tip").replace("</link>", f"{shape}</link>") + a_joint("j", "upper", "tip"))
    return text.replace("</robot>", f"{extension}</robot>")


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with one tetrahedron in several formats, also below meshes/."""
    (tmp_path / "meshes").mkdir()
    for name, data in (("part.obj", obj(TETRAHEDRON)), ("part.stl", binary_stl(TETRAHEDRON))):
        (tmp_path / name).write_bytes(data)
        (tmp_path / "meshes" / name).write_bytes(data)
    (tmp_path / "part.dae").write_bytes(dae(TETRAHEDRON))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def rejected(text: str, target: str) -> bool:
    """Whether RD901 says that a program rejects it."""
    Path("robot.urdf").write_text(text)
    options = Options(select=("RD901",), asked=Asked(targets=(target,)))
    (one,) = check_one("robot.urdf", options)
    return one.message.startswith(f"{target} rejects it")


def mujoco_rejects(text: str) -> bool:
    Path("robot.urdf").write_text(text)
    try:
        mujoco.MjModel.from_xml_path("robot.urdf")
    except ValueError:
        return True
    return False


def drake_rejects(text: str) -> bool:
    parsing = peer("pydrake.multibody.parsing")
    from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
    from pydrake.systems.framework import DiagramBuilder

    Path("robot.urdf").write_text(text)
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, 0.0)
    try:
        parsing.Parser(plant).AddModels("robot.urdf")
        plant.Finalize()
        builder.Build().CreateDefaultContext()
    except RuntimeError:
        return True
    return False


REJECTS = {"mujoco": mujoco_rejects, "drake": drake_rejects}


@pytest.mark.parametrize("target", REJECTS)
@pytest.mark.parametrize("kind", ["visual", "collision"])
@pytest.mark.parametrize("name", ["part.obj", "part.stl", "part.dae", "none.obj"])
def test_formats(target: str, kind: str, name: str) -> None:
    text = described(name, kind)
    assert rejected(text, target) == REJECTS[target](text)


@pytest.mark.parametrize(
    ("name", "extension"),
    [
        (name, extension)
        for name in ("package://{0.name}/part.stl", "part.stl", "file://{0}/part.stl")
        for extension in ("", STRIPPED, STRIPPED.replace("true", "false"))
    ],
)
def test_uris_in_mujoco(folder: Path, name: str, extension: str) -> None:
    """The package is the file's own folder, so that the mesh is there for us; MuJoCo has it in meshdir, too."""
    text = described(name.format(folder), extension=extension)
    assert rejected(text, "mujoco") == mujoco_rejects(text) == ("://" in name and "true" not in extension)


@pytest.mark.parametrize(("scale", "sign"), [("1 1 1", 1), ("1 -1 1", -1), ("-1 -1 1", 1), ("-1 -1 -1", -1)])
def test_mirrored_meshes(scale: str, sign: int) -> None:
    """What RD606 says of negative scales: Pinocchio alone has a negative volume; the place is right in all."""
    text = described("part.obj", scale=scale)
    Path("robot.urdf").write_text(text)
    centre = np.array((0.075, 0.05, 0.025)) * [float(word) for word in scale.split()]

    model = pin.buildModelFromUrdf("robot.urdf")
    shape = pin.buildGeomFromUrdf(model, "robot.urdf", pin.GeometryType.COLLISION, package_dirs=["."])
    geometry = shape.geometryObjects[0].geometry
    assert geometry.computeVolume() == pytest.approx(sign * VOLUME, rel=1e-6)
    assert geometry.computeCOM() == pytest.approx(centre, rel=1e-6)

    weighed = text.replace("</robot>", '<mujoco><compiler inertiafromgeom="true"/></mujoco></robot>')
    weighed = weighed.replace(a_link("upper"), a_link("upper").replace("</link>", BALL))
    compiled = mujoco.MjModel.from_xml_string(weighed, {"part.obj": Path("part.obj").read_bytes()})
    assert compiled.body_mass[-1] == pytest.approx(1000 * VOLUME, rel=1e-6)
    assert compiled.body_ipos[-1] == pytest.approx(centre, rel=1e-6)


def test_mirrored_meshes_in_drake() -> None:
    geometry = peer("pydrake.geometry")
    for scale in ((1.0, -1.0, 1.0), (-1.0, -1.0, 1.0), (-1.0, -1.0, -1.0)):
        assert geometry.CalcVolume(geometry.Mesh("part.obj", scale3=scale)) == pytest.approx(VOLUME, rel=1e-6)


BALL = '<collision><geometry><sphere radius="0.1"/></geometry></collision></link>'


def test_a_scale_of_zero_is_refused() -> None:
    text = described("part.obj", scale="0 1 1")
    assert mujoco_rejects(text)
    assert drake_rejects(text)
