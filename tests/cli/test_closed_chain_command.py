"""`robodyn simulate` of closed chains: report, table and document; commands that refuse them; loops that cannot be."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from helpers.command_line import ROBOTS, refused, run, shown

BARS = (str(ROBOTS / "four_bars.urdf"), "--scene", str(ROBOTS / "four_bars_a02.toml"))
PUMP = (str(ROBOTS / "crank_slider.urdf"), "--scene", str(ROBOTS / "crank_slider_pump.toml"))
LOOP = '[[loop]]\nname = "pin"\nlink = "rod"\npoint = [0.3, 0, 0]\nto = "slider"\n'
WRONG = {
    LOOP + LOOP: 'scene.toml: the scene: 2 loops and contacts have the name "pin"',
    LOOP.replace("rod", "bar"): "scene.toml: [[loop]] 'pin': the robot has no link 'bar'",
    LOOP + 'kind = "hinge"': 'scene.toml:1: [[loop]] number 1: "axis" is missing',
    LOOP + "to_point = [0, 0, 2]": 'loop "pin" does not close: it is open by ',
    LOOP + "to_point = [0, 0.1, 0]": 'loop "pin" cannot close: it misses by 0.1 m along y of slider, wherever the joi',
    LOOP + "[initial]\nq = { main = 3.2 }\n": '"rail" begins at -0.',
}


def simulate(*args: str) -> str:
    return shown("simulate", *args)


def test_report() -> None:
    text = simulate(*BARS, "--duration", "1")
    assert (
        "form: index-1 DAE, M qdd + bias = tau + J^T lambda, J qdd = -J' qd by M = C C^T and C^-1 J^T = Q R\n" in text
    )
    assert (
        "loops: 6 equations, 4 of them independent at the start; degrees of freedom left: 1; projection after" in text
    )
    assert "left out, for the others imply them: pin_1 along y, pin_2 along y\n" in text
    lines = [line.split() for line in text.splitlines() if line.startswith("pin_")]
    assert [line[0] for line in lines] == ["pin_1", "pin_2"]
    assert all(float(line[1]) > 10 and float(line[3]) < 1e-13 for line in lines)


@pytest.fixture(scope="module")
def pumped(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """The table of a simulation, and what it says."""
    out = tmp_path_factory.mktemp("pump") / "pump.csv"
    return out, simulate(*PUMP, "--duration", "0.1", "--out", str(out), "--format", "json")


def test_table_and_document(pumped: tuple[Path, str]) -> None:
    out, text = pumped
    loops = json.loads(text)["loops"]
    assert (loops["equations"], loops["dropped"], loops["rank"], loops["freedoms"]) == (3, ["wrist_pin along y"], 2, 1)
    (pin,) = loops["closures"]
    header = out.read_text().splitlines()[0].split(",")
    assert header[-6:] == [f"{part}_wrist_pin" for part in ("fx", "fy", "fz", "mx", "my", "mz")]
    last = np.loadtxt(out, delimiter=",", skiprows=1)[-1]
    assert last[-6:].tolist() == list(pin["final"].values())
    crank, rod, slider = (last[header.index(f"q_{name}")] for name in ("main", "pin", "rail"))
    assert abs(0.1 * np.cos(crank) + 0.3 * np.cos(crank + rod) - slider) <= 1e-14
    drag = 60.0 * last[header.index("qd_rail")]
    push = 1.2 * last[header.index("qdd_rail")] + drag
    assert -pin["final"]["fx"] == pytest.approx(push, rel=1e-9)


def test_torques_refuse_a_table_of_a_closed_chain(pumped: tuple[Path, str]) -> None:
    """The open tree's torques have nothing to do with those that drive the chain."""
    out, _ = pumped
    said = (
        f"{out}:1: columns 'fx_wrist_pin' to 'mz_wrist_pin' are what simulate writes of a loop, and the scene "
        "has no loop of that name: the torques would be those of the open tree (give --scene with its [[loop]]; if "
        "'wrist_pin' is no loop, rename its columns)\n"
    )
    refused(run("torques", PUMP[0], str(out), "--ignore-extra"), said)


def test_torques_of_a_simulation_with_its_own_scene(pumped: tuple[Path, str], tmp_path: Path) -> None:
    """The joints of [drive] drive, and what they did comes back; the columns of the loop's wrench are known."""
    table, out = pumped[0], tmp_path / "tau.csv"
    text = shown("torques", PUMP[0], str(table), *PUMP[1:], "--out", str(out))
    assert "1 degree of freedom; 1 joint drives.\nAll torques are determined" in text
    names = out.read_text().splitlines()[0].split(",")
    assert names == ["time", "tau_main", *(f"{part}_wrist_pin" for part in ("fx", "fy", "fz", "mx", "my", "mz"))]
    found, given = (np.loadtxt(path, delimiter=",", skiprows=1) for path in (out, table))
    assert np.abs(found[:, 1] - 4.0).max() <= 1e-12
    assert np.abs(found[:, 2:] - given[:, -6:]).max() <= 1e-13 * np.abs(given[:, -6:]).max()


@pytest.mark.parametrize("scene", WRONG)
def test_loops_that_cannot_be(scene: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.toml").write_text(scene)
    refused(run("simulate", PUMP[0], "--scene", "scene.toml", "--duration", "0.1"), WRONG[scene])


@pytest.mark.parametrize("call", ["simulate", "linearize", "equations --form dae"])
def test_a_negative_mass_in_a_loop(call: str, tmp_path: Path) -> None:
    slider = tmp_path / "slider.urdf"
    slider.write_text(Path(PUMP[0]).read_text().replace('<mass value="1.2"/>', '<mass value="-1.2"/>'))
    line = 'joint "rail" moves an inertia of -1.2, so its acceleration is not defined (robodyn check finds links '
    refused(run(*call.split(), str(slider), *PUMP[1:]), line)
