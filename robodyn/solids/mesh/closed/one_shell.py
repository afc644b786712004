"""Whether a surface is one shell, proven edge by edge in memory that does not grow with it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from robodyn.solids.mesh.blocks import block_space, fill, rows_for
from robodyn.solids.mesh.closed.fingerprint import EdgeSums, Words
from robodyn.solids.mesh.distinct import Numbers
from robodyn.solids.mesh.indexed import components
from robodyn.solids.mesh.triangles import Triangles

HELD = 1 << 22
"""Sides of triangles that are kept at a time."""

_HASH = 63
_STRIP = 8
"""Triangles of a strip, at least, on the average over a file that lists neighbours one after the other."""

_PIECE = 1 << 13
_DOUBTFUL = 1 << 12
"""Hashes that several edges may share, at most: by chance a mesh of 10^8 triangles has a few hundred."""

_SPARE = 1 << 12


def readings(count: int) -> int:
    """Return how often `is_one_shell` reads a mesh of so many triangles, if all goes well."""
    return 1 << (3 * count // HELD).bit_length()


def is_one_shell(triangles: Triangles) -> bool:
    """Return whether every edge belongs to exactly two triangles, and edges connect all triangles.

    Then no face is there twice, and if the boundary vanishes all have one winding. Triangles that follow each other and
    share an edge are a strip. The sides of all triangles are sorted by a hash of their edge (see
    `robodyn.solids.mesh.closed`), which has the number of the strip for its lowest bits: neighbours of the same hash
    link their strips. Of a large mesh the sides whose hashes begin with the same bits are taken together, and the mesh
    is read as often as that takes. Strips leave 40 to 50 bits of the hash; the few edges that have these in common, as
    some of millions do, are told apart by all 63 when the mesh is read once more.

    Accuracy: decides rightly but for edges with the same 63 bits, which it takes for one edge.
    """
    count = triangles.count
    for strips in (count // _STRIP, count):
        bits = (strips + count // rows_for(count) + 1).bit_length()
        found = _linked(triangles, bits)
        if found is not None:
            return found
    return False


def _linked(triangles: Triangles, bits: int) -> bool | None:
    """`is_one_shell` where numbers of strips have so many bits; None if they have more."""
    split = readings(triangles.count).bit_length() - 1
    room = np.empty((3 * triangles.count >> split) + split * _SPARE, np.uint64)
    doubtful: set[int] = set()
    shells: Numbers | None = None
    for part in range(1 << split):
        found = _sides(triangles, bits, split, part, room)
        if found is None:
            return None
        keys, strips = found
        keys.sort()
        shells = _joined(np.arange(strips) if shells is None else shells, keys, bits, doubtful)
        if shells is None:
            return False
    if doubtful and shells is not None:
        shells = _joined_by_all_bits(triangles, shells, bits, split, doubtful)
    return shells is not None and not shells.any()


def _sided(triangles: Triangles) -> Iterator[tuple[Words, Words]]:
    """Of each block, in the memory of the next: the hash of each side, (3, n), and the strip of each triangle, (n,)."""
    space = block_space(triangles)
    edges = EdgeSums(space)
    strip, first = np.empty(space.shape[-1], np.uint64), 0
    left = triangles.count
    for _ in fill(space, triangles, checked=False):
        edges.add()
        _number_strips(edges.sides, first, strip)
        yield edges.sides[:, :left], strip[:left]
        first = int(strip[:left][-1]) + 1
        left -= strip.size


def _sides(triangles: Triangles, bits: int, split: int, part: int, room: Words) -> tuple[Words, int] | None:
    """The sides of one part, each the hash of its edge with its strip in so many bits; and how many strips there are.

    None if strips have more bits, or sides take more room than chance would have them take.
    """
    drop = np.uint64(_HASH - split)
    filled = strips = 0
    for sides, strip in _sided(triangles):
        keys = _kept_bits(sides, bits, split)
        np.bitwise_or(keys, strip, keys)
        chosen = keys[sides >> drop == part] if split else keys
        if int(strip[-1]) >> bits or filled + chosen.size > room.size:
            return None
        room[filled : filled + chosen.size].reshape(chosen.shape)[...] = chosen
        filled += chosen.size
        strips = int(strip[-1]) + 1
    return room[:filled], strips


def _kept_bits(sides: Words, bits: int, split: int) -> Words:
    """Return the hashes of sides without the bits that name a part, and without those that strips take."""
    keys = sides << np.uint64(1 + split)
    keys &= np.uint64((1 << 64) - (1 << bits))
    return keys


def _number_strips(sides: Words, first: int, out: Words) -> None:
    """Number the strips of a block, (n,), from here on."""
    shared = np.zeros(out.size - 1, np.bool_)
    for i in range(3):
        for j in range(3):
            shared |= sides[i, 1:] == sides[j, :-1]
    out[0] = first
    np.logical_not(shared, out[1:])
    np.cumsum(out, out=out)


def _joined(shells: Numbers, keys: Words, bits: int, doubtful: set[int]) -> Numbers | None:
    """Return the shell of each strip after edges have linked them; None if edges do not have two sides each.

    Args:
        shells: (strips,) numbers from zero on, those that are known to be one being equal.
        keys: of sides, in order.
        doubtful: hashes with more than two sides are added, and link nothing.
    """
    if keys.size % 2:
        return None
    low = np.uint64(bits)
    links: list[Words] = []
    for start in range(0, keys.size, _PIECE):
        piece = keys[start : start + _PIECE + 1]
        one, other, following = piece[0:-1:2], piece[1::2], piece[2::2]
        gaps = one ^ other
        if (gaps >> low).any():
            return None
        shared = (other[: following.size] ^ following) >> low == 0
        if shared.any():
            doubtful.update((following[shared] >> low).tolist())
            if len(doubtful) > _DOUBTFUL:
                return None
        if shells.any():
            apart = np.flatnonzero(gaps)
            pairs = np.stack((one[apart], other[apart]))
            links.append(pairs[:, ~_among(pairs[0] >> low, doubtful)] if doubtful else pairs)
            if sum(link.shape[1] for link in links) >= len(shells):
                shells, links = _merged(shells, links, bits), []
    return _merged(shells, links, bits)


def _among(words: Words, few: set[int]) -> NDArray[np.bool_]:
    return np.isin(words, np.array(sorted(few), np.uint64))


def _joined_by_all_bits(
    triangles: Triangles, shells: Numbers, bits: int, split: int, doubtful: set[int]
) -> Numbers | None:
    """`_joined` by the sides that it left out."""
    found: list[Words] = []
    for sides, strip in _sided(triangles):
        chosen = _among(_kept_bits(sides, bits, split) >> np.uint64(bits), doubtful)
        found.append(np.stack((sides[chosen], np.broadcast_to(strip, sides.shape)[chosen])))
    hashes, strips = np.concatenate(found, axis=1)
    order = np.argsort(hashes)
    one, other = hashes[order].reshape(-1, 2).T
    if (one != other).any() or (other[:-1] == one[1:]).any():
        return None
    return _merged(shells, [strips[order].reshape(-1, 2).T], bits)


def _merged(shells: Numbers, links: list[Words], bits: int) -> Numbers:
    for link in links and [np.concatenate(links, axis=1)]:
        a, b = shells[link & np.uint64((1 << bits) - 1)]
        shells = components(int(shells.max()) + 1, a, b)[shells]
    return shells
