"""The Model: planar and floating joints, names, size; what must not change torques; what Python shows of it."""

from __future__ import annotations

import inspect
import sys
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from helpers.busy_robot import busy_robot
from helpers.command_line import ROBOTS
from helpers.counted_calls import calls
from helpers.example_robots import PATHS
from helpers.oracles import EPS, random_state, worst
from helpers.peers import pin
from helpers.pinocchio_robots import PinocchioRobot
from helpers.small_robots import body_numbers, built, chain_parts, joint, link, random_tree_parts, urdf

import robodyn
from robodyn.dynamics.inverse import inverse_dynamics, mass_matrix
from robodyn.errors import DescriptionError
from robodyn.robot.kinematics import motions, poses
from robodyn.robot.load import load
from robodyn.scene.scene import LimitSpring


@pytest.mark.parametrize("axis", [(0, 0, 1), (1, 0, 0), (0, 1, 0), (0.48, 0.6, -0.64), (0, 0, -1)])
def test_planar_joint(axis):
    """Two slides across the normal and a hinge about it, in a right-handed frame; massless bodies between."""
    rng = np.random.default_rng(1)
    model = built(link("base"), link("puck", *body_numbers(rng)), joint("p", "base", "puck", "planar", axis))
    assert model.rates == model.coordinates == ("p_x", "p_y", "p_theta")
    first, second, normal = (body.joint.axis for body in model.bodies[1:])
    assert worst(np.cross(first, second), normal) <= 2 * EPS
    assert worst([normal @ first, normal @ second, first @ second], [0, 0, 0], 1.0) <= 2 * EPS
    assert worst(normal, np.array(axis, dtype=float)) <= 2 * EPS
    at = poses(model.parents, motions(model, [0.3, -0.7, 0.5], [0] * 3, [0] * 3))[-1]
    assert worst(at.p, 0.3 * first - 0.7 * second) <= 2 * EPS
    assert worst(at.R @ normal, normal) <= 2 * EPS
    assert [body.inertia.m for body in model.bodies[:3]] == [0, 0, 0]
    assert model.independent[2].continuous


@pytest.mark.parametrize("names", [("p", "p_y"), ("p_y", "p")])
def test_a_joint_named_as_a_part_of_a_planar_one(names):
    """Names are looked up: the order of q was p_x, p_theta, p_y."""
    kinds = ["planar" if name == "p" else "revolute" for name in names]
    parts = [link("base"), *(link(name, *body_numbers(np.random.default_rng(1))) for name in ("a", "b"))]
    parts += [joint(names[0], "base", "a", kinds[0], (0, 0, 1)), joint(names[1], "a", "b", kinds[1], (0, 0, 1))]
    with pytest.raises(DescriptionError, match='joint "p_y" is named as a part of planar joint "p"'):
        built(*parts)


def test_planar_joint_about_z_against_pinocchio():
    """Pinocchio's planar joint has its velocity in the body's axes: here a turn of zero compares them."""
    rng = np.random.default_rng(2)
    text = urdf(link("base"), link("puck", *body_numbers(rng)), joint("p", "base", "puck", "planar", (0, 0, 1)))
    model, other = load(text), PinocchioRobot(text)
    qd, qdd = rng.normal(size=(2, 3))
    vx, vy, w = qd
    # At theta = 0 the body's axes are the ground's, and turn under the velocity: a_body = a - w x v.
    a = np.array([qdd[0] + w * vy, qdd[1] - w * vx, qdd[2]])
    expected = pin.rnea(other.model, other.data, np.array([0.3, -0.7, 1, 0]), qd, a)
    assert worst(inverse_dynamics(model, [0.3, -0.7, 0], qd, qdd), expected) <= 1e-14


@pytest.mark.parametrize("kind", ["planar", "floating"])
def test_friction_that_is_not_used_is_noted(kind):
    more = '<dynamics damping="3" friction="2"/>'
    model = built(link("base", 1), link("puck", 1), joint("p", "base", "puck", kind, more=more))
    assert model.notes == (f'joint "p" (line 5): a {kind} joint has no friction here',)
    assert not built(link("base", 1), link("puck", 1), joint("p", "base", "puck", kind)).notes


def test_total_mass_and_merged_links():
    model = busy_robot()
    assert "tool" not in [body.name for body in model.bodies]
    assert model.links["tool"].body == model.links["l3"].body
    assert set(model.links) == {*(f"l{i}" for i in range(7)), "tool"}
    links = [link("a", 1.5), link("b", 2), link("c", 3)]
    single = built(*links, joint("f", "a", "b", "fixed"), joint("j", "b", "c"))
    assert single.total_mass == 6.5
    assert [body.name for body in single.bodies] == ["a", "c"]


