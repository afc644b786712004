"""Scenes and models cannot change after they are made; equal ones are the same to every program."""

from __future__ import annotations

import copy
import pickle
from dataclasses import FrozenInstanceError, fields, is_dataclass, replace

import numpy as np
import pytest
from helpers.busy_robot import BUSY_SCENE, busy_robot
from helpers.oracles import robot
from helpers.small_robots import joint, link, urdf

import robodyn
from robodyn.dynamics.inverse import mass_runner
from robodyn.dynamics.plan import plan
from robodyn.dynamics.recursions.articulated_body import aligned
from robodyn.robot.model import Body, Frame, Joint, Model
from robodyn.scene.scene import (
    DEFAULT,
    Contact,
    ContactCost,
    CoupledMotor,
    Drive,
    ExternalWrench,
    Friction,
    Loop,
    Motor,
    Payload,
    Rotor,
    Scene,
    Spring,
)
from robodyn.scene.uncertainty import Deviation, LinkUncertainty, Uncertainty

EVERYTHING = replace(
    BUSY_SCENE,
    motor={"j1": Motor(0.9, ((0.0, 2.0), (100.0, 1.0)), 3.0)},
    drive={"j4": Drive(1.0, reference="plan"), "j1": Drive(kp=3.0)},
    initial_q={"j1": 0.1, "j4": "begin"},
    loops=(Loop("l", "l2", directions=((0.0, 1.0, 0.0),)),),
    held=True,
    actuated=("j1",),
    passive=("j4",),
    share="weighted",
    weights={"j1": 2.0},
    weight="effort",
    contacts=(Contact("foot", "tool"),),
    contact_cost=ContactCost(2.0),
    coupled=(CoupledMotor("m", {"j1": 1.0, "j2": 2.0}, 1e-3),),
    uncertainty=Uncertainty(Deviation(0.05), link={"l2": LinkUncertainty(com=Deviation(0.003, relative=False))}),
)
"""A scene with something in every field."""


def _inside(value):
    """A value and everything that it holds, but for the description that a model was made of, which is not computed."""
    yield value
    if is_dataclass(value):
        parts = [getattr(value, field.name) for field in fields(value) if field.name != "description"]
    elif hasattr(value, "items"):
        parts = [part for item in value.items() for part in item]
    else:
        parts = value if isinstance(value, tuple) else ()
    for part in parts:
        yield from _inside(part)


def test_nothing_in_a_scene_can_be_edited():
    """The field cannot be set, its mapping not be written to, and nothing that it holds is a list, dict or array."""
    mappings = [field.name for field in fields(Scene) if hasattr(getattr(EVERYTHING, field.name), "items")]
    assert {"friction", "rotor", "spring", "drive", "motor", "gear_life", "initial_q", "initial_qd", "weights"} == set(
        mappings
    )
    for field in fields(Scene):
        with pytest.raises(FrozenInstanceError):
            setattr(EVERYTHING, field.name, getattr(DEFAULT, field.name))
    for name in mappings:
        for scene in (EVERYTHING, DEFAULT):
            with pytest.raises(TypeError, match="does not support item assignment"):
                getattr(scene, name)["j1"] = None
            with pytest.raises(TypeError, match="does not support item deletion"):
                del getattr(scene, name)["j1"]
            assert not hasattr(getattr(scene, name), "update")
    for value in _inside(EVERYTHING):
        assert not isinstance(value, (list, dict, set, np.ndarray)), value
        hash(value)


def test_what_a_scene_was_made_of_can_change_without_it():
    friction, gravity, curve = {"waist": Friction(2.0)}, np.array([0.0, 0.0, -9.81]), [[0.0, 2.0], [100.0, 1.0]]
    loads = [Payload("flange", 1.0, com=[0.1, 0.0, 0.0])]
    scene = Scene(gravity, friction, payloads=loads, motor={"waist": Motor(peak=curve)})
    before = copy.deepcopy(scene)
    friction["waist"], gravity[2], curve[0][1] = Friction(900.0), 5.0, 7.0
    friction["elbow"] = Friction(1.0)
    loads.append(Payload("flange", 9.0))
    assert scene == before
    assert scene.gravity == (0.0, 0.0, -9.81)
    assert scene.friction == {"waist": Friction(2.0)}
    assert scene.motor["waist"].peak == ((0.0, 2.0), (100.0, 1.0))


