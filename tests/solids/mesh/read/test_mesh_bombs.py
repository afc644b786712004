"""Small files that ask for much: refused within a table of limits, or read without it.

Hardly anything here is timed; an alarm after a minute stands for what would never end.
"""

from __future__ import annotations

import io
import json
import os
import signal
import time
import zipfile

import numpy as np
import pytest
from helpers.mesh_files import dae, glb, ply, three_mf
from helpers.mesh_samples import binary_stl, box, moved, tetrahedron

from robodyn.errors import MeshError
from robodyn.solids.mass_properties import mass_properties
from robodyn.solids.mesh.read.load import load_triangles

pytestmark = pytest.mark.skipif(not hasattr(signal, "alarm"), reason="the system has no alarms")
BOX = box()


@pytest.fixture(autouse=True)
def at_most_a_minute():
    def late(*_):
        raise TimeoutError("not done within a minute")

    before = signal.signal(signal.SIGALRM, late)
    signal.alarm(60)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


def _chain(name, uses, last):
    """Elements of a library, each of which uses the next one so many times."""
    each = [f'<node id="{name}{k}">' + f'<instance_node url="#{name}{k + 1}"/>' * uses + "</node>" for k in range(last)]
    return "".join(each) + f'<node id="{name}{last}"><instance_geometry url="#g"/></node>'


def _dae(library="", scene=""):
    text = dae(BOX).decode()
    text = text.replace("<library_visual_scenes>", f"<library_nodes>{library}</library_nodes><library_visual_scenes>")
    return text.replace('<visual_scene id="s">', f'<visual_scene id="s">{scene}').encode()


def _archive(old, new):
    """A 3MF whose model has one text in place of another."""
    with zipfile.ZipFile(io.BytesIO(three_mf(BOX))) as archive:
        model = archive.read("3D/3dmodel.model").decode()
    assert old in model
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("3D/3dmodel.model", model.replace(old, new, 1))
    return stream.getvalue()


def _objects(uses, last):
    each = [
        f'<object id="{k + 1}"><components>{f"""<component objectid="{k}"/>""" * uses}</components></object>'
        for k in range(1, last)
    ]
    item = f'{"".join(each)}</resources><build><item objectid="{last}"/>'
    return _archive("</resources>\n<build>", item)


def _promising(archive, size):
    """An archive whose table says this of the first file."""
    at = archive.index(b"PK\x01\x02") + 24
    return archive[:at] + size.to_bytes(4, "little") + archive[at + 4 :]


MANY = [{"mesh": 0}] * 20_000
SCENES = {
    "glb: many": (lambda: glb(BOX, nodes=MANY, scenes=[{"nodes": list(range(20_000))}]), "20000 nodes, at most 10000"),
    "glb: deep": (
        lambda: glb(BOX, nodes=[*({"children": [k + 1]} for k in range(5000)), {"mesh": 0}]),
        "nodes more than 200 deep",
    ),
    "glb: shared": (
        lambda: glb(BOX, nodes=[*({"children": [k + 1, k + 1]} for k in range(28)), {"mesh": 0}]),
        "nodes of glTF are trees",
    ),
    "glb: huge accessor": (
        lambda: glb(BOX, nodes=[{"mesh": 0}], accessors=[{"bufferView": 0, "count": 4 * 10**9, "type": "VEC3"}]),
        "accessors stand for up to 64000000000 bytes",
    ),
    "glb: sparse": (
        lambda: glb(BOX, nodes=[{"mesh": 0}], accessors=[{"count": 10**9, "type": "VEC3", "sparse": {"count": 1}}]),
        "accessor without a buffer",
    ),
    "dae: deep": (lambda: _dae(scene="<node>" * 5000 + "</node>" * 5000), "nodes more than 200 deep"),
    "dae: shared": (
        lambda: _dae(_chain("a", 2, 28), '<node><instance_node url="#a0"/></node>'),
        "536870913 nodes, at most 10000",
    ),
    "dae: in itself": (
        lambda: _dae('<node id="a"><instance_node url="#a"/></node>', '<node><instance_node url="#a"/></node>'),
        "nodes more than 200 deep",
    ),
    "dae: entities": (
        lambda: (
            b'<!DOCTYPE x [<!ENTITY a "aaaaaaaaaa">'
            + b"".join(b'<!ENTITY %c "%s">' % (98 + k, b"&%c;" % (97 + k) * 10) for k in range(12))
            + b"]><COLLADA>&m;</COLLADA>"
        ),
        "amplification",
    ),
    "3mf: items": (
        lambda: _archive("<build>", "<build>" + '<item objectid="1"/>' * 5000),
        "5001 objects, at most 3000",
    ),
    "3mf: shared": (lambda: _objects(2, 29), "536870912 objects"),
    "3mf: deep": (lambda: _objects(1, 3000), "objects more than 200 deep"),
    "3mf: in itself": (
        lambda: _archive(
            '</resources>\n<build><item objectid="1"',
            '<object id="2"><components><component objectid="2"/></components></object></resources><build>'
            '<item objectid="2"',
        ),
        "objects more than 200 deep",
    ),
    "3mf: unpacks": (lambda: _promising(three_mf(BOX), 2**32 - 2), "unpacks to 4294967294 bytes"),
}


@pytest.mark.parametrize("case", SCENES)
def test_scenes(case):
    make, message = SCENES[case]
    kind = case.partition(":")[0]
    with pytest.raises(MeshError, match=message):
        load_triangles(make(), file_type=kind)


