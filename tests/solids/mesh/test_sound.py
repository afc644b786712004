"""Which surfaces go without repair, and that it would have found nothing to do."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.command_line import ROBOTS
from helpers.mesh_oracle import rotation
from helpers.mesh_samples import binary_stl, box, cylinder, flipped, moved, sheet, torus, uv_sphere

from robodyn.solids.mass_properties import mass_properties
from robodyn.solids.mesh import repair
from robodyn.solids.mesh.integrals import measure
from robodyn.solids.mesh.measured import is_sound
from robodyn.solids.mesh.read.load import load_triangles
from robodyn.solids.mesh.triangles import MemoryTriangles


def test_one_clean_shell_is_not_repaired_and_two_are(monkeypatch):
    asked = []
    monkeypatch.setattr(repair, "repair", lambda *given, real=repair.repair: (asked.append(1), real(*given))[1])
    assert mass_properties(binary_stl(torus(2.0, 0.5, 40, 30))).repairs == ()
    assert mass_properties(cylinder(), strict=True).closed
    mass_properties(sheet(), shell=0.001)
    mass_properties(torus()[1:], repair=False)
    assert not asked
    part = mass_properties(np.concatenate([box(), moved(flipped(box()), (2, 0, 0))]))
    assert [step.name for step in part.repairs] == ["orientation"]
    assert part.body.mass == 2000
    assert len(asked) == 1


def sound(triangles):
    return is_sound(triangles, *measure(triangles))


def body(array):
    return MemoryTriangles("body", np.asarray(array))


SOUND = {
    "box": box(),
    "torus": torus(2.0, 0.5, 40, 30),
    "far away": moved(uv_sphere(), (1e6, -1e6, 0), rotation(2)),
    "small": torus() * 1e-9,
    "plate": moved(box((1, 1, 1e-6)), R=rotation(3)),
    "needle": box((1, 1e-5, 1e-5)),
}
a, b, c = box()[0]
DOUBTFUL = {
    "inwards": flipped(box()),
    "two": np.concatenate([box(), moved(box(), (0.5, 0.5, 0.5))]),
    "open": box()[1:],
    "the same twice": np.concatenate([box(), box()]),
    "a face without area": np.concatenate([box()[1:], [(a, (a + b) / 2, c), ((a + b) / 2, b, c), (a, b, (a + b) / 2)]]),
    "a face of nearly no area": np.concatenate(
        [box()[1:], [(a, (a + b) / 2 + 1e-15 * c, c), ((a + b) / 2, b, c), (a, b, (a + b) / 2)]]
    ),
    "nothing inside": np.concatenate([sheet(), flipped(sheet())]),
    "flat": moved(box((1, 1, 0)), R=rotation(1)),
}


@pytest.mark.parametrize("name", [*SOUND, *DOUBTFUL])
def test_sound_and_doubtful_surfaces(name):
    given = body((SOUND | DOUBTFUL)[name])
    assert sound(given) == (name in SOUND)
    if name in SOUND:
        found = repair.repair(given)
        assert (found.steps, found.remarks, found.closed, found.quadrature) == ((), (), True, None)


@pytest.mark.parametrize("path", sorted((ROBOTS / "meshes").glob("*.stl")), ids=lambda path: path.stem)
def test_what_is_sound_needs_no_repair(path):
    triangles = load_triangles(path)
    found = repair.repair(triangles)
    assert sound(triangles) == (not found.steps and not found.remarks and found.shells == 1)
