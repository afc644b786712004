"""Closed chains by the DAE form: against `dynamics.loops`, in the coordinates that loops leave, and cut open."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers.closed_chains import branch, crank_slider, four_bars, spatial_loop
from helpers.oracles import worst
from helpers.single_bodies import HINGE, NEAR, four_bar
from helpers.small_robots import body_numbers, built, joint, link

import robodyn
from robodyn.equations.dae.dae import dae
from robodyn.errors import InputError
from robodyn.scene.scene import Loop, Scene


def torques(model, seed=0):
    found = zip(model.rates, np.random.default_rng(seed).normal(size=model.n).tolist(), strict=True)
    return {name: x for name, x in found if not name.startswith("base_")}


def agrees(found):
    """With `robodyn.dynamics.loops`: accelerations, and forces at all joints."""
    both = found.comparison
    assert max(both.accelerations, both.forces, both.moments) <= 1e-12
    assert max(step.error for step in found.steps) <= 1e-13
    assert np.abs(found.residuals.places).max() <= 1e-13 * max(found.system.length, 1.0)


@pytest.mark.parametrize(("kind", "free"), [("point", True), ("hinge", False), ("weld", False)])
def test_loops_in_space(kind, free):
    model, scene = spatial_loop(4, kind, free)
    last = model.joint_names[-1]
    found = dae(model, scene, at={last: 0.3}, qd={last: 1.0}, tau=torques(model))
    assert found.counts.freedom == model.n - {"point": 3, "hinge": 5, "weld": 6}[kind]
    assert not found.counts.redundant
    assert found.q[model.coordinates.index(last)] == pytest.approx(0.3, abs=1e-12)
    agrees(found)


def turned_ends(kind, **more):
    """Two branches of skew joints; the loop's links are fixed to the last bodies, turned and moved."""
    rng = np.random.default_rng(7)
    parts = [link("l0", *body_numbers(rng)), *branch(rng, "a", 4), *branch(rng, "b", 4)]
    for name in "ab":
        placed = {"xyz": rng.uniform(-0.3, 0.3, 3), "rpy": rng.uniform(-3, 3, 3)}
        parts.append(link(f"end_{name}", *body_numbers(rng)))
        parts.append(joint(f"fix_{name}", f"{name}3", f"end_{name}", "fixed", **placed))
    loop = Loop("tie", "end_a", (0.1, 0.2, -0.1), "end_b", (0.2, 0, 0.1), kind, **more)
    return built(*parts), Scene(loops=(loop,))


@pytest.mark.parametrize(
    ("kind", "more", "held"),
    [
        ("point", {}, 3),
        ("point", {"directions": ((0.3, 1.0, 0.2), (0.0, 0.5, -1.0))}, 2),
        ("hinge", {"axis": (0.3, -0.2, 0.9), "to_axis": (1.0, 0.4, 0.1)}, 5),
        ("weld", {"rpy": (0.4, -0.8, 1.9)}, 6),
    ],
)
def test_links_that_are_turned_in_their_bodies(kind, more, held):
    model, scene = turned_ends(kind, **more)
    found = dae(model, scene, qd={"jb3": 0.5}, tau=torques(model))
    assert found.counts.freedom == 8 - held
    agrees(found)


@pytest.mark.parametrize("count", [1, 4])
def test_four_bars_side_by_side(count):
    """The IFToMM benchmark: one freedom for any number of four-bars, one redundant equation in each."""
    model, scene = four_bars(count)
    for at in (None, {"k0": 1.1}):
        found = dae(model, scene, at=at, qd={"k0": -1.0}, tau={"k0": 3.0})
        assert (found.counts.freedom, len(found.counts.redundant)) == (1, count)
        assert found.qd[: count + 1] == pytest.approx(-1.0, abs=1e-13)
        agrees(found)


@pytest.mark.parametrize("cut", ["small_end", "big_end"])
def test_crank_and_slider(cut):
    found = dae(*crank_slider(cut=cut), tau={"main": 1.5})
    agrees(found)
    other = dae(*crank_slider(), tau={"main": 1.5})
    assert found.qdd[0] == pytest.approx(other.qdd[0], rel=1e-12)


