"""What connects two bodies: equations that hold them together, and what they leave free."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from robodyn.equations.dae.equations import Across, Along, Equation
from robodyn.programs.vectors import Array, product
from robodyn.support.floats import first_largest


@dataclass(frozen=True, eq=False)
class Connection:
    """A joint, a mimic rule or a loop's closure, as equations between a body and another.

    Attributes:
        kind: "fixed", "revolute", "prismatic", "floating", "mimic", "point", "hinge", "weld" or "directions".
        body, other: what is held, and what holds it; -1 is the ground.
        held: names of the reactions, F for forces and M for moments, each with its direction, and their equations.
        free: rates of the joint's own coordinates, f of them; along them act drives, friction, springs and rotors.
    """

    name: str
    kind: str
    body: int
    other: int
    held: tuple[tuple[str, Equation], ...]
    free: tuple[Equation, ...] = ()

    @cached_property
    def equations(self) -> tuple[Equation, ...]:
        """One for each reaction."""
        return tuple(equation for _, equation in self.held)

    @cached_property
    def reactions(self) -> tuple[str, ...]:
        """Names of the reactions."""
        return tuple(name for name, _ in self.held)


class Anchors(NamedTuple):
    """Two bodies, a point of each from its mass centre in its axes [m], and the turn R from the body's to the other's.

    Axes that are R apart coincide where the bodies are connected.
    """

    body: int
    other: int
    point: Array
    to: Array
    R: Array


class Basis(NamedTuple):
    """Three perpendicular unit vectors, right-handed, and their names; `last` is the one that matters, if one does."""

    vectors: tuple[Array, Array, Array]
    names: tuple[str, str, str]
    last: int = 2


PLAIN = Basis((np.array((1.0, 0, 0)), np.array((0, 1.0, 0)), np.array((0, 0, 1.0))), ("x", "y", "z"))


def basis_about(axis: Array) -> Basis:
    """x, y and z for one of these or its opposite; for any other axis a two vectors 1 and 2 with 1 x 2 = a."""
    k = int(np.argmax(np.abs(axis)))
    if abs(axis[k]) == 1.0:
        return PLAIN._replace(last=k)
    first = np.cross(PLAIN.vectors[first_largest(-np.abs(axis), noise=1e-9)], axis)
    first = first / np.sqrt(product(first, first))
    return Basis((first, np.cross(axis, first), axis), ("1", "2", "a"))


def held_along(anchors: Anchors, basis: Basis, directions: Sequence[int]) -> list[tuple[str, Equation]]:
    """Return equations that keep the point from moving along some of the directions, with their reactions' names."""
    body, other, point, to, R = anchors
    return [(f"F{basis.names[k]}", Along(body, other, point, to, product(R, basis.vectors[k]))) for k in directions]


def held_about(anchors: Anchors, basis: Basis, directions: Sequence[int]) -> list[tuple[str, Equation]]:
    """Return equations that keep the body from turning about some of the directions, with their reactions' names.

    For the moment about k = i x j, direction i of the body stays across direction j of the other. Where the body may
    turn about j, direction j of the body stays across -i of the other, so that the moment keeps its place in the other.
    """
    body, other, _, _, R = anchors
    out: list[tuple[str, Equation]] = []
    for k in directions:
        i, j = (k + 1) % 3, (k + 2) % 3
        if j in directions or i not in directions:
            own, across = basis.vectors[i], product(R, basis.vectors[j])
        else:
            own, across = basis.vectors[j], -product(R, basis.vectors[i])
        out.append((f"M{basis.names[k]}", Across(body, other, own, across)))
    return out


def connected(
    name: str, kind: str, anchors: Anchors, found: Sequence[tuple[str, Equation]], free: Sequence[Equation] = ()
) -> Connection:
    """Return a connection of named equations."""
    return Connection(name, kind, anchors.body, anchors.other, tuple(found), tuple(free))


def weld(name: str, anchors: Anchors, kind: str = "weld") -> Connection:
    """Hold everything: 6 equations."""
    everything = [*held_along(anchors, PLAIN, (0, 1, 2)), *held_about(anchors, PLAIN, (0, 1, 2))]
    return connected(name, kind, anchors, everything)


def hinge(name: str, anchors: Anchors, axis: Array, kind: str = "hinge", free: Sequence[Equation] = ()) -> Connection:
    """Hold the points together, the body turning about `axis` (its axes) alone: 5 equations."""
    basis = basis_about(axis)
    across = [k for k in range(3) if k != basis.last]
    held = [*held_along(anchors, basis, (0, 1, 2)), *held_about(anchors, basis, across)]
    return connected(name, kind, anchors, held, free)


def slide(name: str, anchors: Anchors, axis: Array, kind: str = "slide", free: Sequence[Equation] = ()) -> Connection:
    """Let the body move along `axis` (its axes), and not turn: 5 equations."""
    basis = basis_about(axis)
    across = [k for k in range(3) if k != basis.last]
    held = [*held_along(anchors, basis, across), *held_about(anchors, basis, (0, 1, 2))]
    return connected(name, kind, anchors, held, free)


def point(name: str, anchors: Anchors) -> Connection:
    """Hold the points together, a ball joint: 3 equations."""
    return connected(name, "point", anchors, held_along(anchors, PLAIN, (0, 1, 2)))


def directions(name: str, anchors: Anchors, along: Sequence[Array]) -> Connection:
    """Hold the points level along some directions (in the other's axes): an equation for each."""
    unit = [n / np.sqrt(product(n, n)) for n in along]
    body, other, own, to, _ = anchors
    return connected(
        name, "directions", anchors, [(f"F{k}", Along(body, other, own, to, n)) for k, n in enumerate(unit, 1)]
    )
