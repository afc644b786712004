"""Configurations in which the loops hold less than elsewhere: refused, warned of, or told, never silent."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from helpers.closed_chains import bennett, crank_slider, four_bars, parallelogram
from helpers.report_text import simulation_text

import robodyn
from robodyn.errors import InputError
from robodyn.measure.accuracy.simulate_within import simulate_within
from robodyn.report.simulation import simulation_json, simulation_page

LEAVE = "the loops leave 2 degrees of freedom where the motion begins, and 1 nearby: "
WAYS = {"a": 1.0, "b": 1.0, "c": -1.0}, {"a": 1.0, "b": -3.0, "c": -3.0}


def test_speeds_that_no_motion_has_are_refused_with_those_that_one_has():
    """The energy of a parallelogram that lies flat drifted by 7 % and its motion depended on the step, silently.

    With a, b the speeds of the cranks and c that of the bar against its crank, r a + d (a + c) = r b holds the bar's
    end across, and r a^2 + d (a + c)^2 = r b^2 along x, so that (a + c) (d (a + c) + r (a + c) + 2 r a) = 0, d = 2 r.
    """
    model, scene = parallelogram(initial_qd={"a": 1.0})
    with pytest.raises(InputError, match=LEAVE + "with the speeds given they come apart at 0.36 m/s") as caught:
        robodyn.simulate(model, scene, 1.0)
    both = "a = 1, b = 1, c = -1; or a = 1, b = -3, c = -3"
    assert caught.value.remedy == f"begin a little away from there, or give all [initial] qd of one way on: {both}"


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
    found = robodyn.simulate(model, scene, 0.1)
    assert any(each.text.startswith(LEAVE) and "at rest none is marked" in each.text for each in found.caveats)
    asked = simulate_within(model, scene, 0.1, 1e-2)
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
    found = robodyn.simulate(*chain(), 1.0)
    assert found.loops.singular == ()
    assert found.loops.usual == found.loops.freedoms
    assert not any("ways part" in line for line in (*found.notes, *(each.text for each in found.caveats)))
