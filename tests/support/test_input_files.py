"""One function opens what is read: regular files within limits; nothing else in the product opens a file."""

from __future__ import annotations

import ast
import os
import re
import socket
from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers.command_line import motion, run, write_arm
from helpers.hurried import hurried
from helpers.sampled import sampled

from robodyn.errors import InputError
from robodyn.support.input_file import VARIABLE, limits, open_input, read_input, vetted

pytestmark = pytest.mark.skipif(os.name != "posix", reason="needs pipes and devices")
ROOT = Path(__file__).parents[2]
OPENS = {
    *("open", "io.open", "os.open", "codecs.open", "fdopen", "os.fdopen", "read_text", "read_bytes", "fromfile"),
    *("memmap", "loadtxt", "genfromtxt", "np.load", "numpy.load", "OSFile", "memory_map", "ParquetFile", "AnyReader"),
    *("ZipFile", "is_zipfile", "sqlite3.connect", "TarFile", "fileinput", "linecache", "copyfile", "copy2", "copytree"),
    *("read_csv", "scan_csv", "read_parquet", "scan_parquet", "ElementTree.parse", "iterparse", "process_file"),
    "load_mesh",
}
"""Calls that open a file by its name, by their last word, or by two where one says too little."""
MAY = {
    "robodyn/support/input_file.py": {"open": "the function itself", "os.open": "the function itself"},
    "robodyn/support/files.py": {"open": "files that are written", "fdopen": "a stream", "os.fdopen": "a stream"},
    "robodyn/support/cache.py": {
        "open": "regular files of this user alone, checked there",
        "os.open": "the same",
        "read_bytes": "robodyn's own modules",
    },
    "robodyn/support/processes.py": {"open": "the null device", "fdopen": "a stream", "os.fdopen": "a stream"},
    "robodyn/report/renderers/pages.py": {"read_text": "robodyn's own assets"},
    "cli/view.py": {"open": "the page in the browser"},
    "robodyn/measure/doctor.py": {"read_text": "/proc/cpuinfo"},
    "robodyn/trajectory/write.py": {"memmap": "a temporary file of its own", "ZipFile": "an output that is open",
                                    "open": "a member of that"},
    "robodyn/trajectory/formats/binary_tables.py": {"ZipFile": "a stream that is open", "open": "a member of that",
                                                    "scan_parquet": "a file that was vetted"},
    "robodyn/trajectory/formats/csv_table.py": {"read_csv": "bytes in memory"},
    "robodyn/trajectory/formats/bags.py": {"AnyReader": "a bag whose files were vetted", "open": "a stream of rosbags"},
    "robodyn/solids/mesh/read/scenes.py": {"ElementTree.parse": "a stream that is open", "ZipFile": "the same",
                                           "open": "a member of that"},
    "cli/screen.py": {"open": "the null device", "os.open": "the same"},
}  # fmt: skip
"""Who calls one, and on what."""
_SEPARATE = ("robodyn/robot/urdf/xacro", "robodyn/checks/imported", "robodyn/robot/mjcf/compiler")
"""What runs as a process of its own, with bounds of its own."""


def _calls() -> Iterator[tuple[str, str, int]]:
    last = {name.rpartition(".")[2] for name in OPENS}
    called = re.compile(rf"\b({'|'.join(last)})\W*\(")
    for base in ("robodyn", "cli"):
        for path in sorted((ROOT / base).rglob("*.py")):
            text = path.read_text()
            for node in ast.walk(ast.parse(text)) if called.search(text) else ():
                if isinstance(node, ast.Call) and getattr(node.func, "attr", getattr(node.func, "id", "")) in last:
                    words = ast.unparse(node.func).split(".")
                    for name in dict.fromkeys((words[-1], ".".join(words[-2:]))):
                        if name in OPENS:
                            yield path.relative_to(ROOT).as_posix(), name, node.lineno


def test_nothing_else_opens_files() -> None:
    """A new place has to call `open_input`, or to be listed above with what it opens."""
    calls = [*_calls()]
    others = [f"{file}:{line}: {name}" for file, name, line in calls if name not in MAY.get(file, {})]
    assert not [other for other in others if not other.startswith(_SEPARATE)], others
    assert not {(file, name) for file, names in MAY.items() for name in names} - {call[:2] for call in calls}


def test_regular_files_alone(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"content")
    os.mkfifo(tmp_path / "pipe")
    os.mkdir(tmp_path / "folder")
    for name, target in (("zero", "/dev/zero"), ("stdin", "/dev/stdin"), ("link", "file"), ("endless", "endless")):
        os.symlink(target, tmp_path / name)
    with socket.socket(socket.AF_UNIX) as server:
        server.bind(str(tmp_path / "socket"))
        assert read_input(tmp_path / "link") == b"content"
        assert read_input(tmp_path / "file", 3) == b"con"
        assert vetted(tmp_path / "file") == str(tmp_path / "file")
        for name in ("pipe", "folder", "zero", "endless", "none", "socket"):
            for typed in (False, True):
                with pytest.raises(OSError, match=r"not a file|directory|No such|Too many|address"), hurried():
                    open_input(tmp_path / name, typed)
    with pytest.raises(ValueError, match="null"):
        open_input("a\0b")


