"""Figures for motor sizing: closed forms, peaks with sign, time and row, uneven time stamps, limits."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.flywheels import EXAMPLE, SIZING, in_space, swing, wheel, worked_example
from helpers.motions import waves
from helpers.oracles import EPS, robot, run, worst
from scipy.integrate import trapezoid

from robodyn.dynamics.inverse import inverse_dynamics
from robodyn.dynamics.plan import Plan
from robodyn.loads.accumulate import quadrature_errors
from robodyn.loads.statistics import Integrals
from robodyn.loads.torques import torques
from robodyn.scene.parts import Friction, Motor
from robodyn.scene.scene import Scene


def test_closed_form_of_a_swinging_wheel():
    """J = 2: peak 39.4784, RMS 27.9155, power 62.0126 W, work 19.7392 J per cycle; a motor without a gear does it."""
    expected, result = SIZING["closed_form_test"], torques(wheel(), swing(wheel()), in_space(Motor()))
    (load,), (sized,) = result.joints, result.sizing.joints
    for found in (load, sized.motor):
        assert abs(abs(found.peak) / expected["tau_peak"] - 1) <= 4 * EPS
        assert abs(found.rms / expected["tau_rms"] - 1) <= 2e-9
        assert abs(found.max_speed / expected["qd_peak"] - 1) <= 4 * EPS
        assert abs(found.peak_power / expected["power_peak"] - 1) <= 1e-9
        assert abs(found.least_power / -expected["power_peak"] - 1) <= 1e-9
        assert abs(found.work_positive / expected["positive_work_per_cycle"] - 1) <= 3e-6
        assert abs(found.work_positive + found.work_negative) <= 1e-12 * found.work_positive
        assert abs(found.torque_at_max_speed) <= 1e-12
        assert (found.peak_time, found.peak_row) == (0.25, 1001)
        assert (found.max_speed, found.max_speed_time, found.max_speed_row) == (np.pi, 0.0, 1)
        assert found.peak < 0
        assert abs(found.peak_speed) <= 1e-12
    assert abs(load.mean) <= 1e-12 * load.rms
    assert abs(sized.motor.mean_speed - 2.0) <= 1e-6
    assert abs(sized.mean_speed - 2.0) <= 1e-6
    assert (sized.motor.inertia_ratio, sized.motor.unit, sized.motor.speed_unit) == (None, "N m", "rad/s")
    assert (sized.static_peak, sized.static_rms, sized.static_share) == (0, 0, 0)


def test_harmonic_drives_worked_example():
    """Cubic mean 89.39 N m, dwell not in it: a flywheel is pushed so that its torque is what the example asks for."""
    load = torques(wheel(), worked_example(), in_space()).joints[0]
    assert abs(load.cubic_mean - EXAMPLE["T_av"]) <= 0.005
    squares = sum(T * T * t for T, t in zip(EXAMPLE["T"], EXAMPLE["t"], strict=True))
    assert load.rms == pytest.approx(np.sqrt(squares / 3.7), rel=1e-6)


@pytest.mark.parametrize("name", ["puma560", "scara", "gripper"])
def test_figures_by_their_definitions(name):
    """Plain NumPy on the whole arrays, with uneven time stamps."""
    model = robot(name)
    time = np.sort(np.random.default_rng(2).uniform(0, 5, 501))
    trajectory = waves(model, time)
    tau = inverse_dynamics(model, trajectory.q, trajectory.qd, trajectory.qdd)
    qd, power = trajectory.qd, tau * trajectory.qd
    result = torques(model, trajectory)
    assert (result.samples, result.duration) == (501, time[-1] - time[0])
    for k, load in enumerate(result.joints):
        row = np.abs(tau[:, k]).argmax()
        fast = np.abs(qd[:, k]).argmax()
        expected = {
            "peak": tau[row, k],
            "peak_time": time[row],
            "peak_row": row + 1,
            "peak_speed": qd[row, k],
            "max_speed": qd[fast, k],
            "torque_at_max_speed": tau[fast, k],
            "rms": np.sqrt(trapezoid(tau[:, k] ** 2, time) / result.duration),
            "mean": trapezoid(tau[:, k], time) / result.duration,
            "cubic_mean": np.cbrt(
                trapezoid(np.abs(qd[:, k] * tau[:, k] ** 3), time) / trapezoid(np.abs(qd[:, k]), time)
            ),
            "peak_power": power[:, k].max(),
            "least_power": power[:, k].min(),
            "work_positive": trapezoid(np.maximum(power[:, k], 0), time),
            "work_negative": trapezoid(np.minimum(power[:, k], 0), time),
            "q_min": trajectory.q[:, k].min(),
            "q_max": trajectory.q[:, k].max(),
        }
        for key, value in expected.items():
            scale = np.abs(tau[:, k]).max() if key == "mean" else abs(value)
            assert abs(getattr(load, key) - value) <= 64 * EPS * scale, key
        assert load.unit == ("N" if model.independent[k].kind == "prismatic" else "N m")


def test_base_loads_and_their_resultants():
    model = robot("puma560")
    time = np.sort(np.random.default_rng(2).uniform(0, 5, 301))
    trajectory = waves(model, time)
    plan = Plan(model, Scene())
    base = run(plan.wrenches(), plan, trajectory.q, trajectory.qd, trajectory.qdd)[:, model.n :]
    wanted = dict(zip(("fx", "fy", "fz", "mx", "my", "mz"), base.T, strict=True))
    wanted |= {"fxy": np.hypot(base[:, 0], base[:, 1]), "mxy": np.hypot(base[:, 3], base[:, 4])}
    loads = {load.name: load for load in torques(model, trajectory).base_wrench}
    assert loads.keys() == wanted.keys()
    for name, values in wanted.items():
        row = np.abs(values).argmax()
        assert abs(loads[name].peak - values[row]) <= 16 * EPS * np.abs(base).max()
        assert loads[name].peak_time == time[row]
        rms = np.sqrt(trapezoid(values**2, time) / (time[-1] - time[0]))
        assert abs(loads[name].rms - rms) <= 64 * EPS * np.abs(base).max()


def test_limits_exceeded_are_told_apart():
    model = wheel(limits='<limit lower="-0.4" upper="0.6" effort="30" velocity="2"/>')
    result = torques(model, swing(model), in_space())
    load = result.joints[0]
    assert (load.effort_limit, load.velocity_limit, load.lower, load.upper) == (30, 2, -0.4, 0.6)
    assert worst(load.effort_margin, 30 - 8 * np.pi**2 / 2) <= 1e-12
    assert worst(load.velocity_margin, 2 - np.pi) <= 1e-12
    assert load.seconds_over_effort == pytest.approx(1 - 4 * np.arcsin(30 / (4 * np.pi**2)) / (2 * np.pi), abs=2e-3)
    assert load.seconds_over_velocity == pytest.approx(1 - 4 * np.arcsin(2 / np.pi) / (2 * np.pi), abs=2e-3)
    found = [(excess.joint, excess.quantity, excess.limit, excess.unit) for excess in result.exceeded]
    assert found == [("j", "effort", 30, "N m"), ("j", "velocity", 2, "rad/s"), ("j", "position", -0.4, "rad")]
    assert [round(excess.value, 6) for excess in result.exceeded] == [39.478418, 3.141593, -0.5]


def test_hold_band_is_the_coulomb_friction():
    model = wheel()
    scene = Scene(friction={"j": Friction(1.0, 0.4, -0.35)})
    assert abs(torques(model, swing(model, 21), scene).joints[0].hold - 0.375) <= EPS


def test_quadrature_error_of_a_parabola():
    """Trapezoids and Richardson: for x^2 on an even grid the estimate is exact."""
    x = np.linspace(0, 2, 9)
    error = trapezoid(x**2, x) - 8 / 3
    assert error > 0.01
    assert abs(abs(quadrature_errors(np.diff(x), x**2).sum()) - error) <= 1e-15
    assert not quadrature_errors(np.diff(x), 3 * x + 1).any()
    assert len(quadrature_errors(np.empty(0), np.ones(1))) == 0


def test_integrals_over_uneven_steps():
    rng = np.random.default_rng(5)
    time, values = np.sort(rng.uniform(0, 9, 50)), rng.normal(size=(3, 50))
    integrals = Integrals()
    for start, stop in ((0, 1), (1, 20), (20, 21), (21, 50)):
        integrals.update(time[start:stop], {"x": values[:, start:stop]})
    assert worst(integrals.totals["x"], trapezoid(values, time, axis=1)) <= 8 * EPS
