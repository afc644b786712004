"""PLY in its three encodings, with every type of number, and every way to be cut short."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.mesh_files import indexed, ply, rows
from helpers.mesh_samples import box, corners

from robodyn.errors import MeshError
from robodyn.solids.mesh.read.load import load_triangles

ENCODINGS = ["ascii", "<", ">"]
POINTS, FACES = indexed(box())
MIXED = [(0, 1, 3, 2), (4, 5, 7), (0, 1, 2, 3, 4), (5, 6, 7)]
MIXED_TRIANGLES = [(0, 1, 3), (0, 3, 2), (4, 5, 7), (0, 1, 2), (0, 2, 3), (0, 3, 4), (5, 6, 7)]


def read(data):
    return load_triangles(data, file_type="ply")


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_every_type_of_index(encoding):
    for length, index in (("u1", "i4"), ("i4", "u4"), ("u4", "u1"), ("u1", "i2")):
        data = ply(POINTS, FACES.tolist(), encoding, "f8", length, index)
        np.testing.assert_array_equal(rows(read(data).array()), rows(box()))


@pytest.mark.parametrize("encoding", ENCODINGS)
@pytest.mark.parametrize(("coordinate", "bits"), [("f4", 24), ("f8", 53), ("i2", 53)])
def test_coordinates_have_the_type_of_the_header(encoding, coordinate, bits):
    points = np.round(POINTS * 1000) if coordinate == "i2" else POINTS / 3
    result = read(ply(points, FACES.tolist(), encoding, coordinate))
    assert result.significand == bits
    np.testing.assert_array_equal(result.array(), corners(points.astype(coordinate), FACES))


@pytest.mark.parametrize(("encoding", "length"), [("ascii", "u1"), ("<", "u4"), (">", "u1")])
def test_polygons_of_different_sizes(encoding, length):
    result = read(ply(POINTS, MIXED, encoding, length=length))
    np.testing.assert_array_equal(result.array(), corners(POINTS, MIXED_TRIANGLES))
    assert "2 of 4 faces have more than three corners: cut into triangles" in result.notes


@pytest.mark.parametrize(("encoding", "feed"), [("ascii", "\r"), ("<", "\r\n"), (">", "\r")])
def test_ends_of_lines_of_other_systems(encoding, feed):
    points = POINTS + 10.0
    np.testing.assert_array_equal(
        read(ply(points, FACES.tolist(), encoding, feed=feed)).array(), corners(points, FACES)
    )


LISTS = """ply
format ascii 1.0
element note 2
property list uchar uchar letters
element empty 3
element vertex 3
property list uchar int neighbours
property double z
property double y
property double x
element face 1
property list uchar float uv
property list uchar int vertex_index
property uchar red
element edge 0
property int a
end_header
3 1 2 3
0

