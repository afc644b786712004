"""Drawings of free bodies: well-formed, complete, on the page, and legible on light and dark paper."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from itertools import combinations

import numpy as np
import pytest
from helpers.html_pages import contrast
from helpers.oracles import random_state, robot

import robodyn
from robodyn.dynamics.plan import EFFECTS
from robodyn.report.pictures.free_body import (
    COLOURS,
    LONGEST,
    PAGE,
    PAPERS,
    SHEET,
    SHORTEST,
    STYLE,
    _apart,
    arrows,
    drawing,
    drawings,
    page_drawing,
)
from robodyn.report.sizes import free_body_sizes

NAMES = ("puma560", "scara", "cylindrical", "satellite", "two_link_spatial")


def found(name, seed=0):
    model = robot(name)
    (q,), (qd,), (qdd,) = random_state(model, np.random.default_rng(seed), 1)
    return robodyn.free_bodies(model, q, qd, qdd)


def texts(svg):
    return [
        (float(node.get("x")), float(node.get("y")), node.get("text-anchor"), float(node.get("font-size")), node.text)
        for node in ET.fromstring(svg).iter("{http://www.w3.org/2000/svg}text")
    ]


@pytest.mark.parametrize("name", NAMES)
def test_labels_stay_on_the_page_and_apart(name):
    robot = found(name)
    sheets = [(svg, SHEET) for _, svg in drawings(robot, "somewhere")]
    pages = [(page_drawing(body, free_body_sizes(robot)), PAGE) for body in robot.bodies]
    for svg, paper in (*sheets, *pages):
        labels = [each for each in texts(svg) if paper.top < each[1] < paper.bottom and " = " in each[-1]]
        boxes = [(x, y, 0.32 * size * len(text)) for x, y, _, size, text in labels]
        assert all(x - half > 0 and x + half < paper.width for x, _, half in boxes)
        for (x, y, half), (a, b, wide) in combinations(boxes, 2):
            assert abs(x - a) >= half + wide or abs(y - b) >= 16, name


@pytest.mark.parametrize("name", NAMES)
def test_every_force_and_moment_is_drawn_and_listed(name):
    for body, (_, svg) in zip(found(name).bodies, drawings(found(name), "somewhere"), strict=True):
        words = [text for *_, text in texts(svg)]
        for action in body.actions:
            assert any(line.startswith(action.what[:30]) for line in words)
        for part, unit in (("force", "N"), ("moment", "N m")):
            sizes = [np.linalg.norm(getattr(action, part)) for action in body.actions]
            drawn = sum(bool(re.search(rf" = \S+ {unit}$", text)) for text in words)
            assert drawn == sum(size > 1e-9 * max(sizes) for size in sizes)


def test_arrows_are_to_scale():
    body = found("scara").bodies[1]
    spots = [(100.0 * k, 0.0) for k in range(len(body.actions))]
    for turning, part in enumerate(("force", "moment")):
        largest = max(np.linalg.norm(getattr(action, part)) for action in body.actions)
        for arrow in arrows(body, spots, free_body_sizes(found("scara"))):
            if arrow.turning == bool(turning):
                length = np.hypot(arrow.end[0] - arrow.start[0], arrow.end[1] - arrow.start[1])
                assert length <= max(SHORTEST, LONGEST * arrow.value / largest) * np.sqrt(1.5) * (1 + 1e-12)


def test_a_vector_towards_the_reader_is_a_ring():
    found = robodyn.free_bodies(robot("scara"), [0.0] * 3, scene=robodyn.Scene(gravity=(9.0, 9.0, 9.0)))
    body, size = found.bodies[1], free_body_sizes(found)
    (weight,) = (arrow for arrow in arrows(body, [(0.0, 0.0)] * len(body.actions), size) if arrow.symbol == "W")
    assert weight.start == weight.end
    assert weight.towards
    assert 'r="3.5"' in drawing(body, "", size)


def test_colours_can_be_read_on_both_papers():
    for paper in PAPERS:
        assert paper in STYLE
        assert [kind for kind, colour in COLOURS.items() if contrast(colour, paper) < 3.0] == []


def test_every_effect_has_its_colour():
    inside = {"gravity", "inertia", "coriolis", "moving base", "payload", "mimic"}
    assert {effect.name for effect in EFFECTS} <= inside | set(COLOURS)


def test_marks_stand_apart():
    """Also where joints and mass centre coincide, as in a robot of points."""
    spot = (100.0, 100.0)
    marks = _apart([spot] * 4)
    assert marks[1] == spot
    for (x, y), (a, b) in combinations(marks, 2):
        assert np.hypot(x - a, y - b) >= 18


def test_letters_are_large_enough():
    for _, svg in drawings(found("puma560"), "somewhere"):
        assert min(size for *_, size, _ in texts(svg)) >= 12


def test_names_cannot_break_a_drawing():
    model = robodyn.load(b'<robot name="a&lt;b"><link name="x"/></robot>')
    (_, svg), *_ = drawings(robodyn.free_bodies(model, []), "<&>")
    assert any("a<b, <&>" in text for *_, text in texts(svg))
