"""Surfaces that go without repair, that have one side or gaps, and faults of shells: told alike wherever read."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.command_line import run
from helpers.mesh_oracle import rotation
from helpers.mesh_samples import binary_stl, box, cylinder, flipped, moved, sheet, torus, uv_sphere
from helpers.one_sided import SURFACES, klein_bottle

import robodyn
from robodyn.errors import MeshError
from robodyn.solids.mass_properties import is_sound, mass_properties
from robodyn.solids.mesh import repair
from robodyn.solids.mesh.holes import Gaps, gaps
from robodyn.solids.mesh.inside import may_cross, shell_faults
from robodyn.solids.mesh.integrals import measure
from robodyn.solids.mesh.read.load import from_array
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


REASON = "form surfaces with one side only, like a Moebius strip or a Klein bottle"
ROBOT = """<robot name="r"><link name="l"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0"
  iyz="0"/></inertial><visual><geometry><mesh filename="klein.stl"/></geometry></visual></link></robot>"""


@pytest.mark.parametrize("surface", SURFACES.values(), ids=SURFACES.keys())
def test_one_sided_surfaces_are_refused(surface):
    rng = np.random.default_rng(1)
    surface = rng.permutation(surface)
    surface[::3] = flipped(surface[::3])
    with pytest.raises(MeshError, match=f"{len(surface)} of {len(surface)} faces {REASON}"):
        robodyn.mass_properties(surface)


def test_one_beside_a_sound_body_is_refused():
    with pytest.raises(MeshError, match=f"1920 of 1932 faces {REASON}"):
        robodyn.mass_properties(np.concatenate([box(), moved(klein_bottle(), (9, 0, 0))]))


def test_the_command_refuses_one_and_offers_a_sheet(tmp_path):
    path = tmp_path / "klein.stl"
    path.write_bytes(binary_stl(klein_bottle()))
    outcome = run("inertia", str(path))
    assert (outcome.status, outcome.out) == (2, "")
    assert outcome.err.startswith(f"error: {path}: 1920 of 1920 faces {REASON}")
    assert run("inertia", str(path), "--shell", "0.001").status == 0


def test_a_link_that_uses_one_is_refused_and_check_says_why(tmp_path):
    (tmp_path / "klein.stl").write_bytes(binary_stl(klein_bottle()))
    path = tmp_path / "robot.urdf"
    path.write_text(ROBOT)
    outcome = run("inertia", str(path), "--link", "l", "--geometry", "visual")
    assert outcome.status == 2
    assert REASON in outcome.err
    assert REASON in run("inertia", str(path), "--compare").out
    assert "1920 faces in surfaces with one side only" in run("check", str(path), "--select", "ALL").out


CASES = {
    "a body in a cavity": ([box(), flipped(box((0.8, 0.8, 0.8))), box((0.5, 0.5, 0.5))], 0, False),
    "both inside out": ([flipped(box()), moved(flipped(box()), (2.0, 0.0, 0.0))], 2, False),
    "crossing": ([box((3.0, 1.0, 1.0)), moved(box((1.0, 3.0, 0.5)), (0.1, 0.0, 0.0))], 0, True),
    "shifted": ([box(), moved(box(), (0.5, 0.5, 0.5))], 0, True),
    "touching": ([box(), moved(box(), (1.0, 0.25, 0.25))], 0, False),
    "through a ring": ([torus(2.0, 0.5, 24, 12), box((0.5, 0.5, 6.0))], 0, False),
    "round ones": ([uv_sphere(), moved(uv_sphere(), (0.7, 0.2, 0.1))], 0, True),
}


@pytest.mark.parametrize("case", CASES)
def test_known_cases(case: str) -> None:
    parts, inverted, overlapping = CASES[case]
    for size in (1e-6, 1e6):
        assert shell_faults(from_array(size * np.concatenate(parts))) == (inverted, overlapping)


BALL = uv_sphere(rings=8, sectors=12)
SURFACES = {
    "sound": box(),
    "a face short": box()[1:],
    "a side short": box()[2:],
    "three faces short": BALL[[k for k in range(len(BALL)) if k not in (20, 60, 100)]],
    "half a ball": BALL[: len(BALL) // 2],
    "a face twice": np.concatenate([box(), box()[:1]]),
    "a stray sheet": np.concatenate([box(), moved(0.01 * sheet(), (2.0, 0.0, 0.0))]),
    "a sheet": sheet(),
    "wound at random": np.where((np.arange(12) % 3 > 0)[:, None, None], box(), flipped(box()))[1:],
    "two open bodies": np.concatenate([box()[2:], moved(cylinder(), (4.0, 0.0, 0.0))[3:]]),
}


@pytest.mark.parametrize("surface", SURFACES.values(), ids=SURFACES)
def test_as_repair_has_it(surface: np.ndarray, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("robodyn.solids.mesh.columns._MOST", 512)
    triangles = MemoryTriangles("part", surface)
    found, fixed = gaps(triangles), repair.repair(triangles)
    steps = {step.name: step for step in fixed.steps}
    assert (not found.left) == fixed.closed
    assert found.one_sided == 0
    words = steps["holes"].what.split(" filled")[0] if "holes" in steps else ""
    assert found.mended == sum(int(word) for word in words.split() if word.isdigit())
    if "winding numbers" in steps:
        assert steps["winding numbers"].count == found.left


def test_one_sided_ones_are_told_where_repair_refuses_them() -> None:
    triangles = MemoryTriangles("part", klein_bottle()[1:])
    assert gaps(triangles) == Gaps(one_sided=len(klein_bottle()) - 1)
    assert gaps(MemoryTriangles("part", np.zeros((2, 3, 3)))) == Gaps()
    with pytest.raises(MeshError, match="one side only"):
        repair.repair(triangles)


@pytest.mark.parametrize("rows", [10, 50])
@pytest.mark.parametrize(("shift", "meet"), [(0.5, False), (0.01, True)])
def test_boxes_are_told_apart_in_pairs_or_by_cells(rows: int, shift: float, meet: bool) -> None:
    """Two wavy layers within one another's range; those of 2500 boxes are compared by the cells that they touch."""
    x, y = np.divmod(np.arange(rows * rows), rows)
    low = np.stack([x, y, np.sin(0.3 * x)], axis=1)
    boxes = np.stack([low, low + np.array([0.2, 0.2, 0.02])])
    assert may_cross(boxes, boxes + np.array([0.0, 0.0, shift])) == meet
