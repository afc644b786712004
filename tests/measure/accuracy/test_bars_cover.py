"""Every error bar that a command prints covers the true error in 19 of 20 random cases.

Those of tessellation are in solids/mesh/test_tessellation.py, of overlaps and holes in test_repair_regions.py there, of
simulated motions in test_random_scenes.py, of torques in test_within.py, of peaks from positions in
test_bars_of_motions.py. What is measured - asymmetry, drift, quartiles - has no bar."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from helpers import mesh_samples as samples
from helpers.identified_logs import waves
from helpers.mesh_oracle import rotation
from helpers.oracles import robot

import robodyn
from robodyn.solids.mesh.integrals import integrate
from robodyn.solids.mesh.read.load import from_array
from robodyn.trajectory.read import motion

ENOUGH = 0.95


def random_body(rng):
    """A solid of random kind and proportions, anywhere."""
    solid = [samples.box, samples.tetrahedron, samples.cylinder, samples.torus, samples.uv_sphere][rng.integers(5)]()
    stretch = 10.0 ** rng.uniform(-2, 0.5, 3)
    return samples.moved(solid * stretch, 10.0 ** rng.uniform(-1, 5) * rng.normal(size=3), rotation(rng.integers(9999)))


def test_arithmetic_of_meshes() -> None:
    """Bounds are proven: all of them hold. The bodies are thin, and far from the origin."""
    rng = np.random.default_rng(1)
    finite = 0
    for _ in range(30):
        triangles = from_array(random_body(rng))
        found, exact = integrate(triangles), integrate(triangles, exact=True).moments
        off = abs(Fraction(found.volume) - exact.volume) / abs(exact.volume)
        assert off <= found.bound
        assert found.bound <= 1e-12
        finite += found.method != "rational"
    assert finite >= 10


def test_rounding_of_files() -> None:
    """Corners in float32 or in six decimals, against those that were meant."""
    rng = np.random.default_rng(2)
    held = []
    for _ in range(40):
        body = random_body(rng) * 1e-3
        meant = robodyn.mass_properties(body)
        found = robodyn.mass_properties(samples.binary_stl(body), file_type="stl")
        if found.closed and not found.repairs:
            held.append(abs(found.body.volume / meant.body.volume - 1) <= found.rounding)
    assert len(held) >= 20
    assert np.mean(held) >= ENOUGH


def test_what_sampling_explains_of_the_energy() -> None:
    """The residual of exact motions is that of the trapezoidal rule, which the report estimates to a factor of two."""
    rng, held = np.random.default_rng(5), []
    for k in range(20):
        model = robot(("puma", "two_link_spatial", "two_link_planar")[k % 3])
        time = np.linspace(0.0, rng.uniform(0.5, 2.0), rng.integers(100, 400))
        balance = robodyn.torques(model, motion(model, time, *waves(rng, time, model.n))).checks.energy_balance
        held.append(abs(balance.residual) <= 2 * abs(balance.quadrature) + 1e-12 * balance.turnover)
    assert np.mean(held) >= ENOUGH
