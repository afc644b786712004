"""Links whose names differ in one word, and what each of them hangs on.

Where every other link named left has a namesake named right that hangs on the namesake of its parent, one that does not
hangs on the wrong parent. The robot itself says which words go in pairs, so that left and right, FL and RR, arm and
leg, or finger 1 and 2 need no list; a row of numbers, link_4 on link_3, is read likewise.
"""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

from robodyn.checks.bodies.contacts import contacts
from robodyn.checks.context import Context
from robodyn.support.wording import shown

_WORD = re.compile(r"(?:left|right)|[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+")
_NUMBER = re.compile(r"(?<!\d)\d{1,9}(?!\d)")
_OTHERS, _EACH, _OF_SIDES, _MOST = 3, 2, 1, 0.9
"""Least number of pairs that hang alike: by all words together, by each, and by words of sides; and their share of all
but one. Of 124 descriptions, most of them published, none has an exception then."""
_ENDS = ("", *"fbhmr")
_LEFT = {"left": "right", **{f"{end}l": f"{end}r" for end in _ENDS}, **{f"l{end}": f"r{end}" for end in _ENDS}}
_MIRROR = {**_LEFT, **{right: left for left, right in _LEFT.items()}}
_FAMILY = 10
"""Names that differ in one word, above which they are a list: 40 patches of skin."""

Parents = Mapping[str, str]
Swap = Mapping[str, str]


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


@dataclass(frozen=True)
class _Split:
    """Two namesakes that hang on parents that are none.

    Attributes:
        links: they. expected: the parent of each that the other says.
        alike: pairs of the same words that hang alike. enough: whether these are as many as is asked for.
    """

    links: tuple[str, str]
    expected: tuple[str, str]
    alike: int
    enough: bool


def odd_parents(context: Context) -> tuple[Odd, ...]:
    """Return the links that hang on another parent than those whose names differ in one word. From stage TREE on."""
    parent = {child: joint.parent for child, joint in context.tree.above.items()}
    found = {odd.link: odd for odd in _rows(parent)}
    splits, company = _splits(parent)
    judged = [(split, _blamed(context, split, company, parent)) for split in splits]
    for split, blamed in judged:
        if not blamed or found.keys() & set(split.links):
            continue
        link = split.links[blamed[0]]
        told = sum(other.alike for other, its in judged if its and other.links[its[0]] == link)
        if split.enough or told >= _OTHERS:
            found[link] = _odd(split, blamed, parent)
    return tuple(found.values())


def _odd(split: _Split, blamed: Sequence[int], parent: Parents) -> Odd:
    k = blamed[0]
    other = split.links[1 - k]
    pairs = "1 other pair named so hangs" if split.alike == 1 else f"{split.alike} other pairs named so hang"
    why = f"{shown(other)} hangs on {shown(parent[other])}, and {pairs} alike"
    return Odd(split.links[k], split.expected[k], other if len(blamed) > 1 else None, why)


def _blamed(context: Context, split: _Split, company: set[str], parent: Parents) -> Sequence[int]:
    """Return which of the links is the wrong one, or both, the later in the file first; none where each has company.

    The wrong one is that which hangs as no namesake does, or on the other's side, or apart from its parent's shapes.
    """
    links = split.links
    if company.issuperset(links):
        return ()
    alone = [link not in company for link in links]
    crossed = [_crossed(links[k], links[1 - k], parent) for k in (0, 1)]
    for signs in (alone, crossed, [_apart(context, link) for link in links]):
        if signs[0] != signs[1]:
            return (0,) if signs[0] else (1,)
    return sorted((0, 1), key=lambda k: -context.tree.above[links[k]].element.start)


def _crossed(link: str, other: str, parent: Parents) -> bool:
    """Return whether the name of a link's parent has the word of the other link and not that of its own."""
    own, its, above = (_words(name) for name in (link, other, parent[link]))
    return bool(above & (its - own)) and not above & (own - its)


def _apart(context: Context, link: str) -> bool:
    contact = context.once(contacts).get(context.tree.above[link].name)
    return contact is not None and not contact.touches


def _splits(parent: Parents) -> tuple[list[_Split], set[str]]:
    """Return the namesakes that do not hang alike where others of the same words do, and the links that hang as one of
    their namesakes does."""
    having: dict[str, dict[str, None]] = defaultdict(dict)
    for name in (*parent, *parent.values()):
        for word in _words(name):
            having[word][name] = None
    links = {*parent, *parent.values()}
    found, company = list[_Split](), set[str]()
    for swap in (_MIRROR, *_swaps(links)):
        whole = _twins(having, swap, links, False)
        first_word = _twins(having, swap, links, True) if swap is _MIRROR else {}  # R is roll, too
        ways = {**whole, **first_word}, {**first_word, **whole}
        is_row, alike, splits = next(iter(swap)).isdigit(), list[str](), []
        for one, other in ways[True].items():
            if one > other or one not in parent or other not in parent:
                continue
            twin = ways[one in whole]
            first, second = parent[one], parent[other]
            expected = twin.get(second, second), twin.get(first, first)
            named = first in twin or second in twin
            if expected[1] == second and not (named and first == second):
                alike += [one, other]
            elif (named or swap is _MIRROR) and not (is_row and (first == other or second == one)):
                splits.append(((one, other), expected))
        count, others = (
            len(alike) // 2,
            sum(not {one, other} & {parent[one], parent[other]} for (one, other), _ in splits),
        )
        if count >= (_OF_SIDES if swap is _MIRROR else _EACH) and count >= _MOST * (count + others - 1):
            found += [_Split(*split, count, swap is _MIRROR or count >= _OTHERS) for split in splits]
            company.update(alike)
    return sorted(found, key=lambda split: -split.alike), company


def _twins(having: Mapping[str, Collection[str]], swap: Swap, links: Collection[str], first: bool) -> dict[str, str]:
    """Return by name the link that has the other words, or only another first one, of those that are there."""
    words = swap if swap is _MIRROR else [min(swap, key=lambda word: len(having[word]))]
    found = {}
    for name in (name for word in words for name in having.get(word, ())):
        other = _swapped(name, swap, first)
        if other in links and other != name:
            found[name], found[other] = other, name
    return found


def _swaps(links: Iterable[str]) -> Iterator[Swap]:
    """Yield the words, in lower case, in which names differ that are otherwise the same; without left and right."""
    families: dict[tuple[str, str], list[str]] = defaultdict(list)
    for name in links:
        for found in _WORD.finditer(name):
            families[name[: found.start()], name[found.end() :]].append(found[0].lower())
    pairs = {pair for words in families.values() if len(words) <= _FAMILY for pair in combinations(sorted(words), 2)}
    for a, b in sorted(pairs):
        if a != b and a.isdigit() == b.isdigit() and _MIRROR.get(a) != b:
            yield {a: b, b: a}


def _words(name: str) -> set[str]:
    return {word.lower() for word in _WORD.findall(name)}


def _swapped(name: str, swap: Swap, first: bool) -> str:
    """Return a name with words for each other, in upper and lower case as they were; all, or the first of them."""
    if not first:
        return _WORD.sub(lambda found: _cased(swap.get(found[0].lower()), found[0]), name)
    word = next(found for found in _WORD.finditer(name) if found[0].lower() in swap)
    return name[: word.start()] + _cased(swap[word[0].lower()], word[0]) + name[word.end() :]


def _cased(word: str | None, like: str) -> str:
    if word is None:
        return like
    if like.isupper():
        return word.upper()
    return word.capitalize() if like[0].isupper() else word


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
