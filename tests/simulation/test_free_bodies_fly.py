"""Free bodies against closed forms by every kind of method: flips, precession, satellites; momenta that stay."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.oracles import reference, robot
from helpers.sampled import sampled
from helpers.simulated_robots import pendulum, tumbling
from helpers.small_robots import built, link

import robodyn
from robodyn.errors import InputError
from robodyn.programs.vectors import rotation_about, rotation_from_quaternion
from robodyn.scene.scene import Drive, Scene, Spring

ANALYTIC = reference("analytic")
FLIP = ANALYTIC["dzhanibekov_I(1,2,3)_w(0.001,1,0.001)"]
CYLINDER = ANALYTIC["free_cylinder_drake"]
EVERY = {"gauss6": {"step": 5e-3}, "rk4": {"step": 2e-4}, "dop853": {"rtol": 1e-13}, "radau": {"rtol": 1e-9}}
BOUND = {"gauss6": 1e-11, "rk4": 1e-11, "dop853": 1e-11, "radau": 1e-7}


def turning(w):
    speeds = dict(zip(("base_wx", "base_wy", "base_wz"), w, strict=True))
    return Scene(gravity=(0, 0, 0), initial_qd=speeds, joint_limits="ignore")


def body(*moments):
    Ixx, Iyy, Izz = moments
    return built(link("body", 1.0, inertia=(Ixx, 0, 0, Iyy, 0, Izz)), moving_base=True)


@pytest.mark.parametrize(("method", "time"), [*((method, 5) for method in EVERY), ("gauss6", 20)])
def test_dzhanibekov(method, time):
    found = robodyn.simulate(robot("rigid_body"), turning((1e-3, 1.0, 1e-3)), time, method=method, **EVERY[method])
    expected = np.array(FLIP["w_body(t)"][str(time)], dtype=float)
    assert np.abs(found.qd[-1, :3] - expected).max() <= BOUND[method]


def test_a_free_cylinder_precesses():
    """w turns about the axis at s = (I - J) / I w_z; the body about H at |H| / I and back about its axis at s."""
    time, (I, J) = 5.0, (CYLINDER["I"], CYLINDER["J"])
    w0 = np.array(CYLINDER["w0"], dtype=float)
    found = robodyn.simulate(body(I, I, J), turning(w0), time, method="gauss6", **EVERY["gauss6"])
    assert np.abs(found.qd[-1, :3] - np.array(CYLINDER["w_body(t)"]["5"], dtype=float)).max() <= BOUND["gauss6"]
    H, s = np.array([I, I, J]) * w0, float(CYLINDER["body_rate_s=(I-J)/I*wz"])
    size = np.linalg.norm(H)
    assert abs(size / I - float(CYLINDER["precession_rate_H/I"])) <= 1e-14
    expected = rotation_about(H / size, size / I * time) @ rotation_about(np.array([0.0, 0.0, 1.0]), s * time)
    assert np.abs(rotation_from_quaternion(*found.q[-1, 3:]) - expected).max() <= BOUND["gauss6"]


@pytest.mark.parametrize("method", sampled(["dop853", "radau", "rk4-momenta"]))
def test_a_tree_that_tumbles_is_where_gauss_and_the_exponential_map_have_it(method):
    """Quaternions as four numbers, of adaptive methods, and rotation vectors within steps: the same motion."""
    model, scene = tumbling()
    settled = robodyn.simulate(model, scene, 0.4, method="gauss6", step=2e-3)
    how = {"rtol": 1e-11} if method in ("dop853", "radau") else {"step": 5e-4}
    found = robodyn.simulate(model, scene, 0.4, method=method, **how)
    q, expected = found.q[-1], settled.q[-1]
    assert np.abs(rotation_from_quaternion(*q[3:7]) - rotation_from_quaternion(*expected[3:7])).max() <= 1e-9
    assert np.abs(np.delete(q, range(3, 7)) - np.delete(expected, range(3, 7))).max() <= 1e-9
    assert np.abs(found.qd[-1] - settled.qd[-1]).max() <= 1e-9
    assert np.abs(np.linalg.norm(found.q[:, 3:7], axis=1) - 1).max() <= 4e-16


def satellite(**drives):
    scene = Scene(
        gravity=(0, 0, 0),
        moving_base=True,
        initial_qd={"base_wx": 0.1, "base_wy": 0.3, "base_wz": -0.05, "base_vx": 0.2, "left_array": 0.05},
        drive=drives,
        joint_limits="ignore",
    )
    return robot("satellite", moving_base=True), scene


@pytest.mark.parametrize("method", sampled(["gauss6", "rk4-momenta", "dop853"], 3))
def test_the_arrays_of_a_satellite_change_no_momentum(method):
    """Driven to and fro, the arrays turn the bus; linear and angular momentum stay to 1e-12."""
    drives = {"left_array": Drive(kp=4.0, kd=6.0, reference=1.2), "right_array": Drive(kp=2.0, kd=5.0, reference=-0.9)}
    model, scene = satellite(**drives)
    how = {"rtol": 1e-13} if method == "dop853" else {"step": 0.01}
    found = robodyn.simulate(model, scene, 20.0, method=method, **how)
    linear, angular = found.momentum_drift
    assert np.abs(found.qd[:, 0] - found.qd[0, 0]).max() >= 0.01
    assert linear <= 1e-12 * np.abs(found.figures.linear).max()
    assert angular <= 1e-12 * np.abs(found.figures.angular).max()


def test_momenta_stay_at_steps_that_are_too_long_for_the_motion():
    """Springs that ring with steps of 20 ms: the motion is poor, its momenta are exact."""
    model, scene = satellite()
    scene = Scene(**{**vars(scene), "spring": {"left_array": Spring(500.0, 0.3), "right_array": Spring(300.0)}})
    runs = {name: robodyn.simulate(model, scene, 20.0, method=name, step=0.02) for name in ("rk4", "rk4-momenta")}
    for name, found in runs.items():
        linear, angular = found.momentum_drift
        relative = max(linear / np.abs(found.figures.linear).max(), angular / np.abs(found.figures.angular).max())
        assert (relative <= 1e-12) == (name == "rk4-momenta"), relative


@pytest.mark.parametrize(("method", "step"), [("rk4-momenta", 0.01), ("gauss6", 2e-3)])
def test_momenta_of_a_body_that_falls(method, step):
    """Gravity changes the linear momentum by its impulse alone."""
    model, scene = tumbling()
    found = robodyn.simulate(model, scene, 2.0, method=method, step=step)
    assert found.free
    assert found.energy_drift <= (1e-11 if method == "gauss6" else 1e-3) * found.figures.kinetic.max()
    linear, angular = found.momentum_drift
    assert linear <= 1e-12 * np.abs(found.figures.linear).max()
    assert angular <= 1e-12 * np.abs(found.figures.angular).max()
    assert np.ptp(found.figures.linear[:, 2]) >= 10.0


def test_a_robot_on_the_ground_has_no_momenta_to_keep():
    assert not robodyn.simulate(pendulum(), Scene(), 0.01).free
    with pytest.raises(InputError, match="rk4-momenta does not apply: the momenta of a robot that is held or pushed"):
        robodyn.simulate(pendulum(), Scene(), 1.0, method="rk4-momenta")
