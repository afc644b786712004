"""Error bars that commands print cover the true error: of motions with corners and noise, of meshes, of energy.

Those of tessellation are in solids/mesh/test_tessellation.py, of overlaps and holes in test_repair_regions.py there, of
simulated motions in test_random_scenes.py, of torques in test_within.py.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from benchmarks.derivative_errors import NOISES, ONE, Held, held, one_joint
from helpers import mesh_samples as samples
from helpers.exact_motions import MOTIONS
from helpers.identified_logs import waves
from helpers.mesh_oracle import rotation
from helpers.oracles import robot
from helpers.small_robots import built, joint, link

import robodyn
from robodyn.solids.mesh.integrals import integrate
from robodyn.solids.mesh.read.load import from_array
from robodyn.trajectory.options import Reading
from robodyn.trajectory.read import from_arrays, motion

ENOUGH = 0.93


def pooled(cases: list[Held]) -> float:
    return float(np.mean([case.peak for case in cases]))


@pytest.mark.parametrize("name", ["trapezoid", "S-curve, triangular"])
def test_bars_hold_in_every_class_of_motion(name: str) -> None:
    cases = [held(name, noise, 200, seed) for noise in NOISES for seed in range(2)]
    assert pooled(cases) >= 0.9
    assert np.mean([case.rows for case in cases]) >= ENOUGH


@pytest.mark.slow
@pytest.mark.parametrize("name", MOTIONS)
def test_bars_of_all_noises_together(name: str) -> None:
    cases = [held(name, noise, rate, seed) for noise in NOISES for rate in (50, 200, 1000) for seed in range(4)]
    assert pooled(cases) >= ENOUGH
    assert np.mean([case.rows for case in cases]) >= ENOUGH


def surest(found) -> int:
    return int(np.argmax(np.abs(found.qdd[:, 0]) - found.sampling.off[:, 0]))


@pytest.mark.parametrize("noise", ["encoder", "none"])
def test_torque_of_one_joint_with_trapezoidal_speed(noise: str) -> None:
    """10.62 +- 0.24 and 10.39 +- 0.033 N m were printed where 10 is true, and --accuracy 1e-2 was called met."""
    time = np.arange(0.0, 2.0, 1e-3)
    a = np.select([time % 1 < 0.25, time % 1 < 0.5], [10.0, 0.0], 0.0) - 10.0 * ((time % 1 >= 0.5) & (time % 1 < 0.75))
    v = np.concatenate(([0.0], np.cumsum(a[:-1]) * 1e-3))
    q = np.concatenate(([0.0], np.cumsum(v[:-1] * 1e-3 + a[:-1] * 5e-7)))
    step = 2 * np.pi / 2**17
    model = built(link("l0"), link("l1", 1.0, (0, 0, 0), (1, 0, 0, 1, 0, 1)), joint("j1", "l0", "l1", "continuous"))
    given = step * np.round(q / step) if noise == "encoder" else q
    found = robodyn.torques(model, robodyn.motion(model, time, given[:, None]))
    (load,) = found.joints
    assert abs(abs(load.peak) - 10.0) <= min(load.error_bar + 1e-6, 0.05)
    assert load.error_bar <= 0.2


@pytest.mark.parametrize(
    "mode", ["spline", *(pytest.param(mode, marks=pytest.mark.slow) for mode in ("savgol", "central"))]
)
def test_bars_of_chosen_methods_hold_too(mode: str) -> None:
    ok = []
    for seed in range(2):
        for kind in ("trapezoid", "sines"):
            time, q, (_, _, qdd) = one_joint(kind, "white noise", 200, seed)
            found = from_arrays(ONE, time, q, reading=Reading(mode))
            ok.extend(np.abs(found.qdd - qdd) <= found.sampling.off)
    assert np.mean(ok) >= ENOUGH


def test_bars_of_given_noisy_velocities_hold() -> None:
    ok = []
    for seed in range(6):
        time, q, (_, qd, qdd) = one_joint(list(MOTIONS)[seed % len(MOTIONS)], "exact", 200, seed)
        rng = np.random.default_rng(seed)
        found = from_arrays(ONE, time, q, qd + 10.0 ** rng.uniform(-4, -2) * rng.standard_normal(qd.shape))
        k = surest(found)
        ok.append(abs(found.qdd[k, 0] - qdd[k, 0]) <= found.sampling.off[k, 0])
    assert np.mean(ok) >= 0.9


NEARLY_ALL = 0.95


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
    assert np.mean(held) >= NEARLY_ALL


def test_what_sampling_explains_of_the_energy() -> None:
    """The residual of exact motions is that of the trapezoidal rule, which the report estimates to a factor of two."""
    rng, held = np.random.default_rng(5), []
    for k in range(20):
        model = robot(("puma", "two_link_spatial", "two_link_planar")[k % 3])
        time = np.linspace(0.0, rng.uniform(0.5, 2.0), rng.integers(100, 400))
        balance = robodyn.torques(model, motion(model, time, *waves(rng, time, model.n))).checks.energy_balance
        held.append(abs(balance.residual) <= 2 * abs(balance.quadrature) + 1e-12 * balance.turnover)
    assert np.mean(held) >= NEARLY_ALL
