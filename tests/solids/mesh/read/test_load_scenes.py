"""DAE, GLB, glTF and 3MF through trimesh: units, places of instances, nothing merged, nothing read as zero."""

from __future__ import annotations

import base64
import io
import json
import zipfile

import numpy as np
import pytest
from helpers.mesh_files import dae, glb, rows, three_mf
from helpers.mesh_samples import box, uv_sphere

from robodyn.errors import MeshError
from robodyn.solids.mesh.read import scenes
from robodyn.solids.mesh.read.load import load_triangles

BALL = uv_sphere(rings=8, sectors=12).astype(np.float32)
TURN = np.array([[0, -2, 0, 1], [2, 0, 0, 0.5], [0, 0, 2, -3], [0, 0, 0, 1]], np.float64)
TILT = np.eye(4)
TILT[:3, :3] = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0].astype(np.float32)
TILT[:3, 3] = 0.125, 7, 1e3
"""Of numbers that are exact in float32, as DAE keeps them, and round in every product."""
MIRROR = np.diag([-1.0, 1.0, 1.0, 1.0])
MIRROR[:3, 3] = 0.25


def placed(triangles, matrix):
    """By the same operations for every corner; a mirror image is wound the other way."""
    x, y, z = np.moveaxis(np.asarray(triangles, np.float64), -1, 0)
    moved = np.stack([row[0] * x + row[1] * y + row[2] * z + row[3] for row in matrix[:3]], axis=-1)
    return moved[:, ::-1] if np.linalg.det(matrix[:3, :3]) < 0 else moved


def row_major(matrix):
    """A transform of 3MF: the transposed matrix without its last column."""
    return " ".join(map(repr, matrix[:3].T.ravel().tolist()))


WRITERS = {
    "dae": lambda matrix: dae(BALL, matrix=matrix),
    "glb": lambda matrix: glb(BALL, matrix),
    "3mf": lambda matrix: three_mf(BALL, transform=row_major(matrix)),
}


@pytest.mark.parametrize("matrix", [np.eye(4), TURN, TILT, MIRROR], ids=["still", "turned", "tilted", "mirrored"])
def test_geometry_stands_in_its_place(matrix):
    for kind, write in WRITERS.items():
        read = load_triangles(write(matrix), file_type=kind)
        np.testing.assert_array_equal(rows(read.array()), rows(placed(BALL, matrix)))


def test_nested_nodes_of_gltf():
    nodes = [
        {"children": [1], "translation": [1, 2, 3]},
        {"children": [2], "scale": [2, 1, 0.5], "rotation": [0, 0, 1, 0]},
        {"mesh": 0, "matrix": TILT.ravel(order="F").tolist()},
    ]
    half_turn = np.diag([-2, -1, 0.5, 1.0])
    half_turn[:3, 3] = 1, 2, 3
    found, expected = load_triangles(glb(BALL, nodes=nodes)).array(), placed(BALL, half_turn @ TILT)
    np.testing.assert_allclose(rows(found), rows(expected), rtol=0, atol=4e-16 * np.abs(expected).max())


def test_nothing_is_merged():
    """Sizes near 1e-8, where trimesh takes vertices as one."""
    small = box() * 1e-9
    np.testing.assert_array_equal(rows(load_triangles(three_mf(small), file_type="3mf").array()), rows(small))
    np.testing.assert_array_equal(rows(load_triangles(dae(small)).array()), rows(small.astype(np.float32)))


@pytest.mark.parametrize("damage", [b"", b"x", b"-1", b"<ph/>"])
def test_polygons_one_by_one_are_the_triangles_they_make(damage, monkeypatch):
    """Lists of whole corners are read as one; others each by itself, so that errors say what they did."""
    before, _, rest = dae(BALL).partition(b"<triangles")
    words = rest.partition(b"<p>")[2].partition(b"</p>")[0].split()
    lists = [b"<p>" + b" ".join(words[k : k + 3]) + b"</p>" for k in range(0, len(words), 3)]
    head = b'<polygons count="%d"><input semantic="VERTEX" source="#v" offset="0"/>' % len(lists)
    lists[1] = lists[1].replace(b"</p>", b"</p>" + damage if b"<" in damage else b" " + damage + b"</p>")
    data = before + head + b"".join(lists) + b"</polygons>" + rest.partition(b"</triangles>")[2]
    joined, loaded = [], scenes._loaded
    monkeypatch.setattr(scenes, "_loaded", lambda *given: joined.append(b"polylist" in given[2]) or loaded(*given))
    if damage in (b"", b"<ph/>"):
        np.testing.assert_array_equal(rows(load_triangles(data, file_type="dae").array()), rows(BALL))
        assert joined == [not damage]
    else:
        with pytest.raises(MeshError, match="polygons index" if damage == b"x" else "an index is negative"):
            load_triangles(data, file_type="dae")


def test_instances_are_taken_together():
    read = load_triangles(dae(BALL, instances=3))
    np.testing.assert_array_equal(rows(read.array()), rows(np.concatenate([BALL] * 3)))
    assert "3 geometries of the scene are taken together" in read.notes
    hidden = load_triangles(dae(BALL, material=True))  # by a material that is missing
    np.testing.assert_array_equal(rows(hidden.array()), rows(BALL))