@pytest.mark.parametrize(("kind", "more"), [("hinge", HINGE), ("point", {})])
def test_the_loop_cut_open(kind, more):
    """The open chain with the loop's reaction as torques accelerates as the closed one does."""
    model, scene = four_bar(kind, **more)
    found = dae(model, scene, *NEAR)
    agrees(found)
    assert "G_l" in found.steps[5].formula
    loads = found.reduced.G.T @ found.solution.reactions[found.system.tree :]
    free = robodyn.forward_dynamics(model, found.q, found.qd, found.tau + loads, scene=replace(scene, loops=()))
    assert worst(free, found.qdd) <= 1e-12
    assert worst(found.reduced.G @ found.qdd, found.reduced.gamma) <= 1e-13


def test_loops_that_depend_on_each_other_leave_reactions_open():
    """A loop given twice: accelerations are unique, who carries what is not, and the counts say so."""
    model, scene = spatial_loop(4)
    loop = scene.loops[0]
    again = Scene(loops=(loop, Loop("again", loop.link, loop.point, loop.to, loop.to_point)))
    once, twice = dae(model, scene, tau=torques(model)), dae(model, again, tau=torques(model))
    assert worst(twice.qdd, once.qdd) <= 1e-12
    assert twice.counts.redundant == (("again", "Fx"), ("again", "Fy"), ("again", "Fz"))
    assert {name for name, _ in twice.counts.undetermined} == {"tie", "again"}
    assert max(twice.comparison.forces, twice.comparison.moments) <= 1e-12


def test_what_cannot_close_is_refused():
    model, scene = four_bar("point")
    far = replace(scene, loops=(replace(scene.loops[0], to_point=(5.0, 0.0, 0.0)),))
    with pytest.raises(InputError, match='loop "closure" does not close'):
        dae(model, far, at={"j1": 1.4})


def test_axes_that_are_not_quite_parallel_are_refused():
    """1e-8 rad off: a loop closes in its plane, and its redundant equations do not hold."""
    model, scene = four_bar("hinge", axis=(1e-8, 0.0, 1.0), to_axis=(0.0, 0.0, 1.0))
    with pytest.raises(InputError, match=r"the loops stay 1e-08 apart \(look for axes that are not quite parallel\)"):
        dae(model, scene, *NEAR)


def test_velocities_from_which_no_motion_goes_on():
    """A flat four-bar whose rod turns against its cranks: the pins would have to move apart by 5 - 1 m/s^2."""
    model, scene = four_bars(1)
    flat = {"k0": 0.0, "k1": 0.0, "c0": 0.0}
    found = dae(model, scene, at=flat, qd={"k0": 1.0, "k1": -1.0, "c0": -3.0})
    assert found.counts.freedom == 2
    assert "contradict the others for accelerations by 4 m/s^2" in found.warnings[0]
    assert not dae(model, scene, at=flat, qd={"k0": 1.0, "k1": 1.0, "c0": -1.0}).warnings
    assert not dae(model, scene).warnings


def test_counts_of_a_planar_four_bar_of_hinges():
    """Three bodies and the ground, 4 hinges: 18 - 20 = -2 by counting, 1 by rank; what is out of its plane is open."""
    counts = dae(*four_bar(**HINGE), *NEAR).counts
    assert (counts.bodies, counts.reactions, counts.rank, counts.freedom) == (4, 6 + 3 * 5 + 5, 23, 1)
    assert counts.redundant == (("closure", "Fz"), ("closure", "Mx"), ("closure", "My"))
    assert {reaction for _, reaction in counts.undetermined} == {"Fz", "Mx", "My"}
    assert len(counts.undetermined) == 5 * 3
    assert counts.index == (3, 2, 1)


@pytest.mark.parametrize(
    ("more", "redundant"), [({}, ["Fz"]), ({"directions": ((1.0, 0.0, 0.0), (0.0, 2.0, 0.0))}, [])]
)
def test_redundancy_depends_on_the_closure(more, redundant):
    counts = dae(*four_bar("point", **more), *NEAR).counts
    assert [reaction for _, reaction in counts.redundant] == redundant
    assert counts.freedom == 1
