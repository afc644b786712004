"""Paths in time: closed forms, other programs' torques and durations, and limits that random motions must keep."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from helpers.command_line import run
from helpers.drake_toppra import durations
from helpers.example_robots import path_of, real
from helpers.peers import needs_peers
from helpers.pinocchio_robots import PinocchioRobot
from helpers.robot_files import FOLDER

import robodyn
from robodyn.errors import InputError, RobodynError
from robodyn.loads.sizing import allowed, train_of
from robodyn.robot.limits import coordinate_ranges
from robodyn.scene.scene import CoupledMotor, ExternalWrench, Friction, Motor, Payload, Rotor, Scene, Spring
from robodyn.sizing.along import Along, bounds_of
from robodyn.sizing.path import WayPoints, lines, spline
from robodyn.sizing.reachability import Intervals
from robodyn.sizing.retime import retime

ROBOTS = ("ur5_robot", "panda", "kinova", "talos_left_arm", "xarm7", "z1")
BY_DEFAULT = ("ur5_robot", "panda")
HELD = re.compile("finger|gripper")
SLIDE = """<robot name="slide"><link name="rail"/><link name="car"><inertial><mass value="2"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link><joint name="x" type="KIND">
<parent link="rail"/><child link="car"/><axis xyz="AXIS"/><limit lower="-9" upper="9" effort="4" velocity="VELOCITY"/>
</joint></robot>"""


def slide(velocity=0, kind="prismatic", axis="1 0 0"):
    text = SLIDE.replace("KIND", kind).replace("AXIS", axis).replace("VELOCITY", str(velocity))
    return robodyn.load(text.encode())


def random_path(model, rng, rows):
    """Way-points well inside the limits; what grips is held."""
    least, largest = (np.clip(each, -2.5, 2.5) for each in coordinate_ranges(model))
    q = least + (largest - least) * rng.uniform(0.25, 0.75, (rows, model.n))
    if rng.uniform() < 0.5:  # near each other
        q = np.clip(q[0] + np.cumsum(rng.normal(0.0, 0.15, q.shape), axis=0), least, largest)
    held = [i for i, name in enumerate(model.joint_names) if HELD.search(name)]
    q[:, held] = q[0, held]
    return q


# A mass that is pushed: 2 kg, 4 N


@pytest.mark.parametrize("grid", [101, 1000, 2000, 2333])
def test_a_double_integrator_goes_bang_bang(grid):
    found = retime(slide(), [[0.0], [3.0]], grid=grid)
    assert found.duration == pytest.approx(2.0 * np.sqrt(3.0 / 2.0), rel=1e-6 if grid >= 1000 else 1e-4)
    t, half = found.time, found.duration / 2.0
    wanted = np.where(t < half, t * t, 3.0 - (found.duration - t) ** 2)
    assert np.abs(found.q[:, 0] - wanted).max() <= (1e-6 if grid >= 1000 else 1e-3)
    assert [(one.joint, one.limit) for one in found.binding] == [("x", "effort")]


def test_closed_forms_with_a_largest_speed_and_a_given_acceleration():
    model = slide(velocity=1.5)
    assert retime(model, [[0.0], [3.0]]).duration == pytest.approx(3.0 / 1.5 + 1.5 / 2.0, rel=1e-6)
    assert retime(model, [[0.0], [3.0]], speed=0.5).duration == pytest.approx(3.0 / 0.75 + 0.75 / 2.0, rel=1e-6)
    assert retime(model, [[0.0], [3.0]], acceleration=0.5).duration == pytest.approx(2.0 * np.sqrt(6.0), rel=1e-6)
    turning = slide(kind="revolute", axis="0 0 1")
    slow = retime(turning, [[0.0], [1.0]], acceleration={"x": 3.75})
    assert slow.duration == pytest.approx(2.0 * np.sqrt(1.0 / 3.75), rel=1e-6)


def test_going_up_and_down_under_weight_differs_by_it():
    up = retime(slide(axis="0 0 1"), [[0.0], [1.0]], Scene(gravity=(0.0, 0.0, -1.5)))
    # speeding up at (4 - 3) / 2, slowing down at (4 + 3) / 2
    a, b = 0.5, 3.5
    assert up.duration == pytest.approx(np.sqrt(2.0 * (a + b) / (a * b)), rel=1e-5)


def test_viscous_friction_as_the_equation_of_motion_has_it():
    d, m, F, L = 2.0, 2.0, 4.0, 3.0
    found = retime(slide(), [[0.0], [L]], Scene(friction={"x": Friction(viscous=d)}))
    # v' = (F - d v) / m until the switch at time t, then v' = -(F + d v) / m until rest
    k = d / m

    def rest(t):
        v = F / d * (1.0 - np.exp(-k * t))
        s = F / d * (t - (1.0 - np.exp(-k * t)) / k)
        more = np.log(1.0 + d * v / F) / k
        return s + (F / d + v) * (1.0 - np.exp(-k * more)) / k - F / d * more, t + more

    low, high = 0.0, 10.0
    for _ in range(80):
        t = 0.5 * (low + high)
        low, high = (t, high) if rest(t)[0] < L else (low, t)
    sticky = Scene(friction={"x": Friction(viscous=1e4)})
    slow = retime(slide(), [[0.0], [L]], sticky, rate=10.0)  # at its last speed all along
    assert slow.duration == pytest.approx(L * 1e4 / F, rel=1e-3)
    # in each interval the friction of its faster end counts: the error is of first order in their length
    assert 0.0 <= found.duration / rest(low)[1] - 1.0 <= 6e-4


def test_coulomb_friction_and_the_loss_of_a_gear():
    J, F, L = 0.001, 0.05, 1.0
    scene = Scene(
        friction={"x": Friction(forward=1.0, backward=-1.0)},
        rotor={"x": Rotor(J, 50.0)},
        motor={"x": Motor(efficiency=0.8, peak=F)},
    )
    found = retime(slide(), [[0.0], [L]], scene)
    # driving: T = G J a + (m a + f) / (G e); braking: T = G J a + (m a + f) / G with the load's share
    G, m, f, e = 50.0, 2.0, 1.0, 0.8
    up = min((F - f / (G * e)) / (G * J + m / (G * e)), (4.0 - f) / (m + G * G * J))
    down = min(max((F + f * s / G) / (G * J + m * s / G) for s in (e, 1.0 / e)), (4.0 + f) / (m + G * G * J))
    assert found.duration == pytest.approx(np.sqrt(2.0 * L * (up + down) / (up * down)), rel=2e-3)


def test_a_trapezoid_and_an_s_curve_have_their_closed_forms():
    model = slide(velocity=1.5)
    found = retime(model, [[0.0], [3.0], [1.0]], profile="trapezoid", speed=0.8, acceleration=1.0)
    assert found.duration == pytest.approx((3.0 / 1.2 + 1.2) + (2.0 / 1.2 + 1.2), abs=1e-9)
    found = retime(model, [[0.0], [3.0]], profile="scurve", acceleration=1.0, jerk=4.0)
    assert found.duration == pytest.approx(3.0 / 1.5 + 1.5 + 0.25, abs=1e-9)
    found = retime(slide(), [[0.0], [3.0]], profile="trapezoid")  # as torque allows
    assert found.duration == pytest.approx(2.0 * np.sqrt(3.0 / 2.0), rel=1e-9)
    for length in np.random.default_rng(1).uniform(0.2, 1.0, 9):  # the largest speed is reached at most for a moment
        found = retime(slide(), [[0.0], [length]], profile="scurve", acceleration=1.0, jerk=400.0)
        a, J, L = 1.0, 400.0, length
        v = 0.5 * a * (np.hypot(a / J, 2.0 * np.sqrt(L / a)) - a / J)
        assert found.duration == pytest.approx(L / v + v / a + a / J, rel=1e-7)
    jerky = retime(slide(), [[0.0], [0.5]], profile="scurve", jerk=1.0)  # neither acceleration nor speed is reached
    assert jerky.duration == pytest.approx((32.0 * 0.5) ** (1 / 3), rel=1e-9)


def test_waiting_stops_and_takes_its_time():
    table = np.array([[0.0], [1.0], [2.0]])
    model = slide()
    through = retime(model, table).duration
    stopping = retime(model, table, blend=0.0).duration
    assert through == pytest.approx(2.0, rel=1e-6)
    assert stopping == pytest.approx(2.0, rel=1e-6)  # the line goes straight on
    assert retime(model, [[0.0], [1.0], [0.5]], blend=0.0).duration == pytest.approx(2**0.5 + 1.0, rel=1e-6)


def test_dwell_of_a_table(tmp_path):
    table = tmp_path / "way.csv"
    table.write_text("x,dwell,time\n0,0.5,3\n1,0.25,2\n1,0.25,2\n2,1,1\n")
    model = slide()
    for profile in ("optimal", "trapezoid"):
        found = retime(model, table, profile=profile)
        assert found.duration == pytest.approx(0.5 + 2**0.5 + 0.5 + 2**0.5 + 1.0, rel=1e-6)
        waits = (found.time > 0.5 + 2**0.5 + 0.01) & (found.time < 1.0 + 2**0.5 - 0.01)
        assert np.abs(found.q[waits] - 1.0).max() <= 1e-12
        assert not found.qd[waits].any()


# Limits, by other programs and by our own shafts


def over(model, found, tau):
    """What a motion passes its limits by at most, of velocity, effort and given accelerations."""
    limits = found.limits
    used = [np.abs(x) / limit for x, limit in zip((found.qd, found.qdd, tau), limits[:3], strict=True)]
    return float(np.max(used)) - 1.0


def kept_by_pinocchio(stem, count, seed):
    """Retime random paths; return how many had a motion, and what limits are passed by at most by Pinocchio."""
    model, oracle, rng = real(stem), PinocchioRobot(path_of(stem)), np.random.default_rng(seed)
    bare = Scene(friction={joint.name: Friction() for joint in (body.joint for body in model.bodies[1:])})
    done, worst = 0, 0.0
    for k in range(count):
        how = {"blend": float(rng.uniform(0.0, 0.3))} if k % 3 == 2 else {}
        path = random_path(model, rng, int(rng.integers(2, 8)))
        found = retime(model, path, bare, acceleration=float(rng.uniform(5.0, 40.0)), grid=300, rate=4000.0, **how)
        if not found.feasible:
            assert found.where["missing"] > 0.0 or "no speed" in found.reason
            continue
        done += 1
        rows = np.unique(np.linspace(0, found.samples - 1, 300).astype(int))
        near = np.argsort(-found.used.max(axis=(0, 2)))[:100]
        rows = np.concatenate((rows, near))
        tau = found.tau.copy()
        tau[rows] = oracle.torques(model, found.q[rows], found.qd[rows], found.qdd[rows])
        assert np.abs(tau - found.tau)[rows].max() <= 1e-9 * np.abs(found.tau).max()
        worst = max(worst, over(model, found, tau))
    return done, worst


@needs_peers
@pytest.mark.parametrize(
    "stem", [each if each in BY_DEFAULT else pytest.param(each, marks=pytest.mark.slow) for each in ROBOTS]
)
def test_random_paths_keep_all_limits_by_pinocchio(stem):
    done, worst = kept_by_pinocchio(stem, 3, 1)
    assert done >= 1
    assert worst <= 1e-6


@needs_peers
@pytest.mark.slow
@pytest.mark.parametrize("stem", ROBOTS)
def test_many_random_paths_keep_all_limits_by_pinocchio(stem):
    done, worst = kept_by_pinocchio(stem, 38, 2)
    assert done >= 15
    assert worst <= 1e-6


def beside_drake(stem, count, seed):
    model, rng = real(stem), np.random.default_rng(seed)
    bare = Scene(friction={body.joint.name: Friction() for body in model.bodies[1:]})  # Drake's torques have none
    paths = [random_path(model, rng, int(rng.integers(2, 7))) for _ in range(count)]
    found = [one for one in (retime(model, path, bare, acceleration=20.0) for path in paths) if one.feasible]
    theirs = durations(path_of(stem), model, found)
    return [abs(one.duration / time - 1.0) for one, time in zip(found, theirs, strict=True) if time is not None]


@needs_peers
def test_durations_are_those_of_drake():
    apart = beside_drake("ur5_robot", 2, 2)
    assert apart
    assert max(apart) <= 0.005


@needs_peers
@pytest.mark.slow
@pytest.mark.parametrize("stem", ["ur5_robot", "panda", "kinova", "xarm7"])
def test_many_durations_are_those_of_drake(stem):
    apart = beside_drake(stem, 8, 5)
    assert len(apart) >= 4
    assert max(apart) <= 0.005


def test_a_pass_is_that_of_a_linear_program():
    linprog = pytest.importorskip("scipy.optimize").linprog
    model, rng = real("ur5_robot"), np.random.default_rng(8)
    path = spline(WayPoints(random_path(model, rng, 4), np.arange(1, 5), np.zeros(4)))
    along = Along(bounds_of(model, Scene(), 10.0, None, 1.0), path, path.grid(60))
    n = len(along.steps)
    kept = np.ones((6, n, model.n))
    rows, most = along.rows(np.zeros(n + 1), kept), along.most(kept)
    for one, other in zip(*(along.rows(x * np.ones(n + 1), kept) for x in (0.5, 9.0)), strict=True):
        assert np.abs(one - other).max() <= 1e-6 * np.abs(one).max()  # without friction they are lines everywhere
    mine, _ = Intervals(rows, along.steps, most).fastest()
    # u = (x' - x) / (2 step): all limits are lines in neighbouring x, of which the largest sum is wanted
    A, limit = [], []
    for k in range(n):
        for end in (0, 1):
            for a, b, d in zip(rows.a[end, k], rows.b[end, k], rows.d[end, k], strict=True):
                line = np.zeros(n + 1)
                line[k] -= a / (2.0 * along.steps[k])
                line[k + 1] += a / (2.0 * along.steps[k])
                line[k + end] += b
                A.append(line)
                limit.append(d)
    best = linprog(-np.ones(n + 1), A, limit, bounds=[(0.0, None if np.isinf(x) else x) for x in most])
    speeds = np.sqrt(mine), np.sqrt(np.maximum(best.x, 0.0))
    quick, quickest = (float((2.0 * along.steps / (v[1:] + v[:-1])).sum()) for v in speeds)
    assert quickest * (1.0 - 1e-9) <= quick <= quickest * (1.0 + 2e-5)  # less than all of an interval's is given away
    assert np.abs(best.x - mine).max() <= 1e-3 * best.x.max()


def test_the_panda_keeps_its_accelerations_through_uneven_corners():
    """MoveIt's time parameterization passed 3.75 rad/s^2 by 2.75 times where way-points lie close and unevenly."""
    model, rng = real("panda"), np.random.default_rng(3778)
    q = np.tile([0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785, 0.02], (24, 1))
    steps = rng.normal(0.0, 1.0, (24, 7)) * rng.choice([0.002, 0.02, 0.2], (24, 1))
    q[:, :7] += np.cumsum(steps, axis=0)
    q = np.clip(q, *coordinate_ranges(model))
    q[:, 7] = 0.02
    for how in ({"blend": 0.05}, {"blend": 0.0}):
        found = retime(model, q, acceleration=3.75, rate=2000.0, **how)
        assert found.feasible, found.reason
        assert np.abs(found.qdd).max() <= 3.75 * (1.0 + 1e-9)
        assert np.abs(found.qdd).max() >= 3.75 * 0.999


