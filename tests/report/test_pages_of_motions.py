"""What pages of accuracy, linearize and simulate draw: numbers where they are, motions as they should be."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.oracles import ROBOTS, robot

import robodyn
from robodyn.measure.accuracy.ladder import Accuracy, Ladder, Rung, Spread
from robodyn.report import document as doc
from robodyn.report.accuracy import accuracy_page
from robodyn.report.equations.linearized import linearized_page
from robodyn.report.renderers.pages import html
from robodyn.report.simulation import simulation_page


def looks(document: doc.Document, kind: type) -> list:
    return [block.look for block in document.blocks if isinstance(block, kind)]


def series(look: dict) -> dict[str, dict]:
    return {each["label"]: each for each in look["series"]}


def test_methods_stand_at_their_time_and_error() -> None:
    times = (3e-6, 2e-6, 1e-6)
    rungs = tuple(
        Rung(name, (error,), Spread(t, 0.9 * t, 1.2 * t, 5))
        for name, error, t in zip(("a, fine", "a, coarse", "b <script>"), (0.0, 1e-25, 1e-3), times, strict=True)
    )
    accuracy = Accuracy("r", (Ladder("torques", ("torque",), "digits", "sample", rungs),), ())
    document = accuracy_page(accuracy, 1e-28)
    (look,) = looks(document, doc.Chart)
    found = series(look)
    assert look["log"]
    assert found["a"]["x"] == pytest.approx([3000.0, 2000.0])
    assert found["a"]["y"] == pytest.approx([1e-30, 1e-25])
    assert found["a"]["names"] == [
        "a, fine, quartiles 2700 .. 3600 ns per sample",
        "a, coarse, quartiles 1800 .. 2400 ns per sample",
    ]
    assert found["front"]["y"] == pytest.approx([1e-3, 1e-25, 1e-30])
    assert found["target 1e-28"]["y"] == pytest.approx([1e-28, 1e-28])
    assert "<script>alert" not in html(document)
    assert "b \\u003cscript>" in html(document)


def test_poles_of_an_arm_upright_and_its_modes() -> None:
    """The arm is symmetric about its plane: it falls as fast as it comes back."""
    found = robodyn.linearize(robot("two_link_planar"), at=[np.pi / 2, 0.0], equilibrium=True)
    document = linearized_page(found)
    (poles,) = looks(document, doc.Chart)
    dots = series(poles)
    assert sorted(dots["grows"]["x"]) == pytest.approx(sorted(-dots["decays"]["x"]), rel=1e-6)
    assert poles["spans"][0][0] == 0.0
    (stage,) = looks(document, doc.Stage)
    motions = stage["robots"][0]["motions"]
    for motion, mode in zip(motions, found.modes.modes, strict=True):
        away = np.array([np.asarray(q) - rest for q, rest in zip(motion["q"], found.q, strict=True)])
        assert np.abs(away).max() == pytest.approx(0.35)
        rates = np.log(np.abs(away[:, 1:] / away[:, :-1])) / np.diff(motion["time"])
        assert rates == pytest.approx(mode.real * np.ones_like(rates), rel=1e-3)


def test_a_mode_that_swings_does_so_for_whole_periods() -> None:
    found = robodyn.linearize(robot("two_link_planar"), at=[-np.pi / 2, 0.0], equilibrium=True)
    motion = looks(linearized_page(found), doc.Stage)[0]["robots"][0]["motions"][0]
    mode = found.modes.modes[0]
    assert motion["time"][-1] * mode.imag / (2 * np.pi) == pytest.approx(round(motion["time"][-1] * mode.frequency))
    assert motion["q"][0][0] == pytest.approx(motion["q"][0][-1], abs=1e-9)
    assert f"{mode.frequency:.4g} Hz" in motion["name"]


def simulated(name: str, scene: str, duration: float, **options: Any) -> tuple[robodyn.Simulation, doc.Document]:
    model = robot(name, moving_base="moving" in (ROBOTS / f"{scene}.toml").read_text(encoding="utf-8"))
    found = robodyn.simulate(model, robodyn.load_scene(ROBOTS / f"{scene}.toml"), duration, **options)
    return found, simulation_page(found)


def charts(document: doc.Document) -> dict[str, doc.Chart]:
    return {each.caption: each for block in document.blocks if isinstance(block, doc.Gallery) for each in block.figures}


def test_a_satellite_flies_along_its_simulated_motion() -> None:
    found, document = simulated("satellite", "satellite_deploy", 2.0, step=0.01)
    (stage,) = looks(document, doc.Stage)
    motion = stage["robots"][0]["motions"][0]
    assert np.array_equal(motion["time"], found.time)
    for k, q in enumerate(motion["q"]):
        assert np.array_equal(q, found.q[:, k])
    (path,) = stage["marks"]
    assert sum(np.array(vector) for _, vector, _ in path["pieces"]) == pytest.approx(found.q[-1, :3], abs=1e-12)
    torques = [arrow for arrow in motion["arrows"] if arrow["kind"] == "torque"]
    assert len(torques) == 2
    k = found.model.rates.index("left_array")
    assert any(np.array_equal(np.abs(part), np.abs(found.tau[:, k])) for arrow in torques for part in arrow["values"])
    shown = charts(document)
    momentum = series(dict(shown["Angular momentum, about the mass centre [N m s]"].look))
    assert np.ptp(momentum["y"]["y"]) < 1e-9 < np.abs(momentum["y"]["y"]).max()
    assert f"drive's torque {-0.0 + found.tau[:, k].min():#.4g} to" in shown["left_array: drive's torque [N m]"].alt
    assert shown["left_array: drive's torque [N m]"].look["levels"] == [(-1.0, "limit"), (1.0, "limit")]


def test_red_leads_the_one_verdict_of_a_simulation(tmp_path: Path) -> None:
    """A joint beyond its speed stands above the energy that balances."""
    scene = tmp_path / "fast.toml"
    scene.write_text("gravity = [0, 0, 0]\n[initial]\nqd = { shoulder = 7.0 }\n", encoding="utf-8")
    document = simulation_page(robodyn.simulate(robot("two_link_planar"), robodyn.load_scene(scene), 0.1))
    (verdict,) = (block for block in document.blocks if isinstance(block, doc.Verdict))
    assert verdict.level == "bad"
    assert "moves at" in verdict.reasons[0]
    assert "The motion ran for its 0.1 s, and its energy balances." in verdict.reasons
    (bars,) = (block for block in document.blocks if isinstance(block, doc.Bars))
    assert bars.rows[0][0] == "shoulder"
    assert max(used for _, _, used, _ in bars.rows[0][1]) == 100.0


def test_loops_tell_their_forces() -> None:
    found, document = simulated("five_bar", "five_bar_reach", 0.1)
    assert found.loops is not None
    (curve,) = charts(document)["Force of loops [N]"].look["series"]
    assert curve["label"] == "tip"
    assert curve["y"] == pytest.approx(np.linalg.norm(found.loops.wrenches[:, 0, :3], axis=1))
    motion = looks(document, doc.Stage)[0]["robots"][0]["motions"][0]
    assert [arrow["what"] for arrow in motion["arrows"] if arrow["kind"] == "loop"] == ["by a loop"]
