"""The front of a ladder, and which method is the cheapest within a target; errors of meshes and of torques."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from helpers.command_line import ROBOTS
from hypothesis import given
from hypothesis import strategies as st

from robodyn.dynamics.inverse import inverse_dynamics
from robodyn.errors import InputError, MeshError
from robodyn.measure.accuracy.ladder import Ladder, Rung, Spread, timed
from robodyn.measure.accuracy.meshes import (
    OPERATIONS,
    mesh_accuracy,
)
from robodyn.measure.accuracy.torques import file_accuracy
from robodyn.robot.load import load
from robodyn.scene.scene import DEFAULT
from robodyn.solids.mesh.kernel import volume_kernel
from robodyn.solids.mesh.read.load import from_array
from robodyn.solids.mesh.triangles import CHUNK, workspace
from robodyn.trajectory.read import read_motion


def rung(name: str, error: float, seconds: float) -> Rung:
    return Rung(name, (error,), Spread(seconds, seconds, seconds, 1))


def ladder(*rungs: Rung) -> Ladder:
    return Ladder("task", ("result",), "truth", "mesh", rungs)


FEW = st.integers(0, 6).map(float)
RUNGS = st.lists(st.tuples(FEW, FEW), min_size=1, max_size=12).map(
    lambda pairs: [rung(str(k), error, seconds) for k, (error, seconds) in enumerate(pairs)]
)


@given(RUNGS, FEW)
def test_the_front_is_monotone_and_dominates_the_rest_and_has_the_cheapest(rungs: list[Rung], target: float) -> None:
    whole = ladder(*rungs)
    best = whole.front
    assert all(a.time.median < b.time.median and a.error > b.error for a, b in pairwise(best))
    for each in rungs:
        other = whole.dominator(each)
        assert (other is None) == (each in best)
        if other is not None:
            assert other in best
            assert other.time.median <= each.time.median
            assert other.error <= each.error
    within = [each.time.median for each in rungs if each.error <= target]
    found = whole.cheapest(target)
    assert (found is None) == (not within)
    if found is not None:
        assert found.error <= target
        assert found.time.median == min(within)


def test_what_is_slow_runs_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("robodyn.measure.accuracy.ladder.SPREAD_ROUNDS", 2)
    monkeypatch.setattr("robodyn.measure.accuracy.ladder.CACHED", 0.01)
    calls: list[str] = []
    act = {"act": lambda: calls.append("run")}
    assert timed(act)["act"][1].runs == 2
    assert len(calls) == 5  # a short one fills the caches before each
    monkeypatch.setattr("robodyn.measure.accuracy.ladder.CACHED", 0.0)
    assert timed(act)["act"][1].runs == 2
    assert len(calls) == 8
    monkeypatch.setattr("robodyn.measure.accuracy.ladder.SLOW", 0.0)
    assert timed(act)["act"][1].runs == 1
    assert len(calls) == 9


TETRAHEDRON = np.array([(0, 0, 0), (5, 0, 0), (0, 4, 0), (0, 0, 3)], float)[
    np.array([(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)])
]


def test_ladder_of_a_tetrahedron() -> None:
    found = mesh_accuracy(from_array(TETRAHEDRON + 1 / 3))
    (ladder,) = found.ladders
    errors = {rung.name: rung.error for rung in ladder.rungs}
    assert errors["integral, exact rationals"] <= 2.0**-53
    assert errors["integral, float64"] < 16 * 2.0**-52
    assert errors["integral, escalated to float64"] == errors["integral, float64"]
    kinds = ("bounding box", "convex hull", "decimated", "columns", "winding numbers")
    assert all(any(kind in name for name in errors) for kind in kinds)
    assert 1e-12 < errors["integral, float32"] < 1e-6
    assert {rung.name: rung.errors[0] for rung in ladder.rungs}["bounding box"] == pytest.approx(5, rel=1e-14)
    assert errors["convex hull"] < 1e-15
    columns, chances = ([e for name, e in errors.items() if kind in name] for kind in kinds[-2:])
    assert columns[0] < 2e-2
    assert columns[1] < columns[0] / 4  # the error falls at least in proportion to the distance of columns
    assert chances[-1] < 3 * np.sqrt(5 / 10_000)  # a sixth of the box is inside
    assert [price.name for price in found.prices] == [
        *("proof that it is closed", "proof that it is one shell", "repair ladder", "tessellation error"),
        "symmetry",
    ]


def test_operations_are_those_of_the_kernel() -> None:
    sizes = {np.matmul: lambda a: 2 * a[0].size, np.add.reduce: lambda a: a[0].size, np.copyto: lambda a: 0}
    steps = volume_kernel(workspace(12, CHUNK).reshape(4, 3, CHUNK)).steps
    total = sum(sizes.get(function, lambda a: a[-1].size)(arguments) for function, arguments in steps)
    assert 9 + round(total / CHUNK) == OPERATIONS


@pytest.mark.parametrize("scale", [2.0**-50, 2.0**40])
def test_sizes_that_single_precision_cannot_hold(scale: float) -> None:
    found = mesh_accuracy(from_array((TETRAHEDRON + 1 / 3) * scale))
    errors = {rung.name: rung.error for rung in found.ladders[0].rungs}
    assert errors["integral, float64"] < 16 * 2.0**-52
    assert errors.get("integral, float32", 1.0) >= 0.1
    assert ("integral, float32" not in errors) == ("integral, float32: finds no volume" in found.notes)


def test_what_is_open_has_no_exact_reference() -> None:
    with pytest.raises(MeshError, match="no definite volume"):
        mesh_accuracy(from_array(TETRAHEDRON[:1]))


SCARA, MOTION = ROBOTS / "scara.urdf", str(ROBOTS / "scara_pick_and_place.csv")

pytest.importorskip("mpmath")


def test_scara() -> None:
    model = load(SCARA)
    found = file_accuracy(model, DEFAULT, MOTION)
    executors, derivatives, rates = found.ladders
    errors = {rung.name: rung.error for rung in executors.rungs}
    assert errors["numpy float64"] <= 1e-14
    assert 1e-12 < errors["numpy float32"] <= 1e-6
    assert errors["mpmath, 20 digits"] <= 1e-19
    assert errors["double-double"] <= 1e-29
    assert [rung.name.partition(",")[0] for rung in rates.rungs] == [
        *("every sample", "every 2nd", "every 4th", "every 8th")
    ]
    assert rates.rungs[0].error == 0.0 < rates.rungs[1].error
    assert {rung.operations for rung in executors.rungs} == {executors.rungs[0].operations}
    assert [rung.name for rung in derivatives.rungs] == ["auto", "spline", "savgol", "central"]
    with read_motion(MOTION, model) as reader:
        block = next(iter(reader.blocks()))
    tau = inverse_dynamics(model, block.q, block.qd, block.qdd)
    still = inverse_dynamics(model, block.q, block.qd, block.qdd, scene=replace(DEFAULT, gravity=(0.0, 0.0, 0.0)))
    gravity = found.effects[0]
    assert (gravity.name, gravity.unit, gravity.joint) == ("gravity", "N", "quill")
    assert gravity.torque == pytest.approx(np.abs(tau - still).max(), rel=1e-12)
    assert all(effect.saved >= 0 for effect in found.effects)


@pytest.mark.slow
def test_derived_accelerations_are_measured_on_a_motion_like_the_given_one() -> None:
    """With noise, methods that do not smooth are bad by a lot."""
    found = file_accuracy(load(ROBOTS / "puma.urdf"), DEFAULT, str(ROBOTS / "puma_encoder.csv"))
    derivatives = found.ladders[1]
    assert derivatives.reference == "a smooth motion like the given one, with noise of 1.5e-05 as in it"
    errors = {rung.name: rung.error for rung in derivatives.rungs}
    assert errors["auto"] < 1e-2 > errors["savgol"]
    assert errors["central"] > 1.0


@pytest.fixture
def spinning(tmp_path: Path):
    """A table of nine rows at these speeds of two joints."""

    def write(speed: float) -> str:
        path = tmp_path / "fast.csv"
        names = [f"{kind}_{joint}" for kind in ("q", "qd", "qdd") for joint in ("shoulder", "elbow", "quill")]
        rows = [f"{k / 100},0.1,0.2,0.3,{speed},{speed},0,0,0,0\n" for k in range(9)]
        path.write_text(f"time,{','.join(names)}\n{''.join(rows)}")
        return str(path)

    return write


def test_what_single_precision_cannot_hold_is_left_out(spinning) -> None:
    found = file_accuracy(load(SCARA), DEFAULT, spinning(1e30))
    assert "numpy float32: the torques overflow" in found.notes
    assert "numpy float64" in [rung.name for rung in found.ladders[0].rungs]
    with pytest.raises(InputError, match="overflow"):
        file_accuracy(load(SCARA), DEFAULT, spinning(1e200))
