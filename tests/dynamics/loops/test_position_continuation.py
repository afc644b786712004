"""What loops imply of coordinates that are not given: closed forms, simulated motions, blocks, branches."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers.closed_chains import bennett, crank_slider, four_bars, parallelogram, spatial_loop
from helpers.small_robots import built, joint, link

import robodyn
from robodyn.dynamics.loops.position_continuation import Follow
from robodyn.dynamics.plan import plan
from robodyn.errors import InputError, TrajectoryError
from robodyn.scene.scene import Loop, Scene

CRANK, ROD = 0.3, 0.8


def follow(model, scene, followed, q, qd=None, qdd=None, time=None, blocks=None):
    """The follower, and q, qd and qdd that it completes; entries of joints that follow are blanked first.

    Args:
        q, qd, qdd: by coordinate and rate, (N,) each; what is not there is zero. blocks: samples in each.
    """
    N = len(next(iter(q.values())))
    time = np.linspace(0.0, 1.0, N) if time is None else time
    whole = []
    for given, names in ((q, model.coordinates), (qd or {}, model.rates), (qdd or {}, model.rates)):
        whole.append(np.stack([given.get(n, np.zeros(N)) * (n.split("_")[0] not in followed) for n in names], axis=1))
    follower = Follow(plan(model, scene), followed)
    parts = [
        follower.take(time[k : k + (blocks or N)], *(each[k : k + (blocks or N)] for each in whole), first_row=k + 1)
        for k in range(0, N, blocks or N)
    ]
    return follower, *(np.concatenate([part[i] for part in parts]) for i in range(3))


def begun(robot, **q):
    model, scene = robot
    return model, replace(scene, initial_q=q)


def named(model, q, qd, qdd):
    return (
        dict(zip(model.coordinates, q.T, strict=True)),
        dict(zip(model.rates, qd.T, strict=True)),
        dict(zip(model.rates, qdd.T, strict=True)),
    )


def slider(th):
    """q of the slider-crank by the angle of its crank."""
    tilt = np.arcsin(CRANK * np.sin(th) / ROD)
    return {"main": th, "rail": CRANK * np.cos(th) + ROD * np.cos(tilt), "big_end": -tilt - th}


@pytest.mark.parametrize(("rows", "turn"), [(4, 2.0 * np.pi), (300, 20.0)])
def test_few_rows_of_full_turns(rows, turn):
    """Whose stamps may jump by a turn, as those of continuous joints do."""
    model, scene = crank_slider()
    th = 0.7 + np.linspace(0.0, turn, rows)
    q = slider(th)
    stamped = (th + np.pi) % (2 * np.pi) - np.pi if turn > 7.0 else th
    _, found, _, _ = follow(model, scene, ("rail", "big_end"), {"main": stamped})
    assert np.abs(found[:, model.coordinates.index("rail")] - q["rail"]).max() <= 1e-13
    assert np.abs(found[:, model.coordinates.index("big_end")] - q["big_end"]).max() <= 1e-12


def test_which_way_is_taken_where_the_scene_does_not_say_it():
    th = np.linspace(0.7, 0.9, 3)
    follower, q, _, _ = follow(*begun(crank_slider()), ("rail", "big_end"), {"main": th})
    assert np.abs(q[:, follower.plan.model.coordinates.index("rail")] - slider(th)["rail"]).max() <= 1e-13
    (note,) = follower.notes
    assert note.startswith("the loops close in 2 ways or more at the first row: taken is rail = 1.006, ")


def test_both_branches_of_a_slider_are_kept():
    """Given the slider, the crank may stand on either side; the scene says on which."""
    model, scene = crank_slider()
    x = 0.9 + 0.15 * np.sin(np.linspace(0.0, 6.0, 60))
    for side in (1.0, -1.0):
        _, there = begun((model, scene), rail=0.9, main=1.0 * side, big_end=-1.4 * side)
        _, q, _, _ = follow(model, there, ("main", "big_end"), {"rail": x})
        exact = np.arccos((x**2 + CRANK**2 - ROD**2) / (2 * CRANK * x))
        assert np.abs(q[:, model.coordinates.index("main")] - side * exact).max() <= 1e-12


def simulated(model, scene, duration=0.1):
    run = robodyn.simulate(model, scene, duration)
    return run.time, (run.q, run.qd, run.qdd)


SIMULATED = [
    pytest.param(four_bars(2), ("c0", "k1", "c1", "k2"), id="four-bars"),
    *(
        pytest.param(*each, id=name, marks=pytest.mark.slow)
        for name, each in {
            "Bennett": (bennett(), ("j2", "j3")),
            "free base": (spatial_loop(1, "point", moving_base=True), ("ja0", "ja2", "jb1")),
            "hinge": (spatial_loop(2, "hinge"), ("ja0", "ja1", "ja2", "ja3", "jb0")),
            "weld": (spatial_loop(1, "weld"), ("ja0", "ja1", "ja2", "ja3", "jb0", "jb1")),
            "base that follows": (spatial_loop(4, "weld", moving_base=True, to="ground"), ("base",)),
        }.items()
    ),
]


@pytest.mark.parametrize(("robot", "followed"), SIMULATED)
def test_simulated_motions_come_back(robot, followed):
    model, scene = robot
    time, arrays = simulated(model, scene)
    follower, *found = follow(model, scene, followed, *named(model, *arrays), time=time)
    for values, exact in zip(found, arrays, strict=True):
        assert np.abs(values - exact).max() <= 1e-12 * np.abs(exact).max()
    assert follower.caveats == ()


def test_blocks_do_not_matter():
    """With as many coordinates as are needed, and with one more."""
    model, scene = four_bars(2)
    time, arrays = simulated(model, scene, 0.03)
    given = named(model, *arrays)
    for followed in (("c0", "k1", "c1", "k2"), ("c0", "c1", "k2")):
        _, *whole = follow(model, scene, followed, *given, time=time)
        follower, *parts = follow(model, scene, followed, *given, time=time, blocks=7)
        for a, b in zip(whole, parts, strict=True):
            assert np.abs(a - b).max() <= 1e-13 * np.abs(a).max()
        assert len(follower.misfits) == 3


def test_ways_that_part_between_rows_are_passed_straight_on():
    """A parallelogram that turns fully lies flat twice; it remains one."""
    model, scene = begun(parallelogram(), a=0.3, b=0.3, c=-0.3)
    th = 0.3 + np.linspace(0.0, 2.0 * np.pi, 20)
    follower, q, _, _ = follow(model, scene, ("b", "c"), {"a": th})
    assert np.abs(q[:, model.coordinates.index("b")] - th).max() <= 1e-12
    assert np.abs(q[:, model.coordinates.index("c")] + th).max() <= 1e-12
    (caveat,) = follower.caveats
    assert "singular where the motion passes at 0.4474, 0.9737 s (2 in all)" in caveat.text


def test_error_bars_are_those_of_the_rates_they_come_of():
    """a_d = D a_g + ...: by differences of the given acceleration."""
    model, scene = four_bars(1)
    time, arrays = simulated(model, scene, 0.05)
    q, qd, qdd = (each.copy() for each in arrays)
    bar = np.zeros_like(qdd)
    bar[:, model.rates.index("k0")] = 0.25
    whole = Follow(plan(model, scene), ("k1", "c0")).take(time, q, qd, qdd, [bar])
    qdd[:, model.rates.index("k0")] += 0.25
    more = Follow(plan(model, scene), ("k1", "c0")).take(time, q, qd, qdd)
    assert np.abs(whole.bars[0] - np.abs(more.qdd - whole.qdd)).max() <= 1e-12


def test_joints_that_mimic_follow_with_their_master():
    """A rhombus whose right half mimics the left: one coordinate is given, one follows, b = pi - 2 a."""
    turn = (0, -1, 0)
    parts = [
        link("frame"),
        *(link(name, 1.0) for name in ("left", "left_up", "right", "right_up")),
        joint("a", "frame", "left", "continuous", turn),
        joint("b", "left", "left_up", "continuous", turn, (1, 0, 0)),
        joint("c", "frame", "right", "continuous", turn, more=f'<mimic joint="a" multiplier="-1" offset="{np.pi!r}"/>'),
        joint("d", "right", "right_up", "continuous", turn, (1, 0, 0), more='<mimic joint="b" multiplier="-1"/>'),
    ]
    loop = Loop("top", "left_up", (1, 0, 0), "right_up", (1, 0, 0))
    model = built(*parts)
    scene = Scene(loops=(loop,), initial_q={"a": 0.5, "b": 2.0})
    a = np.linspace(0.5, 1.0, 30)
    _, q, qd, _ = follow(model, scene, ("b",), {"a": a}, {"a": np.ones(30)})
    assert np.abs(q[:, 1] - (np.pi - 2.0 * a)).max() <= 1e-13
    assert np.abs(qd[:, 1] + 2.0).max() <= 1e-13


def test_noise_of_encoders_is_followed():
    """1e-3 rad in every row, 10 000 rows: each is closed by itself, and the branch is kept."""
    model, scene = crank_slider()
    th = 0.7 + np.linspace(0.0, 3.0, 2_000) + np.random.default_rng(0).normal(size=2_000) * 1e-3
    exact = slider(th)
    _, q, _, _ = follow(model, scene, ("rail", "big_end"), {"main": th})
    assert np.abs(q[:, model.coordinates.index("rail")] - exact["rail"]).max() <= 1e-13
    noisy = {name: values + np.random.default_rng(1).normal(size=2_000) * 4e-4 for name, values in exact.items()}
    follower, *_ = follow(model, scene, (), noisy)
    assert "is open by up to 0.002" in follower.notes[0]


SLIDER, BARS = ("main", "big_end"), ("c0", "k1", "c1", "k2", "k0")
NONE, FREE = {"none": np.zeros(3)}, "1 freedom of the loops follows from no column"
REFUSED = {
    'row 34, 0.673469 s: loop "pin" misses by 0.00204 m at least with q_rail = 1.10204, out of': (
        (crank_slider(), SLIDER, {"rail": np.linspace(0.9, 1.2, 50)}),
        "(correct these columns, the loop's points or the links' lengths)",
    ),
    'row 1, 0 s: loop "pin" misses by 0.15 m at least with q_rail = 1.25': (
        (crank_slider(), SLIDER, {"rail": np.full(3, 1.25)}),
        "",
    ),
    "row 50, 1 s: the loops are singular, so that q_main, q_big_end do not follow": (
        (crank_slider(), SLIDER, {"rail": np.linspace(0.9, 1.1, 50)}),
        "",
    ),
    "row 1, 0 s: the loops are singular, so that q_b": (
        (parallelogram(), ("b", "c"), {"a": np.linspace(0.0, -0.6, 31)}),
        "give q_b or q_c as well",
    ),
    "row 16, 0.5 s: the loops are singular, so that q_b": (
        (begun(parallelogram(), a=0.3, b=0.3, c=-0.3), ("b", "c"), {"a": np.linspace(0.3, -0.3, 31)}),
        "give q_b or q_c as well",
    ),
    FREE: ((bennett(), ("j1", "j2", "j3"), NONE), ""),
    f"{FREE} ": ((four_bars(2), BARS, NONE), "give q_k0, or one of q_k1, q_k2"),
    f"{FREE}  ": (
        (crank_slider(actuated=("rail",)), ("rail", *SLIDER), NONE),
        "(give q_rail, or one of q_main, q_big_end)",
    ),
}


@pytest.mark.parametrize("start", REFUSED)
def test_what_is_refused(start):
    (robot, followed, q), more = REFUSED[start]
    with pytest.raises(InputError) as caught:
        follow(*robot, followed, q)
    text = str(caught.value)
    assert "\n" not in text
    assert start.strip() in text
    assert more in text


def test_a_joint_of_no_loop():
    model, scene = bennett(link("arm", 1.0), joint("lone", "l0", "arm"))
    with pytest.raises(TrajectoryError, match="no column says where 'lone' is, and it is in no loop"):
        Follow(plan(model, scene), ("lone",))


@pytest.mark.parametrize("followed", [(), ("main",)])
def test_columns_that_contradict_each_other(followed):
    model, scene = crank_slider()
    q = {name: np.full(5, scene.initial_q[name]) for name in model.coordinates}
    exact, *_ = follow(model, scene, followed, q)
    assert exact.misfits[0].size <= 1e-15
    assert exact.notes == ()
    near = q | {"rail": q["rail"] + np.array([0.0, 0.0, 2e-3, 1e-3, 0.0])}
    kept, *_ = follow(model, scene, followed, near)
    (misfit, *_) = kept.misfits
    assert (misfit.loop, misfit.unit, misfit.time) == ("pin", "m", 0.5)
    assert kept.notes == ('loop "pin" is open by up to 0.002 m (0.5 s)',)
    assert misfit.size == pytest.approx(2e-3, rel=1e-9)  # the crank moves the pin across the slide
    far = q | {"rail": q["rail"] + np.array([0.0, 0.0, 0.0, 0.02, 0.0])}
    with pytest.raises(InputError) as caught:
        follow(model, scene, followed, far)
    text = str(caught.value)
    assert text.startswith('row 4, 0.75 s: loop "pin" is open by 0.0')
    assert "with these columns, more than 0.008 m (correct the columns, or leave some out" in text


def test_rates_that_do_not_go_with_the_loops_are_in_doubt():
    model, scene = crank_slider()
    q = {name: np.full(5, scene.initial_q[name]) for name in model.coordinates}
    follower, *_ = follow(model, scene, (), q, {"main": np.full(5, 2.0)})
    said = [caveat.text for caveat in follower.caveats]
    assert any(each.startswith('the velocities given open loop "pin" at ') for each in said)
    assert follower.misfits[1].unit == "m/s"
    follower, *_ = follow(model, scene, ("big_end",), q | {"main": q["main"]}, {})
    assert follower.caveats == ()