def random_scene(model, rng):
    """Motors with curves, losses, rotors and gears of both signs, friction, a payload, a spring and a wrench."""
    friction, rotors, motors = {}, {}, {}
    for joint in model.independent:
        limit, fast = joint.effort or 50.0, joint.velocity or 3.0
        gear = float(rng.choice([-1.0, 1.0]) * rng.uniform(20.0, 160.0))
        size = limit / abs(gear) * rng.uniform(0.9, 1.6)
        knee, end = fast * abs(gear) * rng.uniform(0.2, 0.6), fast * abs(gear) * rng.uniform(0.8, 1.5)
        friction[joint.name] = Friction(
            0.05 * limit / fast * rng.uniform(), *(limit * rng.uniform(0, 0.05) * np.array([1, -1]))
        )
        rotors[joint.name] = Rotor(float(0.1 * limit / 30.0 / gear**2 * rng.uniform()), gear)
        peak = ((0.0, size), (knee, size), (end, size * rng.uniform(0.2, 0.7)))
        motors[joint.name] = Motor(
            float(rng.uniform(0.6, 1.0)), peak=peak, gear_peak=float(limit * rng.uniform(0.9, 2.0))
        )
    last, first = list(model.links)[-1], model.joint_names[0]
    return Scene(
        friction=friction,
        rotor=rotors,
        motor=motors,
        payloads=(Payload(last, 0.5, (0.0, 0.0, 0.05)),),
        spring={first: Spring(2.0, 0.1)},
        wrenches=(ExternalWrench(last, (2.0, -1.0, 3.0), frame="world"),),
    )


