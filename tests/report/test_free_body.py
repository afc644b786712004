"""Free bodies as drawings: complete, legible, in colours that can be read."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from helpers.html_pages import contrast
from helpers.oracles import random_state, robot

import robodyn
from robodyn.dynamics.plan import EFFECTS
from robodyn.report.equations.free_body import BOTTOM, COLOURS, OTHER, STYLE, TOP, WIDTH, arrows, drawing, drawings
from robodyn.report.sizes import free_body_sizes

NAMES = ("puma560", "scara", "satellite")


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
    for _, svg in drawings(robot, "somewhere"):
        labels = [each for each in texts(svg) if TOP < each[1] < BOTTOM and " = " in each[-1]]
        assert labels
        boxes = [(x, y, 0.32 * size * len(text)) for x, y, _, size, text in labels]
        assert all(x - half > 0 and x + half < WIDTH for x, _, half in boxes)
        for (x, y, half), (a, b, wide) in combinations(boxes, 2):
            assert abs(x - a) >= half + wide or abs(y - b) >= 16, name


@pytest.mark.parametrize("name", NAMES)
def test_every_force_and_moment_is_drawn_and_listed(name):
    for body, (_, svg) in zip(found(name).bodies, drawings(found(name), "somewhere"), strict=True):
        words = [text for *_, text in texts(svg)]
        assert min(size for *_, size, _ in texts(svg)) >= 12
        for action in body.actions:
            assert any(line.startswith(action.what[:30]) for line in words)
        for part, unit in (("force", "N"), ("moment", "N m")):
            sizes = [np.linalg.norm(getattr(action, part)) for action in body.actions]
            drawn = sum(bool(re.search(rf" = \S+ {unit}$", text)) for text in words)
            assert drawn == sum(size > 1e-9 * max(sizes) for size in sizes)


def test_a_vector_towards_the_reader_is_a_ring():
    found = robodyn.free_bodies(robot("scara"), [0.0] * 3, scene=robodyn.Scene(gravity=(9.0, 9.0, 9.0)))
    body, size = found.bodies[1], free_body_sizes(found)
    (weight,) = (arrow for arrow in arrows(body, [(0.0, 0.0)] * len(body.actions), size) if arrow.symbol == "W")
    assert weight.start == weight.end
    assert weight.towards
    assert 'r="3.5"' in drawing(body, "", size)


def test_colours_can_be_read_on_both_papers():
    inside = {"gravity", "inertia", "coriolis", "moving base", "payload", "mimic"}
    assert {effect.name for effect in EFFECTS} <= inside | set(COLOURS)
    papers = re.findall(r"\.paper \{ fill: (#\w+)", STYLE)
    assert len(papers) == 2
    for paper in papers:
        assert [kind for kind, colour in COLOURS.items() if contrast(colour, paper) < 3.0] == []
    assert min(contrast(OTHER, paper) for paper in papers) >= 3.0
    body, size = found("scara").bodies[1], free_body_sizes(found("scara"))
    new = replace(body, actions=(*body.actions[1:], replace(body.actions[0], kind="yet unknown")))
    assert OTHER in drawing(new, "", size)
    model = robodyn.load(b'<robot name="a&lt;b"><link name="x"/></robot>')
    (_, svg), *_ = drawings(robodyn.free_bodies(model, []), "<&>")
    assert any("a<b, <&>" in text for *_, text in texts(svg))
