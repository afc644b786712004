"""Where a mesh comes from and of which type it is: names, contents, standard input, pipes, arrays, units."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest
from helpers.mesh_files import ascii_stl, dae, glb, indexed, obj, off, ply, rows, three_mf
from helpers.mesh_samples import binary_stl, box, torus

from robodyn.errors import MeshError
from robodyn.solids.mesh.read.load import from_array, load_triangles
from robodyn.solids.mesh.read.source import METRES

BOX = box((1, 2, 3))
FILES = {
    "stl": binary_stl(BOX),
    "obj": obj(BOX),
    "ply": ply(indexed(BOX)[0], indexed(BOX)[1].tolist()),
    "off": off(BOX),
    "dae": dae(BOX),
    "glb": glb(BOX),
    "3mf": three_mf(BOX),
}


@pytest.mark.parametrize("kind", FILES)
def test_by_the_suffix_in_any_case_or_by_the_content(kind, tmp_path):
    for name in (f"part.{kind.upper()}", "part")[: 2 - (kind == "3mf")]:
        (tmp_path / name).write_bytes(FILES[kind])
        np.testing.assert_array_equal(rows(load_triangles(str(tmp_path / name)).array()), rows(BOX))
    assert load_triangles(ascii_stl(BOX)).count == 12


@pytest.mark.parametrize("unit", METRES)
def test_units_scale_and_leave_the_corners(unit):
    for kind in ("stl", "obj", "ply", "off"):
        read, bare = load_triangles(FILES[kind], unit=unit), load_triangles(FILES[kind])
        assert read.scale == {"m": 1, "mm": 0.001, "cm": 0.01, "in": 0.0254}[unit]
        np.testing.assert_array_equal(rows(read.array()), rows(BOX))
        assert read.notes[0] == f"unit: {unit} as asked"
        assert (bare.scale, bare.notes) == (1.0, ("unit: metres, as the file says none",))


@pytest.mark.parametrize(
    ("name", "kind", "what"),
    [
        ("part.obj", "stl", "is named .obj but begins as STL does (rename it to .stl)"),
        ("part.stl", "ply", "is named .stl but begins as PLY does"),
        ("part.step", "stl", "unknown type of mesh .step (types: stl, obj, ply"),
        ("part", "3mf", "the type of mesh is not known (say which: stl, obj"),
    ],
)
def test_names_that_do_not_fit(name, kind, what, tmp_path):
    path = tmp_path / name
    path.write_bytes(FILES[kind])
    with pytest.raises(MeshError) as caught:
        load_triangles(path)
    assert str(caught.value).startswith(f"{path}: {what}")
    assert load_triangles(path, file_type=f".{kind.upper()}").count == 12
    for read in (lambda: load_triangles(path, unit="ft", file_type=kind), lambda: from_array(BOX, unit="ft")):
        with pytest.raises(MeshError, match=r"unknown unit 'ft' \(units: m, mm, cm, in\)"):
            read()
    with pytest.raises(MeshError, match=r"unknown type of mesh 'step' \(types: stl, "):
        load_triangles(path, file_type="step")


def test_nothing_to_read(tmp_path):
    (tmp_path / "empty.stl").write_bytes(b"")
    cases = {
        "empty.stl": "is empty",
        "none.stl": "there is no such file",
        ".": "is a folder, not a file",
        "empty.stl/x.stl": "cannot be read: not a directory",
        "a\0b.stl": "is not the name of a file",
        "/dev/zero": "is a device",
    }
    for name, what in cases.items():
        with pytest.raises(MeshError, match=what):
            load_triangles(os.path.join(tmp_path, name))
    with pytest.raises(MeshError, match=r"^'': there is no such file"):
        load_triangles("")


def test_no_permission_by_the_word_of_the_system(tmp_path, monkeypatch):
    def refuse(*_, **__):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("builtins.open", refuse)
    with pytest.raises(MeshError, match="no permission to read the file"):
        load_triangles(tmp_path / "part.stl")


READ = """
import sys
from robodyn.solids.mesh.read.load import load_triangles
read = load_triangles("-", file_type=sys.argv[1] if len(sys.argv) > 1 else None)
print(read.name, read.count, sum(len(block) for block in read.blocks()), sum(len(block) for block in read.blocks()))
"""


@pytest.mark.parametrize("kind", ["stl", "ply", pytest.param("3mf", marks=pytest.mark.slow)])
def test_standard_input(kind):
    call = [sys.executable, "-c", READ, *([kind] if kind == "3mf" else [])]
    done = subprocess.run(call, input=FILES[kind], capture_output=True, check=True)
    assert (done.stdout.split(), done.stderr) == ([b"<stdin>", b"12", b"12", b"12"], b"")


def test_standard_input_that_is_closed(monkeypatch):
    monkeypatch.setattr(sys, "stdin", None)
    with pytest.raises(MeshError, match=r"^<stdin>: standard input is closed"):
        load_triangles("-")


@pytest.mark.skipif(not os.path.isdir("/dev/fd"), reason="the system has no names for descriptors")
def test_a_pipe_that_was_typed_is_read_once_and_used_twice():
    """As `<(zcat part.stl.gz)` of shells is."""
    end, other = os.pipe()
    with os.fdopen(other, "wb") as stream:
        stream.write(FILES["stl"])
    try:
        with pytest.raises(MeshError, match="this is a pipe, not a file"):
            load_triangles(f"/dev/fd/{end}")
        read = load_triangles(f"/dev/fd/{end}", typed=True)
    finally:
        os.close(end)
    for _ in range(2):
        np.testing.assert_array_equal(read.array(), BOX)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="the system has no named pipes")
@pytest.mark.parametrize("typed", [False, True])
def test_a_named_pipe_is_refused(tmp_path, typed):
    pipe = tmp_path / "pipe.stl"
    os.mkfifo(pipe)
    with pytest.raises(MeshError, match="this is a pipe, not a file"):
        load_triangles(pipe, typed=typed)


def test_a_binary_stl_needs_no_heavy_module(tmp_path):
    path = tmp_path / "part.stl"
    path.write_bytes(FILES["stl"])
    code = (
        "import sys; from robodyn.solids.mesh.read.load import load_triangles; load_triangles(sys.argv[1]).array(); "
        "print(*{'trimesh', 'scipy', 'json', 'zipfile', 'tempfile', 'xml.etree.ElementTree'} & sys.modules.keys())"
    )
    done = subprocess.run([sys.executable, "-c", code, path], capture_output=True, text=True, check=True)
    assert done.stdout == "\n"


def test_arrays():
    assert from_array(BOX.astype(np.float32)).significand == 24
    read = from_array(BOX.astype(int) * 2, unit="mm")
    assert (read.name, read.count, read.significand, read.scale) == ("<array>", 12, 53, 1e-3)
    assert read.array().dtype == np.float64
    blocks = list(from_array(torus()).blocks(100))
    assert [len(block) for block in blocks] == [100] * 10 + [24]
    np.testing.assert_array_equal(np.concatenate(blocks), torus())


@pytest.mark.parametrize(
    ("corners", "what"),
    [
        (np.zeros((0, 3, 3)), r"shape \(0, 3, 3\)"),
        (np.zeros((4, 3)), r"shape \(4, 3\)"),
        ([[["a"]]], "not numbers"),
        (np.zeros((1, 3, 3), complex), "not numbers"),
        ([[1], [1, 2]], "not numbers"),
        (np.where(np.arange(108).reshape(12, 3, 3) == 100, np.nan, 0), "face 12 has a corner"),
    ],
)
def test_arrays_that_are_no_triangles(corners, what):
    with pytest.raises(MeshError, match=what):
        from_array(corners)
