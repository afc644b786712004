"""Slips planted in links of real robots are named by the links' own shapes, and none by another name.

The robots are none of those on which the distributions of `robodyn.robot.masses.mistakes` were measured.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
from helpers.example_robots import path_of

from robodyn.checks.bodies.bodies import bodies, given, shaped
from robodyn.checks.context import Context
from robodyn.robot.masses.mistakes import UPPER, Given, Posterior, Uniform, mistake_posterior
from robodyn.robot.urdf.document import read

pytestmark = pytest.mark.slow
ROBOTS = ("go2", "laikago", "kinova", "panda", "xarm7", "solo12", "z1", "bolt", "allegro_right_hand", "human")
LB, INCH = 0.45359237, 0.0254


def steiner(g: Given, times: float) -> tuple[float, ...]:
    return tuple((g.tensor + times * g.steiner)[UPPER].tolist())


def put(g: Given, entries: tuple[float, ...]) -> Given:
    return Given(g.mass, g.c, g.R, tuple(entries))


def times(mass: float, centre: float, inertia: float) -> Callable[[Given], Given]:
    return lambda g: Given(g.mass * mass, g.c * centre, g.R, tuple(inertia * x for x in g.entries))


def order(*places: int) -> Callable[[Given], Given]:
    return lambda g: put(g, tuple(g.entries[k] for k in places))


def flipped(g: Given) -> Given:
    return put(g, tuple(-x if k in (1, 2, 4) else x for k, x in enumerate(g.entries)))


PLANTED: dict[str, tuple[Callable[[Given], Given], str | tuple[float, float, float] | None, float]] = {
    "nothing": (lambda g: g, None, 0.0),
    "signs": (flipped, "RD306", 0.0),
    "about the origin": (lambda g: put(g, steiner(g, 1.0)), "RD307", 0.0),
    "parallel axis subtracted": (lambda g: put(g, steiner(g, -1.0)), "RD308", 0.15),
    "axes": (order(5, 2, 4, 0, 1, 3), "RD312", 0.0),
    "MuJoCo's order": (order(0, 3, 5, 1, 2, 4), "RD310", 0.25),
    "iyy ten times": (lambda g: put(g, (*g.entries[:3], 10 * g.entries[3], *g.entries[4:])), "RD311", 0.25),
    "mass in g": (times(1e3, 1, 1), (1e3, 1, 1), 0.7),
    "mass in t": (times(1e-3, 1, 1), (1e-3, 1, 1), 0.5),
    "mass and inertia in g": (times(1e3, 1, 1e3), (1e3, 1, 1e3), 0.6),
    "mass in g, inertia in g mm^2": (times(1e3, 1, 1e9), (1e3, 1, 1e9), 0.85),
    "centre in mm": (times(1, 1e3, 1), (1, 1e3, 1), 0.5),
    "g mm^2": (times(1, 1, 1e9), (1, 1, 1e9), 0.6),
    "kg mm^2": (times(1, 1, 1e6), (1, 1, 1e6), 0.6),
    "kg cm^2": (times(1, 1, 1e4), (1, 1, 1e4), 0.25),
    "lb in^2": (times(1, 1, 1 / LB / INCH**2), (1, 1, 1 / LB / INCH**2), 0.0),
    "g m^2": (times(1, 1, 1e3), (1, 1, 1e3), 0.35),
    "centre times 16.7": (times(1, 16.7, 1), None, 0.0),
    "centre times 60": (times(1, 60, 1), None, 0.0),
    "inertia times 50": (times(1, 1, 50), None, 0.0),
    "mass times 30": (times(30, 1, 1), None, 0.0),
}
"""What is done to what a link says, the code or the factors that it is to be named by, None if by nothing, and the
share that is named at least. Of others few are: within what is usual, or as probable by another slip."""


@cache
def healthy() -> tuple[tuple[Given, Uniform], ...]:
    """What links say that their shapes do not contradict, and the shapes; up to 8 of each robot."""
    found = []
    for stem in ROBOTS:
        context = Context(read(path_of(stem)))
        shapes, kept = context.once(shaped), set()
        for name in context.once(bodies):
            said = given(context.view.link[name])
            if said is None or name not in shapes or said.entries in kept or len(kept) == 8 or not said.c.any():
                continue
            solid = shapes[name].solid.along(said.R)
            if mistake_posterior(said, solid).right > 0.7:
                kept.add(said.entries)
                found.append((said, solid))
    return tuple(found)


def is_it(verdict: Posterior, meant: str | tuple[float, float, float] | None) -> bool:
    first = verdict.named[0]
    if isinstance(meant, str):
        return first.mistake.code == meant
    return (
        meant is not None and first.mistake.factors is not None and np.allclose(first.mistake.factors, meant, rtol=1e-4)
    )


@cache
def counted(kind: str) -> Counter[str]:
    plant, meant, _ = PLANTED[kind]
    verdicts = [mistake_posterior(plant(said), solid) for said, solid in healthy()]
    return Counter(
        ("right" if is_it(one, meant) else "wrong") if one.named else "either" if one.either else "none"
        for one in verdicts
    )


def test_at_most_one_in_twenty_of_a_kind_and_one_in_fifty_of_all_has_another_name() -> None:
    assert len(healthy()) >= 40
    assert set(counted("nothing")) == {"none"}
    assert [kind for kind in PLANTED if counted(kind)["wrong"] > 0.05 * counted(kind).total()] == []
    found = sum((counted(kind) for kind in PLANTED), Counter[str]())
    assert found["wrong"] <= 0.02 * (found["right"] + found["wrong"])


@pytest.mark.parametrize("kind", [kind for kind, (*_, least) in PLANTED.items() if least])
def test_a_share_is_named(kind: str) -> None:
    found = counted(kind)
    assert found["right"] >= PLANTED[kind][2] * found.total(), found
