"""Bytes of mesh files in every format, from arrays (m, 3, 3) of corners; see `mesh_samples`."""

from __future__ import annotations

import io
import json
import struct
import zipfile

import numpy as np

PLY_TYPES = {"f4": "float", "f8": "double", "i4": "int", "u4": "uint", "u1": "uchar", "i2": "short"}


def indexed(triangles):
    """Vertices (v, 3), each once, and faces (m, 3)."""
    vertices, faces = np.unique(np.asarray(triangles).reshape(-1, 3), axis=0, return_inverse=True)
    return vertices, faces.reshape(-1, 3)


def ascii_stl(triangles, name="part", number="%.17g", feed="\n"):
    lines = [f"solid {name}"]
    for corners in triangles:
        vertices = [f"    vertex {' '.join(number % value for value in corner)}" for corner in corners]
        lines += ["facet normal 0 0 0", "  outer loop", *vertices, "  endloop", "endfacet"]
    return feed.join([*lines, f"endsolid {name}", ""]).encode()


def obj(triangles, corner="{}", number="%.17g"):
    """`corner` formats the index of a vertex, as "{}/1/1"."""
    vertices, faces = indexed(triangles)
    lines = [f"v {' '.join(number % value for value in vertex)}" for vertex in vertices]
    lines += [f"f {' '.join(corner.format(index + 1) for index in face)}" for face in faces]
    return "\n".join([*lines, ""]).encode()


def off(triangles, number="%.17g"):
    vertices, faces = indexed(triangles)
    lines = ["OFF", f"{len(vertices)} {len(faces)} 0"]
    lines += [" ".join(number % value for value in vertex) for vertex in vertices]
    lines += [f"3 {' '.join(map(str, face))}" for face in faces]
    return "\n".join([*lines, ""]).encode()


def ply(vertices, polygons, encoding="ascii", coordinate="f8", length="u1", index="i4", feed="\n"):
    """A PLY with a colour for every vertex and a quality before the list of every face, which are to be passed over.

    Args:
        polygons: lists of indices. encoding: "ascii", "<" or ">". coordinate, length, index: NumPy codes.
    """
    formats = {"ascii": "ascii", "<": "binary_little_endian", ">": "binary_big_endian"}
    header = ["ply", f"format {formats[encoding]} 1.0", "comment made for a test", f"element vertex {len(vertices)}"]
    header += [f"property {PLY_TYPES[coordinate]} {axis}" for axis in "xyz"] + ["property uchar red"]
    header += [f"element face {len(polygons)}", "property float quality"]
    header += [f"property list {PLY_TYPES[length]} {PLY_TYPES[index]} vertex_indices", "end_header", ""]
    if encoding == "ascii":
        body = [" ".join([*(f"{value:.17g}" for value in vertex), "255"]) for vertex in vertices]
        body += [" ".join(map(str, [0.5, len(polygon), *polygon])) for polygon in polygons]
        return feed.join([*header, *body, ""]).encode()
    parts = [feed.join(header).encode()]
    for vertex in vertices:
        parts += [np.asarray(vertex, encoding + coordinate).tobytes(), b"\xff"]
    for polygon in polygons:
        size = np.array(len(polygon), encoding + length).tobytes()
        parts += [np.array(0.5, encoding + "f4").tobytes(), size, np.array(polygon, encoding + index).tobytes()]
    return b"".join(parts)


def dae(triangles, unit='<unit name="millimeter" meter="0.001"/>', matrix=None, up="Z_UP", instances=1, material=False):
    """A COLLADA whose one geometry stands `instances` times in the scene, each time moved by `matrix` (4, 4)."""
    vertices, faces = indexed(triangles)
    rows = " ".join(f"{value:.9g}" for value in np.ravel(np.eye(4) if matrix is None else matrix))
    bound = (
        "<bind_material><technique_common><instance_material symbol='m' target='#missing'/></technique_common>"
        "</bind_material>"
    )
    nodes = "".join(
        f"<node id='n{k}'><matrix>{rows}</matrix><instance_geometry url='#g'>{bound if material else ''}"
        "</instance_geometry></node>"
        for k in range(instances)
    )
    return f"""<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><created>2020-01-01T00:00:00</created><modified>2020-01-01T00:00:00</modified>{unit}<up_axis>{up}</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="{vertices.size}">{" ".join(f"{value:.9g}" for value in vertices.ravel())}
</float_array><technique_common><accessor source="#a" count="{len(vertices)}" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="{len(faces)}"{" material='m'" if material else ""}>
<input semantic="VERTEX" source="#v" offset="0"/><p>{" ".join(map(str, faces.ravel()))}</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s">{nodes}</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>
""".encode()


def glb(triangles, matrix=None, **changes):
    """A GLB of one node moved by `matrix` (4, 4); `changes` replace top-level keys of its JSON."""
    vertices, faces = indexed(triangles)
    points, index = vertices.astype("<f4").tobytes(), faces.astype("<u4").tobytes()
    size = len(points) + len(index)
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "matrix": np.ravel(np.eye(4) if matrix is None else matrix, order="F").tolist()}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(vertices), "type": "VEC3"},
            {"bufferView": 1, "componentType": 5125, "count": faces.size, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": len(points)},
            {"buffer": 0, "byteOffset": len(points), "byteLength": len(index)},
        ],
        "buffers": [{"byteLength": size}],
    }
    text = json.dumps({**document, **changes}).encode()
    text += b" " * (-len(text) % 4)
    body = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", size, b"BIN\0") + points + index
    return struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body


def three_mf(triangles, unit='unit="inch"', transform="1 0 0 0 1 0 0 0 1 0 0 0"):
    vertices, faces = indexed(triangles)
    points = "".join(f'<vertex x="{x:.17g}" y="{y:.17g}" z="{z:.17g}"/>' for x, y, z in vertices)
    index = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in faces)
    model = f"""<?xml version="1.0" encoding="UTF-8"?>
<model {unit} xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"><resources><object id="1" type="model">
<mesh><vertices>{points}</vertices><triangles>{index}</triangles></mesh></object></resources>
<build><item objectid="1" transform="{transform}"/></build></model>"""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("3D/3dmodel.model", model)
    return stream.getvalue()


def rows(triangles):
    """(m, 9), each triangle from its least corner on, in order: equal arrays hold the same triangles."""
    values = np.asarray(triangles, np.float64) + 0.0
    first = np.lexsort(values.transpose(2, 0, 1)[::-1], axis=1)[:, :1]
    turned = np.take_along_axis(values, ((first + np.arange(3)) % 3)[:, :, None], axis=1).reshape(-1, 9)
    return turned[np.lexsort(turned.T[::-1])]
