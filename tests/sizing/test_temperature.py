"""Windings and housings against analytic solutions, plain integration and MuJoCo's motor; the bus and its energies."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers.command_line import ROBOTS
from helpers.small_robots import built, link
from scipy.integrate import solve_ivp, trapezoid
from scipy.linalg import expm

import robodyn
from robodyn.loads import temperature
from robodyn.loads.temperature import HeatPass, loss_factor, response
from robodyn.scene.read import load_scene
from robodyn.scene.scene import Motor, Rotor, Scene, Thermal
from robodyn.trajectory.read import motion

LIMITS = '<limit lower="-1e6" upper="1e6" effort="1e6" velocity="1e6"/>'
CONSTANT = Thermal(0.5, 0.05, 1.2, 20.0, 155.0, 5.0, 400.0, resistance_coefficient=0.0)
COPPER = replace(CONSTANT, resistance_coefficient=0.00393, ambient=40.0)
MAGNETS = replace(COPPER, torque_coefficient=-0.002)


def wheel(J=2.0):
    hinge = (
        f'<joint name="j" type="revolute"><parent link="base"/><child link="wheel"/><axis xyz="0 0 1"/>{LIMITS}</joint>'
    )
    return built(link("base"), link("wheel", J, inertia=(J, 0, 0, J, 0, J)), hinge)


def heated(thermal, time, qdd, qd=None, **motor):
    """The heat of a wheel of 2 kg m^2 that is turned so, by a motor without a gear."""
    model, qdd = wheel(), np.asarray(qdd, dtype=float)[:, None]
    qd = 0 * qdd if qd is None else np.asarray(qd, dtype=float)[:, None]
    scene = Scene(gravity=(0.0, 0.0, 0.0), motor={"j": Motor(thermal=thermal, **motor)})
    return robodyn.torques(model, motion(model, time, 0 * qd, qd, qdd), scene, history=True)


def matrix(thermal):
    """Of winding and housing above ambient."""
    a, b = (
        1 / (thermal.winding_housing * thermal.winding_capacity),
        1 / (thermal.winding_housing * thermal.housing_capacity),
    )
    return np.array([[-a, a], [b, -b - 1 / (thermal.housing_ambient * thermal.housing_capacity)]])


def random_course(seed, n=300):
    rng = np.random.default_rng(seed)
    return rng.uniform(0.001, 0.5, n), rng.uniform(0, 0.02, n)


def test_two_nodes_along_a_course_are_those_of_matrix_exponentials():
    """Constant coefficients, 300 uneven intervals: 1e-12 of the largest rise."""
    steps, square = random_course(1)
    start = np.array((30.0, 10.0))
    found, _ = response(CONSTANT, steps, square, start)
    state, expected = start, [start]
    for h, mean in zip(steps, square, strict=True):
        M = np.zeros((3, 3))
        M[:2, :2] = matrix(CONSTANT)
        M[0, 2] = 0.5 / 0.05**2 * mean / 20.0
        state = (expm(M * h) @ np.append(state, 1.0))[:2]
        expected.append(state)
    assert np.abs(found - expected).max() <= 1e-12 * np.abs(expected).max()


def test_constant_torque_and_its_steady_state():
    """20 s of 0.1 N m at 0.05 N m/A and 0.5 ohm, 2 W: eigenvalues, and 2 W (R1 + R2) for ever, at 1e-9."""
    heat = heated(CONSTANT, np.linspace(0, 20, 2001), np.full(2001, 0.05)).sizing.joints[0].motor.heat
    M, b = matrix(CONSTANT), np.array((2.0 / 20.0, 0.0))
    rest = -np.linalg.solve(M, b)
    values, vectors = np.linalg.eig(M)
    once = rest + vectors @ (np.exp(values * 20.0) * np.linalg.solve(vectors, -rest))
    assert abs(heat.winding_once - 25 - once[0]) <= 1e-9 * once[0]
    assert abs(heat.housing_once - 25 - once[1]) <= 1e-9 * once[1]
    assert abs(heat.winding - 25 - 2.0 * 6.2) <= 1e-9 * 12.4
    assert abs(heat.housing - 25 - 2.0 * 5.0) <= 1e-9 * 10.0
    assert abs(heat.copper_loss - 40.0) <= 1e-12 * 40.0


def test_periodic_steady_state_of_a_duty_cycle_is_the_analytic_one():
    """On for 3 s, off for 7 s, by eigenvalues: x = (I - e^(M 10))^-1 e^(M 7) (e^(M 3) - I) M^-1 b, at 1e-9."""
    time = np.array((0.0, 3.0 - 1e-9, 3.0, 10.0))
    heat = heated(CONSTANT, time, (0.1, 0.1, 0.0, 0.0)).sizing.joints[0].motor.heat
    M, b = matrix(CONSTANT), np.array((0.5 * (0.2 / 0.05) ** 2 / 20.0, 0.0))
    on, off = expm(M * 3.0), expm(M * 7.0)
    gained = (on - np.eye(2)) @ np.linalg.solve(M, b)
    begin = np.linalg.solve(np.eye(2) - off @ on, off @ gained)
    hottest = on @ begin + gained
    assert abs(heat.winding - 25 - hottest[0]) <= 2e-9 * hottest[0]


def test_short_cycles_of_slow_motors_keep_their_digits():
    """1 s of 1000 rows, and a housing that takes 2e5 s: what a cycle changes is small beside what it keeps."""
    slow = replace(CONSTANT, housing_capacity=4e4)
    heat = heated(slow, np.linspace(0, 1, 1001), np.full(1001, 0.05)).sizing.joints[0].motor.heat
    assert abs(heat.winding - 25 - 12.4) <= 1e-11
    assert abs(heat.housing - 25 - 10.0) <= 1e-11


@pytest.mark.parametrize("thermal", [COPPER, MAGNETS])
def test_warm_windings_and_weak_magnets_against_an_integrator(thermal):
    """DOP853 along the steady state: 1e-7 K over 60 intervals, whose loss is that of their middle."""
    steps, square = random_course(2, 60)
    steady, _ = response(thermal, 0.1 * steps, square, None)
    assert np.abs(steady[-1] - steady[0]).max() <= 1e-9

    def slope(_, x, mean):
        heat = loss_factor(thermal, x[0])[0] * mean
        return [(heat - (x[0] - x[1]) / 1.2) / 20.0, ((x[0] - x[1]) / 1.2 - x[1] / 5.0) / 400.0]

    state = steady[0]
    for k, (h, mean) in enumerate(zip(0.1 * steps, square, strict=True), start=1):
        state = solve_ivp(slope, (0, h), state, "DOP853", args=(mean,), rtol=1e-12, atol=1e-12).y[:, -1]
        assert np.abs(state - steady[k]).max() <= 1e-7
    hotter = loss_factor(thermal, np.array(50.0))[0] / loss_factor(thermal, np.array(0.0))[0]
    expected = (
        (1 + 0.00393 * 65)
        / (1 + 0.00393 * 15)
        * ((1 + thermal.torque_coefficient * 15) / (1 + thermal.torque_coefficient * 65)) ** 2
    )
    assert abs(hotter - expected) <= 1e-14 * expected


@pytest.mark.parametrize("thermal", [COPPER, MAGNETS])
def test_runaway_begins_where_no_temperature_balances(thermal):
    """Held torque T: heat f(x) T^2 against x / 6.2 K/W; the least T without a solution is told within 1e-6."""
    x = np.linspace(0, 2e4 if thermal is COPPER else 450.0, 400_001)
    most = np.max(x / 6.2 / loss_factor(thermal, x)[0]) if thermal is MAGNETS else 1 / 6.2 / (200.0 * 0.00393)
    for share, runs in ((1 - 1e-6, False), (1 + 1e-6, True)):
        found, _ = response(thermal, np.array([50.0, 10.0]), np.full(2, most * share), None)
        assert (found is None) == runs
    result = heated(thermal, [0.0, 10.0], [0.5, 0.5])
    (joint,) = result.sizing.joints
    assert (joint.level, joint.exceeded[0].quantity, joint.motor.heat.winding) == (
        "over temperature",
        "thermal runaway",
        None,
    )
    assert result.within_limits is False


def test_a_cycle_in_pieces_is_the_cycle():
    """Blocks of any size gather the same, and merged intervals keep the integrals."""
    rng = np.random.default_rng(3)
    time, torque, speed = np.cumsum(rng.uniform(0.01, 0.1, 500)), rng.normal(size=(1, 500)), rng.normal(size=(1, 500))
    whole, pieces = HeatPass({0: COPPER}), HeatPass({0: COPPER})
    whole.update(time, 0.1 * torque, speed)
    for k in range(0, 500, 37):
        pieces.update(time[k : k + 37], 0.1 * torque[:, k : k + 37], speed[:, k : k + 37])
    one, other = (each.report(["j"], False) for each in (whole, pieces))
    assert one.motors["j"].winding == pytest.approx(other.motors["j"].winding, rel=1e-13)
    assert one.bus.drawn == pytest.approx(other.bus.drawn, rel=1e-13)


def test_long_motions_are_merged(monkeypatch):
    """5000 rows in 300 intervals: the winding within 0.01 K of the whole, the energy of the bus to the last digits."""
    t = np.linspace(0, 50, 5001)
    whole = heated(COPPER, t, 0.2 * np.sin(t) ** 2).sizing
    monkeypatch.setattr(temperature, "MOST", 300)
    merged = heated(COPPER, t, 0.2 * np.sin(t) ** 2).sizing
    assert abs(merged.joints[0].motor.heat.winding - whole.joints[0].motor.heat.winding) <= 0.01
    assert merged.bus.drawn == pytest.approx(whole.bus.drawn, rel=1e-5)


def test_pose_is_held_for_ever():
    (joint,) = heated(COPPER, [0.0], [0.1]).sizing.joints
    heat, loss = joint.motor.heat, 0.5 * (0.2 / 0.05) ** 2
    rise = 6.2 * loss * (1 + 0.00393 * 15) / (1 - 6.2 * loss * 0.00393)
    assert heat.winding - 40 == pytest.approx(rise, rel=1e-12)
    assert (heat.winding_once, heat.copper_loss, heat.drawn) == (40.0, 0.0, 0.0)


def test_limit_of_winding_and_housing_in_degrees_decides_in_place_of_the_rms_torque():
    t = np.linspace(0, 1, 11)
    hot = heated(replace(CONSTANT, winding_limit=100.0), t, np.full(11, 0.05), continuous=0.05).sizing.joints[0]
    assert (hot.level, hot.exceeded) == ("OK", ())
    hot = heated(replace(CONSTANT, winding_limit=37.0, housing_limit=34.0), t, np.full(11, 0.05)).sizing.joints[0]
    assert {each.quantity: round(each.excess, 9) for each in hot.exceeded} == {
        "winding temperature": 0.4,
        "housing temperature": 1.0,
    }
    assert {each.level for each in hot.exceeded} == {"over temperature"}
    assert {each.unit for each in hot.exceeded} == {"degC"}


def test_power_of_the_bus_is_torque_times_speed_and_loss():
    """P = (T w + R i^2) / e drawn, times e returned; a motor that is braked returns what its loss leaves."""
    t = np.linspace(0, 2 * np.pi, 40_001)
    thermal = replace(CONSTANT, drive_efficiency=0.9)
    sizing = heated(thermal, t, 0.1 * np.cos(t), 100 * np.sin(t)).sizing
    torque, speed = 0.2 * np.cos(t), 100 * np.sin(t)
    power = torque * speed + 0.5 * (torque / 0.05) ** 2
    power = np.where(power > 0, power / 0.9, power * 0.9)
    drawn, returned = trapezoid(np.maximum(power, 0), t), trapezoid(np.minimum(power, 0), t)
    bus, heat = sizing.bus, sizing.joints[0].motor.heat
    for found in (bus, heat):
        assert abs(found.drawn - drawn) <= 1e-8 * drawn
        assert abs(found.returned - returned) <= 1e-8 * drawn
        assert abs(found.peak_power - power.max()) <= 1e-4 * drawn
    assert heat.returned < -1.0
    assert abs(heat.copper_loss - 0.5 * 16 * np.pi) <= 1e-9 * 8 * np.pi


def test_cycles_on_the_way_are_those_of_repeating_the_motion():
    """The page's curve over cycles, against the motion done 40 times in one table."""
    t = np.linspace(0, 5, 101)
    once = heated(COPPER, t, 0.2 * np.sin(t))
    begins, hottest = once.history.heat.courses["j"]
    stride = round(begins[1] / 5.0)
    steps, square = np.diff(t), 0.5 * ((0.4 * np.sin(t[1:])) ** 2 + (0.4 * np.sin(t[:-1])) ** 2)
    many, _ = response(COPPER, np.tile(steps, 4 * stride), np.tile(square, 4 * stride), np.zeros(2))
    for k in range(4):
        inside = 40 + many[k * stride * 100 : (k * stride + 1) * 100 + 1]
        assert np.abs(hottest[k] - inside.max(axis=0)).max() <= 1e-10
    left = once.sizing.joints[0].motor.heat.winding - hottest[-1, 0]
    assert 0 < left <= 0.005 * (hottest[-1, 0] - 40)


