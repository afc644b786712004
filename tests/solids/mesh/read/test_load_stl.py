"""STL, binary and ASCII: which of the two it is, its triangles to the last bit, and every way to be cut short."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest
from helpers.command_line import run
from helpers.mesh_files import ascii_stl
from helpers.mesh_samples import binary_stl, box, flipped, moved, torus

import robodyn
from robodyn.errors import MeshError
from robodyn.solids.mesh.read.load import load_triangles
from robodyn.solids.mesh.triangles import BLOCK

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


@pytest.mark.parametrize("header", [b"solid exported by a program", b"solid x facet normal", b"\xff" * 80])
def test_the_size_tells_binary_from_text(header):
    assert stl(binary_stl(box(), header)).count == 12


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
    corners = RING.copy()
    corners[5000, 1, 2] = value
    read = stl(write(corners))
    for use in (lambda: list(read.blocks()), read.array):
        with pytest.raises(MeshError, match=rf"face 5001 has a corner at \(.*{value:g}\)"):
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
        ascii_stl(RING, feed="\r\n").upper(),
        b"\xef\xbb\xbf" + ascii_stl(RING, feed="\r").replace(b" ", b" \t "),
        *(ascii_stl(RING, name) for name in ("", "vertex 1 2 3", "a solid, endfacet", "solid", "\xe9")),
        *(
            ascii_stl(RING).replace(b"facet normal 0 0 0", normal)
            for normal in (b"facet", b"facet normal", b"facet normal nan nan -nan(ind)", b"facet normal 1 2")
        ),
    ],
)
def test_ascii_in_every_spelling(data):
    """Ends of lines, cases and blanks, names of solids, and normals do not matter."""
    read = stl(data)
    assert read.significand == 53
    np.testing.assert_array_equal(read.array(), RING)


@pytest.mark.parametrize(("number", "bits"), [("%.12g", 39), ("%.9e", 33), ("%+.6g", 19), ("%.2f", 53)])
def test_the_digits_of_a_text_tell_how_far_it_is_rounded(number, bits):
    """Numbers of fewer than five digits are taken as exact; all are rounded correctly."""
    found = stl(ascii_stl(RING, number=number))
    assert found.significand == bits
    written = np.array([float(number % value) for value in RING.ravel()]).reshape(RING.shape)
    np.testing.assert_array_equal(found.array(), written)


def test_several_solids_are_taken_together():
    read = stl(ascii_stl(box()) + ascii_stl(RING))
    np.testing.assert_array_equal(read.array(), np.concatenate([box(), RING]))
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


def test_the_warning_outlives_a_repair():
    found = robodyn.mass_properties(
        binary_stl(flipped(torus()), count=len(torus()) - 1), file_type="stl", scale=(1, 1, -2)
    )
    assert found.repairs
    assert "1 are left out" in found.warnings[0]
