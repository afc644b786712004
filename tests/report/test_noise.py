"""Rounding noise is shown as 0 wherever numbers are shown, and no text depends on the last digit of a sum."""

from __future__ import annotations

import math
import re
from dataclasses import fields, replace
from functools import cache

import numpy as np
import pytest
from helpers.example_robots import real
from helpers.oracles import ROBOTS, robot
from helpers.report_text import simulation_text, torques_text

import robodyn
from robodyn.loads.many import Worst
from robodyn.loads.result import JointLoad, Result
from robodyn.report.document import text
from robodyn.report.equations import free_body_sections
from robodyn.report.pictures.free_body import drawings
from robodyn.report.renderers.markdown import markdown
from robodyn.report.sizes import free_body_sizes, result_sizes
from robodyn.report.torques import worst_table
from robodyn.report.torques_json import torques_json
from robodyn.report.torques_page import torques_page
from robodyn.scene.read import load_scene
from robodyn.simulation.simulate import simulate

TINY = re.compile(r"\de-(?:1[2-9]|[2-9]\d|\d{3})")
"""A number that only rounding makes, in cases of newtons and metres."""


@cache
def falling() -> Result:
    """The arm in a pose that it keeps while its base falls freely: nothing carries anything."""
    model = robot("puma560", moving_base=True)
    time = np.linspace(0.0, 1.0, 60)
    q, qd, qdd = np.zeros((60, model.nq)), np.zeros((60, model.n)), np.zeros((60, model.n))
    q[:, 3:7] = np.array((0.1, -0.5, 0.3, 0.8)) / math.sqrt(0.99)
    q[:, 7:] = np.linspace(0.3, 1.9, model.nq - 7)
    qdd[:, 3:6] = (0.0, 0.0, -9.81 * (1.0 + np.finfo(float).eps))
    q[:, 2], qd[:, 5] = -9.81 / 2 * time**2, -9.81 * time
    scene = robodyn.Scene(moving_base=True)
    return robodyn.torques(model, robodyn.motion(model, time, q, qd, qdd), scene, sizing=True, history=True)


def test_free_fall_carries_nothing_in_text_and_page() -> None:
    found = falling()
    peaks = [abs(joint.peak) for joint in found.joints]
    assert 0.0 < max(peaks) < 1e-12, "rounding leaves something, or this tests nothing"
    for words in (torques_text(found), _page(found)):
        assert not TINY.search(words.replace("<1e-12", "")), words
    assert any(f'"peak": {joint.peak!r}' in torques_json(found) for joint in found.joints if joint.peak), "all digits"
    assert "zero throughout" in torques_text(found)


def _page(found: Result) -> str:
    model, scene = robot("puma560", moving_base=True), robodyn.Scene(moving_base=True)
    return markdown(torques_page(found, model, scene, pictures=False))


def test_noise_is_no_arrow_of_a_drawing() -> None:
    """A wrist at rest whose moments are the rounding of forces at the end of an arm."""
    model = real("ur5_robot")
    found = robodyn.free_bodies(model, [0.0] * model.n)
    moments = [float(np.linalg.norm(a.moment)) for body in found.bodies for a in body.actions]
    assert any(0.0 < x < 1e-11 for x in moments), "rounding leaves something, or this tests nothing"
    for _, svg in drawings(found, "at rest"):
        assert not TINY.search(svg)
    assert not TINY.search(text(free_body_sections(found, "at rest")).replace("<1e-12", ""))


def test_a_moment_is_told_beside_the_largest_force_at_the_reach() -> None:
    model = real("ur5_robot")
    found = robodyn.free_bodies(model, [0.0, -math.pi / 2, 0.0, 0.0, 0.0, 0.0])
    size = free_body_sizes(found)
    assert size["N"] == pytest.approx(9.81 * model.total_mass, rel=0.2)
    assert size["N m"] >= 0.5 * size["N"]
    assert 1.0 < model.reach < 1.5


def test_simulations_show_no_noise() -> None:
    model = robot("heavy_top")
    scene = load_scene(ROBOTS / "heavy_top_steady.toml")
    found = simulate(model, scene, duration=0.2)
    assert 0.0 < np.abs(found.qdd).max() < 1e-10
    text = simulation_text(found)
    assert not TINY.search(text.replace("<1e-12", "")), text


@pytest.mark.parametrize("sizing", [False, True])
def test_no_text_depends_on_the_last_digit(sizing: bool) -> None:
    """All figures of a motion moved by some units of rounding of the largest of their kind: the same text."""
    model = robot("puma560")
    found = robodyn.torques(model, ROBOTS / "puma560_sweep.csv", sizing=sizing)
    rng, size = np.random.default_rng(1), result_sizes(found)
    shown = torques_text(found, explain=True)
    for _ in range(5):
        joints = tuple(_moved(joint, size, rng) for joint in found.joints)
        base = tuple(
            replace(part, peak=_by_noise(part.peak, size["N" if part.name[0] == "f" else "N m"], rng))
            for part in found.base_wrench
        )
        checks = replace(found.checks, first_law=rng.uniform(0, 1e-14), second_law=0.0, power=rng.uniform(0, 1e-14))
        assert torques_text(replace(found, joints=joints, base_wrench=base, checks=checks), explain=True) == shown


def _moved(joint: JointLoad, size, rng) -> JointLoad:
    kinds = {"peak_power": "W", "work_positive": "J", "work_negative": "J", "max_speed": "rad/s"}
    kinds |= dict.fromkeys(("peak", "rms", "cubic_mean"), "N m")
    names = {field.name for field in fields(joint)}
    assert kinds.keys() <= names
    moved = {name: _by_noise(getattr(joint, name), size[kind], rng) for name, kind in kinds.items()}
    shares = {name: _by_noise(share, size["N m"], rng) for name, share in joint.shares.items()}
    return replace(joint, **moved, shares=shares)


def _by_noise(x: float, scale: float, rng) -> float:
    return x + rng.uniform(-4.0, 4.0) * np.finfo(float).eps * scale


def test_a_batch_shows_no_noise() -> None:
    """A joint that carries nothing in any file, beside one that does."""
    idle = "idle", "N m", 3e-16, 0.5, 7, 1e-16, 0.5, None, None, None
    worst = Worst(*idle, peak_in="a.csv", rms_in="a.csv", max_speed_in="a.csv", level_in="")
    loaded = replace(worst, name="loaded", peak=12.0, rms=5.0)
    _, rows = worst_table((worst, loaded))
    assert (rows[0][1], rows[0][2], rows[0][5]) == ("0 N m", "-", "0")
    assert (rows[1][1], rows[1][2], rows[1][5]) == ("12.00 N m", "0.5", "5.000")
