"""Questions about links and joints that need not be a tree."""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping
from typing import TypeVar

from robodyn.checks.view import JointView, View

K = TypeVar("K", bound=Hashable)


def first_above(view: View) -> dict[str, JointView]:
    """For each link that is a joint's child, the first such joint."""
    above: dict[str, JointView] = {}
    for joint in view.joints:
        if joint.child:
            above.setdefault(joint.child, joint)
    return above


def cycles(successor: Mapping[K, K]) -> Iterator[list[K]]:
    """Every cycle of a graph in which each node has at most one successor. Each node is visited twice at most."""
    walk_of: dict[K, int] = {}
    for walk, start in enumerate(successor):
        node = start
        while node in successor and node not in walk_of:
            walk_of[node] = walk
            node = successor[node]
        if walk_of.get(node) == walk and node in successor:
            cycle = [node]
            while (node := successor[node]) != cycle[0]:
                cycle.append(node)
            yield cycle
