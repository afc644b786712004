"""What pages of accuracy and linearize draw: dots and lines where the numbers are, modes that move as they should."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.oracles import robot

import robodyn
from robodyn.measure.accuracy.ladder import Accuracy, Ladder, Rung, Spread
from robodyn.report import document as doc
from robodyn.report.accuracy import accuracy_page
from robodyn.report.linearized import linearized_page
from robodyn.report.renderers.pages import html


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
    assert found["quartiles"]["x"][:2] == pytest.approx([2700.0, 3600.0])
    assert np.isnan(found["quartiles"]["x"][2])
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