@pytest.mark.parametrize("count", [3, pytest.param(10, marks=pytest.mark.slow)])
def test_mujocos_motor_gets_as_hot(count):
    """dcmotor, whose one node is a winding beside a housing at ambient: random voltages of 8 s at 1 ms, 0.1 K."""
    mujoco = pytest.importorskip("mujoco", minversion="3.5")
    thermal = Thermal(1.3, 0.05, 2.5, 30.0, 500.0, reference=25.0, ambient=40.0)
    J = 0.02
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><option timestep="0.001" gravity="0 0 0"/><worldbody><body><joint name="j" axis="0 0 1"/>
        <inertial pos="0 0 0" mass="1" diaginertia="{J} {J} {J}"/></body></worldbody><actuator><dcmotor joint="j"
        motorconst="0.05 0.05" resistance="1.3" thermal="2.5 30 0 0.00393 25 40"/></actuator></mujoco>"""
    )
    rng, ours = np.random.default_rng(4), wheel(J)
    for _ in range(count):
        data, rows = mujoco.MjData(model), []
        volts, w, phase = rng.uniform(5, 30, 3), rng.uniform(0.2, 6, 3), rng.uniform(0, 6, 3)
        for _ in range(8000):
            data.ctrl[0] = np.sum(volts * np.sin(w * data.time + phase))
            before = data.time, data.qpos[0], data.qvel[0], data.act[0]
            mujoco.mj_step(model, data)
            rows.append((*before, data.qacc[0]))
        t, q, qd, rise, qdd = np.array(rows).T
        scene = Scene(gravity=(0.0, 0.0, 0.0), motor={"j": Motor(thermal=thermal)})
        moved = motion(ours, t, q[:, None], qd[:, None], qdd[:, None])
        heat = robodyn.torques(ours, moved, scene).sizing.joints[0].motor.heat
        assert rise.max() > 5.0
        assert abs(heat.winding_once - 40 - rise.max()) <= 0.1


def test_gear_takes_its_share_of_the_energy():
    """An efficiency of 0.8: a fifth of what goes in while driving, of what comes back while braking."""
    t = np.linspace(0, 2 * np.pi, 20_001)
    model = wheel()
    scene = Scene(gravity=(0.0, 0.0, 0.0), motor={"j": Motor(efficiency=0.8)}, rotor={"j": Rotor(1e-5, gear=50.0)})
    qd = np.sin(t)[:, None]
    motor = robodyn.torques(model, motion(model, t, 0 * qd, qd, np.cos(t)[:, None]), scene).sizing.joints[0].motor
    load = 2.0  # J w per half cycle of accelerating, two of them
    assert motor.gear_loss == pytest.approx(load * (1 / 0.8 - 1) + load * (1 - 0.8), rel=1e-6)
    begin = motion(model, t[:5001], 0 * qd[:5001], qd[:5001], np.cos(t[:5001])[:, None])  # 1 J into the wheel
    assert robodyn.torques(model, begin, scene).sizing.joints[0].motor.gear_loss == pytest.approx(1 / 0.8 - 1, rel=1e-6)


def test_example_of_the_puma_row_by_row():
    """The waist of robots/puma560_heat.toml: maps of single rows by expm, composed, and their fixed point, at 1e-9."""
    model, scene = (
        robodyn.load(f"{ROBOTS}/puma560.urdf"),
        load_scene(*(f"{ROBOTS}/puma560_{x}.toml" for x in ("sizing", "heat"))),
    )
    result = robodyn.torques(model, f"{ROBOTS}/puma560_sweep.csv", scene, history=True)
    columns = dict(zip(result.history.motion.names, result.history.motion.first.T, strict=True))
    gear, inertia = -62.6111, 200e-6
    T = (columns["tau_waist"] - gear**2 * inertia * columns["qdd_waist"]) / gear + gear * inertia * columns["qdd_waist"]
    squares, steps = 0.5 * (T[1:] ** 2 + T[:-1] ** 2), np.diff(columns["time"])
    maps = [np.eye(3)]
    for h, square in zip(steps, squares, strict=True):
        loss, M = 1.6 * square / 0.25**2, np.zeros((3, 3))
        M[:2, :2] = [[(0.00393 * loss - 1 / 1.2) / 20, 1 / 24], [1 / 480, -1 / 480 - 1 / 1200]]
        M[0, 2] = loss / 20
        maps.append(expm(M * h) @ maps[-1])
    whole = maps[-1]
    begin = np.linalg.solve(np.eye(2) - whole[:2, :2], whole[:2, 2])
    hottest = max((each @ np.append(begin, 1.0))[0] for each in maps)
    assert abs(result.sizing.joints[0].motor.heat.winding - 25 - hottest) <= 1e-9 * hottest


def test_a_pause_in_one_row_is_as_exact_as_in_many():
    """10 s of work and 60 s of holding: energy within 1e-4, the housing's peak inside the pause within 0.01 K."""
    hot = replace(COPPER, housing_capacity=40.0)
    t, torque = np.array((0.0, 10.0, 10.001, 70.0)), np.array((0.2, 0.2, 0.05, 0.05))
    many = np.unique(np.concatenate((t, np.linspace(0, 70, 7001))))
    one, other = (heated(hot, x, np.interp(x, t, torque)).sizing.joints[0].motor.heat for x in (t, many))
    assert one.copper_loss == pytest.approx(other.copper_loss, rel=1e-4)
    assert abs(one.housing - other.housing) <= 0.01
    assert abs(one.winding - other.winding) <= 0.01
