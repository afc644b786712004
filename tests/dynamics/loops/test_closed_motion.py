"""Motions of closed chains: IFToMM's A02, a crank-slider cut at either pin, and what stays as it was."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from helpers.closed_chains import bennett, crank_slider, four_bars
from helpers.small_robots import built, joint, link

import robodyn
from robodyn.errors import InputError
from robodyn.scene.scene import Loop, Scene

REFERENCE = Path(__file__).parents[2] / "data" / "reference" / "a02_reference.json"
ENERGY_BAR = 0.1
"""J over 10 s, of the benchmark."""


def errors(count, step, **more):
    """Errors of B0 at the times of the exact reduction to one freedom, rows of t, x, z, vx, vz, and the motion."""
    model, scene = four_bars(count)
    result = robodyn.simulate(model, scene, 20.0, step=step, **more)
    rows = []
    for t, *expected in np.array(json.loads(REFERENCE.read_text())["data"][f"N={count}"]["rows"], dtype=float):
        k = round(t / step)
        th, w = result.q[k, 0], result.qd[k, 0]
        rows.append(np.abs(np.array((np.cos(th), np.sin(th), -np.sin(th) * w, np.cos(th) * w)) - expected).max())
    return rows, result


@pytest.mark.parametrize(
    ("count", "step", "bar"), [(2, 2e-3, 1e-8), pytest.param(40, 2e-3, 1e-4, marks=pytest.mark.slow)]
)
def test_four_bars_through_their_flat_configuration(count, step, bar):
    found, result = errors(count, step)
    assert max(found) <= bar
    assert np.abs(result.figures.energy - result.figures.energy[0])[: round(10 / step) + 1].max() <= 1e-2 * ENERGY_BAR
    assert result.loops.gap.max() <= 1e-9
    assert result.loops.slip.max() <= 1e-6
    assert result.loops.freedoms == 1
    assert (result.loops.equations, len(result.loops.dropped), result.loops.rank) == (3 * count, count, 2 * count)


def test_a_step_that_begins_exactly_where_the_equations_depend_on_each_other():
    """Laid flat at rest the four-bars may fall either way, and no number overflows."""
    model, scene = four_bars(2)
    flat = dict.fromkeys(scene.initial_q, 0.0)
    start = Scene(loops=scene.loops, initial_q=flat, initial_qd={})
    result = robodyn.simulate(model, start, 1.0)
    assert result.loops.rank == 2
    assert result.energy_drift <= 1e-4
    assert result.loops.gap.max() <= 1e-9


def test_a_crank_slider_moves_alike_wherever_it_is_cut():
    one, other = (robodyn.simulate(*crank_slider(cut=cut), 1.0, step=5e-4) for cut in ("small_end", "big_end"))
    assert np.abs(one.q[:, 0] - other.q[:, 0]).max() <= 1e-9
    assert np.abs(one.qd[:, 0] - other.qd[:, 0]).max() <= 1e-8
    for result in (one, other):
        assert result.loops.freedoms == 1
        assert result.loops.gap.max() <= 1e-14
        assert result.energy_drift <= 1e-9


@cache
def moved(step, method="gauss4"):
    return robodyn.simulate(*crank_slider(), 0.48, step=step, method=method).q[-1, 0]


@pytest.mark.parametrize(
    ("method", "order"),
    [("rk4", 4), pytest.param("gauss4", 4, marks=pytest.mark.slow), ("midpoint", 2), ("symplectic-euler", 1)],
)
def test_orders_of_methods(method, order):
    exact = moved(1e-3)
    ratio = (moved(8e-3, method) - exact) / (moved(4e-3, method) - exact)
    assert 0.7 * 2**order <= ratio <= 1.35 * 2**order


def test_a_free_closed_chain_keeps_its_momenta_and_energy():
    rod, turn = (1.0, (0.5, 0, 0.1), (0.01, 0, 0, 1 / 12, 0, 1 / 12)), (0, -1, 0)
    parts = [link("frame", 2.0, (0.4, 0.1, 0.2), (0.3, 0.02, 0.01, 0.5, 0.03, 0.4))]
    for name, parent, place in (("a", "frame", 0), ("b", "a", 1), ("c", "b", 1)):
        parts += [link(name, *rod), joint(f"j{name}", parent, name, "continuous", turn, (place, 0, 0))]
    model = built(*parts, moving_base=True)
    scene = Scene(
        loops=(Loop("tie", "c", (1, 0, 0), "frame", (1.5, 0, 0), "hinge", axis=turn, to_axis=turn),),
        initial_q={"ja": 1.2, "jb": -1.0},
        initial_qd={"base_wx": 0.7, "base_wz": -0.4, "base_vx": 0.3, "ja": 2.0},
        moving_base=True,
    )
    result = robodyn.simulate(model, scene, 0.3)
    linear, angular = result.momentum_drift
    assert linear <= 1e-9
    assert angular <= 1e-9
    assert result.energy_drift <= 1e-9
    assert result.loops.gap.max() <= 1e-13
    assert result.loops.slip.max() <= 1e-12
    assert len(result.loops.dropped) == 3


def test_a_linkage_that_moves_though_it_should_not():
    """Bennett's: five equations for three hinges, of which two count; opposite hinges turn by opposite angles."""
    model, scene = bennett()
    result = robodyn.simulate(model, scene, 0.25, step=5e-4)
    assert (len(result.loops.dropped), result.loops.rank, result.loops.freedoms) == (3, 2, 1)
    assert np.abs(result.q[:, 0] + result.q[:, 2]).max() <= 1e-9
    assert result.energy_drift <= 1e-6
    ratio = np.sin((1.1 + 0.6) / 2) / np.sin((1.1 - 0.6) / 2)
    products = np.tan(result.q[:, 0] / 2) * np.tan(result.q[:, 1] / 2)
    assert np.abs(products - ratio).max() <= 1e-8 * ratio