@pytest.mark.parametrize(
    ("data", "kind", "scale"),
    [
        (dae(box()), "dae", 1e-3),
        (dae(box(), unit='<unit meter="0.0254" name="inch"/>'), "dae", 0.0254),
        (dae(box(), unit='<unit name="meter"/>'), "dae", 1.0),
        (dae(box(), unit=""), "dae", 1.0),
        (glb(box()), "glb", 1.0),
        (three_mf(box()), "3mf", 0.0254),
        (three_mf(box(), unit=""), "3mf", 1e-3),
        (three_mf(box(), unit='unit="micron"'), "3mf", 1e-6),
    ],
)
def test_the_unit_of_the_file(data, kind, scale):
    read = load_triangles(data, file_type=kind)
    assert read.scale == scale
    np.testing.assert_array_equal(rows(read.array()), rows(box()))
    assert sum(note.startswith("unit:") for note in read.notes) == 1
    asked = load_triangles(data, file_type=kind, unit="cm")
    assert asked.scale == 1e-2
    assert any(note.startswith("unit: cm as asked") for note in asked.notes)
    if scale == 1e-3 and kind == "dae":
        assert "unit: cm as asked, though the file says mm" in asked.notes
        assert "unit: mm as asked" in load_triangles(data, unit="mm").notes


def test_the_axis_that_points_up_is_noted():
    for up in "XYZ":
        read = load_triangles(dae(BALL, up=f"{up}_UP"))
        np.testing.assert_array_equal(rows(read.array()), rows(BALL))
        assert (f"the axis {up} points up in the file; its axes are kept" in read.notes) == (up != "Z")


def test_gltf_with_its_buffer_beside_it_or_inside(tmp_path):
    data = glb(BALL)
    length = int.from_bytes(data[12:16], "little")
    document, buffer = json.loads(data[20 : 20 + length]), data[28 + length :]
    document["buffers"][0]["uri"] = "ball.bin"
    (tmp_path / "ball.bin").write_bytes(buffer)
    (tmp_path / "ball.gltf").write_text(json.dumps(document))
    np.testing.assert_array_equal(rows(load_triangles(tmp_path / "ball.gltf").array()), rows(BALL))
    with pytest.raises(MeshError, match="cannot be read as GLTF"):
        load_triangles(json.dumps(document).encode(), file_type="gltf")
    document["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64.b64encode(buffer).decode()
    inside = load_triangles(json.dumps(document).encode(), file_type="gltf")
    np.testing.assert_array_equal(rows(inside.array()), rows(BALL))


GLB = glb(BALL)
DAE = dae(BALL)
FIRST = DAE[DAE.index(b"<float_array") :].partition(b">")[2].split()[0]
BAD = [
    (GLB[:-1], "glb", "the header promises"),
    (b"glTF" + GLB[4:8] + b"\0" * 12, "glb", "does not begin as a GLB does"),
    (glb(BALL, extensionsRequired=["KHR_draco_mesh_compression"]), "glb", "'KHR_draco_mesh_compression'"),
    (glb(BALL, accessors=[{"componentType": 5126, "count": 10**9, "type": "VEC3"}] * 2), "glb", "without a buffer"),
    (glb(BALL, nodes=[{"mesh": 0, "scale": [float("nan"), 1, 1]}]), "glb", "not affine"),
    (glb(BALL, nodes=[]), "glb", "cannot be read as GLB"),
    (glb(BALL[:0]), "glb", "no vertices and no faces"),
    (DAE[:-30], "dae", "cannot be read as DAE"),
    (DAE.replace(b'meter="0.001"', b'meter="-1"'), "dae", "the unit '-1' is not a length"),
    (DAE.replace(b">" + FIRST, b">NaN", 1), "dae", "vertex 1 of 'p' has the coordinate NaN"),
    (DAE.replace(b">" + FIRST, b">abc", 1), "dae", "cannot be read as DAE"),
    (DAE.replace(b"<p>", b"<p>999999 0 0 "), "dae", "cannot be read as DAE"),
    (DAE.replace(b"<p>", b"<p>-1 0 0 "), "dae", "an index is negative"),
    (DAE.replace(b'url="#s"', b'url="#t"'), "dae", "cannot be read as DAE"),
    (three_mf(BALL, unit='unit="furlong"'), "3mf", "unknown unit 'furlong'"),
    (three_mf(BALL)[:-30], "3mf", "cannot be read as 3MF"),
    (b"PK\x03\x04", "3mf", "cannot be read as 3MF"),
]


@pytest.mark.parametrize(("data", "kind", "what"), BAD)
def test_what_is_wrong_is_told(data, kind, what, capfd):
    with pytest.raises(MeshError, match=r"^<bytes>:") as caught:
        load_triangles(data, file_type=kind)
    assert what in str(caught.value)
    assert capfd.readouterr() == ("", "")


def test_what_trimesh_warns_of_is_noted(capfd):
    """A component that does not exist is left out."""
    data = three_mf(BALL)
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        model = archive.read("3D/3dmodel.model")
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        archive.writestr("3D/3dmodel.model", model.replace(b"</build>", b'<item objectid="7"/></build>'))
    read = load_triangles(stream.getvalue(), file_type="3mf")
    assert any("7" in note and note.startswith("trimesh: ") for note in read.notes)
    assert capfd.readouterr() == ("", "")
