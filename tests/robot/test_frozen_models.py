"""Models cannot change after they are made: programs that were traced for them stay true."""

from __future__ import annotations

import copy
import pickle
from dataclasses import fields, is_dataclass, replace

import numpy as np
import pytest
from helpers.busy_robot import busy_robot
from helpers.small_robots import joint, link, urdf

import robodyn
from robodyn.dynamics.recursions.elimination import aligned
from robodyn.robot.model import Body, Frame, Joint, Model


def _inside(value):
    """A value and everything that it holds, but for the description that a model was made of, which is not computed."""
    yield value
    if is_dataclass(value):
        parts = [getattr(value, field.name) for field in fields(value) if field.name != "description"]
    elif hasattr(value, "items"):
        parts = value.values()
    else:
        parts = value if isinstance(value, tuple) else ()
    for part in parts:
        yield from _inside(part)


def _assert_frozen(model):
    arrays = [value for value in _inside(model) if isinstance(value, np.ndarray)]
    assert len(arrays) == 5 * len(model.bodies) + 2 * len(model.links)
    for array in arrays:
        assert not array.flags.writeable
    assert not [value for value in _inside(model) if isinstance(value, (list, dict, set))]
    with pytest.raises(TypeError, match="does not support item assignment"):
        model.links["l1"] = None


@pytest.mark.parametrize(
    "made",
    [
        lambda: robodyn.load(urdf(link("a"), link("b", 1.0), joint("j", "a", "b", "planar"))),
        lambda: busy_robot(True),
        lambda: aligned(busy_robot()),
        lambda: copy.copy(busy_robot()),
        lambda: copy.deepcopy(busy_robot()),
        lambda: pickle.loads(pickle.dumps(busy_robot())),
        lambda: replace(busy_robot(), bodies=list(busy_robot().bodies), links=dict(busy_robot().links)),
    ],
    ids=["loaded", "floating", "aligned", "copied", "copied deeply", "pickled", "replaced"],
)
def test_nothing_in_a_model_can_be_edited(made):
    _assert_frozen(made())


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
