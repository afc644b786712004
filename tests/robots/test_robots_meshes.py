"""The meshes of robots/meshes: as their script makes them, and with the properties that their shapes have."""

from __future__ import annotations

import make_meshes
import numpy as np
import pytest

from robodyn.errors import MeshError
from robodyn.inertia.solids import box
from robodyn.part import mass_properties

EPS = np.finfo(float).eps
FILE_EPS = 2.0**-24


def test_every_mesh_is_made_by_the_script():
    assert {path.name for path in make_meshes.FOLDER.iterdir()} == set(make_meshes.MESHES)


@pytest.mark.parametrize("name", make_meshes.MESHES)
def test_bytes(name):
    assert make_meshes.content(name) == (make_meshes.FOLDER / name).read_bytes()


def test_bracket():
    """Two boxes side by side, in millimetres that float32 holds exactly."""
    found = mass_properties(make_meshes.FOLDER / "bracket.stl", unit="mm", density=2700).body
    legs = box(0.06, 0.03, 0.005, density=2700).moved([0.03, 0, 0.0025])
    legs += box(0.005, 0.03, 0.035, density=2700).moved([0.0025, 0, 0.0225])
    assert found.volume == pytest.approx(475 * 30e-9, rel=8 * EPS)
    np.testing.assert_allclose(found.com, legs.com, rtol=0, atol=8 * EPS * 0.06)
    np.testing.assert_allclose(found.inertia, legs.inertia, rtol=0, atol=32 * EPS * np.abs(legs.inertia).max())


def test_hollow_box():
    found = mass_properties(make_meshes.FOLDER / "hollow_box.stl", density=1000).body
    expected = box(0.1, 0.08, 0.06, density=1000) - box(0.08, 0.06, 0.04, density=1000)
    limit = 32 * FILE_EPS * np.abs(expected.inertia).max()
    np.testing.assert_allclose(found.inertia, expected.inertia, rtol=0, atol=limit)


def test_open_tray():
    with pytest.raises(MeshError, match="not closed"):
        mass_properties(make_meshes.FOLDER / "open_tray.stl")
    sheet = mass_properties(make_meshes.FOLDER / "open_tray.stl", shell=1e-3, density=1000)
    assert sheet.body.mass == pytest.approx(0.2 * 0.1 + 2 * 0.05 * (0.2 + 0.1), rel=32 * FILE_EPS)