def test_adaptive_methods_follow_too():
    model, scene = crank_slider(baumgarte=20.0)
    result = robodyn.simulate(model, scene, 0.48, rtol=1e-11)
    assert np.abs(result.q[-1, 0] - moved(1e-3)) <= 1e-8
    loose = robodyn.simulate(*crank_slider(), 0.48, rtol=1e-9)
    assert loose.loops.stabilised.startswith("not stabilised")
    assert 1e-14 < loose.loops.gap.max() <= 1e-6


def test_rollouts_of_states_on_the_loops():
    model, scene = crank_slider()
    alone = robodyn.simulate(model, scene, 0.1, executor="compiled")
    q, qd = np.repeat(alone.q[:1], 3, axis=0), np.repeat(alone.qd[:1], 3, axis=0)
    many = robodyn.rollouts(model, q, qd, 100, 1e-3, scene=scene, every=100)
    assert np.abs(many.q[-1] - alone.q[-1]).max() <= 1e-13
    q[1, 0] += 0.1
    with pytest.raises(InputError, match="row 1 misses the loops by 0"):
        robodyn.rollouts(model, q, qd, 100, 1e-3, scene=scene)


@pytest.mark.slow
def test_redundancy_is_judged_where_a_column_of_the_table_begins():
    """Two rods in line, as they are at zero, cannot bend to close their loop, so that nothing can be judged there."""
    rod = 1.0, (0.25, 0, 0), (0.01, 0, 0, 0.02, 0, 0.02)
    rods = link("r1", *rod), link("r2", *rod), joint("k1", "l0", "r1"), joint("k2", "r1", "r2", xyz=(0.5, 0, 0))
    model, scene = bennett(*rods)
    tie = Loop("tie", "r2", (0.5, 0, 0), to_point=(0.6, 0, 0))
    scene = replace(scene, loops=(*scene.loops, tie), initial_q={**scene.initial_q, "k1": 1.0, "k2": -2.0})
    table = {"time": [0.0, 1.0], **{name: [x, 0.0] for name, x in scene.initial_q.items()}, "rate": [3.0, 0.0]}
    named = replace(scene, initial_q={name: name for name in scene.initial_q}, initial_qd={"j1": "rate"})
    how = {"executor": "numpy", "step": 1e-3}
    result = robodyn.simulate(model, named, 3e-3, table=table, **how)
    expected = robodyn.simulate(model, scene, 3e-3, **how)
    assert result.loops.dropped == expected.loops.dropped
    assert sum(name.startswith("pin") for name in expected.loops.dropped) == 3
    np.testing.assert_array_equal(result.q, expected.q)
    bare = replace(scene, initial_q={}, initial_qd={})
    many = robodyn.rollouts(model, expected.q[:1], expected.qd[:1], 3, 1e-3, scene=bare, executor="numpy")
    assert np.abs(many.q[-1] - expected.q[-1]).max() <= 1e-12
