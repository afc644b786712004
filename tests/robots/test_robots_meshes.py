"""The meshes of robots/meshes: with the properties that their shapes have."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.oracles import ROBOTS

from robodyn.solids.inertia.solids import box
from robodyn.solids.mass_properties import mass_properties

FOLDER = ROBOTS / "meshes"
EPS = np.finfo(float).eps
FILE_EPS = 2.0**-24


def test_bracket():
    """Two boxes side by side, in millimetres that float32 holds exactly."""
    found = mass_properties(FOLDER / "bracket.stl", unit="mm", density=2700).body
    legs = box(0.06, 0.03, 0.005, density=2700).placed(np.eye(3), [0.03, 0, 0.0025])
    legs += box(0.005, 0.03, 0.035, density=2700).placed(np.eye(3), [0.0025, 0, 0.0225])
    assert found.volume == pytest.approx(475 * 30e-9, rel=8 * EPS)
    np.testing.assert_allclose(found.com, legs.com, rtol=0, atol=8 * EPS * 0.06)
    np.testing.assert_allclose(found.inertia, legs.inertia, rtol=0, atol=32 * EPS * np.abs(legs.inertia).max())


def close(found, expected):
    """Within what rounding coordinates to float32 can do."""
    assert found.volume == pytest.approx(expected.volume, rel=8 * FILE_EPS)
    np.testing.assert_allclose(found.com, expected.com, rtol=0, atol=8 * FILE_EPS * 0.1)
    np.testing.assert_allclose(found.inertia, expected.inertia, rtol=0, atol=32 * FILE_EPS * expected.inertia.max())


def test_cross():
    """What the bars share counts once."""
    part = mass_properties(FOLDER / "cross.stl", density=1000)
    bars = box(0.2, 0.04, 0.04, density=1000) + box(0.04, 0.2, 0.04, density=1000)
    close(part.body, bars - box(0.04, 0.04, 0.04, density=1000))
    assert [step.name for step in part.repairs] == ["union"]


def test_hollow_box():
    found = mass_properties(FOLDER / "hollow_box.stl", density=1000).body
    close(found, box(0.1, 0.08, 0.06, density=1000) - box(0.08, 0.06, 0.04, density=1000))


@pytest.mark.parametrize(("name", "step"), [("twisted_block", "winding"), ("torn_block", "holes")])
def test_blocks(name, step):
    part = mass_properties(FOLDER / f"{name}.stl", density=1000)
    close(part.body, box(0.12, 0.06, 0.04, density=1000))
    assert [found.name for found in part.repairs] == [step]


OCTAGON = [(30, 12), (12, 30), (-12, 30), (-30, 12), (-30, -12), (-12, -30), (12, -30), (30, -12)]
PAD = [(40, -30), (40, 27), (37, 30), (-40, 30), (-40, -30)]


@pytest.mark.parametrize(("name", "outline"), [("hub", OCTAGON), ("worn_pad", PAD)])
def test_prisms(name, outline):
    """The integrals over a polygon by Green's theorem, times the height; coordinates are exact in float32."""
    x, y = np.array(outline).T
    right, up = np.roll(x, -1), np.roll(y, -1)
    z = x * up - right * y
    area, squares = z.sum() / 2, ((x * x + x * right + right * right) * z).sum() / 12
    first_x, first_y = ((x + right) * z).sum() / 6, ((y + up) * z).sum() / 6
    centre = [first_x / area / 1e3, first_y / area / 1e3, 0.02]
    found = mass_properties(FOLDER / f"{name}.stl", unit="mm", density=1000).body
    assert found.volume == pytest.approx(area * 40e-9, rel=8 * EPS)
    np.testing.assert_allclose(found.com, centre, rtol=0, atol=8 * EPS * 0.03)
    assert found.S_c[0, 0] == pytest.approx(1000 * 40e-15 * (squares - first_x**2 / area), rel=32 * EPS)
    assert found.S_c[2, 2] == pytest.approx(found.mass * 0.04**2 / 12, rel=32 * EPS)
