"""Where a mesh comes from and of which type it is: names, contents, pipes, arrays, units; STL, binary and ASCII."""

from __future__ import annotations

import io
import os
import sys
import tracemalloc
from types import SimpleNamespace

import numpy as np
import pytest
from helpers.command_line import run
from helpers.mesh_files import ascii_stl, dae, glb, indexed, obj, off, ply, rows, three_mf
from helpers.mesh_samples import binary_stl, box, moved, torus
from helpers.processes import python

import robodyn
from robodyn.errors import MeshError
from robodyn.solids.mesh.read.load import from_array, load_triangles
from robodyn.solids.mesh.read.source import METRES
from robodyn.solids.mesh.triangles import BLOCK

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


@pytest.mark.parametrize("kind", ["stl", "3mf"])
def test_standard_input(kind, monkeypatch):
    monkeypatch.setattr(sys, "stdin", SimpleNamespace(buffer=io.BytesIO(FILES[kind])))
    read = load_triangles("-", file_type=kind if kind == "3mf" else None)
    assert read.name == "<stdin>"
    for _ in range(2):
        assert sum(len(block) for block in read.blocks()) == read.count == 12


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
    assert python(code.replace("sys.argv[1]", repr(str(path)))).stdout == "\n"


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


TORUS = torus(rings=16, sectors=12)
RING = torus(rings=60, sectors=50)
"""6000 triangles: a whole block and a part of one."""


@pytest.fixture
def ring(tmp_path):
    path = tmp_path / "ring.stl"
    path.write_bytes(binary_stl(RING))
    return path


def stl(data):
    return load_triangles(data, file_type="stl")


@pytest.mark.parametrize("rows", [7, BLOCK, 10**6])
def test_blocks_are_consecutive_for_two_readers_at_once(ring, rows):
    read = load_triangles(ring)
    assert (read.name, read.count, read.significand, read.scale) == (str(ring), 6000, 24, 1.0)
    assert read.array().dtype == np.float64
    blocks, others = zip(*zip(read.blocks(rows), read.blocks(rows), strict=True), strict=True)
    assert {len(block) for block in blocks[:-1]} <= {rows}
    for found in (blocks, others, list(load_triangles(ring.read_bytes()).records(rows))):
        np.testing.assert_array_equal(np.concatenate(found), RING.astype(np.float32))


def test_a_binary_file_is_never_in_memory_as_a_whole(tmp_path):
    path = tmp_path / "large.stl"
    path.write_bytes(binary_stl(np.tile(RING, (50, 1, 1))))
    tracemalloc.start()
    try:
        count = sum(len(block) for block in load_triangles(path).blocks())
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert count == 300_000
    assert peak < 1 << 20 < path.stat().st_size // 14


def test_bytes_after_the_last_triangle_are_noted():
    read = stl(binary_stl(box(), extra=b"12345"))
    assert read.count == 12
    assert "5 bytes after the last triangle are left out" in read.notes


@pytest.mark.parametrize(
    ("data", "what"),
    [
        (binary_stl(box())[:-1], "the header promises 12 triangles (684 bytes), the file has 683 bytes, 11 whole"),
        (binary_stl(box(), b"solid x")[:300], "promises 12 triangles (684 bytes), the file has 300 bytes, 4 whole"),
        (binary_stl(box(), count=2**32 - 1), "promises 4294967295 triangles"),
        (binary_stl(box(), count=0), "promises 0 triangles, though 600 bytes follow"),
        (binary_stl(box()[:0]), "promises 0 triangles"),
        (b"\0" * 83, "83 bytes are no STL"),
        (b"just some words", "text without 'solid' or 'facet'"),
        (b"solid nothing\nendsolid nothing\n", "no facets"),
        (ascii_stl(box())[:-14], "12 facets without 'endsolid'"),
        (ascii_stl(box())[:800], "ends where 'vertex' should follow"),
        (ascii_stl(box()).replace(b"solid part\n", b"", 1), "no line begins with 'solid'"),
        (ascii_stl(box()).replace(b"0.5", b"0,5", 1), "write decimals with a point"),
        (ascii_stl(box()).replace(b"-0.5", b"5x", 1), "'5x' is not a number"),
        (ascii_stl(box()).replace(b"endloop", b"vertex 1 2 3 endloop", 1), "where 'endloop' should stand"),
        (b"", "is empty"),
    ],
)
def test_what_is_wrong_is_told(data, what):
    with pytest.raises(MeshError, match=r"^<bytes>:") as caught:
        stl(data)
    assert what in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("value", [np.nan, -np.inf])
