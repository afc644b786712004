"""All planes and axes of bodies with the symmetry of each finite group, in any orientation, and of almost such."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.point_groups import GOLDEN, axes, body, group, hulled, planes
from helpers.symmetric_bodies import extrusion, found
from helpers.symmetry_cases import bodies

AXIAL = ["C", "Cv", "Ch", "D", "Dh", "Dd", "S"]
REGULAR = ["T", "Td", "Th", "O", "Oh", "I", "Ih"]
GROUPS = [(name, 2 + k % 2) for k, name in enumerate(AXIAL)] + [("T", 1), ("Td", 1)]
FURTHER = [(name, n) for n in (4, 5, 7) for name in AXIAL] + [(name, 1) for name in REGULAR]
ALMOST = [(name, 3) for name in AXIAL] + [(name, 1) for name in REGULAR]
ICOSAHEDRON = [np.roll((0.0, s, t), k) for s in (-1, 1) for t in (-GOLDEN, GOLDEN) for k in range(3)]


def same(one: np.ndarray, other: np.ndarray, within: float) -> bool:
    return bool(np.linalg.norm(np.cross(one, other)) < within)


def all_found(name: str, n: int, noise: float = 0.0, seed: int = 0, within: float = 1e-5) -> None:
    elements = group(name, n)
    corners, R = body(elements, noise, seed)
    verdict = found(corners)
    least = max(1e-6, 100 * noise)
    mirrors = [plane.normal for plane in verdict.planes if plane.asymmetry <= least]
    turns = [(axis.direction, axis.fold) for axis in verdict.axes if axis.asymmetry <= least]
    for normal in planes(elements):
        assert any(same(R @ normal, other, within) for other in mirrors)
    for direction, fold in axes(elements):
        assert any(same(R @ direction, other, within) and fold == many for other, many in turns)
    assert len(mirrors) == len(planes(elements))
    assert len(turns) == len(axes(elements))


@pytest.mark.parametrize(("name", "n"), GROUPS)
def test_every_element_of_a_finite_group_is_found_and_no_other(name: str, n: int) -> None:
    all_found(name, n)


def test_an_icosahedron_has_15_planes_and_31_axes() -> None:
    corners, _ = hulled(np.array(ICOSAHEDRON), np.random.default_rng(2))
    verdict = found(corners)
    assert [plane.verdict for plane in verdict.planes] == ["exact"] * 15
    assert [axis.fold for axis in verdict.axes] == [5] * 6 + [3] * 10 + [2] * 15
    assert {axis.verdict for axis in verdict.axes} == {"exact"}


@pytest.mark.parametrize("longer", [1e-3, 1e-2])
def test_an_axis_is_near_though_one_arm_of_a_star_is_longer(longer: float) -> None:
    angles, radii = np.pi * np.arange(6) / 3, np.array((1 + longer, 0.5, 1.0, 0.5, 1.0, 0.5))
    verdict = found(extrusion(np.column_stack([radii * np.cos(angles), radii * np.sin(angles)]), 0.6))
    ((asymmetry, kind),) = [(axis.asymmetry, axis.verdict) for axis in verdict.axes if axis.fold == 3]
    assert kind == "near"
    assert 0.2 * longer < asymmetry < longer
    assert sum(axis.fold == 2 for axis in verdict.axes) == 3


@pytest.mark.slow
@pytest.mark.parametrize(("name", "n"), FURTHER)
def test_every_element_of_further_axial_groups_is_found(name: str, n: int) -> None:
    all_found(name, n, seed=n)


@pytest.mark.parametrize(("name", "n"), [("Cv", 3), ("D", 4)])
def test_every_element_is_found_where_it_is_near(name: str, n: int) -> None:
    all_found(name, n, noise=1e-5, within=0.03)


@pytest.mark.slow
@pytest.mark.parametrize("noise", [1e-9, 1e-5])
@pytest.mark.parametrize(("name", "n"), ALMOST)
def test_every_element_of_a_group_is_found_where_it_is_near(name: str, n: int, noise: float) -> None:
    all_found(name, n, noise, seed=1, within=max(1e-4, min(0.05, 1e3 * noise)))


@pytest.mark.slow
def test_fewer_than_one_verdict_in_a_hundred_is_false():
    given = list(bodies(100))
    wrong, told = (sum(part) for part in zip(*(body.false_verdicts() for body in given), strict=True))
    assert told == 300
    assert wrong < 0.01 * told
    assert sum(len(body.holding) for body in given) > 80
    assert sum(len(body.broken) for body in given) > 80
    assert len({body.name for body in given}) > 20
