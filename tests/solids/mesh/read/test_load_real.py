"""Meshes of example-robot-data, as trimesh and pycollada read them; the memory that a large one takes."""

from __future__ import annotations

import importlib.metadata
import os
from pathlib import Path

import numpy as np
import pytest
import trimesh
from helpers.mesh_files import rows
from helpers.mesh_samples import binary_stl, torus
from helpers.processes import python

from robodyn.solids.mesh.read.load import load_triangles

SUFFIXES = (".stl", ".obj", ".dae")
HIDDEN = "anymal_foot.dae"
"""Refers to a material that is not there, for which pycollada leaves out its only geometry."""
MIRRORED = "hyq_description/meshes/trunk/trunk.dae"
"""Has a mirrored instance, which pycollada leaves inside out."""

pytestmark = pytest.mark.filterwarnings("ignore:the matrix subclass")


def all_meshes():
    files = importlib.metadata.files("example-robot-data") or []
    return sorted(Path(str(file.locate())) for file in files if file.suffix.lower() in SUFFIXES)


def small_ones():
    """Of each type and robot the smallest."""
    first: dict[tuple[str, str], Path] = {}
    for path in sorted(all_meshes(), key=lambda path: path.stat().st_size):
        robot = next(part for part in path.parts if part.endswith(("_description", "_robot")) or part == "meshes")
        first.setdefault((path.suffix.lower(), robot), path)
    return sorted(first.values())


def check(path):
    read = load_triangles(path).array()
    if path.suffix.lower() != ".dae":
        scene = trimesh.load(path, force="scene", process=False, skip_materials=True)
        np.testing.assert_array_equal(rows(read), rows(np.concatenate([mesh.triangles for mesh in scene.dump()])))
    elif path.name == HIDDEN:
        assert len(read) == 81 + 4484 + 39
    else:
        expected, still = by_pycollada(path)
        if still:
            np.testing.assert_array_equal(rows(read), rows(expected))
            return
        if str(path).endswith(MIRRORED):
            read, expected = (np.sort(triangles, axis=1) for triangles in (read, expected))
        assert read.shape == expected.shape  # in the same order, up to rounding of pycollada's products in float32
        np.testing.assert_allclose(read, expected, rtol=0, atol=8 * np.finfo(np.float32).eps * np.abs(expected).max())


def by_pycollada(path):
    """Triangles as pycollada places them, in float32, and whether it leaves all where they are."""
    import collada

    found, placed = [], list(collada.Collada(str(path), ignore=[collada.common.DaeError]).scene.objects("geometry"))
    for part in (part for geometry in placed for part in geometry.primitives()):
        triangles = part.triangleset() if isinstance(part, collada.polylist.BoundPolylist) else part
        if isinstance(triangles, collada.triangleset.BoundTriangleSet) and triangles.vertex is not None:
            found.append(triangles.vertex[triangles.vertex_index])
    return np.concatenate(found), all(np.array_equal(geometry.matrix, np.eye(4)) for geometry in placed)


@pytest.mark.parametrize("path", small_ones(), ids=lambda path: path.name)
def test_the_smallest_of_each_robot(path):
    check(path)


@pytest.mark.slow
@pytest.mark.parametrize("path", all_meshes()[::4], ids=lambda path: path.name)
def test_every_fourth(path):
    check(path)


MEASURE = """
from robodyn.solids.mass_properties import mass_properties
print(mass_properties(PATH).triangles)
print(next(line.split()[1] for line in open("/proc/self/status") if line.startswith("VmHWM")))
"""


@pytest.mark.slow
@pytest.mark.skipif(not os.path.exists("/proc/self/status"), reason="the system does not tell the peak of a process")
def test_peak_resident_memory(tmp_path):
    path = tmp_path / "large.stl"
    path.write_bytes(binary_stl(torus(rings=2500, sectors=500)))
    count, peak = map(int, python(MEASURE.replace("PATH", repr(str(path)))).stdout.split())
    assert count == 2_500_000
    assert peak < 100 * 1024 + 100 * count // 1024
