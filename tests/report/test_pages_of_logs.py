"""Pages of `identify`, `torques --measured` and `excite`: what plots and bars show is what was found."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from helpers.command_line import ROBOTS
from helpers.html_pages import checked
from helpers.identified_logs import waves, write_log

import robodyn
from robodyn.identification.excitation.excite import excite
from robodyn.identification.faults.compare import compare
from robodyn.identification.identify import identify
from robodyn.identification.log.log import read_log
from robodyn.identification.result import Identified, MotorFit
from robodyn.report import document as doc
from robodyn.report.identification import excitation_page, identified_page
from robodyn.report.measured import measured_page
from robodyn.report.renderers.pages import html
from robodyn.scene.scene import Friction, Scene
from robodyn.support import courses

TIME = 0.005 * np.arange(2400)
RUBS = Friction(0.5, 1.0, -0.8)


@pytest.fixture(scope="module")
def logged(tmp_path_factory: pytest.TempPathFactory) -> tuple[robodyn.Model, str]:
    """A model without friction, and a log of the same robot with friction and noise."""
    model, rng = robodyn.load(ROBOTS / "two_link_spatial.urdf"), np.random.default_rng(3)
    q, qd, qdd = waves(rng, TIME, model.n)
    tau = robodyn.inverse_dynamics(model, q, qd, qdd, scene=Scene(friction=dict.fromkeys(model.rates, RUBS)))
    path = tmp_path_factory.mktemp("logs") / "log.csv"
    write_log(path, model, TIME, q, tau + 0.02 * tau.std(axis=0) * rng.standard_normal(tau.shape), qd, qdd)
    return model, str(path)


@pytest.fixture(scope="module")
def found(logged: tuple[robodyn.Model, str]) -> Identified:
    model, path = logged
    return identify([read_log(path, model)])


def charts(page: doc.Document) -> dict[str, Any]:
    """The looks of all charts by their captions."""
    every = [chart for block in page.blocks if isinstance(block, doc.Gallery) for chart in block.figures]
    return {chart.caption: chart.look for chart in every}


def bars(page: doc.Document) -> dict[str, Any]:
    """By caption the bars of every row."""
    every = [block for block in page.blocks if isinstance(block, doc.Bars)]
    return {block.caption: {name: each for name, each, _ in block.rows} for block in every}


def test_an_overlay_has_the_errors_that_are_told(found: Identified) -> None:
    page, new, old = identified_page(found), found.held_out, found.original_held_out
    assert isinstance(page.blocks[0], doc.Verdict)
    assert new is not None
    assert old is not None
    looks, errors = charts(page), bars(page)["||computed - measured|| of ||measured||, held out"]
    for name in found.model.rates:
        look, residual = looks[f"{name}: torque [N m]"], looks[f"{name}: residual [N m]"]
        measured, described, identified = (series["y"] for series in look["series"])
        np.testing.assert_allclose(residual["series"][1]["y"], measured - identified, atol=1e-12)
        ((start, stop, word),) = look["spans"]
        assert word == "held out"
        held = (look["x"] >= start) & (look["x"] <= stop)
        for computed, told, (_, _, end, _) in zip((described, identified), (old, new), errors[name], strict=True):
            part = np.linalg.norm((computed - measured)[held]) / np.linalg.norm(measured[held])
            assert part == pytest.approx(told.joints[name])
            assert end == pytest.approx(100.0 * part)


def test_dots_of_friction_lie_along_the_law(found: Identified) -> None:
    look = charts(identified_page(found))["azimuth: friction over speed"]
    dots, law = look["series"]
    fast = np.abs(dots["x"]) > 0.3
    there = np.isfinite(law["x"])
    by_law = np.interp(dots["x"][fast], law["x"][there], law["y"][there])
    assert np.median(np.abs(dots["y"][fast] - by_law)) < 0.06
    np.testing.assert_allclose(
        by_law, RUBS.viscous * dots["x"][fast] + np.where(dots["x"][fast] > 0, 1.0, -0.8), atol=0.03
    )


def test_what_is_not_determined_stands_apart(found: Identified) -> None:
    groups = bars(identified_page(found))
    unsure = groups["Not determined: 0 is within the interval of 95 %"]
    fit = found.base
    for name, value, error in zip(fit.base.short_groups, fit.values, fit.standard_errors, strict=True):
        assert (name in unsure) == (abs(value) <= 1.96 * error)
    (label, start, end, _), (_, left, right, _) = groups["Friction and rotors"]["azimuth.viscous"]
    assert label.endswith("description 0")
    assert left == 0.0 < right < start < end == 100.0


def test_a_page_of_an_identification_is_whole(found: Identified) -> None:
    page = identified_page(found)
    (robot,) = (block.look["robots"][0] for block in page.blocks if isinstance(block, doc.Stage))
    assert "calibrated" in robot["bodies"][-1]["words"]
    assert {arrow["kind"] for arrow in robot["motions"][0]["arrows"]} == {"torque"}
    drawn = checked(html(page)).all("main")[0].text
    assert "Along the logs" in drawn
    assert not charts(identified_page(found, pictures=False))


def test_long_logs_keep_their_peaks(found: Identified, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = found.curves()
    monkeypatch.setattr(courses, "MOST", 50)
    monkeypatch.setattr(courses, "LEAST", 10)
    few = found.curves()
    assert few.per > 1
    for name in few.curves:
        assert few.of(name)[0].min() == whole.of(name)[0].min()
        assert few.of(name)[1].max() == whole.of(name)[1].max()


def test_a_law_has_breakaway_offset_and_load() -> None:
    motor = MotorFit({"a": 1.0}, 2.0, 3.0, 0.5, 0.1, stribeck=4.0, stribeck_velocity=0.2, load=0.1)
    at = np.array([-5.0, -1e-9, 1e-9, 5.0])
    np.testing.assert_allclose(motor.friction(at, 10.0), [-10.0 - 3.0 + 0.5 - 1.0, -5.0, 5.0, 10.0 + 3.0 + 0.5 + 1.0])


def test_effects_that_are_told_explain_what_is_measured(logged: tuple[robodyn.Model, str]) -> None:
    model, path = logged
    found = compare(model, path)
    page = measured_page(found)
    looks = charts(page)
    assert len(looks) == 3 * model.n
    verdict = page.blocks[0]
    assert isinstance(verdict, doc.Verdict)
    assert any("Coulomb friction" in reason for reason in verdict.reasons)
    for joint in found.joints:
        off, left = (series["y"] for series in looks[f"{joint.name}: residual [N m]"]["series"])
        assert np.sqrt(np.mean(off**2)) == pytest.approx(joint.residual)
        assert np.sqrt(np.mean(left**2)) == pytest.approx(joint.left)
        dots, told = looks[f"{joint.name}: friction over speed"]["series"]
        np.testing.assert_allclose(dots["y"] - told["y"], left, atol=1e-9)
    (stage,) = (block for block in page.blocks if isinstance(block, doc.Stage))
    (motion,) = stage.look["robots"][0]["motions"]
    rows = np.rint((motion["time"] + 0.0) / 0.005).astype(int)
    q = np.loadtxt(path, delimiter=",", skiprows=1)[:, 1 : 1 + model.n]
    np.testing.assert_allclose(np.stack(motion["q"], axis=1), q[rows], atol=0.01)  # through the filter
    assert not charts(measured_page(found, pictures=False))


@cache
def excited() -> Any:
    return excite(robodyn.load(ROBOTS / "two_link_planar.urdf"), period=4.0, harmonics=3)


def test_an_exciting_motion_is_drawn_within_its_limits() -> None:
    found = excited()
    page = excitation_page(found)
    looks = charts(page)
    assert [caption.split()[0] for caption in looks] == ["Position", "Speed", "Acceleration", "Effort"]
    for look in looks.values():
        for series in look["series"]:
            assert np.abs(series["y"]).max() <= 100.0 + 1e-6
    speed = looks["Speed [% of limits]"]["series"][0]["y"]
    assert np.abs(speed).max() == pytest.approx(100.0 * found.joints[0].speed / found.joints[0].speed_limit, rel=5e-3)
    (stage,) = (block for block in page.blocks if isinstance(block, doc.Stage))
    assert stage.look["loop"]
    np.testing.assert_array_equal(stage.look["robots"][0]["motions"][0]["q"][1], found.motion[0, :, 1])


def test_bars_of_standard_errors_are_logarithmic() -> None:
    found = excited()
    rows = bars(excitation_page(found))["Standard errors of base parameters"]
    errors = zip(found.base.short_groups, found.values, found.information.standard_errors, strict=True)
    for name, value, error in errors:
        label, start, end, colour = rows[name][0]
        assert start == 0.0
        if value:
            part = 100.0 * error / abs(value)
            assert end == pytest.approx(25.0 * (np.clip(np.log10(part), -2.0, 2.0) + 2.0))
            assert colour == ("good" if part < 10.0 else "doubtful" if part < 100.0 else "bad")
        else:
            assert (end, colour) == (0.0, "raised")
            assert label.startswith("0 +- ")
