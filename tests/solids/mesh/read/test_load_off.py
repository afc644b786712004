"""OFF: headers, comments and colours, polygons, and every way to be cut short."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.mesh_files import off, rows
from helpers.mesh_samples import corners, torus

from robodyn.errors import MeshError
from robodyn.solids.mesh.read.load import load_triangles

POINTS = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
TEXT = "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n"


def read(text):
    return load_triangles(text.encode() if isinstance(text, str) else text, file_type="off")


def test_many_chunks_of_text():
    ring = torus(rings=90, sectors=50)
    np.testing.assert_array_equal(rows(read(off(ring)).array()), rows(ring))


@pytest.mark.parametrize(
    "text",
    [
        TEXT,
        TEXT.replace("\n", "\r\n"),
        TEXT.replace("\n", "\r"),
        TEXT.replace("OFF\n", "OFF "),
        TEXT.replace("OFF\n", "# a comment: OFF 9 9 9\n\n  OFF # here\n"),
        TEXT.replace("4 2 0", "4 2"),
        TEXT.replace("OFF", "COFF").replace("1 0 0\n", "1 0 0 255 255 0 128\n"),
        TEXT.replace("OFF", "NOFF").replace("1 0 0\n", "1 0 0 0 0 1 # normal\n"),
        TEXT.replace("3 0 1 2", "3  0 1 2 0.5 0.5 0.5"),
        TEXT.replace("2 0\n", "1 0\n").replace("3 0 1 2\n3 0 2 3", "4 0 1 2 3"),
        TEXT + "more words that do not matter\n",
    ],
)
def test_the_same_square_in_many_spellings(text):
    np.testing.assert_array_equal(read(text).array(), corners(POINTS, [(0, 1, 2), (0, 2, 3)]))


def test_every_truncation_is_told():
    for length in range(len(TEXT) - 2):
        with pytest.raises(MeshError, match=r"^<bytes>:.*\)$"):
            read(TEXT[:length])


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
def test_what_is_wrong_is_told(old, new, what):
    with pytest.raises(MeshError, match=r"^<bytes>:") as caught:
        read(TEXT.replace(old, new, 1))
    assert what in str(caught.value)
