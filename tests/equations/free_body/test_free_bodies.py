"""Free bodies: they balance, joints transmit what they can, and everything has its opposite on the other body."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers.command_line import ROBOTS as FOLDER
from helpers.oracles import EPS, random_state, robot, worst
from helpers.small_robots import chain

import robodyn
from robodyn.scene.scene import DEFAULT, ExternalWrench, Friction, Immersed, Payload, Rotor, Scene, Spring
from robodyn.support.wording import figure

ROBOTS = ("puma560", "gripper", "satellite", "quadruped")
BUSY = Scene(
    friction={"shoulder": Friction(2.0, 3.0, -1.0)},
    rotor={"elbow": Rotor(0.01, 20.0)},
    spring={"quill": Spring(200.0, 0.1)},
    payloads=(Payload("spindle", 2.0, (0.1, 0, 0)),),
    wrenches=(ExternalWrench("spindle", (1.0, -2.0, 3.0), (0.5, 0, 0), (0, 0, -0.2), "world"),),
    immersed=(Immersed("outer_arm", 0.01, (0.1, 0, 0), (0.1, 0.2, 0.3)),),
    fluid_density=1000.0,
)


def taken_apart(model, seed=0, scene=DEFAULT):
    (q,), (qd,), (qdd,) = state = random_state(model, np.random.default_rng(seed), 1)
    return state, robodyn.free_bodies(model, q, qd, qdd, scene=scene)


def balanced(found):
    """The sums over each body, added here from the actions, beside the largest action of the robot."""
    actions = [action for body in found.bodies for action in body.actions]
    force = max(np.abs(a.force).max() for a in actions)
    moment = max(np.abs(a.moment + np.cross(a.point, a.force)).max() for a in actions)
    for body in found.bodies:
        f = np.sum([a.force for a in body.actions], axis=0)
        n = np.sum([a.moment + np.cross(a.point, a.force) for a in body.actions], axis=0)
        assert np.abs(f).max() <= 1e-14 * force
        assert np.abs(n).max() <= 1e-14 * moment
    return force, moment


@pytest.mark.parametrize("free", [False, True])
@pytest.mark.parametrize("name", ROBOTS)
def test_every_body_is_in_balance(name, free):
    model = robot(name, free)
    _, found = taken_apart(model)
    force, moment = balanced(found)
    assert min(force, moment) > 0.1
    assert max(found.residual_force, found.residual_moment) <= 1e-14


def test_a_wrong_inertia_would_unbalance_it(monkeypatch):
    """The balance can fail: the inertial forces do not come from the recursion that gives the reactions."""
    from robodyn.equations.free_body import bodies

    monkeypatch.setattr(bodies, "about_centre", lambda I, m, r: 1.001 * I)
    assert taken_apart(robot("puma560"))[1].residual_moment > 1e-6


def test_everything_has_its_opposite():
    """What a joint does to its body, part by part, is the opposite of what it does to the parent."""
    _, found = taken_apart(robot("scara"), scene=BUSY)
    balanced(found)
    own = {a.symbols: (body, a) for body in found.bodies for a in body.actions if a.symbols[0][-1:].isdigit()}
    minus = {key: value for key, value in own.items() if key[0].startswith("-")}
    assert len(minus) == 3 * 2 + 2 + 1 + 1
    for (force, moment), (parent, action) in minus.items():
        child, reaction = own[force[1:], moment[1:]]
        for name in ("force", "moment"):
            one, other = (body.pose.R @ getattr(a, name) for body, a in ((parent, action), (child, reaction)))
            assert worst(one, -other, max(1.0, np.abs(other).max())) <= 8 * EPS
        assert worst(parent.pose.p + parent.pose.R @ action.point, child.pose.p) <= 8 * EPS
        assert (action.by, reaction.by) == (child.name, parent.name)


@pytest.mark.parametrize(("name", "scene"), [("scara", BUSY), ("gripper", DEFAULT), ("puma560", DEFAULT)])
def test_drives_are_the_torques_of_inverse_dynamics(name, scene):
    model = robot(name)
    (q, qd, qdd), found = taken_apart(model, scene=scene)
    tau = robodyn.inverse_dynamics(model, q[0], qd[0], qdd[0], scene=scene)
    total = np.zeros(model.n)
    for row, body in zip(found.joints, model.bodies, strict=True):
        if row.drive is not None:
            total[body.joint.rate] += body.joint.multiplier * row.drive
    assert worst(total, tau) <= 16 * EPS
    assert worst(list(found.tau.values()), tau) <= 16 * EPS


def test_a_pendulum_in_closed_form():
    """Turning at qd, accelerating at qdd: -m a_c, -I_c qdd, and the hinge carries weight and centripetal force."""
    model = chain(1)
    found = robodyn.free_bodies(model, [0.0], [2.0], [3.0], scene=Scene(gravity=(0.0, -10.0, 0.0)))
    m, I = model.bodies[1].inertia.m, model.bodies[1].inertia.I
    weight, inertia, reaction, drive = found.bodies[1].actions
    assert worst(weight.force, [0, -10 * m, 0]) <= 4 * EPS
    assert worst(inertia.force, [0.5 * m * 4, -0.5 * m * 3, 0]) <= 4 * EPS
    assert worst(inertia.moment, [0, 0, -3 * (I[2, 2] - 0.25 * m)]) <= 16 * EPS
    assert worst(reaction.force, [-0.5 * m * 4, 10 * m + 0.5 * m * 3, 0]) <= 4 * EPS
    assert worst(drive.moment, [0, 0, 3 * I[2, 2] + 10 * m * 0.5]) <= 4 * EPS
    assert np.array_equal(weight.point, [0.5, 0, 0])


def test_what_acts_from_outside_stands_where_it_acts():
    _, found = taken_apart(robot("scara"), scene=BUSY)
    (pushed,) = (a for a in found.bodies[3].actions if a.kind == "external wrench")
    assert np.array_equal(pushed.point, [0, 0, -0.2])
    assert worst(found.bodies[3].pose.R @ pushed.force, [1, -2, 3]) <= 8 * EPS
    assert worst(found.bodies[3].pose.R @ pushed.moment, [0.5, 0, 0]) <= 8 * EPS
    (floats,) = (a for a in found.bodies[2].actions if a.kind == "fluid")
    assert np.array_equal(floats.point, [0.1, 0, 0])
    assert not floats.moment.any()
    assert found.bodies[3].mass == robot("scara").bodies[3].inertia.m + 2


def four_bar(angle: float, actuated: tuple[str, ...] = ("left",)):
    model, scene = robodyn.load(FOLDER / "four_bar.urdf"), robodyn.load_scene(FOLDER / "four_bar_lift.toml")
    q = {"left": angle, "right": angle, "top": -angle}
    return robodyn.free_bodies(model, [q[name] for name in model.rates], scene=replace(scene, actuated=actuated))


@pytest.mark.parametrize(("angle", "actuated"), [(0.5 * np.pi, ("left",)), (0.3, ())], ids=["flat", "no drive"])
def test_what_nothing_gives_is_told(angle, actuated):
    found = four_bar(angle, actuated)
    passive = [name for name in found.tau if name not in actuated]
    told = [name for name in passive if abs(found.tau[name]) > 1e-9]
    assert told
    assert found.warnings == tuple(
        f"nothing drives '{name}', and the motion takes {figure(found.tau[name])} N m there, shown as its drive"
        for name in told
    )
