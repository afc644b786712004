"""`robodyn inertia`: symmetry, its average and the error of facets."""

from __future__ import annotations

import json

import numpy as np
import pytest
from helpers import mesh_samples as samples
from helpers.command_line import run
from helpers.smooth_solids import solids

import robodyn
from robodyn.solids.mesh import measured

EPS = np.finfo(float).eps


@pytest.fixture
def lever(tmp_path):
    """Planes y = 0 and z = 0; in float32, so that they hold but for rounding."""
    return saved(tmp_path, solid("lever").mesh(32))


def solid(name):
    (found,) = [one for one in solids() if one.name == name]
    return found


def saved(folder, corners):
    path = folder / "part.stl"
    path.write_bytes(samples.binary_stl(corners))
    return str(path)


def mesh(*args):
    outcome = run("inertia", *args, "--format", "json")
    assert (outcome.status, outcome.err) == (0, "")
    (only,) = json.loads(outcome.out)["meshes"]
    return only


def test_symmetry_as_data(lever):
    found = mesh(lever, "--unit", "mm", "--density", "1")["symmetry"]
    assert [plane["verdict"] for plane in found["planes"]] == ["exact", "exact", "none"]
    assert {tuple(np.abs(plane["normal"])) for plane in found["planes"][:2]} == {(0, 1, 0), (0, 0, 1)}
    assert set(found["planes"][0]) == {"normal", "offset", "asymmetry", "verdict"}
    (axis,) = found["axes"]
    assert (axis["fold"], np.abs(axis["direction"]).tolist()) == (2, [1, 0, 0])
    assert 1e-4 < axis["point"][0] < 3e-3
    assert [(product["axes"], product["zero_by_symmetry"]) for product in found["products"]] == [
        ("xy", True),
        ("xz", True),
        ("yz", True),
    ]


def test_symmetry_of_a_round_part_has_an_axis_without_a_fold(tmp_path):
    axes = mesh(saved(tmp_path, solid("tube").mesh(32)))["symmetry"]["axes"]
    assert [(axis["fold"], axis["verdict"]) for axis in axes] == [(32, "exact"), (None, "within tessellation")]


def test_products_of_a_part_askew(tmp_path):
    """Computed products are those of the matrix."""
    found = mesh(saved(tmp_path, samples.tetrahedron()), "--density", "2")
    I = found["inertia"]
    products = [product["computed"] for product in found["symmetry"]["products"]]
    assert products == pytest.approx([I[0][1], I[0][2], I[1][2]], rel=1e-14)
    assert not any(product["zero_by_symmetry"] for product in found["symmetry"]["products"])


def test_text(lever):
    out = run("inertia", lever).out
    block = out.partition("\nSymmetry\n")[2].partition("\n\n")[0].splitlines()
    assert block[0].split() == ["normal", "or", "axis", "at", "asymmetry", "verdict"]
    assert [line.split()[0] for line in block[1:-1]] == ["plane", "plane", "axis,"]
    assert all(line.endswith("exact") for line in block[1:-1])
    assert block[-1].startswith("0 by symmetry: Ixy, Ixz, Iyz (computed ")
    assert "if facets are meant flat, nothing is missing; if they stand for smooth faces, the volume is off by" in out
    assert "with smooth faces through the corners: volume 3.287 m^3, principal moments" in out
    assert "if the corners are on them: volume within " in out


def test_text_of_what_has_neither(tmp_path):
    out = run("inertia", saved(tmp_path, samples.tetrahedron())).out
    assert "Symmetry\nnone; the nearest plane leaves " in out
    assert "tessellation: no facets that may stand for a curved face\n" in out


