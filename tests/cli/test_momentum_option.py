"""`robodyn torques --momentum`: its columns, its block of text and its JSON."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from helpers.command_line import ROBOTS, run
from helpers.motions import Pieces, waves
from helpers.oracles import EPS, robot, worst

import robodyn
from robodyn.dynamics.momenta import View
from robodyn.loads.accumulate import NAMES
from robodyn.scene.parts import Rotor
from robodyn.scene.scene import Scene

SCARA = (str(ROBOTS / "scara.urdf"), str(ROBOTS / "scara_pick_and_place.csv"))


def test_columns_of_the_file(tmp_path: Path) -> None:
    out = tmp_path / "tau.csv"
    assert run("torques", *SCARA, "--momentum", "--about", "com", "--frame", "spindle", "--out", str(out)).status == 0
    names = out.read_text().partition("\n")[0].split(",")
    assert names == ["time", "tau_shoulder", "tau_elbow", "tau_quill", *NAMES]
    table = np.loadtxt(out, delimiter=",", skiprows=1)
    model = robodyn.load(SCARA[0])
    with robodyn.read_motion(SCARA[1], model) as reader:
        (block,) = reader.blocks()
    found = robodyn.momenta(model, block.q, block.qd, about="com", frame="spindle")
    columns = (found.com, found.linear, found.angular, found.kinetic[:, None], found.potential[:, None])
    assert worst(table[:, 4:-1], np.hstack(columns)) <= 4 * EPS
    assert worst(table[:, -1], np.einsum("ij,ij->i", table[:, 1:4], block.qd)) <= 4 * EPS


def test_text_and_json_say_where_each_is_least_and_greatest() -> None:
    text = run("torques", *SCARA, "--momentum").out
    assert "Momentum and energy in the frame of the ground, L about the origin; power is tau . qd" in text
    data = json.loads(run("torques", *SCARA, "--momentum", "--about", "0.1,0,0", "--format", "json").out)["momentum"]
    assert (data["about"], data["frame"]) == ([0.1, 0.0, 0.0], "ground")
    assert [row["name"] for row in data["ranges"]] == list(NAMES)
    assert all(row["least"] <= row["greatest"] for row in data["ranges"])
    assert "Momentum" not in run("torques", *SCARA).out


def test_power_is_the_rate_of_energy_without_losses() -> None:
    """dE/dt by differences of T + V, at an error that shrinks with the square of the step."""
    model, scene = robot("two_link_spatial"), Scene(rotor={"elevation": Rotor(1e-3, 10.0)})
    errors = []
    for step in (2e-3, 1e-3):
        time = np.arange(0.0, 0.5, step)
        rows: list[np.ndarray] = []
        robodyn.torques(model, waves(model, time), scene, sinks=[lambda _, x, to=rows: to.append(x)], momentum=View())
        energy, power = rows[0][:, -3] + rows[0][:, -2], rows[0][:, -1]
        rate = (energy[2:] - energy[:-2]) / (2 * step)
        errors.append(np.abs(rate - power[1:-1]).max() / np.abs(power).max())
    assert errors[0] < 1e-3
    assert 3.5 < errors[0] / errors[1] < 4.5


def test_blocks_do_not_show() -> None:
    model = robot("scara")
    motion = waves(model, np.linspace(0, 1, 100))
    rows: dict[int, list[np.ndarray]] = {1: [], 3: []}
    reports = []
    for parts, lengths in ((1, [100]), (3, [1, 60, 39])):
        sink = lambda _, x, to=rows[parts]: to.append(x)  # noqa: E731
        result = robodyn.torques(model, Pieces(motion, lengths), sinks=[sink], momentum=View("com"), executor="numpy")
        reports.append(result.momentum)
    assert np.array_equal(np.vstack(rows[1]), np.vstack(rows[3]))
    assert reports[0] == reports[1]


def test_satellite_floats_with_no_momentum() -> None:
    call = ("satellite.urdf", "satellite_slew.csv", "--scene", "satellite.toml", "--momentum", "--format", "json")
    found = json.loads(run("torques", *(str(ROBOTS / x) if "." in x else x for x in call)).out)["momentum"]
    ranges = {row["name"]: row for row in found["ranges"]}
    for name in ("p_x", "p_y", "p_z", "L_x", "L_y", "L_z"):
        assert max(abs(ranges[name]["least"]), abs(ranges[name]["greatest"])) <= 1e-12
    assert ranges["T"]["greatest"] > 0.01


@pytest.mark.parametrize(
    ("more", "line"),
    [
        (("--about", "com"), "--about goes with --momentum (try: robodyn torques --help)"),
        (("--frame", "base"), "--frame goes with --momentum (try: robodyn torques --help)"),
        (("--momentum", "--frame", "bse"), f"{SCARA[0]}: no frame 'bse' (did you mean 'base'?)"),
        (
            ("--momentum", "--about", "1,2"),
            "invalid value for '--about': '1,2' is neither com nor origin nor X,Y,Z in m",
        ),
    ],
)
def test_wrong_calls(more: tuple[str, ...], line: str) -> None:
    outcome = run("torques", *SCARA, *more)
    assert (outcome.status, outcome.out) == (2, "")
    assert outcome.err.startswith(f"error: {line}")
