"""Hard meshes through `robodyn.mass_properties`: what each gives, against exact rationals, and what is said."""

from __future__ import annotations

import json

import numpy as np
import pytest
from helpers.command_line import run
from helpers.mesh_files import obj
from helpers.mesh_oracle import centred, deviation, exact, rational_moments, rotation
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

import robodyn

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


def expected(triangles):
    """Volume, centre and inertia matrix about it, as fractions."""
    V, first, S = rational_moments(triangles, (0, 0, 0))
    S_c = centred(V, first, S)
    return V, first / V, np.trace(S_c) * exact(np.eye(3)) - S_c


def holds(found, triangles, bound=1e-15):
    """V and I are those of these triangles, the centre to the same part of the distance from the origin."""
    V, centre, I = expected(triangles)
    assert deviation(found.body.volume, V) <= bound
    assert deviation(found.body.inertia, I) <= bound
    far = float(np.abs(triangles).max())
    assert np.abs(exact(found.body.com) - centre).max() <= bound * far


def said(found):
    """(name, count) of every repair."""
    return [(step.name, step.count) for step in found.repairs]


@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_scale(body, scale):
    """The same body, and the same repairs, however small or large: no threshold has a unit."""
    holds(part(body * scale), body * scale)
    wrong = np.concatenate([flipped(body[:1]), body[1:], body[2:3]]) * scale
    found = part(wrong)
    holds(found, body * scale)
    assert {"duplicate", "winding"} <= {step.name for step in found.repairs}


def test_mixed_winding(body):
    wrong = body.copy()
    wrong[::4] = flipped(wrong[::4])
    found = part(wrong)
    holds(found, body)
    assert ("winding", len(body[::4])) in said(found)


def cut_ball(ball):
    return ball[(ball[:, :, 2] < 0.72).all(axis=1)]


def test_duplicate_and_degenerate_faces(body):
    line = corners([(0, 0, 0), (1, 1, 1), (2, 2, 2)], [(0, 1, 2)])
    point = np.ones((2, 3, 3))
    found = part(body, body[:3], flipped(body[1:2]), line, point)
    holds(found, body)
    assert said(found) == [("degenerate", 3), ("duplicate", 4)]
    assert [step.what for step in found.repairs] == [
        "3 faces without area dropped",
        "4 faces given more than once dropped",
    ]


def test_stray_vertices_and_vertices_out_of_use_that_are_no_numbers(body):
    lines = [f"v {x:.17g} {y:.17g} {z:.17g}" for x, y, z in body.reshape(-1, 3)]
    lines += ["v 1e9 -1e9 1e9", "v nan 0 inf"]
    lines += [f"f {3 * k + 1} {3 * k + 2} {3 * k + 3}" for k in range(len(body))]
    found = robodyn.mass_properties("\n".join(lines).encode(), file_type="obj", density=1.0)
    holds(found, body)
    assert said(found) == []
    assert (found.lo == body.min(axis=(0, 1))).all()


def tube():
    """A cylinder without its ends, which are more than a tenth of it."""
    whole = cylinder(1.0, 2.0, 12)
    return whole[np.abs(whole.mean(axis=1)[:, 2]) < 0.9]


@pytest.fixture
def refusal(tmp_path):
    """What the command says of a file with these bytes that it refuses, after the name of the file."""

    def of(data, *options, name="part.stl"):
        path = tmp_path / name
        path.write_bytes(data)
        outcome = run("inertia", str(path), *options)
        assert (outcome.status, outcome.out) == (2, "")
        assert outcome.err.startswith(f"error: {path}: ")
        assert outcome.err.count("\n") == 1
        return outcome.err.removeprefix(f"error: {path}: ").rstrip("\n")

    return of


@pytest.mark.parametrize("surface", [sheet(), tube()])
def test_half_open_surfaces_and_sheets(refusal, tmp_path, surface):
    message = refusal(binary_stl(surface))
    assert message.startswith("the surface is not closed (")
    assert "too large to be filled" in message
    assert "--shell THICKNESS takes it as a sheet" in message
    assert run("inertia", str(tmp_path / "part.stl"), "--shell", "0.001").status == 0


@pytest.mark.parametrize(
    ("mesh", "what"),
    [
        (cut_ball(uv_sphere(1.0, 8, 16)), "left to winding numbers"),
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


def test_a_used_vertex_that_is_no_number(refusal):
    mesh = box()
    mesh[4, 1, 2] = np.nan
    assert refusal(binary_stl(mesh)) == "face 5 has a corner at (0.5, -0.5, nan) (coordinates must be finite)"
    text = obj(box()).replace(b"v 0.5 0.5 0.5", b"v 0.5 inf 0.5")
    assert "finite" in refusal(text, name="part.obj")


@pytest.mark.parametrize(
    ("data", "name"),
    [
        (b"", "empty.stl"),
        (b"", "empty.obj"),
        (binary_stl(box())[:60], "header.stl"),
        *((b"Dear reader,\nthis is a letter.\n", f"letter.{kind}") for kind in ("stl", "obj", "ply", "dae", "xyz")),
    ],
)
def test_files_that_are_no_meshes(refusal, data, name):
    assert refusal(data, name=name)


def test_the_error_bar_is_printed(tmp_path):
    path = tmp_path / "blocks.stl"
    path.write_bytes(binary_stl(np.concatenate([box(), moved(box((1, 1, 3)), (0, 0, 1))])))
    (found,) = json.loads(run("inertia", str(path), "--format", "json").out)["meshes"]
    assert 0 < found["error"]["union"] < 1e-4
    assert abs(found["volume"] / 3 - 1) < found["error"]["union"]
    bar = f"holes and overlaps: relative error at most {found['error']['union']:.0e}\n"
    assert bar in run("inertia", str(path)).out