2 7 8 3 2 1
0 6 5 4
1 9 9 8 8
4 .5 .5 .5 .5 3 2 1 0 255
"""


def test_other_elements_lists_and_orders_of_properties():
    np.testing.assert_array_equal(read(LISTS.encode()).array(), [[(8, 8, 9), (4, 5, 6), (1, 2, 3)]])


def test_other_elements_lists_and_orders_of_properties_in_bytes():
    header = LISTS[: LISTS.index("3 1 2 3")].replace("ascii", "binary_big_endian").encode()
    body = bytes([3, 1, 2, 3, 0])
    for neighbours, zyx in (([7, 8], [3, 2, 1]), ([], [6, 5, 4]), ([9], [9, 8, 8])):
        body += bytes([len(neighbours)]) + np.array(neighbours, ">i4").tobytes() + np.array(zyx, ">f8").tobytes()
    body += b"\4" + np.full(4, 0.5, ">f4").tobytes() + b"\3" + np.array([2, 1, 0], ">i4").tobytes() + b"\xff"
    np.testing.assert_array_equal(read(header + body).array(), [[(8, 8, 9), (4, 5, 6), (1, 2, 3)]])


@pytest.mark.parametrize(("encoding", "polygons"), [("ascii", MIXED), ("<", MIXED), (">", FACES.tolist())])
def test_every_truncation_is_told(encoding, polygons):
    data = ply(POINTS, polygons, encoding).rstrip(b"\n")
    for length in range(len(data)):
        with pytest.raises(MeshError, match=r"^<bytes>:.*\)$"):
            read(data[:length])


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_vertices_that_are_not_finite(encoding):
    points = np.vstack([POINTS, [np.nan, 0, 0]])
    np.testing.assert_array_equal(rows(read(ply(points, FACES.tolist(), encoding)).array()), rows(box()))
    with pytest.raises(MeshError, match=r"face 13 has a corner at \(nan, 0, 0\)"):
        read(ply(points, [*FACES.tolist(), [0, 1, 2, 8]], encoding))


@pytest.mark.parametrize("encoding", ENCODINGS)
@pytest.mark.parametrize("polygon", [(0, 1, 8), (0, 1, 2, -1)])
def test_vertices_that_do_not_exist(encoding, polygon):
    with pytest.raises(MeshError, match=rf"face 13 names vertex {polygon[-1]}, counted from 0, of 8"):
        read(ply(POINTS, [*FACES.tolist(), polygon], encoding))


GOOD = ply(POINTS, FACES.tolist())


@pytest.mark.parametrize(
    ("old", "new", "what"),
    [
        (b"ply\n", b"pla\n", "does not begin with 'ply'"),
        (b"format ascii 1.0\n", b"", "names no format"),
        (b"format ascii", b"format text", "2: 'format text 1.0' is not understood"),
        (b"property double x", b"property real x", "5: 'property real x' is not understood"),
        (b"property double x", b"property double w", "no property 'x'"),
        (b"property double y", b"property double w", "no property 'y'"),
        (b"property uchar red", b"property double x", "the property 'x' twice"),
        (b"element vertex 8", b"element vertex -8", "'element vertex -8' is not understood"),
        (b"element vertex 8", b"element point 8", "has 0 elements 'vertex'"),
        (b"element face 12", b"element tristrips 12", "has no element 'face'"),
        (b"element face 12", b"element face 13", "promises 13 of the element 'face', 12 are there"),
        (b"element face 12", b"element face 999999999999999999", "the element 'face', 12 are there"),
        (b"element face 12", b"element face 0", "holds 8 vertices and no faces"),
        (b"element vertex 8", b"element vertex 7", "is not an index"),
        (b"list uchar int", b"list float int", "'property list float int vertex_indices' is not understood"),
        (b"list uchar int", b"list uchar float", "of type float"),
        (b"property list uchar int vertex_indices", b"property int vertex_indices", "no list of vertex indices"),
        (b"end_header", b"endheader", "does not end with 'end_header'"),
        (b"0.5 3 ", b"0.5 4 ", "not the number of words"),
        (b"0.5 3 ", b"0.5 -1 ", "not the number of words"),
        (b"255\n", b"255 7\n", "14: the line has not the number of words"),
        (b"0.5 3 ", b"0.5 3/1 ", "'3/1' is not an index"),
        (b"0.5 3 ", b"0.5 x ", "'x' is not an index"),
    ],
)
def test_what_is_wrong_is_told(old, new, what):
    assert old in GOOD
    with pytest.raises(MeshError, match=r"^<bytes>:") as caught:
        read(GOOD.replace(old, new, 1))
    assert what in str(caught.value)


@pytest.mark.parametrize("name", ["vertex", "face"])
@pytest.mark.parametrize("encoding", ["<", ">"])
def test_lying_counts_and_lengths_take_no_memory(name, encoding):
    data = ply(POINTS, FACES.tolist(), encoding)
    count = b"8" if name == "vertex" else b"12"
    data = data.replace(f"element {name} ".encode() + count, f"element {name} 999999999999999999".encode())
    with pytest.raises(MeshError, match=f"promises 999999999999999999 of the element '{name}', the bytes are enough"):
        read(data)
    data = ply(POINTS, FACES.tolist(), "<", length="u4")
    at = data.index(b"end_header\n") + 11 + 25 * len(POINTS) + 4
    with pytest.raises(MeshError, match="the bytes are enough for 0"):
        read(data[:at] + b"\xff" * 4 + data[at + 4 :])
