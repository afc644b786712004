"""`robodyn convert`: what it writes, what it says, what it refuses."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from helpers.command_line import run

ROBOTS = Path(__file__).parents[2] / "robots"
SCARA = str(ROBOTS / "scara.urdf")


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def test_it_says_what_is_lost_and_writes_again(tmp_path):
    for _ in range(2):
        done = run("convert", SCARA, "--to", "mjcf", "--out", "scara.xml")
        assert (done.status, done.err) == (0, "")
        assert done.out.splitlines() == [
            "MJCF cannot say velocity limits: 'shoulder', 'elbow', 'quill'",
            "MJCF cannot say materials",
            "written: scara.xml, 2 kB",
        ]
    text = Path(SCARA).read_text()
    done = run("convert", "-", "--to", "urdf", "--out", "copy.urdf", stdin=text.encode())
    assert (done.status, done.err, done.out) == (0, "", "written: copy.urdf, 3 kB\n")
    assert Path("copy.urdf").read_text().replace("<!-- converted by robodyn -->\n", "") == text


def test_a_scene_goes_along():
    Path("scene.toml").write_text("gravity = [0, 0, -3]\nfriction.elbow = { viscous = 0.25 }\n")
    done = run("convert", SCARA, "--scene", "scene.toml", "--payload", "spindle=2", "--to", "mjcf", "--out", "a.xml")
    assert (done.status, done.err) == (0, "")
    text = Path("a.xml").read_text()
    assert '<option gravity="0 0 -3"/>' in text
    assert 'damping="0.25"' in text
    assert '<body name="spindle_payload">' in text


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (
            (str(ROBOTS / "puma560.urdf"), "--out", "a.xml"),
            r"puma560.urdf:63: link 'trunk' is impossible: .* rule RD207",
        ),
        ((str(ROBOTS / "pendulum.urdf"), "--out", "a.xml"), r"pendulum.urdf:46: link 'bob' moves, .* rule RD204"),
        (("arm.urdf", "--out", "./arm.urdf"), "./arm.urdf: the output would overwrite an input"),
        (("arm.urdf", "--out", "notes.xml"), "notes.xml: is there already, and is no converted description"),
        (("arm.urdf", "--out", "none/a.xml"), "none/a.xml: cannot be written: no such file or directory"),
        (("arm.urdf",), "missing option '--out'"),
    ],
)
def test_what_is_refused(words, message):
    Path("arm.urdf").write_text(Path(SCARA).read_text())
    Path("notes.xml").write_text("<mujoco/>")
    done = run("convert", *words, "--to", "mjcf")
    assert (done.status, done.out) == (2, "")
    assert done.err.count("\n") == 1
    assert re.search(message, done.err), done.err
    assert sorted(path.name for path in Path().iterdir()) == ["arm.urdf", "notes.xml"], "nothing is written"
    assert Path("notes.xml").read_text() == "<mujoco/>"


def test_meshes_are_written_beside_it():
    done = run("convert", str(ROBOTS / "meshed_arm.urdf"), "--to", "mjcf", "--out", "a.xml", "--meshes")
    assert (done.status, done.err) == (0, "")
    mujoco = pytest.importorskip("mujoco")
    assert mujoco.MjModel.from_xml_path("a.xml").nv == 6


def test_meshes_of_others_are_not_replaced(tmp_path):
    pytest.importorskip("trimesh").creation.box().export(tmp_path / "part.ply")
    shape = '<visual><geometry><mesh filename="part.ply"/></geometry></visual>'
    Path("arm.urdf").write_text(f'<robot name="r"><link name="l">{shape}</link></robot>')
    call = ("convert", "arm.urdf", "--to", "mjcf", "--out", "a.xml", "--meshes")
    for _ in range(2):
        assert run(*call).out == "written: a.xml, 1 kB\n"
    assert Path("a_meshes/part.stl").stat().st_size == 84 + 12 * 50
    Path("a.xml").unlink()
    Path("a_meshes/part.stl").write_text("mine")
    done = run(*call)
    assert (done.status, done.err.partition(" (")[0]) == (
        2,
        "error: a_meshes/part.stl: is there already, and is no converted mesh that robodyn has written",
    )
    assert not Path("a.xml").exists()


def test_xacro_is_expanded():
    pytest.importorskip("xacro")
    text = '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:property name="n" value="l"/>'
    Path("r.xacro").write_text(f'{text}<link name="${{n}}"/></robot>')
    done = run("convert", "r.xacro", "--to", "urdf", "--out", "r.urdf")
    assert (done.status, done.err) == (0, "")
    assert done.out.startswith("URDF cannot say macros and arguments of xacro, whose expansion it is\n")
    assert '<link name="l"/>' in Path("r.urdf").read_text()
