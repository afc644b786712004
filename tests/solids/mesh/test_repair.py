"""Every rung of the repair, and hard meshes through `robodyn.mass_properties`, against exact rationals."""

from __future__ import annotations

import json
from fractions import Fraction

import numpy as np
import pytest
from helpers.command_line import run
from helpers.mesh_oracle import rotation
from helpers.mesh_samples import (
    binary_stl,
    box,
    corners,
    cylinder,
    flipped,
    moved,
    sheet,
    tetrahedron,
    torus,
    uv_sphere,
)
from helpers.repaired_meshes import R, enclosed, repaired, taken, volume
from hypothesis import given
from hypothesis import strategies as st

import robodyn
from robodyn.errors import MeshError
from robodyn.solids.mesh.integrals import integrate
from robodyn.solids.mesh.shells import collinear

EPS = np.finfo(np.float64).eps


def same_volume(found, expected, k=64):
    assert volume(found) == pytest.approx(expected, rel=k * EPS, abs=0)


def test_a_body_in_another_wound_alike_is_a_part_of_it_or_a_cavity_if_so_asked():
    found = repaired(box((3, 3, 3)), box())
    assert taken(found) == [("nested", 1)]
    assert found.steps[0].change == pytest.approx(-1, rel=1e-12)
    (remark,) = found.remarks
    assert remark.endswith("taken as a part of it: if it is a cavity, say --cavities (1 m^3 less)")
    same_volume(found, 27)
    found = repaired(box((3, 3, 3)), box(), cavities=True)
    assert taken(found) == [("orientation", 1)]
    assert found.steps[0].what == "1 shell turned inwards, being a cavity in another"
    assert found.remarks == ()
    same_volume(found, 26)


@pytest.mark.parametrize("signs", list(np.ndindex(2, 2, 2, 2)))
def test_nesting_of_any_winding(signs):
    """By winding numbers, from each body in empty space on in its own sense; if asked, every second is a cavity."""
    sizes = (7, 5, 3, 1, 0)
    winding, sense, expected = 0, 0, 0
    for depth, flip in enumerate(signs):
        way = -1 if flip else 1
        sense = sense if winding else way
        winding += way * sense
        expected += (winding > 0) * (sizes[depth] ** 3 - sizes[depth + 1] ** 3)
    boxes = [box((s, s, s)) for s in sizes[:4]]
    parts = [flipped(one) if flip else one for one, flip in zip(boxes, signs, strict=True)]
    same_volume(repaired(*[moved(part, R=R) for part in parts]), expected)
    found = repaired(*[moved(part, R=R) for part in parts], cavities=True)
    same_volume(found, 7**3 - 5**3 + 3**3 - 1)
    assert sum(step.count for step in found.steps) == sum(flip != depth % 2 for depth, flip in enumerate(signs))


@pytest.mark.parametrize("turn", [np.eye(3), R])
def test_volume_does_not_jump_when_a_body_slides_into_another(turn):
    """A cube of edge 1 slides into one of edge 3 through its side: what sticks out is all that it adds."""
    for reach in (-0.25, 0.0, 0.25, 0.999999, 1.0, 1.5):
        slid = moved(box(), (2.0 - reach, 0.1, 0.2))
        found = repaired(moved(box((3, 3, 3)), R=turn), moved(slid, R=turn))
        assert volume(found) == pytest.approx(27 + 1 - min(max(reach, 0), 1), rel=1e-12)


def test_nothing_but_lines_is_refused():
    with pytest.raises(MeshError, match="no triangle with an area"):
        repaired(corners([(0, 0, 0), (1, 1, 1), (2, 2, 2)], [(0, 1, 2)]))


def test_a_face_on_a_line_that_closes_a_seam_stays():
    a, b, c = box()[0]
    middle = a / 2 + b / 2
    split = np.array([(a, middle, c), (middle, b, c)])
    whole = np.concatenate([box()[1:], split, [(a, b, middle)]])
    found = repaired(whole)
    assert found.steps == ()
    assert found.closed


def test_walls_within_a_block_of_eight_boxes_cancel():
    offsets = np.array(list(np.ndindex(2, 2, 2)))
    found = repaired(*[moved(box(), offset) for offset in offsets])
    assert found.triangles.count == 4 * 12
    assert integrate(found.triangles).volume == 8
    assert taken(found) == [("duplicate", 4 * 12)]


@given(st.lists(st.integers(-(2**20), 2**20), min_size=6, max_size=6), st.integers(1, 2**20), st.integers(-1, 1))
def test_lines_are_told_from_triangles_without_rounding(numbers, factor, nudge):
    a, step = np.array(numbers[:3], float), np.array(numbers[3:], float)
    c = a + factor * step
    c[0] += nudge
    triangle = np.array([[a, a + step, c]])
    p, q, r = ([Fraction(x) for x in corner] for corner in triangle[0].tolist())
    e, f = [y - x for x, y in zip(p, q, strict=True)], [y - x for x, y in zip(p, r, strict=True)]
    exact = all(e[i] * f[j] == e[j] * f[i] for i, j in ((0, 1), (1, 2), (2, 0)))
    assert collinear(triangle)[0] == exact


