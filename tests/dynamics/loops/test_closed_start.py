"""Where closed chains begin: what the scene gives stays, the rest is found, and loops that cannot close say so."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers.closed_chains import crank_slider, four_bars, spatial_loop

import robodyn
from robodyn.dynamics.initial_state import initial_state
from robodyn.dynamics.loops.closed_start import closed_start, independent_equations
from robodyn.dynamics.plan import plan
from robodyn.errors import InputError
from robodyn.scene.parts import Loop


def started(model, scene):
    """q and qd that a motion begins with, and the chain."""
    a_plan = plan(model, scene)
    state = closed_start(a_plan, initial_state(model, scene))
    return state[: model.nq], state[model.nq : model.nq + model.n], independent_equations(a_plan)


def test_given_coordinates_stay_and_the_others_are_found():
    model, scene = crank_slider()
    exact = scene.initial_q
    q, qd, chain = started(model, replace(scene, initial_q={"main": 0.7}))
    names = model.coordinates
    assert q[names.index("main")] == 0.7
    assert qd[names.index("main")] == 2.0
    found = dict(zip(names, q.tolist(), strict=True))
    reach = exact["rail"] - 0.3 * np.cos(0.7)
    assert abs(found["rail"] - 0.3 * np.cos(0.7)) == pytest.approx(reach, rel=1e-12)
    sample = chain.sample(q.tolist(), qd.tolist())
    assert np.abs(np.array(chain.equations(sample).error, dtype=float)).max() <= 1e-13
    assert np.abs(chain.jacobian(sample) @ qd).max() <= 1e-13


@pytest.mark.parametrize("kind", ["point", "hinge", "weld"])
def test_residual_of_spatial_loops(kind):
    q, _, chain = started(*spatial_loop(3, kind))
    sample = chain.sample(q.tolist(), (0.0,) * len(q))
    assert np.abs(np.array(chain.equations(sample).error, dtype=float)).max() <= 1e-13
    if kind == "weld":
        assert np.trace(chain.equations(sample).places[0].B) > -1
        turn = robodyn.programs.vectors.rotation_from_rpy(*chain.closures[0].loop.rpy)
        assert np.allclose(chain.equations(sample).places[0].B.astype(float), turn, atol=1e-12)


def test_what_had_to_change_is_said():
    model, scene = crank_slider()
    shifted = dict(scene.initial_q) | {"rail": scene.initial_q["rail"] + 0.01}
    result = robodyn.simulate(model, replace(scene, initial_q=shifted), 0.01)
    (note,) = [note for note in result.notes if note.startswith("the loops close only with other values than given: ")]
    assert "q rail " in note
    assert " -> " in note
    assert not [note for note in robodyn.simulate(model, scene, 0.01).notes if "loops close" in note]


def test_a_loop_that_is_out_of_reach():
    model, scene = crank_slider()
    loop = replace(scene.loops[0], to_point=(0.0, 0.0, 5.0))
    with pytest.raises(InputError, match=r'loop "pin" does not close: it is open by 5 m at the start'):
        started(model, replace(scene, loops=(loop,)))


def test_links_in_two_planes():
    model, scene = four_bars(1)
    loop = Loop("B1", "coupler0", (1, 0, 0), "crank1", (1, 0.01, 0))
    with pytest.raises(
        InputError, match=r'"B1" cannot close: it misses by 0.01 m along y of crank1, wherever the joints'
    ):
        started(model, replace(scene, loops=(loop,)))
    directions = ((1, 0, 0), (0, 0, 1))
    q, _, _ = started(model, replace(scene, loops=(replace(loop, directions=directions),)))
    assert np.allclose(q, [np.pi / 2, np.pi / 2, -np.pi / 2])


def test_forward_dynamics_is_of_open_trees():
    model, scene = four_bars(1)
    still = np.zeros(3)
    with pytest.raises(InputError, match="the scene closes loops"):
        robodyn.forward_dynamics(model, still, still, still, scene=scene)
    assert robodyn.mass_matrix(model, still, scene=scene).shape == (3, 3)
