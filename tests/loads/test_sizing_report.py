"""`robodyn torques` with motors: figures against plain NumPy on the table it writes, verdicts, JSON, exit status."""

from __future__ import annotations

import json

import numpy as np
import pytest
from helpers.command_line import ROBOTS, run
from helpers.oracles import robot
from scipy.integrate import trapezoid

from robodyn.loads.result import Exceeded
from robodyn.loads.sizing import train_of
from robodyn.report.motor_loads import in_words
from robodyn.scene.read import load_scene

PUMA = [str(ROBOTS / name) for name in ("puma560.urdf", "puma560_sweep.csv")]
SCENE = str(ROBOTS / "puma560_sizing.toml")


def read(path):
    with open(path) as lines:
        names = lines.readline().strip().split(",")
        return dict(zip(names, np.loadtxt(lines, delimiter=",").T, strict=True))


@pytest.fixture(scope="module")
def puma(tmp_path_factory):
    """The JSON document, the table of torques and wrenches, and the motion."""
    out = tmp_path_factory.mktemp("sizing") / "loads.csv"
    outcome = run("torques", *PUMA, "--scene", SCENE, "--out", str(out), "--reactions", "--format", "json")
    assert (outcome.status, outcome.err) == (0, "")
    return json.loads(outcome.out), read(out), read(PUMA[1])


def figures(time, torque, speed):
    """By their definitions, in plain NumPy."""
    power, top, fast = torque * speed, np.abs(torque).argmax(), np.abs(speed).argmax()
    return {
        "peak": torque[top],
        "peak_time": time[top],
        "peak_row": top + 1,
        "peak_speed": speed[top],
        "rms": np.sqrt(trapezoid(torque**2, time) / (time[-1] - time[0])),
        "max_speed": speed[fast],
        "max_speed_time": time[fast],
        "max_speed_row": fast + 1,
        "torque_at_max_speed": torque[fast],
        "peak_power": power.max(),
        "least_power": power.min(),
        "work_positive": trapezoid(np.maximum(power, 0), time),
        "work_negative": trapezoid(np.minimum(power, 0), time),
    }


def test_joints_from_the_table_that_is_written(puma):
    document, table, moved = puma
    time = table["time"]
    assert (document["samples"], document["duration"]) == (len(time), time[-1] - time[0])
    for found in document["joints"]:
        tau, q, qd = (each[f"{kind}_{found['name']}"] for each, kind in ((table, "tau"), (moved, "q"), (moved, "qd")))
        expected = figures(time, tau, qd) | {"q_min": q.min(), "q_max": q.max()}
        wear, travel = (trapezoid(np.abs(each), time) for each in (qd * tau**3, qd))
        expected |= {"mean": trapezoid(tau, time) / document["duration"], "cubic_mean": np.cbrt(wear / travel)}
        for key, value in expected.items():
            assert found[key] == pytest.approx(value, rel=1e-12, abs=1e-13 * np.abs(tau).max()), (found["name"], key)


def test_motors_from_the_table_that_is_written(puma):
    """G, J and e of the scene, tau of the table, qd and qdd of the trajectory; all in NumPy."""
    document, table, moved = puma
    time = table["time"]
    T = time[-1] - time[0]
    scene, model = load_scene(SCENE), robot("puma560")
    assert np.array_equal(moved["time"], time)
    for joint, own in zip(document["sizing"]["joints"], model.independent, strict=True):
        name, motor = joint["name"], joint["motor"]
        G, J = scene.rotor[name].gear, scene.rotor[name].inertia
        tau, qd, qdd = table[f"tau_{name}"], moved[f"qd_{name}"], moved[f"qdd_{name}"]
        load = tau - G**2 * J * qdd
        torque = G * J * qdd + load / (G * scene.motor[name].efficiency ** np.sign(load * qd))
        speed = G * qd
        mean = trapezoid(np.abs(speed), time) / T
        expected = figures(time, torque, speed) | {"mean_speed": mean}
        peak = train_of(own, scene).motor.peak
        if isinstance(peak, tuple):
            limit = np.interp(np.abs(speed), *zip(*peak, strict=True), right=0.0)
            at = (np.abs(torque) / limit).argmax()
            assert motor["nearest"]["row"] == at + 1
            assert motor["nearest"]["limit"] == pytest.approx(limit[at], rel=1e-12, abs=1e-15)
            expected["seconds_over_peak"] = trapezoid((np.abs(torque) > limit).astype(float), time)
        for key, value in expected.items():
            assert motor[key] == pytest.approx(value, rel=1e-12, abs=1e-15), (name, key)
        moving = trapezoid((np.abs(qd) > joint["standstill"]).astype(float), time) / T
        assert joint["duty_cycle"] == pytest.approx(moving, rel=1e-12)
        assert joint["mean_speed"] == pytest.approx(mean / abs(G), rel=1e-12)


