"""Links whose names differ in left and right, or in a number, and what each of them hangs on.

Where every other link named left has a namesake named right that hangs on the namesake of its parent, one that does not
hangs on the wrong parent; a row of numbers, link_4 on link_3, is read likewise.
"""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from robodyn.checks.bodies.contacts import contacts
from robodyn.checks.context import Context
from robodyn.checks.mirror.pairs import named_pairs, row_of
from robodyn.support.wording import shown

_NUMBER = re.compile(r"(?<!\d)\d{1,9}(?!\d)")
_OTHERS, _EACH, _MOST = 3, 2, 0.9
"""Least number of links of a row that hang alike, of those that one link carries, and the share of all but one that
hang alike. Of 124 descriptions, most of them published, none has an exception then."""

Parents = Mapping[str, str]


@dataclass(frozen=True)
class Odd:
    """A link that hangs on another parent than its namesakes say.

    Attributes:
        link: it, or the one of two that stands later in the file.
        expected: the parent that its namesakes say.
        other: the namesake that may be the wrong one instead; None if this one is.
        why: what the others do, in words.
    """

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
    """Return which of two twins is the wrong one, or both, the later in the file first.

    The wrong one is that which hangs as none in front of it or behind it does, or on the other's side, or apart from
    its parent's shapes.
    """

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
                yield _of_row(name, after[name], len(chained), most, count)


def _of_row(name: str, before: str | None, chained: int, most: str, count: int) -> Odd:
    if before is not None and chained >= count:
        return Odd(name, before, None, f"{chained} other links of this row of numbers hang on the one before")
    return Odd(name, most, None, f"{count} other links of this row of numbers hang on {shown(most)}")