@pytest.mark.parametrize("count", [1, 5])
def test_scattered_holes_in_a_sphere(count):
    whole = moved(uv_sphere(), (3, 1, -2))
    chosen = np.random.default_rng(count).choice(len(whole), count, replace=False)
    found = repaired(np.delete(whole, chosen, axis=0))
    (step,) = found.steps
    assert step.name == "holes"
    assert 1 <= step.count <= count
    assert found.closed
    assert volume(found) == pytest.approx(enclosed(whole), rel=2e-3)
    assert step.change == pytest.approx(step.volume_after - step.volume_before)


def test_holes_that_touch_at_a_corner():
    whole = torus(rings=64, sectors=32)
    corner = whole[500, 0]
    around = np.flatnonzero((whole == corner).all(axis=2).any(axis=1))
    apart = [around[0], next(k for k in around[1:] if not _share_an_edge(whole[around[0]], whole[k]))]
    found = repaired(np.delete(whole, apart, axis=0))
    assert taken(found) == [("holes", 2)]
    assert volume(found) == pytest.approx(enclosed(whole), rel=16 * EPS)


def _share_an_edge(one, other):
    return sum((one[:, None] == other).all(axis=2).any(axis=1)) > 1


def test_a_plane_hole_that_is_not_convex():
    star = np.array([(np.cos(a), np.sin(a)) for a in np.pi * np.arange(10) / 5]) * np.tile([1.0, 0.4], 5)[:, None]
    bottom, top = np.insert(star, 2, 0.0, axis=1), np.insert(star, 2, 9.0, axis=1)
    after = np.roll(np.arange(10), -1)
    k = np.arange(10)
    sides = np.concatenate([np.stack([k, after, after + 10], axis=1), np.stack([k, after + 10, k + 10], axis=1)])
    found = repaired(corners(np.concatenate([bottom, top]), sides))
    (x, y), (xa, ya) = star.T, star[after].T
    area = float((x * ya - xa * y).sum()) / 2
    assert taken(found) == [("holes", 2)]
    assert volume(found) == pytest.approx(9 * area, rel=64 * EPS)


def test_a_t_junction():
    a, b, c = box()[0]
    middle = a / 2 + b / 2
    found = repaired(box()[1:], np.array([(a, middle, c), (middle, b, c)]))
    assert taken(found) == [("holes", 1)]
    assert found.steps[0].what == "1 seam filled by 1 triangle"
    assert found.steps[0].change == pytest.approx(0, abs=4 * EPS)
    assert volume(found) == 1


def test_an_edge_drawn_twice():
    """Corners of one meridian of a sphere that are off by rounding in the triangles on one side."""
    whole = uv_sphere(rings=32, sectors=64)
    on = (np.abs(whole[:, :, 1]) < 1e-15) & (whole[:, :, 0] > 0.05)
    east = whole[:, :, 1].sum(axis=1) > 0
    cracked = whole.copy()
    cracked[on & east[:, None]] *= 1 + 1e-7
    found = repaired(cracked)
    assert [step.name for step in found.steps] == ["holes"]
    assert found.steps[0].what.startswith("1 seam")
    assert volume(found) == pytest.approx(enclosed(whole), rel=1e-7)


def test_a_stray_sheet_beside_a_body_weighs_nothing():
    found = repaired(box((20, 20, 20)), moved(sheet(), (0, 0, 50)))
    assert taken(found) == [("holes", 1)]
    assert volume(found) == pytest.approx(8000, rel=16 * EPS)


def test_what_may_have_been_where_a_hole_is():
    """A sphere without its ends: what lies beyond the caps is less than the doubt, but not by orders of magnitude."""
    whole = uv_sphere(rings=48, sectors=96)
    for height in (0.95, 0.9, 0.82):
        found = repaired(moved(whole[(whole[:, :, 2] < height).all(axis=1)], R=R))
        assert enclosed(whole) - volume(found) < found.doubt < 20 * (enclosed(whole) - volume(found))


BODIES = {
    "tetrahedron": tetrahedron(),
    "torus": torus(2.0, 0.5, 16, 8),
    "askew box": moved(box((1, 2, 3)), R=rotation(3)),
}


@pytest.fixture(params=BODIES)
def body(request):
    """Triangles of a sound body."""
    return BODIES[request.param]


def part(*triangles, **how):
    return robodyn.mass_properties(np.concatenate(triangles), density=1.0, **how)


def same(found, triangles):
    """The body is that of these triangles, which need no repair, but for rounding."""
    right = part(triangles)
    assert right.repairs == ()
    for name in ("volume", "inertia", "com"):
        one, other = (np.asarray(getattr(each.body, name)) for each in (found, right))
        assert np.abs(one - other).max() <= 4 * EPS * max(
            np.abs(other).max(), np.abs(triangles).max() * (name == "com")
        )