@pytest.mark.parametrize("write", [binary_stl, ascii_stl])
def test_a_corner_that_is_not_finite_names_its_face(write, value):
    corners = TORUS.copy()
    corners[300, 1, 2] = value
    read = stl(write(corners))
    for use in (lambda: list(read.blocks()), read.array):
        with pytest.raises(MeshError, match=rf"face 301 has a corner at \(.*{value:g}\)"):
            use()


def test_a_file_that_changes_meanwhile_is_refused(ring):
    read = load_triangles(ring)
    ring.write_bytes(ring.read_bytes()[:-50])
    with pytest.raises(MeshError, match="has changed since it was opened"):
        list(read.blocks())
    ring.unlink()
    with pytest.raises(MeshError, match="no such file"):
        list(read.blocks())


@pytest.mark.parametrize(
    "data",
    [
        ascii_stl(TORUS, feed="\r\n").upper(),
        b"\xef\xbb\xbf" + ascii_stl(TORUS, feed="\r").replace(b" ", b" \t "),
        *(ascii_stl(TORUS, name) for name in ("", "vertex 1 2 3", "a solid, endfacet", "solid", "\xe9")),
        *(
            ascii_stl(TORUS).replace(b"facet normal 0 0 0", normal)
            for normal in (b"facet", b"facet normal", b"facet normal nan nan -nan(ind)", b"facet normal 1 2")
        ),
    ],
)
def test_ascii_in_every_spelling(data):
    """Ends of lines, cases and blanks, names of solids, and normals do not matter."""
    read = stl(data)
    assert read.significand == 53
    np.testing.assert_array_equal(read.array(), TORUS)


@pytest.mark.parametrize(("number", "bits"), [("%.12g", 39), ("%.9e", 33), ("%+.6g", 19), ("%.2f", 53)])
def test_the_digits_of_a_text_tell_how_far_it_is_rounded(number, bits):
    """Numbers of fewer than five digits are taken as exact; all are rounded correctly."""
    found = stl(ascii_stl(TORUS, number=number))
    assert found.significand == bits
    written = np.array([float(number % value) for value in TORUS.ravel()]).reshape(TORUS.shape)
    np.testing.assert_array_equal(found.array(), written)


def test_several_solids_are_taken_together():
    read = stl(ascii_stl(box()) + ascii_stl(TORUS))
    np.testing.assert_array_equal(read.array(), np.concatenate([box(), TORUS]))
    assert "2 solids are taken together" in read.notes


def test_a_header_that_counts_too_few_triangles_is_a_warning_with_both_numbers(tmp_path):
    path = tmp_path / "part.stl"
    path.write_bytes(binary_stl(np.concatenate([box(), moved(box(), (3, 0, 0))]), count=12))
    warning = "the header counts 12 triangles, the file has room for 24: 12 are left out"
    found = robodyn.mass_properties(path)
    assert (found.triangles, found.warnings) == (12, (warning,))
    with pytest.raises(MeshError, match=f"{warning} .--strict refuses"):
        robodyn.mass_properties(path, strict=True)
    assert f"warning: {warning}\n" in run("inertia", str(path)).out
    robot = tmp_path / "robot.urdf"
    shape = '<visual><geometry><mesh filename="part.stl"/></geometry></visual>'
    robot.write_text(f'<robot name="r"><link name="l">{shape}</link></robot>')
    assert f"may not be whole: {warning}" in run("check", str(robot)).out
