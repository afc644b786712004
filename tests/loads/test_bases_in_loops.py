"""Robots whose base moves and is held by loops to the ground: the loops bear what a fixed base would."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.command_line import ROBOTS

import robodyn

TIME = np.linspace(0.0, 2.0, 41)
ARRAYS = np.stack([np.sin(TIME) ** 2, TIME**3 / 9.0], axis=1)


def moving(joints: np.ndarray, base: np.ndarray | None = None):
    """q of a base that stays at its place, or turns as base has it, and of joints."""
    still = np.tile([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], (len(joints), 1)) if base is None else base
    return np.hstack((still, joints))


def test_bolts_bear_the_wrench_of_a_fixed_base():
    bolt = robodyn.Loop("bolt", "bus", kind="weld")
    scene, fixed = robodyn.Scene(moving_base=True, loops=(bolt,)), robodyn.Scene()
    tables: list[np.ndarray] = []
    model = robodyn.load(ROBOTS / "satellite.urdf", moving_base=True)
    sinks = [lambda time, rows: tables.append(rows)]
    result = robodyn.torques(model, robodyn.motion(model, TIME, moving(ARRAYS), scene=scene), scene, sinks=sinks)
    model = robodyn.load(ROBOTS / "satellite.urdf")
    robodyn.torques(model, robodyn.motion(model, TIME, ARRAYS), fixed, sinks=sinks, reactions=True)
    bolted, base = tables
    scale = np.abs(base).max()
    np.testing.assert_allclose(bolted[:, :8], base[:, :8], rtol=0, atol=1e-12 * scale)
    assert scale > 900.0
    found = result.constraints
    assert found is not None
    assert (found.rank, found.freedoms, found.unbalanced) == (6, 2, ())
    assert found.loops[0].determined
    assert not any("ground holds the base" in said for said in result.warnings)
    assert max(result.checks.first_law, result.checks.second_law) < 1e-12


def test_what_a_ball_does_not_hold_is_told_of_the_base():
    """A plate on a ball beside its middle would fall: m g of the middle's arm is missing."""
    ball = robodyn.Loop("ball", "plate", point=(0.1, 0.0, 0.0), to_point=(0.1, 0.0, 0.0))
    scene = robodyn.Scene(moving_base=True, loops=(ball,))
    model = robodyn.load(ROBOTS / "rigid_body.urdf", moving_base=True)
    result = robodyn.torques(model, robodyn.motion(model, TIME, moving(np.zeros((41, 0))), scene=scene), scene)
    found = result.constraints
    assert found is not None
    assert found.freedoms == 3
    assert {each.name for each in found.unbalanced} == {"base_wy", "base_vz"}
    assert result.within_limits is None
    assert not any("ground holds the base" in said for said in result.warnings)
    lever = 8.0 * 0.1  # the remainder is least with moments in units of 1/8 N m, as equilibration by powers of 2 has it
    assert found.loops[0].force.value == pytest.approx(model.total_mass * 9.81 / (1.0 + lever**2), rel=1e-12)