def at_shafts(model, scene, found):
    """What motors use of their peak curves and speeds, told by their definitions."""
    worst = 0.0
    for i, joint in enumerate(model.independent):
        train = train_of(joint, scene)
        rotor = train.gear**2 * train.inertia * found.qdd[:, i]
        load = found.tau[:, i] - rotor
        share = np.where(load * found.qd[:, i] > 0, 1 / train.motor.efficiency, train.motor.efficiency)
        share = np.where(found.qd[:, i] == 0.0, 1.0, share)
        torque, speed = (rotor + load * share) / train.gear, np.abs(train.gear * found.qd[:, i])
        worst = max(worst, float((np.abs(torque) / allowed(train.motor.peak, speed * (1 - 1e-12))).max()))
        worst = max(worst, float(np.abs(load).max()) / train.motor.gear_peak)
    return worst


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow), pytest.param(3, marks=pytest.mark.slow)])
def test_motors_gears_and_friction_keep_their_limits(seed):
    model, rng = robodyn.load(str(FOLDER / "puma560.urdf")), np.random.default_rng(seed)
    for _ in range(2):
        scene = random_scene(model, rng)
        q = 0.5 * random_path(model, rng, 4)
        found = retime(model, q, scene, grid=400, rate=2000.0)
        assert found.feasible, found.reason
        assert at_shafts(model, scene, found) <= 1.0 + 1e-8
        tau = robodyn.inverse_dynamics(model, found.q, found.qd, found.qdd, scene=scene)
        assert np.abs(found.tau - tau).max() <= 1e-12 * np.abs(tau).max()
        longer = retime(model, q, scene, grid=400, speed=0.9)
        assert longer.duration >= found.duration * (1.0 - 1e-6)
        assert sum(one.share_of_time for one in found.binding) >= 0.5