def test_bearings_and_foundation_from_the_table_that_is_written(puma):
    """All joints of the PUMA turn about z: u is x, v is y."""
    document, table, _ = puma
    time = table["time"]
    T = time[-1] - time[0]

    def agrees(found, values):
        at = np.abs(values).argmax()
        assert found["peak"] == pytest.approx(values[at], rel=1e-12)
        assert (found["peak_time"], found["peak_row"]) == (time[at], at + 1)
        assert found["rms"] == pytest.approx(np.sqrt(trapezoid(values**2, time) / T), rel=1e-12)

    for bearing in document["sizing"]["bearings"]:
        fx, fy, fz, mx, my = (table[f"{part}_{bearing['joint']}"] for part in ("fx", "fy", "fz", "mx", "my"))
        wanted = {
            "fu": fx,
            "fv": fy,
            "fa": fz,
            "mu": mx,
            "mv": my,
            "radial": np.hypot(fx, fy),
            "tilting": np.hypot(mx, my),
        }
        assert bearing["directions"] == {"u": [1, 0, 0], "v": [0, 1, 0], "axis": [0, 0, 1]}
        assert bearing["components"].keys() == wanted.keys()
        for name, values in wanted.items():
            agrees(bearing["components"][name], values)
    base = {name: table[f"base_{name}"] for name in ("fx", "fy", "fz", "mx", "my", "mz")}
    base |= {"fxy": np.hypot(base["fx"], base["fy"]), "mxy": np.hypot(base["mx"], base["my"])}
    assert list(document["base_wrench"]) == list(base)
    for name, load in document["base_wrench"].items():
        agrees({"peak_row": np.abs(base[name]).argmax() + 1, **load}, base[name])
    for name, load in document["sizing"]["foundation"].items():
        values = base[name]
        scale = np.abs(values).max()
        assert load["greatest"] == pytest.approx(values.max(), rel=1e-12)
        assert load["least"] == pytest.approx(values.min(), rel=1e-12)
        assert (load["greatest_time"], load["least_time"]) == (time[values.argmax()], time[values.argmin()])
        assert abs(load["mean"] - trapezoid(values, time) / T) <= 1e-12 * scale
    assert list(document["sizing"]["foundation"]) == ["fxy", "fz", "mxy", "mz"]


def test_static_torque_is_that_of_standing_still(puma):
    from robodyn.dynamics.inverse import inverse_dynamics

    document, _, moved = puma
    model = robot("puma560")
    q = np.column_stack([moved[f"q_{name}"] for name in model.joint_names])
    static = inverse_dynamics(model, q, 0.0, 0.0)
    for k, (joint, load) in enumerate(zip(document["sizing"]["joints"], document["joints"], strict=True)):
        at = np.abs(static[:, k]).argmax()
        rms = np.sqrt(trapezoid(static[:, k] ** 2, moved["time"]) / document["duration"])
        assert abs(joint["static_peak"] - static[at, k]) <= 1e-12 * np.abs(static).max()
        assert abs(joint["static_rms"] - rms) <= 1e-12 * np.abs(static).max()
        assert joint["static_share"] == joint["static_rms"] / load["rms"]


def test_verdicts_in_plain_words():
    """The worst comes first, and is told again in the last line."""
    text = run("torques", *PUMA, "--scene", SCENE).out
    lines = text.partition("\nVerdicts\n")[2].partition("\n\n")[0].splitlines()
    assert lines[3] == (
        "waist        OK: 44 % of the peak curve at 1.69 s, 82 % of the continuous torque, 31 % of the motor's speed, "
        "44 % of the effort limit, 68 % of the velocity limit"
    )
    assert lines[2] == (
        "wrist_roll   OVER CONTINUOUS: the motor's RMS torque is 0.02147 N m, 7.34 % above the 0.02000 N m that the "
        "continuous curve allows at a mean speed of 63.47 rad/s"
    )
    assert lines[0] == (
        "wrist_pitch  OVER PEAK: the motor's torque is 0.02663 N m, 274 % above the 0.007111 N m that the peak curve "
        "allows at 139.3 rad/s; worst at 0.73 s (row 74), over for 0.56 s in all"
    )
    assert lines[1] == (
        "flange_roll  OVER PEAK: the motor's speed is 215.8 rad/s, 7.92 % above the 200.0 rad/s that it may have; "
        "worst at 2.15 s (row 216), over for 0.52 s in all"
    )
    assert "No limit" not in text
    assert text.splitlines()[-1].startswith(
        f"3 of 6 joints ask more than motors, gears or limits bear: {lines[0][:11]}:"
    )


def test_a_limit_of_zero_in_words():
    over = Exceeded("motor torque", 0.5, 0.0, "N", 1.0, 7, 2.0, 0.25)
    assert in_words(over) == (
        "the motor's torque is 0.5000 N, above the 0 N that the peak curve allows at 2.000 m/s; "
        "worst at 1 s (row 7), over for 0.25 s in all"
    )


@pytest.mark.parametrize(("scene", "status"), [("puma560_sizing", 1), ("puma560_motors", 0)])
def test_status(scene, status):
    assert run("torques", *PUMA, "--scene", str(ROBOTS / f"{scene}.toml"), "--fail-on-limits").status == status


@pytest.mark.parametrize("name", ["gripper/gripper_pick", "rigid_body/rigid_body_flip"])
def test_sizing_is_for_every_robot(name):
    """Slides, mimic joints, and no joints at all."""
    urdf, table = name.split("/")
    scene = ROBOTS / f"{urdf}.toml"
    call = [
        str(ROBOTS / f"{urdf}.urdf"),
        str(ROBOTS / f"{table}.csv"),
        *(["--scene", str(scene)] if scene.exists() else []),
    ]
    plain = run("torques", *call, "--format", "json")
    sized = run("torques", *call, "--sizing", "--format", "json")
    assert "sizing" not in json.loads(plain.out)
    document = json.loads(sized.out)
    assert {**document, "sizing": 0} == {**json.loads(plain.out), "sizing": 0}
    text = run("torques", *call, "--sizing").out
    assert "\nFoundation: " in text
    assert ("\nVerdicts\n" in text) == bool(document["joints"])