def test_limits_can_be_raised(monkeypatch):
    data = glb(BOX, nodes=MANY[:40], scenes=[{"nodes": list(range(40))}])
    assert load_triangles(data, file_type="glb").count == 480
    monkeypatch.setenv("ROBODYN_LIMITS", "mesh_nodes=39")
    with pytest.raises(MeshError, match=r"40 nodes, at most 39 are read .*ROBODYN_LIMITS=mesh_nodes=NUMBER"):
        load_triangles(data, file_type="glb")
    monkeypatch.setenv("ROBODYN_LIMITS", "mesh_faces=479")
    with pytest.raises(MeshError, match="480 triangles, at most 479"):
        load_triangles(data, file_type="glb")


@pytest.fixture
def folder(tmp_path):
    """A glTF beside its buffer, that may name another; and what it must not reach."""
    data = glb(BOX)
    size = int.from_bytes(data[12:16], "little")
    text, blob = json.loads(data[20 : 20 + size]), data[28 + size :]
    inner = tmp_path / "inner"
    inner.mkdir()
    for path in (tmp_path / "outside.bin", inner / "beside.bin", inner / "with space.bin"):
        path.write_bytes(blob)
    os.mkfifo(inner / "pipe.bin")
    (inner / "zero.bin").symlink_to("/dev/zero")
    (inner / "up.bin").symlink_to("../outside.bin")

    def write(uri):
        text["buffers"][0]["uri"] = uri
        (inner / "part.gltf").write_text(json.dumps(text))
        return inner / "part.gltf"

    return write


@pytest.mark.parametrize("uri", ["beside.bin", "with space.bin", "with%20space.bin"])
def test_a_gltf_reads_files_of_its_folder(folder, uri):
    assert load_triangles(folder(uri)).count == 12


@pytest.mark.parametrize(
    ("uri", "message"),
    [
        ("../outside.bin", "names '../outside.bin', a file outside of its folder"),
        ("%2e%2e/outside.bin", "outside of its folder"),
        ("up.bin", "outside of its folder"),
        ("/dev/zero", "outside of its folder"),
        ("zero.bin", "outside of its folder"),
        ("pipe.bin", "this is a pipe, not a file"),
        ("missing.bin", "there is no such file"),
        ("http://example.org/x.bin", "there is no such file"),
        (".", "is a folder|outside of its folder"),
    ],
)
def test_a_gltf_reads_nothing_else(folder, uri, message):
    with pytest.raises(MeshError, match=message):
        load_triangles(folder(uri))


@pytest.mark.slow
def test_lines_that_are_continued_without_end():
    corners = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3"
    read = load_triangles(corners + b" \\\n" * 400_000 + b"\n", file_type="obj")
    assert read.count == 1
    read = load_triangles(corners + b"\nf 1 \\\r\n 2 \\\n \\\n 3\n" * 50_000, file_type="obj")
    assert read.count == 50_001
    assert load_triangles(corners + b"\\\n" * 400_000, file_type="obj").count == 1


@pytest.mark.parametrize("corners", ["1 ", "1 2 3 4 "])
def test_a_polygon_that_names_few_corners_often(corners):
    text = f"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf {corners * 250}\n"
    with pytest.raises(MeshError, match=r"no volume|no triangle with an area|not closed"):
        mass_properties(text.encode(), file_type="obj")


@pytest.mark.parametrize(("count", "most"), [(3000, 5), pytest.param(1500, 8, marks=pytest.mark.slow)])
def test_a_polygon_that_crosses_itself(count, most):
    """A star whose fan and caps fold over each other as often as it has corners: few winding numbers are taken."""
    turn = 6.28 * 0.49 * np.arange(count)
    places = np.stack([np.cos(turn) * (1 + np.arange(count) % 2), np.sin(turn), np.arange(count) % 5], axis=1)
    text = "".join(f"v {x} {y} {z}\n" for x, y, z in places) + f"f {' '.join(map(str, range(1, count + 1)))}\n"
    before = time.process_time()
    with pytest.raises(MeshError, match="not closed"):
        mass_properties(text.encode(), file_type="obj")
    assert time.process_time() - before < most


def test_headers_with_many_properties_and_elements():
    head, _, rest = ply([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)]).partition(b"element face")
    more = b"".join(b"property float p%d\n" % k for k in range(10_000))
    with pytest.raises(MeshError, match="number of words"):
        load_triangles(head + more + b"element face" + rest, file_type="ply")
    more = b"".join(b"element e%d 0\n" % k for k in range(10_000))
    assert load_triangles(head + more + b"element face" + rest, file_type="ply").count == 1


@pytest.mark.slow
def test_shells_in_each_others_boxes():
    needle = tetrahedron([(0, 0, 0), (1, 1, 1), (1.01, 1, 1), (1, 1.01, 1)])
    needles = [needle * (1 + k / 100) - np.array((6, 5, 4)) * k / 1000 for k in range(3000)]
    with pytest.raises(MeshError, match=r"3000 shells to be placed in each other by 300.. points, at most 30000"):
        mass_properties(binary_stl(np.concatenate(needles)), file_type="stl")
    nested = [moved(tetrahedron() * k, (-k, -k, -k / 2)) for k in range(1, 2000)]
    with pytest.raises(MeshError, match="1999 shells to be placed in each other"):
        mass_properties(np.concatenate(nested))


def test_bodies_that_all_overlap(monkeypatch):
    """Too many to be united are measured by columns, within memory that does not grow with how often they overlap."""
    rng = np.random.default_rng(3)
    soup = np.concatenate([moved(box((0.8, 0.9, 1.0)), rng.uniform(0, 0.2, 3)) for _ in range(50)])
    exact = mass_properties(soup)
    monkeypatch.setenv("ROBODYN_LIMITS", "mesh_overlaps=1224")
    found = mass_properties(soup)
    assert exact.union is None
    assert [step.name for step in found.repairs] == ["overlaps"]
    assert 0 < abs(found.body.volume / exact.body.volume - 1) <= found.union < 1e-2