def test_stribeck_and_coupled_motors_are_along_for_the_ride():
    model = robodyn.load(str(FOLDER / "puma560.urdf"))
    coupled = CoupledMotor("w", {"wrist_pitch": 1.0, "flange_roll": 0.5}, 1e-4, 50.0, Friction(0.1, 0.2, -0.2))
    friction = {"waist": Friction(1.0, 3.0, -3.0, stribeck=6.0, stribeck_velocity=0.05)}
    found = retime(model, str(FOLDER / "puma560_waypoints.csv"), Scene(friction=friction, coupled=(coupled,)), grid=500)
    assert found.feasible
    assert found.used.max() <= 1.0 + 1e-9


# Jerk


@pytest.mark.parametrize("jerk", [20.0, pytest.param(200.0, marks=pytest.mark.slow)])
def test_limits_of_jerk_are_kept_too(jerk):
    model, rng = real("ur5_robot"), np.random.default_rng(6)
    found = retime(model, random_path(model, rng, 4), acceleration=8.0, jerk=jerk, grid=400, rate=2000.0)
    assert found.feasible
    assert found.used.max() <= 1.0 + 1e-9
    h = found.time[1] - found.time[0]
    assert np.abs(np.diff(found.qdd, axis=0)).max() <= jerk * h * (1.0 + 1e-6)  # the mean of the jerk between rows
    assert np.abs(found.qdd[[0, -1]]).max() <= jerk * h


