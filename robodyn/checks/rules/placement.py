"""Where parts stand: detached, on the wrong parent, drawn in millimetres."""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from robodyn.checks.bodies.contacts import contacts, detached, too_large
from robodyn.checks.bodies.shapes import other_unit
from robodyn.checks.examples import a_joint, a_link, a_tower, arm
from robodyn.checks.mirror.pairs import named_pairs, row_of
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule
from robodyn.robot.urdf.numbers import value_span
from robodyn.support.wording import shown


@rule(
    "RD111",
    Severity.WARNING,
    Stage.TREE,
    good=a_tower(),
    bad=('<child link="hand"/><origin xyz="0 0 0.1"/>', '<child link="hand"/><origin xyz="0 0 1.0"/>'),
)
def detached_part(context: Context) -> Faults:
    """The parts on both sides of a joint are next to each other.

    Where the shapes of nearly all joints' children touch those of their parents, a child far from its parent has
    the wrong one, or its origin is wrong: it has millimetres in an entry, or a sign or digit too many. The gap
    is that between the boxes around the shapes, each joint at 0 or at its limit next to 0; it is reported where it
    is more than a tenth of the larger part and 1 cm, of parts that are fixed half the larger part and 5 cm, and
    nine of ten of the other joints have none.
    """
    for name, (contact, bound) in context.once(detached).items():
        joint = context.view.joint[name]
        below = f"of link '{joint.child}' and what is fixed to it"
        what = f"its parts do not meet: the shapes {below} are {contact.gap:.3g} m from those of '{contact.above}'"
        remedy = "check the parent link, and the unit and signs of the origin"
        at = joint.name_span if joint.origin.element is None else joint.origin.xyz.span
        yield Fault(at, what, remedy, contact.gap, bound, cause=too_large(context, joint))


_NUMBER = re.compile(r"(?<!\d)\d{1,9}(?!\d)")
_OTHERS, _EACH, _MOST = 3, 2, 0.9
"""Least number of links of a row that hang alike, of those that one link carries, and the share of all but one that
hang alike. Of 124 descriptions, most of them published, none has an exception then."""

Parents = Mapping[str, str]


class Odd(NamedTuple):
    """A link (or the one of two that stands later in the file) that hangs on another parent than the `expected` one,
    which its namesakes say; the `other` namesake that may be the wrong one instead; and what the others do."""

    link: str
    expected: str
    other: str | None
    why: str


def odd_parents(context: Context) -> tuple[Odd, ...]:
    """Return the links that hang on another parent than those whose names differ in left and right, or in a number.
    From stage TREE on."""
    parent = {child: joint.parent for child, joint in context.tree.above.items()}
    found = {odd.link: odd for odd in _rows(parent)}
    named = list(named_pairs({*parent, *parent.values()}))
    times = Counter(name for names in named for name in names)  # the left finger of a right hand is in two pairs
    left = {right: left for left, right in named if times[left] == times[right] == 1}
    twin = {**left, **{one: other for other, one in left.items()}}
    alike, splits = 0, []
    for right, one in left.items():
        if one in parent and right in parent:
            first, second = parent[one], parent[right]
            if max(times[first], times[second]) > 1 or first == right or second == one:
                continue
            if twin.get(first, first) == second and not (first in twin and first == second):
                alike += 1
            else:
                splits.append((one, right))
    others = sum(not set(split) & {parent[link] for link in split} for split in splits)
    for split in splits if alike and alike >= _MOST * (alike + others - 1) else ():
        if not found.keys() & set(split):
            blamed = _blamed(context, split, parent, left)
            k, other = blamed[0], split[1 - blamed[0]]
            pairs = "1 other pair named so hangs" if alike == 1 else f"{alike} other pairs named so hang"
            why = f"{shown(other)} hangs on {shown(parent[other])}, and {pairs} alike"
            expected = twin.get(parent[other], parent[other])
            found[split[k]] = Odd(split[k], expected, other if len(blamed) > 1 else None, why)
    return tuple(found.values())


def _blamed(context: Context, split: tuple[str, str], parent: Parents, left: Mapping[str, str]) -> Sequence[int]:
    """Return which of two twins is wrong: the one that hangs as none in front or behind does, or on the other's side,
    or apart from its parent's shapes; else both, the later in the file first."""

    def row(link: str) -> str:
        return row_of(left.get(link, link))

    hung = Counter(row(parent[link]) for link in parent if row(link) == row(split[0]))
    alone = [hung[row(parent[link])] == 1 < max(hung.values()) for link in split]
    known = [context.once(contacts).get(context.tree.above[link].name) for link in split]
    apart = [contact is not None and not contact.touches for contact in known]
    sided = {*left, *left.values()}
    crossed = [parent[link] in sided and (parent[link] in left) != (link in left) for link in split]
    for signs in (alone, crossed, apart):
        if signs[0] != signs[1]:
            return (0,) if signs[0] else (1,)
    return sorted((0, 1), key=lambda k: -context.tree.above[split[k]].element.start)


