"""Torques and mass properties as accurate as asked."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from helpers.command_line import ROBOTS, run
from helpers.mesh_samples import binary_stl, cylinder, tetrahedron

import robodyn
from robodyn.dynamics.plan import plan
from robodyn.errors import InputError, MeshError
from robodyn.measure.accuracy.meshes import needs_rationals, with_promise
from robodyn.measure.accuracy.torques import PAIRS, ROUNDING, arithmetic_within
from robodyn.programs.run.multiprecision import Multiprecision
from robodyn.scene.scene import DEFAULT
from robodyn.trajectory.read import motion, sources_of

SCARA = (str(ROBOTS / "scara.urdf"), str(ROBOTS / "scara_pick_and_place.csv"))


@pytest.fixture
def swing():
    time = np.arange(300) / 100
    phase = np.array([0.0, 1.0, 2.0])
    model = robodyn.load(SCARA[0])
    return model, motion(
        model, time, *(f(2 * time[:, None] + phase) * 2.0**k for k, f in enumerate((np.sin, np.cos, np.sin)))
    )


@pytest.mark.parametrize(("target", "executor"), [(1e-3, None), (1e-14, None), (2e-16, PAIRS), (ROUNDING, PAIRS)])
def test_the_arithmetic_meets_the_target(swing, target, executor):
    pytest.importorskip("mpmath")
    model, samples = swing
    way = arithmetic_within(model, samples, DEFAULT, target)
    assert way.executor == executor
    assert way.expected <= target
    tau = robodyn.inverse_dynamics(model, samples.q, samples.qd, samples.qdd, executor=executor or "numpy")
    exact = Multiprecision(plan(model, DEFAULT).torques())(sources_of(samples, DEFAULT), len(samples))
    assert float(abs(exact - tau.astype(object)).max()) <= way.expected * float(abs(exact).max())


def test_doubles_hold_no_more(swing):
    with pytest.raises(InputError, match="results are doubles"):
        arithmetic_within(*swing, DEFAULT, 1e-17)
    with pytest.raises(InputError, match="results are doubles"):
        needs_rationals(1e-17)


def test_torques_command():
    pytest.importorskip("mpmath")
    outcome = run("torques", *SCARA, "--accuracy", "1e-9")
    assert (outcome.status, outcome.err) == (0, "")
    assert "\naccuracy: 1e-09 asked: doubles are within " in outcome.out
    pairs = run("torques", *SCARA, "--accuracy", "1.2e-16", "--explain")
    assert "double-double: as asked" in pairs.out
    assert "\naccuracy: 1.2e-16 asked: pairs of doubles are within 1e-16 of the largest torque" in pairs.out


def test_noise_is_more_than_the_target():
    pytest.importorskip("mpmath")
    call = ("torques", str(ROBOTS / "puma.urdf"), str(ROBOTS / "puma_encoder.csv"), "--accuracy")
    outcome = run(*call, "1e-6")
    assert outcome.status == 1
    assert "\naccuracy: NOT MET: 1e-06 asked: " in outcome.out
    assert "no arithmetic helps" in outcome.out
    assert run(*call, "1e-2").status == 0


@pytest.mark.parametrize(("target", "method"), [(1e-3, "float64"), (1e-12, "float64"), (9e-13, "exact rationals")])
def test_inertia_by_the_cheapest_arithmetic(target, method):
    part = robodyn.mass_properties(tetrahedron() + 1 / 3, exact=needs_rationals(target))
    assert with_promise(part, target).notes[-1].startswith(f"accuracy: {target:g} asked, proven within ")
    assert f" by {method}" in with_promise(part, target).notes[-1]
    assert abs(part.body.mass / 10e3 - 1) <= target


def test_inertia_that_is_not_known_so_well(tmp_path: Path):
    """A box with a hole too large to be plane: its bar is above the target."""
    open_can = cylinder(sectors=24)
    path = tmp_path / "can.stl"
    path.write_bytes(binary_stl(np.delete(open_can, [0, 7], axis=0)))
    part = robodyn.mass_properties(path)
    assert part.union
    with pytest.raises(MeshError, match="what the surface encloses is known to"):
        with_promise(part, part.union / 2)
    assert with_promise(part, part.union * 2)
    outcome = run("inertia", str(path), "--accuracy", "1e-12")
    assert (outcome.status, outcome.out) == (2, "")
    assert outcome.err.startswith(f"error: {path}: an accuracy of 1e-12 cannot be promised: ")