def test_a_large_limit_of_jerk_costs_little():
    found = retime(slide(), [[0.0], [3.0]], jerk=50.0)
    a, J, L = 2.0, 50.0, 3.0
    v = 0.5 * a * (np.hypot(a / J, 2.0 * np.sqrt(L / a)) - a / J)
    assert found.duration == pytest.approx(L / v + v / a + a / J, rel=1e-3)
    assert found.joints[0].use["jerk"] <= 1.0 + 1e-9


# Curves


def test_the_spline_goes_through_its_points_with_even_accelerations():
    rng = np.random.default_rng(1)
    q = rng.normal(size=(7, 3))
    path = spline(WayPoints(q, np.arange(1, 8), np.zeros(7)))
    assert np.abs(path.at(path.marks, path.pieces(path.marks, np.array(0)))[0] - q).max() <= 1e-12
    left, right = (path.at(path.breaks[1:-1], np.arange(k, 5 + k)) for k in (0, 1))
    for a, b in zip(left[:3], right[:3], strict=True):
        assert np.abs(a - b).max() <= 1e-9


@pytest.mark.parametrize("radius", [0.05, 0.4, 9.0])
def test_blends_leave_lines_and_join_them_with_even_accelerations(radius):
    rng = np.random.default_rng(2)
    q = rng.normal(size=(6, 3))
    path = lines(WayPoints(q, np.arange(1, 7), np.zeros(6)), radius)
    inner = np.arange(len(path.breaks) - 2)
    left, right = (path.at(path.breaks[1:-1], inner + k) for k in (0, 1))
    for a, b in zip(left[:3], right[:3], strict=True):
        assert np.abs(a - b).max() <= 1e-9
    corner = path.at(path.marks[1:-1], path.pieces(path.marks[1:-1], np.array(0)))[0]
    along = np.diff(q, axis=0) / np.linalg.norm(np.diff(q, axis=0), axis=1)[:, None]
    lengths = np.linalg.norm(np.diff(q, axis=0), axis=1)
    r = np.minimum(np.minimum(lengths[:-1], lengths[1:]) / 2, radius)
    assert np.abs(corner - q[1:-1] - 3 / 16 * r[:, None] * (along[1:] - along[:-1])).max() <= 1e-12


