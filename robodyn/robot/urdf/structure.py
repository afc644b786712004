"""One tree: every link but the root is the child of one joint, and each mimic joint has a leader in the end."""

from __future__ import annotations

from collections.abc import Collection, Hashable, Iterable, Iterator, Mapping, Sequence
from itertools import islice
from typing import Protocol, TypeVar

from robodyn.robot.urdf.parts import Joint, Link
from robodyn.robot.urdf.strict import Strict
from robodyn.support.wording import alternatives, listed, shown

_MOST_SHOWN = 6


class _Named(Protocol):
    @property
    def name(self) -> str: ...
    @property
    def line(self) -> int: ...


N = TypeVar("N", bound=_Named)
K = TypeVar("K", bound=Hashable)


def by_name(parts: Iterable[N], kind: str, strict: Strict) -> dict[str, N]:
    """Return the parts by name; no name may stand for two."""
    named: dict[str, N] = {}
    for part in parts:
        first = named.setdefault(part.name, part)
        if first is not part:
            what = f"a second {kind} {shown(part.name)}, the first is in line {first.line}"
            raise strict.error(part.line, what, "rename one of them")
    return named


def root_link(links: Mapping[str, Link], joints: Sequence[Joint], strict: Strict) -> str:
    """Return the name of the one link without a parent, after checking that the joints make a tree of the links."""
    if not links:
        raise strict.error(1, "the robot has no links", "add a <link>")
    above = _joint_above(links, joints, strict)
    for cycle in cycles({child: joint.parent for child, joint in above.items()}):
        first = min((above[link] for link in cycle), key=lambda joint: joint.line)
        start = cycle.index(first.parent)
        downward = [*cycle[start::-1], *cycle[:start:-1]]
        what = f"links are children of each other in a cycle: {_round(downward)}"
        raise strict.error(first.line, what, "a URDF must be a tree")
    roots = [link for link in links if link not in above]
    if len(roots) > 1:
        what = f"{len(roots)} links have no parent: {listed(roots)}"
        raise strict.error(links[roots[1]].line, what, "join them to one tree; a URDF has one root link")
    return roots[0]


def check_mimics(joints: Mapping[str, Joint], lines: Mapping[str, int], strict: Strict) -> None:
    """Check that mimic joints follow joints that lead somewhere; `lines` are those of the <mimic> elements."""
    leaders = {joint.name: joint.mimic.joint for joint in joints.values() if joint.mimic is not None}
    for name, leader in leaders.items():
        if leader not in joints:
            what = f"joint {shown(name)} mimics joint {shown(leader)}, which does not exist"
            raise strict.error(lines[name], what, alternatives(leader, joints, "joints"))
        if leader == name:
            raise strict.error(lines[name], f"joint {shown(name)} mimics itself", "name another joint")
    for cycle in cycles(leaders):
        what = f"joints mimic each other in a cycle: {_round(cycle)}"
        raise strict.error(min(lines[name] for name in cycle), what, "let one of them be free")


def _joint_above(links: Mapping[str, Link], joints: Iterable[Joint], strict: Strict) -> dict[str, Joint]:
    """Return for each link but the roots the joint that it is a child of."""
    above: dict[str, Joint] = {}
    for joint in joints:
        for role, link in (("parent", joint.parent), ("child", joint.child)):
            if link not in links:
                raise _dangling(joint, role, link, links, strict)
        first = above.setdefault(joint.child, joint)
        if first is not joint:
            what = f"link {shown(joint.child)} is a child of two joints: {shown(first.name)} (line {first.line})"
            raise strict.error(joint.line, f"{what} and {shown(joint.name)}", "a link has one parent; remove one joint")
    return above


def _dangling(joint: Joint, role: str, link: str, links: Collection[str], strict: Strict) -> Exception:
    what = f"the {role} of joint {shown(joint.name)} is link {shown(link)}, which does not exist"
    return strict.error(joint.line, what, alternatives(link, links, "links"))


def cycles(successor: Mapping[K, K]) -> Iterator[list[K]]:
    """Yield every cycle of a graph in which each node has at most one successor. Each node is visited twice at most."""
    walk_of: dict[K, int] = {}
    for walk, start in enumerate(successor):
        node = start
        while node in successor and node not in walk_of:
            walk_of[node] = walk
            node = successor[node]
        if walk_of.get(node) == walk:
            cycle = [node]
            while (node := successor[node]) != cycle[0]:
                cycle.append(node)
            yield cycle


def _round(cycle: Sequence[str]) -> str:
    names = [shown(name) for name in islice(cycle, _MOST_SHOWN)]
    if len(cycle) > _MOST_SHOWN:
        names.append(f"... ({len(cycle)} in all)")
    return " -> ".join([*names, names[0]])
