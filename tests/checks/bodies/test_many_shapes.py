"""Links with very many shapes: the work grows as their number, and no table of all pairs is made."""

from __future__ import annotations

import tracemalloc
from collections import Counter
from itertools import pairwise

import numpy as np
import pytest

from robodyn.checks.bodies import collision_fit, contacts
from robodyn.checks.context import Context
from robodyn.robot.urdf.document import read
from robodyn.solids.inertia.validity import Box

MANY = 400
LINK = '<link name="{}">{}</link>'
JOINT = (
    '<joint name="j{1}" type="revolute"><parent link="{0}"/><child link="{1}"/><axis xyz="0 0 1"/>'
    '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
)


def shapes(kind, shift=0.0):
    return "".join(
        f'<{kind}><origin xyz="{0.01 * k + shift} 0 0"/><geometry><box size="0.1 0.1 0.1"/></geometry></{kind}>'
        for k in range(MANY)
    )


def context(*links):
    names = "abcd"[: len(links)]
    parts = [LINK.format(name, content) for name, content in zip(names, links, strict=True)]
    joints = [JOINT.format(*pair) for pair in pairwise(names)]
    return Context(read(f'<robot name="r">{"".join(parts + joints)}</robot>'.encode()))


@pytest.mark.parametrize("seen", ["", shapes("visual")])
def test_shapes_are_measured_once_each(monkeypatch, seen):
    calls = Counter()

    def sides(shape, given, original=collision_fit._sides):
        calls["sides"] += 1
        return original(shape, given)

    monkeypatch.setattr(collision_fit, "_sides", sides)
    assert collision_fit.misfits(context(shapes("collision") + seen, "")) == ()
    assert calls["sides"] <= 2 * MANY


def test_a_shape_aside_is_found_among_many():
    (found,) = collision_fit.misfits(context(shapes("collision", shift=30.0) + shapes("visual"), ""))
    assert "is not where its visual is" in found.what


def test_pairs_of_shapes_of_one_link_are_none(monkeypatch):
    boxes = [Box(np.full(3, 1e-4 * k), np.full(3, 1.0 + 1e-4 * k)) for k in range(1500)]
    tracemalloc.start()
    assert list(contacts._meeting(boxes, ["a"] * len(boxes))) == []
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 10e6
    assert len(list(contacts._meeting(boxes[:30], ["a", "b"] * 15))) == 225


def test_pairs_of_links_are_compared_a_bounded_number_of_times(monkeypatch):
    calls = Counter()

    def deep(*given, original=contacts.depth):
        calls["depth"] += 1
        return original(*given)

    monkeypatch.setattr(contacts, "depth", deep)
    (found,) = contacts.overlaps(context(shapes("collision"), shapes("visual"), shapes("collision")))
    assert (found.first.name, found.second.name) == ("a", "c")
    assert calls["depth"] <= contacts._MOST_PAIRS < MANY**2