@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_scale(body, scale):
    """The same body, and the same repairs, however small or large: no threshold has a unit."""
    wrong = np.concatenate([flipped(body[:1]), body[1:], body[2:3]]) * scale
    found = part(wrong)
    same(found, body * scale)
    assert {"duplicate", "winding"} <= {step.name for step in found.repairs}


def test_duplicate_and_degenerate_faces(body):
    line = corners([(0, 0, 0), (1, 1, 1), (2, 2, 2)], [(0, 1, 2)])
    point = np.ones((2, 3, 3))
    found = part(body, body[:3], flipped(body[1:2]), line, point)
    same(found, body)
    assert [(step.name, step.count) for step in found.repairs] == [("degenerate", 3), ("duplicate", 4)]
    assert [step.what for step in found.repairs] == [
        "3 faces without area dropped",
        "4 faces given more than once dropped",
    ]


def test_stray_vertices_and_vertices_out_of_use_that_are_no_numbers(body):
    lines = [f"v {x:.17g} {y:.17g} {z:.17g}" for x, y, z in body.reshape(-1, 3)]
    lines += ["v 1e9 -1e9 1e9", "v nan 0 inf"]
    lines += [f"f {3 * k + 1} {3 * k + 2} {3 * k + 3}" for k in range(len(body))]
    found = robodyn.mass_properties("\n".join(lines).encode(), file_type="obj", density=1.0)
    same(found, body)
    assert [(step.name, step.count) for step in found.repairs] == []
    assert (found.lo == body.min(axis=(0, 1))).all()


def tube():
    """A cylinder without its ends, which are more than a tenth of it."""
    whole = cylinder(1.0, 2.0, 12)
    return whole[np.abs(whole.mean(axis=1)[:, 2]) < 0.9]


@pytest.fixture
def refusal(tmp_path, monkeypatch):
    """What the command says of a file with these bytes that it refuses, after the name of the file."""
    monkeypatch.setattr("robodyn.solids.mesh.columns._MOST", 512)  # columns through open surfaces, each of which costs

    def of(data, *options, name="part.stl"):
        path = tmp_path / name
        path.write_bytes(data)
        outcome = run("inertia", str(path), *options)
        assert (outcome.status, outcome.out) == (2, "")
        assert outcome.err.startswith(f"error: {path}: ")
        assert outcome.err.count("\n") == 1
        return outcome.err.removeprefix(f"error: {path}: ").rstrip("\n")

    return of


@pytest.mark.parametrize(("surface", "gaps"), [(sheet(), "1 gap 50"), (tube(), "2 gaps 33")])
def test_half_open_surfaces_and_sheets(refusal, tmp_path, surface, gaps):
    message = refusal(binary_stl(surface))
    assert message.startswith("the surface is not closed (")
    many, _, part = gaps.rpartition(" ")
    assert f"{many} too large to be filled: {part} % of their surface is missing" in message
    assert "--shell THICKNESS takes it as a sheet" in message
    assert run("inertia", str(tmp_path / "part.stl"), "--shell", "0.001").status == 0


@pytest.mark.parametrize(
    ("mesh", "what"),
    [
        (uv_sphere(1.0, 8, 16)[(uv_sphere(1.0, 8, 16)[:, :, 2] < 0.72).all(axis=1)], "left to winding numbers"),
        (np.concatenate([box(), moved(box(), (0.5, 0.25, 0.125))]), "2 overlapping bodies united"),
        (np.concatenate([box(), moved(box((1, 1, 3)), (0, 0, 1))]), "overlaps of 1 folded shell counted once"),
        (torus()[1:], "1 hole filled by 1 triangle"),
        (np.concatenate([torus(), torus()[:1]]), "1 face given more than once dropped"),
        (np.concatenate([torus()[1:], flipped(torus()[:1])]), "1 face turned to agree with neighbours"),
        (flipped(torus()), "1 shell turned outwards"),
        (np.concatenate([box((3, 3, 3)), box()]), "1 shell in another, wound as it is, counted once"),
    ],
)
def test_strict_refuses_every_repair(refusal, tmp_path, mesh, what):
    message = refusal(binary_stl(mesh), "--strict")
    assert what in message
    assert message.endswith("(--strict refuses what needs repair)")
    outcome = run("inertia", str(tmp_path / "part.stl"), "--format", "json")
    (found,) = json.loads(outcome.out)["meshes"]
    assert outcome.status == 0
    assert any(what in step["what"] for step in found["repairs"])


def test_the_error_bar_is_printed(tmp_path):
    path = tmp_path / "blocks.stl"
    path.write_bytes(binary_stl(np.concatenate([box(), moved(box((1, 1, 3)), (0, 0, 1))])))
    (found,) = json.loads(run("inertia", str(path), "--format", "json").out)["meshes"]
    assert 0 < found["error"]["union"] < 1e-4
    assert abs(found["volume"] / 3 - 1) < found["error"]["union"]
    bar = f"holes and overlaps: relative error at most {found['error']['union']:.0e}\n"
    assert bar in run("inertia", str(path)).out