@pytest.mark.parametrize("again", [copy.copy, copy.deepcopy, lambda x: pickle.loads(pickle.dumps(x)), replace])
def test_copies_are_equal_and_frozen(again):
    twin = again(EVERYTHING)
    assert twin == EVERYTHING
    assert vars(twin).keys() == vars(EVERYTHING).keys() == {field.name for field in fields(Scene)}
    assert hash(twin) == hash(EVERYTHING)
    with pytest.raises(TypeError):
        twin.friction["j1"] = Friction()
    for value in _inside(twin):
        assert not isinstance(value, (list, dict, set, np.ndarray)), value


EQUAL = [
    (Scene(drive={"a": Drive("x"), "b": Drive("y")}), Scene(drive={"b": Drive("y"), "a": Drive("x")})),
    (Scene((0.0, 0.0, 0.0), {"a": Friction(0.0)}), Scene((0.0, -0.0, 0.0), {"a": Friction(-0.0)})),
    (Scene((0, 0, -10), rotor={"a": Rotor(1, 2)}), Scene((0.0, 0.0, -1e1), rotor={"a": Rotor(1.0, 2.0)})),
    (Scene(np.array([0, 0, -10])), Scene((np.float32(0), np.int64(0), -10.0))),
    (Scene((0.0, float("nan"), 0.0)), Scene((0.0, np.float64("nan"), 0.0))),
    (Scene(wrenches=[ExternalWrench("a", [1, 2, 3])]), Scene(wrenches=(ExternalWrench("a", (1, 2, 3)),))),
]


@pytest.mark.parametrize("pair", EQUAL)
def test_equal_scenes_are_the_same_to_the_bit(pair):
    """Nothing tells them apart, not even what is printed: the sign of a zero, or the order of columns."""
    one, other = pair
    assert one == other
    assert hash(one) == hash(other)
    assert repr(one) == repr(other)
    assert one.table_columns == other.table_columns


def test_equal_scenes_share_programs():
    model = robot("puma560")
    one, other = (Scene(friction={"waist": Friction(2.0)}, spring={"elbow": Spring(3.0)}) for _ in range(2))
    assert one is not other
    assert plan(model, one) is plan(model, other)
    assert mass_runner(model, one) is mass_runner(model, other)
    assert plan(model, one) is not plan(model, replace(one, spring={}))


def _assert_frozen(model):
    arrays = [value for value in _inside(model) if isinstance(value, np.ndarray)]
    assert len(arrays) == 5 * len(model.bodies) + 2 * len(model.links)
    for array in arrays:
        assert not array.flags.writeable
    assert not [value for value in _inside(model) if isinstance(value, (list, dict, set))]
    with pytest.raises(TypeError, match="does not support item assignment"):
        model.links["l1"] = None


def test_nothing_in_a_model_can_be_edited():
    _assert_frozen(robodyn.load(urdf(link("a"), link("b", 1.0), joint("j", "a", "b", "planar"))))
    busy = busy_robot(True)
    twins = copy.copy(busy), copy.deepcopy(busy), pickle.loads(pickle.dumps(busy))
    for model in (busy, aligned(busy_robot()), *twins, replace(busy, bodies=[*busy.bodies], links=dict(busy.links))):
        _assert_frozen(model)


def test_what_a_model_was_made_of_can_change_without_it():
    R, p, axis, mc, I = np.eye(3), np.zeros(3), np.array([0.0, 0.0, 1.0]), np.ones(3), np.eye(3)
    base = Body("base", -1, Joint("base", "fixed", R, p, axis), busy_robot().bodies[0].inertia._replace(mc=mc, I=I))
    links = {"base": Frame(0, R, p)}
    model = Model("one", "one.urdf", [base], links)
    for array in (R, p, axis, mc, I):
        array[...] = 7.0
    links["other"] = links["base"]
    assert list(model.links) == ["base"]
    np.testing.assert_array_equal(model.bodies[0].joint.axis, [0.0, 0.0, 1.0])
    np.testing.assert_array_equal(model.bodies[0].inertia.I, np.eye(3))
    np.testing.assert_array_equal(model.links["base"].p, np.zeros(3))