# What cannot be, and what is wrong


def test_a_path_that_a_joint_cannot_bear_is_told_with_its_place():
    found = retime(slide(axis="0 0 1"), [[0.0], [1.0]])
    assert not found.feasible
    assert found.where == {"joint": "x", "row": 1.0, "missing": pytest.approx(2 * 9.81 - 4.0), "unit": "N"}
    assert "x needs 19.62 N to stand still at row 1" in found.reason
    arm = robodyn.load(str(FOLDER / "two_link_planar.urdf"))
    heavy = retime(arm, [[1.5, 0.0], [0.0, 0.0]], Scene(payloads=(Payload(list(arm.links)[-1], 12.0, (0.5, 0, 0)),)))
    assert not heavy.feasible


def test_positions_beyond_a_limit_are_told():
    found = retime(slide(), [[0.0], [8.9], [0.0]])
    assert found.feasible
    found = retime(slide(), [[0.0], [9.5], [0.0]])
    assert found.where["missing"] == pytest.approx(0.5)
    assert "beyond its limit of 9 m" in found.reason


@pytest.mark.parametrize(
    ("model", "path", "how", "what"),
    [
        ("slide", [[0.0]], {}, "fewer than two places"),
        ("slide", [[1.0], [1.0]], {}, "fewer than two places"),
        ("slide", [[0.0], [np.nan]], {}, "finite numbers"),
        ("slide", [[0.0, 1.0]], {}, "shape (1, 2)"),
        ("slide", [[0.0], [1.0]], {"profile": "fast"}, "no profile 'fast'"),
        ("slide", [[0.0], [1.0]], {"speed": 1.5}, "speed is 150 %"),
        ("slide", [[0.0], [1.0]], {"acceleration": -1.0}, "acceleration is -1"),
        ("slide", [[0.0], [1.0]], {"jerk": [1.0, 2.0]}, "2 values for 1 coordinate"),
        ("slide", [[0.0], [1.0]], {"blend": 0.1, "profile": "scurve"}, "does not go with scurve"),
        ("slide", [[0.0], [1.0]], {"rate": 1e9}, "rows"),
        ("slide", [[0.0], [1e300]], {}, "x is at 1e+300"),
        ("slide", np.linspace(0.0, 1.0, 600)[:, None], {"profile": "trapezoid"}, "600 way-points to stop at"),
    ],
)
def test_what_is_wrong_is_said(model, path, how, what):
    with pytest.raises(InputError, match=re.escape(what)):
        retime(slide(), path, **how)