def _rows(parent: Parents) -> Iterator[Odd]:
    """Yield the links of a row of numbers that hang neither on the one before nor, with others, on one that carries
    several of the row, where all others do."""
    rows: dict[tuple[str, str], dict[int, str]] = defaultdict(dict)
    for name in parent:
        for found in _NUMBER.finditer(name):
            rows[name[: found.start()], name[found.end() :]][int(found[0])] = name
    for row in rows.values():
        if len(row) <= _OTHERS:
            continue
        members = set(row.values())
        carried = Counter(parent[name] for name in row.values() if parent[name] not in members)
        most, count = max(carried.items(), key=lambda one: one[1])
        after = {name: row.get(k - 1) for k, name in row.items()}
        chained = [name for name, before in after.items() if parent[name] == before]
        hung = [name for name in row.values() if carried[parent[name]] > _EACH]
        first = [name for name, before in after.items() if before is None and count <= len(chained)]
        alike = len({*chained, *hung})
        odd = sorted(members.difference(chained, hung, first))
        if odd and alike >= _OTHERS and alike >= _MOST * (alike + len(odd) - 1):
            for name in odd:
                before = after[name]
                if before is not None and len(chained) >= count:
                    why = f"{len(chained)} other links of this row of numbers hang on the one before"
                    yield Odd(name, before, None, why)
                else:
                    why = f"{count} other links of this row of numbers hang on {shown(most)}"
                    yield Odd(name, most, None, why)


_SEGMENTS = [f"segment_{k}" for k in range(1, 7)]
_CHAIN = zip(("upper", *_SEGMENTS), _SEGMENTS, strict=False)
_LONG_ARM = arm(more="".join(a_link(child) + a_joint(f"on_{parent}", parent, child) for parent, child in _CHAIN))


@rule(
    "RD112",
    Severity.WARNING,
    Stage.TREE,
    good=_LONG_ARM,
    bad=('<parent link="segment_4"/>', '<parent link="segment_2"/>'),
    explains=("RD111",),
)
def odd_parent(context: Context) -> Faults:
    """A link has the parent that its namesakes tell.

    Of links whose names differ in left and right, left_hand and right_hand, FL_calf and FR_calf, each is a child of
    the namesake of the other's parent, and link_5 is a child of link_4. Where others do so, and all but one in ten,
    one that does not has the wrong parent: by a copied line that was not changed, or changed twice. Which one of
    two is wrong is told by the links in front of them and behind them, by the side that a name and its parent's name
    say, and by shapes that do not touch those of the parent; where nothing tells, both are named.
    """
    for odd in context.once(odd_parents):
        joint = context.tree.above[odd.link]
        what = f"it makes {shown(odd.link)} a child of {shown(joint.parent)}, but {odd.why}"
        either = "" if odd.other is None else f", or the other pairs show that {shown(odd.other)} is the wrong one"
        parent = next(child for child in joint.element.children if child.tag == "parent")
        yield Fault(value_span(parent, "link"), what, f"make {shown(odd.expected)} its parent{either}")


@rule(
    "RD113",
    Severity.ERROR,
    Stage.TREE,
    good=a_tower(),
    bad=a_tower().replace("0.1 0.1 0.1", "100 100 100").replace("0.1 0.1 0.25", "100 100 250"),
)
def drawn_in_millimetres(context: Context) -> Faults:
    """A robot is drawn in metres.

    Where the links' masses over the boxes around their shapes are 1e9 times too small in the median, and 1000 times
    shorter lengths bring them to what published robots have, all lengths are in millimetres; or they were divided
    by 1000 that were in metres. At least three links with mass and shapes show it. What follows from it, for
    densities, inertias, centres of mass and torques, is not reported beside it. A mesh in millimetres alone is
    RD605's, an origin RD111's.
    """
    unit = context.once(other_unit)
    if unit is None:
        return
    large = unit.times > 1
    what = (
        f"its links weigh {unit.density:.3g} kg/m^3 of the boxes around their shapes (median): lengths are "
        f"{'in millimetres' if large else 'a thousandth of metres'}, which makes {unit.density * unit.times**3:.3g}"
    )
    remedy = f"{'divide' if large else 'multiply'} all lengths by 1000, those of meshes by their scale"
    yield Fault(value_span(context.view.root, "name"), what, remedy, unit.times, 1.0, subject=None)
