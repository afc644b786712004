"""Where closed chains begin and where loops hold less than elsewhere: found, refused or told, never silent."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from helpers.closed_chains import bennett, crank_slider, four_bars, parallelogram, spatial_loop
from helpers.report_text import simulation_text

import robodyn
from robodyn.dynamics.initial_state import closed_start, independent_equations, initial_state
from robodyn.dynamics.plan import plan
from robodyn.errors import InputError
from robodyn.measure.accuracy.simulate_within import simulate_within
from robodyn.report.simulation import simulation_json, simulation_page
from robodyn.scene.scene import Loop

LEAVE = "the loops leave 2 degrees of freedom where the motion begins, and 1 nearby: "
WAYS = {"a": 1.0, "b": 1.0, "c": -1.0}, {"a": 1.0, "b": -3.0, "c": -3.0}


def test_speeds_that_no_motion_has_are_refused():
    """The energy of a parallelogram that lies flat drifted by 7 % and its motion depended on the step, silently.

    With a, b the speeds of the cranks and c that of the bar against its crank, r a + d (a + c) = r b holds the bar's
    end across, and r a^2 + d (a + c)^2 = r b^2 along x, so that (a + c) (d (a + c) + r (a + c) + 2 r a) = 0, d = 2 r.
    """
    model, scene = parallelogram(initial_qd={"a": 1.0})
    with pytest.raises(InputError, match=LEAVE + "with the speeds given they come apart at 0.36 m/s") as caught:
        robodyn.simulate(model, scene, 1.0)
    assert caught.value.remedy == "begin a little away from there, or give all [initial] qd of one way on"


@pytest.mark.parametrize("speeds", WAYS)
def test_speeds_along_one_way_are_followed_and_the_reports_say_what_is_assumed(speeds):
    model, scene = parallelogram(initial_qd=speeds)
    found = robodyn.simulate(model, scene, 0.05, step=1e-4)
    assert found.qd[0].tolist() == pytest.approx(list(speeds.values()))
    assert found.energy_drift <= 2e-4
    (caveat,) = [each for each in found.caveats if each.text.startswith(LEAVE)]
    assert "ways part there, and which one is taken is assumed (they follow the speeds given" in caveat.text
    assert f"warning: {caveat.text}" in simulation_text(found)
    document = json.loads(simulation_json(found))
    assert caveat.text in document["warnings"]
    assert (document["loops"]["freedoms"], document["loops"]["usual_freedoms"]) == (2, 1)
    assert document["loops"]["singular"][0] == {"time": 0.0, "freedoms": 2}
    assert document["within_limits"] is None
    assert caveat.text in str(simulation_page(found, pictures=False))


def test_at_rest_no_way_is_marked():
    model, scene = parallelogram()
    found = robodyn.simulate(model, scene, 0.05)
    assert any(each.text.startswith(LEAVE) and "at rest none is marked" in each.text for each in found.caveats)
    asked = simulate_within(model, scene, 0.05, 1e-2)
    assert any(each.text.startswith(LEAVE) for each in asked.caveats)
    off = replace(scene, initial_q={"a": 0.1}, initial_qd={"a": 1.0})
    assert not any("the loops" in each.text for each in robodyn.simulate(model, off, 0.01).caveats)


@pytest.mark.parametrize("count", [1, 2])
def test_passing_is_told_with_its_times(count):
    """Cranks that all point along x: all loops are flat at once."""
    model, scene = four_bars(count)
    found = robodyn.simulate(model, scene, 3.0, step=2e-3)
    crank = np.sin(found.q[:, 0])
    k = np.flatnonzero(np.sign(crank[1:]) != np.sign(crank[:-1]))
    expected = found.time[k] + (found.time[k + 1] - found.time[k]) * crank[k] / (crank[k] - crank[k + 1])
    times = [each.time for each in found.loops.singular]
    assert len(times) == 3
    assert np.abs(np.array(times) - expected).max() <= 1e-5
    assert {each.freedoms for each in found.loops.singular} == {1 + count}
    (note,) = [note for note in found.notes if note.startswith("the loops leave up to ")]
    shown = ", ".join(f"{time:.4g}" for time in times)
    assert f"up to {1 + count} degrees of freedom, and 1 elsewhere, where the motion passes at {shown} s" in note
    assert not found.caveats or "ways part" not in found.caveats[0].text


@pytest.mark.parametrize("chain", [crank_slider, bennett], ids=lambda chain: chain.__name__)
def test_loops_that_keep_their_rank_are_not_accused(chain):
    found = robodyn.simulate(*chain(), 0.3)
    assert found.loops.singular == ()
    assert found.loops.usual == found.loops.freedoms
    assert not any("ways part" in line for line in (*found.notes, *(each.text for each in found.caveats)))


def started(model, scene):
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


def test_welds_close_without_half_a_turn():
    q, _, chain = started(*spatial_loop(3, "weld"))
    here = chain.equations(chain.sample(q.tolist(), (0.0,) * len(q)))
    assert np.abs(np.array(here.error, dtype=float)).max() <= 1e-13
    turn = robodyn.programs.vectors.rotation_from_rpy(*chain.closures[0].loop.rpy)
    assert np.allclose(here.places[0].B.astype(float), turn, atol=1e-12)


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
