"""Figures for motor sizing: closed forms, peaks with sign, time and row, uneven time stamps, limits."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.motions import waves
from helpers.oracles import EPS, reference, robot, run, worst
from helpers.small_robots import built, joint, link
from scipy.integrate import trapezoid

from robodyn.dynamics.inverse import inverse_dynamics
from robodyn.dynamics.plan import Plan
from robodyn.loads.self_checks import quadrature_errors
from robodyn.loads.statistics import Integrals
from robodyn.loads.torques import torques
from robodyn.scene.parts import Friction
from robodyn.scene.scene import Scene
from robodyn.trajectory.read import motion

SIZING = reference("sizing")
WEIGHTLESS = Scene(gravity=(0.0, 0.0, 0.0))


def flywheel(J=2.0, limits='<limit lower="-9" upper="9" effort="1000" velocity="100"/>'):
    hinge = joint("j", "base", "wheel").replace('<limit lower="-9" upper="9" effort="1000" velocity="100"/>', limits)
    return built(link("base"), link("wheel", 1, inertia=(J, 0, 0, J, 0, J)), hinge)


def swing(model, n=2001, cycles=1):
    """q = A sin(2 pi t) over whole cycles, sampled so that all extremes are met."""
    t = np.linspace(0, cycles, n)
    w, A = 2 * np.pi, 0.5
    return motion(
        model, t, *(x[:, None] for x in (A * np.sin(w * t), A * w * np.cos(w * t), -A * w * w * np.sin(w * t)))
    )


def test_closed_form_of_a_swinging_flywheel():
    expected = SIZING["closed_form_test"]
    load = torques(flywheel(), swing(flywheel()), WEIGHTLESS).joints[0]
    assert abs(abs(load.peak) / expected["tau_peak"] - 1) <= 4 * EPS
    assert abs(load.rms / expected["tau_rms"] - 1) <= 2e-9
    assert abs(load.max_speed / expected["qd_peak"] - 1) <= 4 * EPS
    assert abs(load.peak_power / expected["power_peak"] - 1) <= 1e-9
    assert abs(load.least_power / -expected["power_peak"] - 1) <= 1e-9
    assert abs(load.work_positive / expected["positive_work_per_cycle"] - 1) <= 1e-5
    assert abs(load.work_positive + load.work_negative) <= 1e-12 * load.work_positive
    assert abs(load.mean) <= 1e-12 * load.rms
    assert abs(load.torque_at_max_speed) <= 1e-12
    assert (load.peak_time, load.peak_row) == (0.25, 501)
    assert load.peak < 0
    assert abs(load.peak_speed) <= 1e-12


def test_harmonic_drives_worked_example_end_to_end():
    """The same through `torques`: a flywheel whose friction makes the torque that the example asks for."""
    example = SIZING["harmonic_drive"]["worked_example"]
    rows = [(T, n * np.pi / 30, t) for T, n, t in zip(*(example[key] for key in ("T", "n", "t")), strict=True)]
    ends = np.cumsum([0, *(t for *_, t in rows)])
    time = np.column_stack((ends[:-1] + 1e-9, ends[1:])).ravel()
    speed = np.repeat([n for _, n, _ in rows], 2)[:, None]
    push = np.repeat([T for T, *_ in rows], 2)[:, None] / 2.0
    load = torques(flywheel(), motion(flywheel(), time, 0 * speed, speed, push), WEIGHTLESS).joints[0]
    assert abs(load.cubic_mean - example["T_av"]) <= 0.005
    assert load.rms == pytest.approx(np.sqrt(sum(T * T * t for T, _, t in rows) / 3.7), rel=1e-6)


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


LIMITS = '<limit lower="-0.4" upper="0.6" effort="30" velocity="2"/>'


def test_limits_exceeded_are_told_apart():
    model = flywheel(limits=LIMITS)
    result = torques(model, swing(model), WEIGHTLESS)
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
    model = flywheel()
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
