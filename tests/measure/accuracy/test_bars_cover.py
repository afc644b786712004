"""Every error bar that a command prints covers the true error in 19 of 20 random cases.

Those of tessellation are in solids/mesh/test_tessellation.py, of overlaps and holes in test_repair_regions.py there, of
simulated motions in test_simulation_ladder.py, of peaks from positions in test_bars_of_motions.py. What is measured -
asymmetry, drift, quartiles - has no bar."""

from __future__ import annotations

from fractions import Fraction
from functools import partial

import numpy as np
import pytest
from helpers import mesh_samples as samples
from helpers.mesh_oracle import rotation
from helpers.oracles import robot
from helpers.simulated_robots import pendulum
from helpers.small_robots import random_tree

import robodyn
from robodyn.dynamics.plan import plan
from robodyn.measure.accuracy.simulate_within import simulate_within
from robodyn.measure.accuracy.simulation import motion_reference, state_errors
from robodyn.measure.accuracy.torques import arithmetic_within
from robodyn.programs.run.multiprecision import Multiprecision
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.solids.mesh.integrals import integrate
from robodyn.solids.mesh.read.load import from_array
from robodyn.trajectory.read import motion, sources_of

ENOUGH = 0.95


def counts(few: int, many: int):
    """How many cases; the many are slow."""
    return pytest.mark.parametrize("count", [few, pytest.param(many, marks=pytest.mark.slow)])


def random_motion(rng, n, time):
    """q, qd and qdd (N, n) of sums of three sines up to 1.5 Hz."""
    A, w, p = (rng.uniform(low, high, (3, 1, n)) for low, high in ((0.1, 0.5), (1.2, 9.4), (0.0, 6.28)))
    angle = w * time[:, None] + p
    return (A * np.sin(angle)).sum(axis=0), (A * w * np.cos(angle)).sum(axis=0), -(A * w**2 * np.sin(angle)).sum(axis=0)


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
    for _ in range(60):
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
    for k in range(40):
        model = robot(("puma", "two_link_spatial", "two_link_planar")[k % 3])
        time = np.linspace(0.0, rng.uniform(0.5, 2.0), rng.integers(100, 400))
        balance = robodyn.torques(model, motion(model, time, *random_motion(rng, model.n, time))).checks.energy_balance
        held.append(abs(balance.residual) <= 2 * abs(balance.quadrature) + 1e-12 * balance.turnover)
    assert np.mean(held) >= ENOUGH


@counts(2, 20)
def test_arithmetic_of_torques(count: int) -> None:
    """Measured at 64 samples, held at all others."""
    pytest.importorskip("mpmath")
    rng, held = np.random.default_rng(6), []
    for seed in range(count):
        model = random_tree(seed, n=3)
        time = np.linspace(0.0, 2.0, 100)
        block = motion(model, time, *random_motion(rng, model.n, time))
        way = arithmetic_within(model, block, DEFAULT, 1e-6)
        tau = robodyn.inverse_dynamics(model, block.q, block.qd, block.qdd, executor="numpy")
        exact = Multiprecision(plan(model, DEFAULT).torques(), digits=30)(sources_of(block, DEFAULT), len(block))
        held.append(float(abs(exact - tau.astype(object)).max() / abs(exact).max()) <= way.expected)
    assert np.mean(held) >= ENOUGH


def swinging(rng):
    """A pendulum of one to three masses let go somewhere, and for how long."""
    masses = int(rng.integers(1, 4))
    q = {f"j{k}": rng.uniform(-2.5, 2.5) for k in range(1, masses + 1)}
    qd = {name: rng.uniform(-2, 2) for name in q}
    return pendulum(masses=masses), Scene(initial_q=q, initial_qd=qd), rng.uniform(0.2, 0.6)


@counts(3, 25)
def test_simulations_as_accurate_as_asked(count: int) -> None:
    rng, held = np.random.default_rng(7), []
    for _ in range(count):
        model, scene, duration = swinging(rng)
        found = simulate_within(model, scene, duration, 10.0 ** rng.uniform(-10, -2))
        known = motion_reference(model, duration, partial(robodyn.simulate, model, found.scene))
        held.append(state_errors(found, known)[1] <= found.expected_error + 2 * known.bound)
    assert np.mean(held) >= ENOUGH