def test_average(tmp_path):
    """Of a box with a small hole off its planes: products as large as its tolerance allows, and then none."""
    hole = samples.moved(samples.flipped(samples.box((0.01, 0.01, 0.01))), (0.3, 0.6, 0.9))
    path = saved(tmp_path, np.concatenate([samples.box((1, 2, 3)), hole]))
    as_is, average = mesh(path), mesh(path, "--symmetrize")
    assert as_is["inertia"][0][1] != 0
    I = np.array(average["inertia"])
    assert np.array_equal(I, np.diag(np.diag(I)))
    np.testing.assert_allclose(I, as_is["inertia"], rtol=0, atol=1e-5 * I.max())
    assert average["mass"] == as_is["mass"]
    assert any(note.startswith("symmetrize: averaged over planes (3) and axes (") for note in average["notes"])
    none = mesh(saved(tmp_path, samples.tetrahedron()), "--symmetrize")
    assert "symmetrize: no plane and no axis holds, nothing was changed" in none["notes"]


def test_tessellation_as_data(tmp_path):
    exact = solid("capsule")
    found = mesh(saved(tmp_path, exact.mesh(24)), "--density", "1")
    tessellation = found["error"]["tessellation"]
    volume, inertia = tessellation["volume"], tessellation["inertia"]
    assert volume["mesh"] == found["volume"]
    off = abs(found["volume"] / exact.volume - 1)
    assert 0.01 < off <= volume["bar"] < 1.5 * off
    assert abs(volume["corrected"] / exact.volume - 1) < min(volume["bar_corrected"], off / 20)
    I = np.trace(exact.S) * np.eye(3) - exact.S
    raw, corrected = (
        np.abs(np.array(matrix) - I).max() / I.max() for matrix in (found["inertia"], inertia["corrected"])
    )
    assert corrected < min(inertia["bar_corrected"], raw / 20) < raw <= inertia["bar"]


def test_tessellation_at_a_given_mass(tmp_path):
    exact = solid("capsule")
    inertia = mesh(saved(tmp_path, exact.mesh(24)), "--mass", "3")["error"]["tessellation"]["inertia"]
    I = 3 / exact.volume * (np.trace(exact.S) * np.eye(3) - exact.S)
    assert np.abs(np.array(inertia["corrected"]) - I).max() < inertia["bar_corrected"] * I.max()


def test_only_small_meshes_are_asked_unless_told(lever, monkeypatch):
    monkeypatch.setattr(measured, "SYMMETRY_TRIANGLES", 100)
    monkeypatch.setattr(measured, "TESSELLATION_TRIANGLES", 100)
    found = mesh(lever)
    assert found["symmetry"] is found["error"]["tessellation"] is None
    assert found["notes"][-2:] == [
        "symmetry: not sought unasked above 100 triangles (--symmetry does)",
        "tessellation: not sought unasked above 100 triangles (--tessellation does)",
    ]
    assert len(mesh(lever, "--symmetry")["symmetry"]["planes"]) == 3
    assert mesh(lever, "--tessellation")["error"]["tessellation"]["volume"]["bar"] > 0
    assert len(mesh(lever, "--symmetrize")["symmetry"]["planes"]) == 3


def test_told_not_to(lever):
    found = mesh(lever, "--no-symmetry", "--no-tessellation")
    assert found["symmetry"] is found["error"]["tessellation"] is None
    assert not any("sought" in note for note in found["notes"])
    assert "Symmetry" not in run("inertia", lever, "--no-symmetry").out


def test_sheets_and_open_surfaces_have_neither(tmp_path):
    path = saved(tmp_path, samples.box((2, 2, 2))[:-2])
    for how in (("--shell", "0.001"), ("--no-repair",)):
        found = mesh(path, *how)
        assert found["symmetry"] is found["error"]["tessellation"] is None
    refused = run("inertia", path, "--no-repair", "--symmetrize")
    assert (refused.status, refused.out) == (2, "")
    assert refused.err.startswith("error: ")
    assert refused.err.count("\n") == 1


def test_the_library_does_what_it_is_asked():
    body = solid("tube").mesh(24)
    quick = robodyn.mass_properties(body)
    assert (quick.symmetry, quick.tessellation, quick.corrected) == (None, None, None)
    assert not any("sought" in note for note in quick.notes)
    full = robodyn.mass_properties(body, symmetry=True, tessellation=None, mass=2.0)
    assert len(full.symmetry.planes) == 3
    assert full.corrected.mass == pytest.approx(2.0, rel=4 * EPS)
