"""OBJ and OFF: every form of index, polygons, comments, continued lines, and every way to be cut short."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.mesh_files import obj, rows
from helpers.mesh_samples import box, corners

from robodyn.errors import MeshError
from robodyn.solids.mesh.read.load import load_triangles

VERTICES = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1)]
TEXT = "".join(f"v {x} {y} {z}\n" for x, y, z in VERTICES)


def read(text):
    return load_triangles(text if isinstance(text, bytes) else text.encode(), file_type="obj")


@pytest.mark.parametrize("corner", ["{}", "{}/1", "{}//2", "{}/1/2", "{}/", "+{}"])
def test_every_form_of_index(corner):
    np.testing.assert_array_equal(rows(read(obj(box(), corner)).array()), rows(box()))


@pytest.mark.parametrize(
    "face",
    ["f 1 2 3", "f -5 -4 -3", "f 1 -4 3//7", "f\t1  2\t3 \r", "f 1 \\\n2 \\\r\n 3 # a face", "f 1 2 3 \\"],
)
def test_a_face_in_many_spellings(face):
    for text in (TEXT + face, TEXT + face + "\n", (TEXT + face).replace("\r\n", "\n").replace("\n", "\r")):
        np.testing.assert_array_equal(read(text).array(), corners(VERTICES, [(0, 1, 2)]))
    if not {"-", "\\"} & {*face}:
        np.testing.assert_array_equal(read(f"{face}\n{TEXT}").array(), corners(VERTICES, [(0, 1, 2)]))


def test_negative_indices_count_from_the_vertices_before_the_face():
    text = "v 9 9 9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 0 0 1\nf -1 -2 -4\n"
    points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    np.testing.assert_array_equal(read(text).array(), corners(points, [(0, 1, 2), (3, 2, 0)]))


@pytest.mark.parametrize(
    "vertex", ["v {} {} {} 1.0", "v {} {} {} 0.1 0.2 0.3", "v {} {} {} # 4 5", "  v   {}\t{} {}  \r"]
)
def test_weights_colours_and_blanks(vertex):
    text = "\n".join(vertex.format(*point) for point in VERTICES)
    np.testing.assert_array_equal(read(text + "\nf 1 2 5").array(), corners(VERTICES, [(0, 1, 4)]))


def test_other_lines_do_not_matter():
    text = "\ufeff# v 5 5 5\nmtllib x.mtl\no first#\nvt 1 2\nvn 0 0 1\nvp 1\n" + TEXT + "g a b\ns off\nusemtl v\n"
    read_back = read(text + "f 1 2 3\ng c\nl 1 2\np 3\nf 1 3 4\n# the path ends in a C:\\\nf 1 2 5\n")
    np.testing.assert_array_equal(read_back.array(), corners(VERTICES, [(0, 1, 2), (0, 2, 3), (0, 1, 4)]))


def test_polygons_become_fans():
    result = read(TEXT + "f 1 2 3 4\nf 5 1 2\nf 5 4 3 2 1\n")
    faces = [(0, 1, 2), (0, 2, 3), (4, 0, 1), (4, 3, 2), (4, 2, 1), (4, 1, 0)]
    np.testing.assert_array_equal(result.array(), corners(VERTICES, faces))
    assert "2 of 3 faces have more than three corners: cut into triangles" in result.notes


def test_unused_vertices_do_not_matter():
    text = "v nan inf 1e999\n" + TEXT + "v 1e30 0 0\nf 2 3 4\n"
    np.testing.assert_array_equal(read(text).array(), corners(VERTICES, [(0, 1, 2)]))


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("v nan 0 0\n" + TEXT + "f 2 3 4\nf 2 3 4 1\n", "face 2 has a corner at (nan, 0, 0)"),
        (TEXT + "f 1 2 3\nf 1 2 6\n", "face 2 names vertex 5, counted from 0, of 5"),
        (TEXT + "f 1 2 3\nf 7 1 2\n", "face 2 names vertex 6, counted from 0, of 5"),
        (TEXT + "f 1 2 3\nf 1 2 123456789012\n", "face 2 names vertex 123456789011"),
        (TEXT + "f 1 2 -6\n", "6: vertex -6 of the 5 before this face"),
        (TEXT + "f 1 2 0\n", "6: vertex 0 of the 5"),
        (TEXT + "f 1 2\n", "6: a face with 2 corners"),
        (TEXT + "f\n", "6: a face with 0 corners"),
        (TEXT + "f 1 2 x\n", "6: 'x' is not an index"),
        (TEXT + "f 1 2 3.0\n", "6: '3.0' is not an index"),
        (TEXT + "f 1 2 /3\n", "6: '/3' is not an index"),
        (TEXT + "f 1 2 9999999999999999999\n", "is not an index"),
        ("v 1 2\n" + TEXT, "1: a vertex with 2 coordinates"),
        (TEXT + "v 1 2 3_0\n", "6: '3_0' is not a number"),
        (TEXT + "v 1 2 0x1\n", "6: '0x1' is not a number"),
        (TEXT, "holds 5 vertices and no faces"),
        ("some words\n", "no line begins with 'v' or 'f'"),
        ("v 1 2 3\0\n", "binary data, no OBJ"),
        (b"\xff\xfe" + TEXT.encode("utf-16-le"), "binary data, no OBJ"),
    ],
)
def test_what_is_wrong_is_told(text, what):
    with pytest.raises(MeshError, match=r"^<bytes>:") as caught:
        read(text)
    assert what in str(caught.value)


def test_a_line_without_end_is_refused():
    with pytest.raises(MeshError, match=r"^<bytes>:2: a line longer than 16 MB"):
        read(b"v 1 2 3\nf 1 2 3 " + b"1 " * (9 << 20))


@pytest.mark.parametrize("count", [1000, 2500])
def test_digits_are_told_from_every_coordinate(count):
    """However many points are looked at, y and z are among the numbers."""
    points = "".join(f"v {k % 2} {np.sin(k):.6e} {np.cos(k):.6e}\n" for k in range(count))
    assert read(points + "f 1 2 3\n").significand == 23


POINTS = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
SQUARE = "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n"


def read_off(text):
    return load_triangles(text.encode() if isinstance(text, str) else text, file_type="off")


@pytest.mark.parametrize(
    "text",
    [
        SQUARE,
        SQUARE.replace("\n", "\r\n"),
        SQUARE.replace("\n", "\r"),
        SQUARE.replace("OFF\n", "OFF "),
        SQUARE.replace("OFF\n", "# a comment: OFF 9 9 9\n\n  OFF # here\n"),
        SQUARE.replace("4 2 0", "4 2"),
        SQUARE.replace("OFF", "COFF").replace("1 0 0\n", "1 0 0 255 255 0 128\n"),
        SQUARE.replace("OFF", "NOFF").replace("1 0 0\n", "1 0 0 0 0 1 # normal\n"),
        SQUARE.replace("3 0 1 2", "3  0 1 2 0.5 0.5 0.5"),
        SQUARE.replace("2 0\n", "1 0\n").replace("3 0 1 2\n3 0 2 3", "4 0 1 2 3"),
        SQUARE + "more words that do not matter\n",
    ],
)
def test_the_same_square_in_many_spellings(text):
    np.testing.assert_array_equal(read_off(text).array(), corners(POINTS, [(0, 1, 2), (0, 2, 3)]))


def test_every_truncation_is_told():
    for length in range(len(SQUARE) - 2):
        with pytest.raises(MeshError, match=r"^<bytes>:.*\)$"):
            read_off(SQUARE[:length])


@pytest.mark.parametrize(
    ("old", "new", "what"),
    [
        ("4 2 0", "4 3 0", "the header promises 3 faces, 2 are there"),
        ("4 2 0", "4 999999999999999999 0", "promises 999999999999999999 faces, 2 are there"),
        ("4 2 0", "999999999999999999 2 0", "promises 999999999999999999 vertices, 6 are there"),
        ("4 2 0", "4 0 0", "holds 4 vertices and no faces"),
        ("OFF", "4OFF", "does not begin with 'OFF'"),
        ("OFF\n", "OFF BINARY\n", "does not begin with 'OFF'"),
        ("3 0 1 2", "4 0 1 2", "7: a face of 4 corners with 3 words after that number"),
        ("3 0 1 2", "2 0 1", "7: a face of 2 corners"),
        ("3 0 1 2", "-3 0 1 2", "7: a face of -3 corners"),
        ("3 0 1 2", "3 0 1 4", "face 1 names vertex 4, counted from 0, of 4"),
        ("3 0 2 3", "3 0 2 -1", "face 2 names vertex -1"),
        ("1 1 0", "1 nan 0", "face 1 has a corner at (1, nan, 0)"),
        ("1 1 0", "1 1", "5: a vertex with 2 coordinates"),
        ("1 1 0", "1 1 z", "5: 'z' is not a number"),
    ],
)
def test_what_is_wrong_with_an_off_is_told(old, new, what):
    with pytest.raises(MeshError, match=r"^<bytes>:") as caught:
        read_off(SQUARE.replace(old, new, 1))
    assert what in str(caught.value)
