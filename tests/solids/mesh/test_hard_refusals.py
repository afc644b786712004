"""Hard meshes through the command: one line on standard error and status 2, and what can be done instead."""

from __future__ import annotations

import json

import numpy as np
import pytest
from helpers.command_line import run
from helpers.mesh_files import obj
from helpers.mesh_samples import binary_stl, box, cylinder, flipped, moved, sheet, torus, uv_sphere


def half_ball():
    ball = uv_sphere()
    return ball[(ball[:, :, 2] < 1e-9).all(axis=1)]


def tube():
    """A cylinder without its ends, which are more than a tenth of it."""
    whole = cylinder(1.0, 2.0)
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


@pytest.mark.parametrize("surface", [sheet(), box()[2:], half_ball(), tube()])
def test_half_open_surfaces_and_sheets(refusal, tmp_path, surface):
    message = refusal(binary_stl(surface))
    assert message.startswith("the surface is not closed (")
    assert "too large to be filled" in message
    assert "--shell THICKNESS takes it as a sheet" in message
    assert run("inertia", str(tmp_path / "part.stl"), "--shell", "0.001").status == 0


@pytest.mark.parametrize(
    ("mesh", "what"),
    [
        (uv_sphere(1.0, 48, 96)[(uv_sphere(1.0, 48, 96)[:, :, 2] < 0.72).all(axis=1)], "left to winding numbers"),
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
        (b"solid\nendsolid\n", "nothing.stl"),
        (binary_stl(box())[:-7], "truncated.stl"),
        (binary_stl(box())[:60], "header.stl"),
        (b"Dear reader,\nthis is a letter.\n", "letter.stl"),
        (b"Dear reader,\nthis is a letter.\n", "letter.obj"),
        (b"Dear reader,\nthis is a letter.\n", "letter.ply"),
        (b"Dear reader,\nthis is a letter.\n", "letter.dae"),
        (b"Dear reader,\nthis is a letter.\n", "letter.xyz"),
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
