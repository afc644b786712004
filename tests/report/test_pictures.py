"""Pictures: solids and errors against time, complete, legible, and drawn by what is nearer."""

from __future__ import annotations

import itertools
import re

import numpy as np
import pytest
from helpers.html_pages import checked
from helpers.oracles import ROBOTS
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from robodyn.measure.accuracy.ladder import Accuracy, Ladder, Rung, Spread
from robodyn.programs.vectors import product
from robodyn.report.accuracy import accuracy_page, draw_ladder
from robodyn.report.pictures.robot import PAPER, draw_solids, nearest
from robodyn.report.renderers.pages import html
from robodyn.solids.mesh.read.load import load_triangles


def test_the_long_faces_of_a_bracket_hide_what_is_behind_them() -> None:
    """The top of its plate, of long triangles, shows nothing of the faces below and behind."""
    mesh = load_triangles(str(ROBOTS / "meshes" / "bracket.stl")).array()
    placed = product(mesh, PAPER.T)
    placed = (placed - placed.min(axis=(0, 1))) * 2.0
    away = np.cross(placed[:, 1] - placed[:, 0], placed[:, 2] - placed[:, 0])[:, 2] < 0.0
    seen = nearest(placed, 250, 250)
    covered = seen[seen >= 0]
    assert len(covered) > 5_000
    assert away[covered].mean() < 0.01


def test_thin_triangles_and_those_that_pass_through_one_another_are_drawn() -> None:
    """Without an area or seen from the edge they make a picture; of two that cross each is seen in half."""
    triangles = np.random.default_rng(7).uniform(0.0, 40.0, (8, 3, 3))
    triangles[:2], triangles[2:4, 2] = triangles[0, 0], triangles[2:4, :2].mean(axis=1)
    triangles[4:6] = product(triangles[4:6] * (0.0, 1.0, 1.0), PAPER)
    axes = Figure().subplots()
    draw_solids(axes, [(0, triangles)])
    assert np.isfinite(axes.images[0].get_array()).all()
    rising = np.array(((0.0, 0.0, 0.0), (60.0, 0.0, 60.0), (30.0, 60.0, 30.0)))
    seen = nearest(np.stack((rising, rising * (1.0, 1.0, -1.0) + (0.0, 0.0, 60.0))), 60, 60)
    assert set(seen[:20, 22:28].flat) == {1}
    assert set(seen[:20, 32:38].flat) == {0}


def ladder(errors: list[float], times: list[float]) -> Accuracy:
    """Methods with these errors and times [s]."""
    rungs = tuple(
        Rung(f"method {k}", (error,), Spread(t, 0.99 * t, 1.01 * t, 5))
        for k, (error, t) in enumerate(zip(errors, times, strict=True))
    )
    return Accuracy("r", (Ladder("torques", ("torque",), "digits", "sample", rungs),), ())


def drawn(errors: list[float], times: list[float], target: float | None = None):
    """The axes of a ladder, drawn."""
    axes = Figure().subplots()
    draw_ladder(axes, ladder(errors, times).ladders[0], target)
    FigureCanvasAgg(axes.figure).draw()
    return axes


def heights(axes) -> list[float]:
    """Where the points are on paper, in the order of the methods."""
    return [axes.transData.transform((1.0, container.lines[0].get_ydata()[0]))[1] for container in axes.containers]


def labels(axis) -> list[str]:
    return [label.get_text() for label in axis.get_ticklabels() if label.get_text()]


def test_errors_below_rounding_have_heights_of_their_own() -> None:
    axes = drawn([1e-32, 1e-21, 1e-16, 1e-8], [4e-6, 3e-6, 2e-6, 1e-6])
    found = heights(axes)
    assert found == sorted(found)
    assert min(b - a for a, b in itertools.pairwise(found)) > 0.15 * (found[-1] - found[0])


def test_an_error_of_zero_stands_below_all_others_at_0() -> None:
    axes = drawn([0.0, 1e-25, 1e-3], [3e-6, 2e-6, 1e-6], target=1e-28)
    zero = axes.containers[0].lines[0].get_ydata()[0]
    assert zero < 1e-29
    assert dict(zip(axes.get_yticks(), labels(axes.yaxis), strict=True))[zero] == "0"


@pytest.mark.parametrize("times", [(1.1e-5, 1.25e-5, 1.9e-5), (6.8e-6, 7.0e-6, 7.1e-6), (1e-8, 1e-2), (5e-9, 3e-8)])
def test_no_label_stands_twice(times: tuple[float, ...]) -> None:
    found = ladder([10.0 ** (-3 * k - 1) for k in range(len(times))], list(times))
    texts = [each.text.strip() for each in checked(html(accuracy_page(found))).all("text")]
    numbers = [text for text in texts if re.fullmatch(r"\u2212?\d[\d.]*(e[+\u2212]\d+)?", text)]
    assert len(numbers) == len(set(numbers)) >= 4, numbers
