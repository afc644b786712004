"""Choices of motors and gears against brute force in plain NumPy, `torques` with the same motors, and Pinocchio."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from helpers.example_robots import real
from helpers.motions import waves
from helpers.peers import pin
from helpers.robot_files import FOLDER
from helpers.small_robots import link
from scipy.integrate import trapezoid

import robodyn
from robodyn.sizing.catalogue import LIMITS, Course, judged
from robodyn.sizing.catalogue_tables import CatalogueGear, CatalogueMotor

ROBOTS = ("puma560", "ur5_robot", "scara", "cylindrical", "gripper")
TOLERANCE = 1e-9


@cache
def robot(name):
    return real(name) if name.endswith("robot") else robodyn.load(FOLDER / f"{name}.urdf")


def motions(a_model, count=2, rows=160):
    """Motions of different length, in no more than is plausible for slides."""
    times = (np.linspace(0.0, 1.0 + k, rows) for k in range(count))
    return [waves(a_model, time, seed=k, amplitude=0.3) for k, time in enumerate(times)]


def drawn(a_model, count, ratios, seed=0, scale=20.0):
    """A catalogue of so many motors, and gears, about the size that a robot takes: curves with and without bends, also
    such as rise, unknown limits, and screws."""
    rng = np.random.default_rng(seed)

    def curve(torque, speed):
        match rng.integers(4):
            case 0:
                return float(torque)
            case 1:
                return ((0.0, torque), (0.5 * speed, torque), (speed, torque * rng.uniform(0.2, 0.9)))
            case 2:
                return ((0.0, 0.6 * torque), (0.3 * speed, torque), (speed, torque * rng.uniform(0.2, 0.9)))
            case _:
                return tuple((x * speed, torque * rng.uniform(0.5, 1.0)) for x in (0.0, 0.1, 0.2, 0.4, 1.0))

    motors = []
    for k in range(count):
        torque, speed = 10 ** rng.uniform(-1.5, 1.0), rng.uniform(100, 700)
        inertia = rng.uniform(0, 1) * 1e-4 * torque
        cells = (inertia, curve(0.4 * torque, speed), curve(torque, speed), speed, rng.uniform(0.1, 0.4) * scale / 10)
        price = float(rng.integers(20, 60))
        motors.append(CatalogueMotor(f"m{k}", *cells, price, rng.uniform(0.1, 2), rng.uniform(0.02, 0.3)))
    gears = []
    for k in range(max(1, ratios // 5)):
        peak = 10 ** rng.uniform(0.5, 2.5)
        screw = k % 3 == 2
        values = () if screw else tuple(map(float, rng.choice(np.arange(3, 200), 5, replace=False)))
        lead = float(rng.uniform(0.003, 0.05)) if screw else None
        peak *= 20 if screw else 1
        limits = [None if rng.uniform() < 0.2 else x for x in (peak, 0.5 * peak, rng.uniform(200, 900))]
        gears.append(
            CatalogueGear(f"g{k}", values, lead, rng.uniform(0.4, 1.0), *limits, 1e-5, rng.uniform(0.1, 1), 50.0)
        )
    return motors, gears


def plain(parts, motor, gear, ratio):
    """What a motor uses of each limit, sample by sample: dwell and all, by interpolation and trapezoids as they are."""

    def allowed(curve, speed):
        if isinstance(curve, float):
            return curve
        x, y = np.array(curve).T
        return np.where(speed > x[-1], 0.0, np.interp(speed, x, y))

    J, uses, losses = motor.inertia + gear.inertia, [], []
    fastest = max(np.abs(qd).max() for _, _, qd, _ in parts) * ratio / motor.speed_limit
    for time, load, qd, qdd in parts:
        T, lost = np.zeros(len(time)), np.zeros(len(time))
        for i, (L, v, a) in enumerate(zip(load, qd, qdd, strict=True)):
            e = gear.efficiency
            given, power = L / ratio, L * v
            T[i] = ratio * J * a + (given / e if power > 0 else given * e if power < 0 else given)
            lost[i] = power * (1 / e - 1) if power > 0 else -power * (1 - e)
        speed, span = np.abs(ratio * qd), time[-1] - time[0]
        fast = speed.max()
        use = dict.fromkeys(LIMITS)
        use["speed"] = fast / motor.speed_limit
        if gear.max_input_speed:
            use["input speed"] = fast / gear.max_input_speed
        if fastest <= 1 + TOLERANCE:
            use["peak torque"] = (np.abs(T) / allowed(motor.peak_torque, speed)).max()
        mean = trapezoid(speed, time) / span
        rms = np.sqrt(trapezoid(T * T, time) / span)
        with np.errstate(divide="ignore"):
            use["RMS torque"] = rms / allowed(motor.continuous_torque, mean)
        if gear.peak_torque:
            use["gear peak"] = np.abs(load).max() / gear.peak_torque
        if gear.average_torque:
            travel = trapezoid(np.abs(qd), time)
            use["gear mean"] = np.cbrt(trapezoid(np.abs(qd * load**3), time) / travel) / gear.average_torque
        uses.append(use)
        losses.append(motor.resistance * (rms / motor.torque_constant) ** 2 + trapezoid(lost, time) / span)
    found = {name: [use[name] for use in uses if use[name] is not None] for name in LIMITS}
    return {name: max(values) for name, values in found.items() if values}, max(losses)


def fitting(joint, gears):
    """The gears, each in a ratio, that go between a motor and a joint."""
    slide = joint.kind == "prismatic"
    both = ((gear, ratio) for gear in gears for ratio in ([2 * np.pi / gear.lead] if gear.lead else gear.ratio))
    return [(gear, ratio) for gear, ratio in both if bool(gear.lead) == slide]


def brute(a_model, some_motions, motors, gears):
    """By joint from the tips to the base: every pair with its uses, and the lightest that suffices."""
    places = {body.joint.name: k for k, body in enumerate(a_model.bodies)}
    rotors = {joint.name: robodyn.Rotor(0.0, 1.0) for joint in a_model.independent}
    found, loads = {}, []
    for joint in sorted(a_model.independent, key=lambda each: -places[each.name]):
        bare = robodyn.Scene(rotor=rotors, payloads=tuple(loads))
        parts = []
        for each in some_motions:
            tau = robodyn.inverse_dynamics(a_model, each.q, each.qd, each.qdd, scene=bare)
            parts.append((each.time, tau[:, joint.rate], each.qd[:, joint.rate], each.qdd[:, joint.rate]))
        pairs = {}
        for motor in motors:
            for gear, ratio in fitting(joint, gears):
                pairs[motor.name, gear.name, ratio] = (*plain(parts, motor, gear, ratio), motor.mass + gear.mass)
        enough = [key for key, (uses, _, _) in pairs.items() if max(uses.values()) <= 1 + TOLERANCE]
        some = enough or [min(pairs, key=lambda key: max(pairs[key][0].values()))]
        best = min(some, key=lambda key: pairs[key][2]) if pairs else None
        found[joint.name] = pairs, set(enough), best
        if best:
            before = a_model.bodies[a_model.bodies[places[joint.name]].parent].name
            loads.append(robodyn.Payload(before, pairs[best][2], tuple(joint.p.tolist())))
    return found


def compared(a_model, some_motions, motors, gears):
    """The number of pairs of which brute force says the same as `size`."""
    found = robodyn.size(a_model, some_motions, motors, gears)
    expected, count = brute(a_model, some_motions, motors, gears), 0
    assert found.converged
    assert found.sweeps == 2
    for joint in found.joints:
        pairs, enough, best = expected[joint.name]
        named = {(each.motor.name, each.gear.name, each.ratio): each for each in joint.choices}
        assert named.keys() == pairs.keys()
        assert {key for key, each in named.items() if each.feasible} == enough
        if pairs:
            first = joint.choices[0]
            assert (first.motor.name, first.gear.name, first.ratio) == best
        for key, (uses, loss, mass) in pairs.items():
            each = named[key]
            for name in LIMITS:
                margin = each.margins[name]
                assert (margin is None) == (name not in uses)
                if margin is not None and uses[name] < 1e8:
                    assert abs(1 - margin - uses[name]) <= TOLERANCE * (1 + uses[name]), (joint.name, key, name)
            assert each.mass == mass
            assert abs(each.loss - loss) <= TOLERANCE * loss + 1e-12
        count += len(pairs)
    return count


@pytest.mark.parametrize("name", ["scara", "gripper"])
def test_brute_force_on_a_few(name):
    a_model = robot(name)
    assert compared(a_model, motions(a_model, rows=60), *drawn(a_model, 10, 30)) > 200


@pytest.mark.slow
@pytest.mark.parametrize("name", ROBOTS)
def test_brute_force_on_ten_thousand_pairs(name):
    a_model = robot(name)
    count = compared(a_model, motions(a_model, rows=40), *drawn(a_model, 100, 150 // (2 if a_model.n > 4 else 1)))
    assert count > 10_000


OF_LIMIT = {
    "motor torque": "peak torque",
    "RMS motor torque": "RMS torque",
    "gear torque": "gear peak",
    "mean gear torque": "gear mean",
}


@pytest.mark.parametrize("name", [ROBOTS[0], *(pytest.param(each, marks=pytest.mark.slow) for each in ROBOTS[1:])])
def test_torques_judges_alike(name):
    """Random pairs of all joints at once as motors of a scene: the same limits are exceeded, by as much."""
    a_model, rng = robot(name), np.random.default_rng(3)
    motors, gears = drawn(a_model, 40, 30)
    (only,) = motions(a_model, 1)
    found = robodyn.size(a_model, only, motors, gears)
    exceeded = 0
    for _ in range(20):
        drives, rotors, picked = {}, {}, {}
        for joint in found.joints:
            each = picked[joint.name] = joint.choices[rng.integers(len(joint.choices))]
            most = [x for x in (each.motor.speed_limit, each.gear.max_input_speed) if x]
            limits = each.gear.average_torque, each.gear.peak_torque
            curves = each.motor.continuous_torque, each.motor.peak_torque
            drives[joint.name] = robodyn.Motor(each.gear.efficiency, *curves, min(most), *limits)
            rotors[joint.name] = robodyn.Rotor(each.motor.inertia + each.gear.inertia, each.ratio)
        nearest = {joint.name: joint.choices[0] for joint in found.joints}
        loads = [
            robodyn.Payload(
                a_model.bodies[body.parent].name, nearest[body.joint.name].mass, tuple(body.joint.p.tolist())
            )
            for body in a_model.bodies
            if body.joint.name in nearest
        ]
        scene = robodyn.Scene(rotor=rotors, motor=drives, payloads=tuple(loads))
        for joint in robodyn.torques(a_model, only, scene).sizing.joints:
            each, wrong = picked[joint.name], {one.quantity: one for one in joint.exceeded}
            wrong = {quantity: one for quantity, one in wrong.items() if quantity not in ("effort", "velocity")}
            assert each.feasible == (not wrong), (joint.name, each, wrong)
            exceeded += len(wrong)
            for quantity, limit in OF_LIMIT.items():
                margin = each.margins[limit]
                if quantity in wrong and margin is not None and wrong[quantity].limit:
                    use = wrong[quantity].value / wrong[quantity].limit
                    assert abs(1 - margin - use) <= TOLERANCE * use
    assert exceeded > 15


def test_the_scene_of_the_best_suffices(tmp_path):
    """For every joint, as `torques` reads it from the file that is written."""
    a_model = robot("puma560")
    found = robodyn.size(
        a_model,
        FOLDER / "puma560_sweep.csv",
        FOLDER / "catalogue" / "motors.csv",
        FOLDER / "catalogue" / "gears.csv",
        by="loss",
    )
    (tmp_path / "chosen.toml").write_text(found.toml)
    scene = robodyn.load_scene(tmp_path / "chosen.toml")
    assert replace(scene, motor=found.scene.motor, rotor=found.scene.rotor) == found.scene
    result = robodyn.torques(a_model, FOLDER / "puma560_sweep.csv", scene)
    assert [joint.level for joint in result.sizing.joints] == ["OK"] * 6
    for joint, own in zip(found.joints, result.sizing.joints, strict=True):
        assert own.motor.rms == pytest.approx(
            (1 - joint.best.margins["RMS torque"]) * own.motor.continuous_limit, rel=1e-9
        )


def test_masses_load_the_joints_before():
    """By Pinocchio, with the mass of each motor at the origin of its joint."""
    pytest.importorskip("pinocchio")
    a_model = robot("puma560")
    only, scene = (
        motions(a_model, 1)[0],
        robodyn.Scene(friction={name: robodyn.Friction() for name in a_model.joint_names}),
    )
    found = robodyn.size(a_model, only, *drawn(a_model, 20, 20), scene)
    peer = pin.buildModelFromUrdf(str(FOLDER / "puma560.urdf"))
    for joint in found.joints:
        k = peer.getJointId(joint.name)
        mass = pin.Inertia(joint.choices[0].mass, np.zeros(3), np.zeros((3, 3)))
        peer.appendBodyToJoint(peer.parents[k], mass, peer.jointPlacements[k])
    data = peer.createData()
    peer.armature = np.zeros(6)
    tau = np.array([pin.rnea(peer, data, *each).copy() for each in zip(only.q, only.qd, only.qdd, strict=True)])
    for joint, load in zip(found.joints, np.abs(tau).max(axis=0), strict=True):
        assert joint.course.peak == pytest.approx(load, rel=1e-9)
    heavier = [joint.course.peak for joint in found.joints]
    light = robodyn.size(a_model, only, *drawn(a_model, 20, 20), scene, masses_included=True)
    lighter = [joint.course.peak for joint in light.joints]
    assert heavier[1] > 1.05 * lighter[1]
    assert heavier[-1] == lighter[-1]


def test_harmonic_load_in_closed_form():
    """J q'' alone, q = A sin w t: the RMS of G J w^2 A sin over sqrt(2), the largest speed A w, the inertia ratio."""
    time = np.linspace(0.0, 1.0, 4001)
    A, w, load, G, J = 0.5, 2 * np.pi, 2.0, 10.0, 1e-3
    qd, qdd = A * w * np.cos(w * time), -A * w * w * np.sin(w * time)
    course = Course([(time, load * qdd, qd, qdd)])
    motor = CatalogueMotor("m", J, 1.0, 2.0, 50.0, 1.0, resistance=2.0, torque_constant=0.5)
    gear = CatalogueGear("g", (G,), None, 1.0, 100.0, None, None)
    found = judged(course, load, motor, gear, G)
    rms = (G * J + load / G) * A * w * w / np.sqrt(2)
    assert 1 - found.margins["RMS torque"] == pytest.approx(rms, rel=1e-9)
    assert 1 - found.margins["peak torque"] == pytest.approx(rms * np.sqrt(2) / 2.0, rel=1e-6)
    assert 1 - found.margins["speed"] == pytest.approx(A * w * G / 50.0, rel=1e-12)
    assert found.inertia_ratio == pytest.approx(load / (G * G * J))
    assert found.loss == pytest.approx(2.0 * (rms / 0.5) ** 2, rel=1e-9)
    assert found.margins["gear mean"] is None


def test_ranks_and_ties():
    a_model = robot("puma")
    motors, gears = drawn(a_model, 10, 20)
    only = motions(a_model, 1)
    for by in ("mass", "price", "loss"):
        for joint in robodyn.size(a_model, only, motors, gears, by=by).joints:
            values = [getattr(each, by) for each in joint.choices[: joint.feasible]]
            assert values == sorted(values)
            assert not any(each.feasible for each in joint.choices[joint.feasible :])
            if by == "price":  # of equals the first in the catalogue
                order = [
                    (int(each.motor.name[1:]), int(each.gear.name[1:])) for each in joint.choices[: joint.feasible]
                ]
                runs = {value: [at for at, own in zip(order, values, strict=True) if own == value] for value in values}
                assert all(run == sorted(run) for run in runs.values())


def test_a_limit_on_the_inertia_ratio():
    a_model = robot("puma")
    found = robodyn.size(a_model, motions(a_model, 1), *drawn(a_model, 20, 20), inertia_ratio=5.0)
    for each in (each for joint in found.joints for each in joint.choices if each.inertia_ratio is not None):
        assert each.margins["inertia ratio"] == pytest.approx(1 - each.inertia_ratio / 5.0)
        assert each.inertia_ratio <= 5.0 * (1 + 1e-9) or not each.feasible


def test_the_largest_inertia_may_last_for_one_sample():
    a_model, time, rows = robot("scara"), np.linspace(0.0, 5.0, 5001), np.zeros((5001, 3))
    q = rows + np.array([0.0, 2.0, 0.0])
    q[4001, 1] = 0.0
    drives = drawn(a_model, 5, 5)
    folded, once, straight = (
        robodyn.size(a_model, robodyn.motion(a_model, time, each, rows, rows), *drives, masses_included=True)
        for each in (rows + q[0], q, rows)
    )
    first = [max(each.inertia_ratio for each in found.joints[0].choices) for found in (folded, once, straight)]
    assert first[0] < 0.9 * first[1]
    assert first[1] == pytest.approx(first[2])


def test_several_motions_count_at_their_worst():
    """Peaks of all, RMS of the worst: not of all together."""
    a_model = robot("puma")
    motors, gears = drawn(a_model, 10, 20)
    both = motions(a_model, 2)
    of_each = [robodyn.size(a_model, each, motors, gears, masses_included=True) for each in both]
    found = robodyn.size(a_model, both, motors, gears, masses_included=True)
    for k, joint in enumerate(found.joints):
        assert joint.course.peak == max(each.joints[k].course.peak for each in of_each)
        assert joint.course.rms == pytest.approx(max(each.joints[k].course.rms for each in of_each), rel=1e-12)


def test_motors_that_load_each_other_by_mimicry(tmp_path):
    """Two branches, each of which turns with the last joint of the other: sweeps go on until nothing changes."""
    twin = {name: f'<mimic joint="{name}"/>' for name in ("k", "r")}
    parts = [
        ("m", "base", "a1", twin["r"]),
        ("k", "a1", "a2", ""),
        ("n", "base", "b1", twin["k"]),
        ("r", "b1", "b2", ""),
    ]
    links = "".join(
        link(name, 1.0, (0.15, 0, 0), (0.01, 0, 0, 0.01, 0, 0.01)) for name in ("base", "a1", "a2", "b1", "b2")
    )
    hinge = '<joint name="{}" type="continuous"><parent link="{}"/><child link="{}"/><origin xyz="0.3 0 0"/>'
    joints = "".join(f'{hinge.format(*part)}<axis xyz="0 1 0"/>{mimic}</joint>' for *part, mimic in parts)
    (tmp_path / "twins.urdf").write_text(f'<robot name="twins">{links}{joints}</robot>')
    a_model = robodyn.load(tmp_path / "twins.urdf")
    only = waves(a_model, np.linspace(0.0, 2.0, 100))
    found = robodyn.size(a_model, only, FOLDER / "catalogue" / "motors.csv", FOLDER / "catalogue" / "gears.csv")
    assert found.converged
    assert found.sweeps > 2
    assert {joint.level for joint in robodyn.torques(a_model, only, found.scene).sizing.joints} == {"OK"}