def test_a_massless_root_with_one_floating_joint_is_the_ground():
    parts = [link("world"), link("ship", 2, (0.1, 0, 0), (1, 0, 0, 1, 0, 1)), link("arm", 1)]
    parts += [joint("float", "world", "ship", "floating"), joint("j", "ship", "arm")]
    model = load(urdf(*parts))
    assert model.floating
    assert model.rates[0] == "base_wx"
    with_mass = load(urdf(link("world", 1), *parts[1:]))
    assert not with_mass.floating
    assert with_mass.rates[0] == "float_wx"


def test_a_floating_joint_cannot_be_mimicked():
    parts = [link("base", 1), link("ship", 1), link("arm", 1), joint("float", "base", "ship", "floating")]
    parts.append(joint("j", "ship", "arm", more='<mimic joint="float"/>'))
    with pytest.raises(DescriptionError, match='joint "j" mimics joint "float", which has no single coordinate'):
        load(urdf(*parts))


@pytest.mark.slow
def test_ten_thousand_links():
    """Neither recursion nor quadratic time: counted by the calls that Python makes."""
    assert sys.getrecursionlimit() < 10_000
    one, two = (calls(partial(load, urdf(*chain_parts(n)))).total() for n in (1_000, 2_000))
    assert two < 2.1 * one
    model = load(urdf(*chain_parts(10_000)))
    assert model.n == 10_000
    assert model.parents[-1] == 9_999
    assert model.tips_first[0] == 9_999
    assert model.total_mass == 10_000


@pytest.mark.parametrize("seed", range(2))
def test_the_order_of_the_file(seed):
    """Links and joints shuffled: the same torques joint by joint, in the order in which the file names the joints."""
    rng = np.random.default_rng(seed)
    parts = random_tree_parts(rng, 9)
    shuffled = [parts[k] for k in rng.permutation(len(parts))]
    first, second = load(urdf(*parts)), load(urdf(*shuffled))
    named = [part.split('"')[1] for part in shuffled if part.startswith("<joint") and 'type="fixed"' not in part]
    assert list(second.joint_names) == named
    assert sorted(named) == sorted(first.joint_names)
    assert all(0 <= parent < i for i, parent in enumerate(second.parents) if i)
    q, qd, qdd = random_state(first, np.random.default_rng(1), 20)
    order = [first.rates.index(name) for name in second.rates]
    tau = inverse_dynamics(first, q, qd, qdd)[:, order]
    assert worst(inverse_dynamics(second, q[:, order], qd[:, order], qdd[:, order]), tau) <= 4 * EPS
    assert worst(mass_matrix(second, q[:, order]), mass_matrix(first, q)[:, order][:, :, order]) <= 4 * EPS


FILES = [*sorted(ROBOTS.glob("*.urdf"))[::4], *PATHS[::25]]


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_model_is_shown_in_three_lines(path: Path) -> None:
    model = robodyn.load(path)
    first, second, third = repr(model).split("\n")
    assert first.startswith(f"<Model '{model.name}' of ")
    assert f"{path.name}'" in first
    assert first.endswith("moving base" if model.floating else "fixed base")
    assert second.startswith(f" {model.n} degree")
    assert all(f"'{name}'" in second for name in model.joint_names[:8])
    assert third.endswith(">")
    assert len(repr(model)) < 1000


def test_hostile_names_are_shown_without_effect() -> None:
    long, strange = "l" * 9999, "a\u202e\x85b"
    model = built(link(long), link(strange, 1.0), joint(strange * 500, long, strange))
    text = repr(model)
    assert len(text) < 500
    assert text.count("\n") == 2
    assert all(character.isprintable() or character == "\n" for character in text)


def test_a_scene_is_shown_as_the_call_that_makes_it() -> None:
    assert repr(robodyn.Scene()) == "Scene()"
    assert repr(robodyn.Scene(gravity=(0, 0, -1.62))) == "Scene(gravity=(0.0, 0.0, -1.62))"
    names = {name: getattr(robodyn, name) for name in robodyn.__all__} | {"LimitSpring": LimitSpring}
    for path in ROBOTS.glob("*.toml"):
        scene = robodyn.load_scene(path)
        assert eval(repr(scene), names) == scene


def test_signatures_can_be_read() -> None:
    """No default takes a line of its own: a scene's was 800 characters long."""
    for name in filter(str.islower, robodyn.__all__):
        parameters = inspect.signature(getattr(robodyn, name)).parameters.values()
        assert [each for each in parameters if len(repr(each.default)) > 40] == []
