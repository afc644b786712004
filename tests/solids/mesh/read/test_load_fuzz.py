"""Whatever the bytes are: finite triangles or a MeshError of one line, and no memory that no bytes stand behind."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest
from helpers.mesh_files import ascii_stl, dae, glb, indexed, obj, off, ply, three_mf
from helpers.mesh_samples import binary_stl, tetrahedron
from hypothesis import example, given
from hypothesis import strategies as st

from robodyn.errors import MeshError
from robodyn.solids.mesh.read.load import load_triangles

SOLID = tetrahedron()
POINTS, FACES = indexed(SOLID)
QUADS = [*FACES.tolist(), (0, 1, 2, 3)]
NATIVE = {
    "stl": [binary_stl(SOLID, b"solid x"), ascii_stl(SOLID, number="%g")],
    "obj": [obj(SOLID, "{}/1/2", "%g"), b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1 # end\nf -4 -3 -2 \\\n -1\nf 1//1 2 3\n"],
    "ply": [
        *(ply(POINTS, QUADS, encoding) for encoding in ("ascii", "<", ">")),
        ply(POINTS, FACES.tolist(), "<", "f4", "u4", "u4"),
    ],
    "off": [off(SOLID, "%g")],
}
SCENES = {"dae": [dae(SOLID, material=True)], "glb": [glb(SOLID)], "3mf": [three_mf(SOLID)]}
TOKENS = [
    *(b"", b"\0", b"\n", b"\r", b" ", b"\\\n", b"\xff", b"\xff\xff\xff\xff", b"\xff\xff\xff\x7f", b"\0\0\xc0\x7f"),
    *b'- / . # _ , " < > [ {'.split(),
    *b"0 -1 3 1e999 nan 999999999 99999999999999999999 4294967295 -2147483648 0.5".split(),
    *b"solid endsolid facet vertex endfacet outer v f ply element property list uint64 double end_header OFF".split(),
]
EDITS = st.lists(
    st.tuples(st.floats(0, 1), st.integers(0, 12), st.sampled_from(TOKENS) | st.binary(max_size=4)), max_size=4
)
MOST = 64 << 20
"""Bytes that reading 2 kB may take at the most; chunks of a text and tables of types are part of them."""


def mutated(data, edits, kept):
    """Parts replaced at a share of the length, and the end cut off."""
    for share, length, token in edits:
        at = int(share * len(data))
        data = data[:at] + token + data[at + length :]
    return data[: int(kept * len(data)) + 1]


def read_all(data, kind):
    """What was read, all its blocks, or the error."""
    try:
        read = load_triangles(data, file_type=kind)
        return read, np.concatenate(list(read.blocks(3))), ""
    except MeshError as error:
        return None, None, str(error)


def check(data, kind):
    tracemalloc.start()
    try:
        read, blocks, error = read_all(data, kind)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < MOST
    if read is None:
        assert error.isprintable()
        assert error.startswith("<bytes>:")
    else:
        assert blocks.shape == (read.count, 3, 3)
        assert np.isfinite(blocks).all()
        np.testing.assert_array_equal(read.array(), blocks)


CUT = st.one_of(st.just(1.0), st.floats(0, 1))


@pytest.mark.parametrize("kind", [*NATIVE, *SCENES])
@given(st.data())
def test_damaged_files(kind, data):
    sample = data.draw(st.sampled_from((NATIVE | SCENES)[kind]))
    check(mutated(sample, data.draw(EDITS), data.draw(CUT)), kind)


@given(st.binary(max_size=300), st.sampled_from([*NATIVE, *SCENES, "gltf", None]))
@example(b"solid\n" + b"facet " * 40, "stl")
@example(b"#" * 4000, None)
@example(b" " * 4000, "off")
@example(b"<?xml version='1.0'?><!DOCTYPE a [<!ENTITY b 'cc'><!ENTITY d '&b;&b;'>]><COLLADA>&d;</COLLADA>", None)
def test_any_bytes(data, kind):
    check(data, kind)


@given(st.lists(st.sampled_from(TOKENS), max_size=40), st.sampled_from([b" ", b"\n"]), st.sampled_from([*NATIVE]))
def test_any_words(words, blank, kind):
    check(blank.join(words), kind)
