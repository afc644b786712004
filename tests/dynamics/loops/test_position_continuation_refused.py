"""Motions of closed chains that cannot be: each is refused in one line with row, number and remedy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers.closed_chains import bennett, crank_slider, four_bars, parallelogram
from helpers.followed import follow
from helpers.small_robots import joint, link

from robodyn.dynamics.loops.position_continuation import Follow
from robodyn.dynamics.plan import plan
from robodyn.errors import InputError, TrajectoryError

OTHERS = ("main", "big_end")


def refused(robot, followed, q, **more):
    with pytest.raises(InputError) as caught:
        follow(*robot, followed, q, **more)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_a_slider_beyond_its_dead_centre():
    """The loop closes up to 1.1 m; at row k of 50 the slider is at 0.9 + 0.3 k / 49."""
    text = refused(crank_slider(), OTHERS, {"rail": np.linspace(0.9, 1.2, 50)})
    assert text.startswith('row 34, 0.673469 s: loop "pin" misses by 0.00204 m at least with q_rail = 1.10204, out of')
    assert "(correct these columns, the loop's points or the links' lengths)" in text


def test_a_first_row_that_is_out_of_reach():
    text = refused(crank_slider(), OTHERS, {"rail": np.full(3, 1.25)})
    assert text.startswith('row 1, 0 s: loop "pin" misses by 0.15 m at least with q_rail = 1.25')


def test_a_row_at_a_dead_centre():
    text = refused(crank_slider(), OTHERS, {"rail": np.linspace(0.9, 1.1, 50)})
    assert text.startswith("row 50, 1 s: the loops are singular, so that q_main, q_big_end do not follow")


@pytest.mark.parametrize("first", [0.3, 0.0], ids=["on the way", "at first"])
def test_a_parallelogram_that_lies_flat_in_a_row(first):
    model, scene = parallelogram()
    begun = replace(scene, initial_q={"a": first, "b": first, "c": -first})
    text = refused((model, begun), ("b", "c"), {"a": np.linspace(first, first - 0.6, 31)})
    assert text.startswith(f"row {16 if first else 1}, {0.5 if first else 0:g} s: the loops are singular, so that q_b")
    assert "give q_b or q_c as well" in text


@pytest.mark.parametrize(
    ("robot", "followed", "said"),
    [
        (crank_slider(), ("main", "rail", "big_end"), "1 freedom of the loops follows from no column"),
        (bennett(), ("j1", "j2", "j3"), "1 freedom of the loops follows from no column"),
        (four_bars(2), ("c0", "k1", "c1", "k2", "k0"), "give q_k0, or one of q_k1, q_k2"),
    ],
    ids=["slider-crank", "Bennett", "four-bars"],
)
def test_too_few_columns(robot, followed, said):
    assert said in refused(robot, followed, {"none": np.zeros(3)})


def test_columns_of_drives_are_asked_for():
    model, scene = crank_slider()
    text = refused((model, replace(scene, actuated=("rail",))), ("main", "rail", "big_end"), {"none": np.zeros(3)})
    assert "(give q_rail, or one of q_main, q_big_end)" in text


def test_a_joint_of_no_loop():
    model, scene = bennett(link("arm", 1.0), joint("lone", "l0", "arm"))
    with pytest.raises(TrajectoryError, match="no column says where 'lone' is, and it is in no loop"):
        Follow(plan(model, scene), ("lone",))


@pytest.mark.parametrize("followed", [(), ("main",)], ids=["all given", "one follows"])
def test_columns_that_contradict_each_other(followed):
    model, scene = crank_slider()
    q = {name: np.full(5, scene.initial_q[name]) for name in model.coordinates}
    exact, *_ = follow(model, scene, followed, q)
    assert exact.mismatch[0].size <= 1e-15
    assert exact.notes == ()
    near = q | {"rail": q["rail"] + np.array([0.0, 0.0, 2e-3, 1e-3, 0.0])}
    kept, *_ = follow(model, scene, followed, near)
    (misfit, *_) = kept.mismatch
    assert (misfit.loop, misfit.unit, misfit.time) == ("pin", "m", 0.5)
    assert kept.notes == ('loop "pin" is open by up to 0.002 m (0.5 s)',)
    assert misfit.size == pytest.approx(2e-3, rel=1e-9)  # the crank moves the pin across the slide
    far = q | {"rail": q["rail"] + np.array([0.0, 0.0, 0.0, 0.02, 0.0])}
    text = refused((model, scene), followed, far)
    assert text.startswith('row 4, 0.75 s: loop "pin" is open by 0.0')
    assert "with these columns, more than 0.008 m (correct the columns, or leave some out" in text


def test_rates_that_do_not_go_with_the_loops_are_in_doubt():
    model, scene = crank_slider()
    q = {name: np.full(5, scene.initial_q[name]) for name in model.coordinates}
    follower, *_ = follow(model, scene, (), q, {"main": np.full(5, 2.0)})
    said = [caveat.text for caveat in follower.caveats]
    assert any(each.startswith('the velocities given open loop "pin" at ') for each in said)
    assert follower.mismatch[1].unit == "m/s"
    follower, *_ = follow(model, scene, OTHERS[1:], q | {"main": q["main"]}, {})
    assert follower.caveats == ()