def test_what_has_no_limit_of_acceleration_is_refused():
    text = (
        SLIDE.replace("KIND", "prismatic")
        .replace("AXIS", "1 0 0")
        .replace("VELOCITY", "1")
        .replace('effort="4"', 'effort="0"')
    )
    for profile in ("optimal", "trapezoid"):
        with pytest.raises(InputError, match="nothing limits the acceleration"):
            retime(robodyn.load(text.encode()), [[0.0], [1.0]], profile=profile)


@pytest.mark.parametrize(
    ("scene", "what"),
    [
        (Scene(wrenches=(ExternalWrench("car", ("push", 0.0, 0.0)),)), "column"),
        (Scene(passive=("x",)), "do not drive"),
        (Scene(friction={"x": Friction(load=0.1)}), "grows with load"),
    ],
)
def test_scenes_that_are_not_known_are_refused(scene, what):
    with pytest.raises(RobodynError, match=what):
        retime(slide(), [[0.0], [1.0]], scene)


def test_the_command_writes_what_torques_finds_within_limits(tmp_path, monkeypatch):
    out, arm, way = tmp_path / "motion.csv", str(FOLDER / "puma560.urdf"), str(FOLDER / "puma560_waypoints.csv")
    for options in ([], ["--profile", "trapezoid", "--speed", "80%"], ["--blend", "0.1", "--jerk", "800"]):
        assert run("retime", arm, way, *options, "--grid", "300", "--out", str(out)).status == 0
        assert run("torques", arm, str(out), "--fail-on-limits").status == 0
    out.unlink()
    ended = run("retime", arm, way, "--payload", "flange=90", "--out", str(out))
    assert ended.status == 1
    assert "are missing" in ended.out
    assert not out.exists()


def test_bad_tables_are_told_in_one_line(tmp_path):
    for text, what in (
        ("x,dwell\n0,0\n1,-2\n", "row 2: dwell is -2 s"),
        ("x\n0\nabc\n", ":3:"),
        ("y\n0\n1\n", "no position of joint 'x'"),
        ("x\n", "has no rows"),
        ("", "no header"),
    ):
        table = tmp_path / "bad.csv"
        table.write_text(text)
        with pytest.raises(RobodynError) as told:
            retime(slide(), table)
        assert "\n" not in str(told.value)
        assert what in str(told.value) or what == "no header"


def test_a_limit_that_is_lower_takes_longer():
    model, rng = real("ur5_robot"), np.random.default_rng(9)
    q = random_path(model, rng, 5)
    quick, slow = (retime(model, q, acceleration=a, grid=400).duration for a in (20.0, 10.0))
    assert quick < slow
    weak = [replace(body, joint=replace(body.joint, effort=(body.joint.effort or 0.0) * 0.8)) for body in model.bodies]
    assert retime(replace(model, bodies=tuple(weak)), q, acceleration=20.0, grid=400).duration >= quick