def test_sizes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A file may have as many bytes as are read, and no more: sparse ones cost nothing to send."""
    path = tmp_path / "large"
    with open(path, "wb") as stream:
        stream.truncate(limits().file_bytes + 1)
    monkeypatch.setenv(VARIABLE, "file_bytes=1e5")
    with pytest.raises(InputError, match=r"large: too many bytes, at most 100000 are read \(.*file_bytes=NUMBER"):
        read_input(path)
    path.write_bytes(b"1" * 100_000)
    assert len(read_input(path)) == 100_000


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("bytes=5", "'bytes' is no limit"),
        ("file_bytes=x", "'file_bytes=x' is not NAME=NUMBER"),
        ("file_bytes=-1", "'file_bytes=-1'"),
        ("file_bytes=inf", "'file_bytes=inf' is not NAME=NUMBER"),
        ("file_bytes", "'file_bytes' is not NAME=NUMBER"),
    ],
)
def test_limits_that_are_none(text: str, words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, text)
    write_arm(tmp_path)
    outcome = run("info", str(tmp_path / "arm.urdf"))
    assert (outcome.status, outcome.err.count("\n")) == (2, 1)
    assert words in outcome.err


OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"
ROBOT = """<robot name="arm">
  <link name="base"><visual><geometry><mesh filename="package://arm_description/meshes/a.obj"/></geometry></visual>
    <collision><geometry><mesh filename="package://arm_description/meshes/b.stl"/></geometry></collision></link>
  <link name="tip"><visual><geometry><mesh filename="package://arm_description/meshes/c.dae"/></geometry>
      <material name="m"><texture filename="package://arm_description/meshes/t.png"/></material></visual>
    <inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
    <collision><geometry><mesh filename="../meshes/d.glb"/></geometry></collision></link>
  <joint name="j" type="revolute"><parent link="base"/><child link="tip"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="9" velocity="9"/></joint>
</robot>
"""
MANIFEST = "<package><name>{}</name></package>"
TEXTS = {
    "package.xml": MANIFEST.format("arm_description"),
    "urdf/arm.urdf": ROBOT,
    "config/arm.srdf": '<robot name="arm"><group name="g"><joint name="j"/></group></robot>',
    "robodyn.toml": "[tool.robodyn.check]\n",
    "pyproject.toml": "",
    "base.json": '{"robodyn_baseline": 1, "findings": []}',
    "arm.csv": "time,q_j\n0,0\n0.1,0\n0.2,0\n0.3,0\n",
    "meshes/a.obj": OBJ,
    **dict.fromkeys(("meshes/b.stl", "meshes/c.dae", "meshes/d.glb", "meshes/t.png"), ""),
    "scene.toml": "gravity = [0, 0, -1]\n",
    "b.csv": "time,q_j\n0,0\n0.1,0\n0.2,0\n0.3,0\n",
    "../other/package.xml": MANIFEST.format("other"),
    "urdf/part.xacro": "",
    "map.toml": 'q_j = "q_j"\n',
    "meshes/a.mtl": "",
}
NAMES = [*TEXTS]
CALLS = [
    ("check", "urdf/arm.urdf", "--select", "ALL", "--trajectory", "arm.csv", "--baseline", "base.json"),
    ("check", ".", "--select", "ALL"),
    ("check", "meshes/a.obj"),
    ("check", "config/arm.srdf"),
    ("info", "urdf/arm.urdf"),
    ("torques", "urdf/arm.urdf", "arm.csv", "--scene", "scene.toml", "--map", "map.toml"),
    ("torques", "urdf/arm.urdf", "arm.csv", "b.csv", "--out", "out/"),
    ("inertia", "meshes/a.obj", "meshes/b.stl"),
    ("inertia", "urdf/arm.urdf"),
]


@pytest.fixture(name="package")
def _package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    root = tmp_path / "src" / "arm_description"
    monkeypatch.setenv("ROBODYN_CACHE", "0")
    for name, text in TEXTS.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text)
    monkeypatch.chdir(root)
    return root


TRIED = [(name, "pipe") for name in NAMES] + [(name, kind) for name in NAMES[::6] for kind in ("zero", "stdin")]


@pytest.mark.parametrize(("name", "kind"), sampled([pytest.param(*each) for each in TRIED], 6))
def test_no_file_is_waited_for(name: str, kind: str, package: Path) -> None:
    """Any file of a package may be a pipe, or a link to a device or to standard input, which is open and silent."""
    (package / name).unlink()
    reader, writer = os.pipe()
    if kind == "pipe":
        os.mkfifo(package / name)
    else:
        os.symlink("/dev/zero" if kind == "zero" else f"/dev/fd/{reader}", package / name)
    for call in (call for call in CALLS if call in CALLS[:2] or name in call):
        with hurried():
            outcome = run(*call)
        assert outcome.status in (0, 1, 2), call
        assert "internal error" not in outcome.err, (call, outcome.err)
        if name in call:
            assert outcome.status == 2, call
            assert "not a file" in outcome.err or "no such file" in outcome.err, (call, outcome.err)
    os.close(writer)
    os.close(reader)


def test_a_member_of_a_batch(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The others are computed."""
    write_arm(tmp_path)
    monkeypatch.chdir(tmp_path)
    os.mkdir("runs")
    Path("runs/a.csv").write_text(motion(10))
    os.mkfifo("runs/b.csv")
    os.symlink("/dev/zero", "runs/c.csv")
    os.mkfifo("runs/d.mcap")
    with hurried():
        outcome = run("torques", "arm.urdf", "runs/*", "--out", "out", "--jobs", "1")
    assert outcome.status == 2
    assert outcome.err.count("not a file") == 3, outcome.err
    assert sorted(os.listdir("out")) == ["a.csv", "a.json"]
