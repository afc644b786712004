"""Whether a surface is one shell, proven edge by edge in memory that does not grow with it."""

from __future__ import annotations

import numpy as np

from robodyn.mesh.blocks import block_space, fill, rows_for
from robodyn.mesh.closed import EdgeSums, Words
from robodyn.mesh.indexed import Numbers, components
from robodyn.mesh.triangles import Triangles

HELD = 1 << 22
"""Sides of triangles that are kept at a time."""

_HASH = 63
_STRIP = 8
"""Triangles of a strip, at least, on the average over a file that lists neighbours one after the other."""

_PIECE = 1 << 13
_SPARE = 1 << 12


def is_one_shell(triangles: Triangles) -> bool:
    """Whether every edge belongs to exactly two triangles, and edges connect all triangles.

    Then no face is there twice, and if the boundary vanishes all have one winding. Triangles that follow each other and
    share an edge are a strip. The sides of all triangles are sorted by a hash of their edge (see
    `robodyn.mesh.closed`), which has the number of the strip for its lowest bits: neighbours of the same hash link
    their strips. Of a large mesh the sides whose hashes begin with the same bits are taken together, and the mesh is
    read as often as that takes.

    Accuracy: never True of another surface, but for edges with the same 63 bits. Also False where edges have the same
        bits of those that strips leave, which a mesh of a million triangles has with a probability below 2 %, and 13 %
        if its triangles are in random order.
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
    split = (3 * triangles.count // HELD).bit_length()
    room = np.empty((3 * triangles.count >> split) + split * _SPARE, np.uint64)
    shells: Numbers | None = None
    for part in range(1 << split):
        found = _sides(triangles, bits, split, part, room)
        if found is None:
            return None
        keys, strips = found
        keys.sort()
        shells = _joined(np.arange(strips) if shells is None else shells, keys, bits)
        if shells is None:
            return False
    return shells is not None and not shells.any()


def _sides(triangles: Triangles, bits: int, split: int, part: int, room: Words) -> tuple[Words, int] | None:
    """The sides of one part, each the hash of its edge with its strip in so many bits; and how many strips there are.

    None if strips have more bits, or sides take more room than chance would have them take.
    """
    space = block_space(triangles)
    edges = EdgeSums(space)
    strip, keys = np.empty(space.shape[-1], np.uint64), np.empty_like(edges.sides)
    drop, shift, low = np.uint64(_HASH - split), np.uint64(1 + split), np.uint64((1 << 64) - (1 << bits))
    filled = strips = 0
    left = triangles.count
    for _ in fill(space, triangles, checked=False):
        edges.add()
        _number_strips(edges.sides, strips, strip)
        np.left_shift(edges.sides, shift, keys)
        np.bitwise_and(keys, low, keys)
        np.bitwise_or(keys, strip, keys)
        chosen = keys[:, :left]
        if split:
            chosen = chosen[edges.sides[:, :left] >> drop == part]
        if int(strip[-1]) >> bits or filled + chosen.size > room.size:
            return None
        room[filled : filled + chosen.size].reshape(chosen.shape)[...] = chosen
        filled += chosen.size
        strips = int(strip[:left][-1]) + 1
        left -= strip.size
    return room[:filled], strips


def _number_strips(sides: Words, first: int, out: Words) -> None:
    """Number the strips of a block, (n,), from here on."""
    shared = np.zeros(out.size - 1, np.bool_)
    for i in range(3):
        for j in range(3):
            shared |= sides[i, 1:] == sides[j, :-1]
    out[0] = first
    np.logical_not(shared, out[1:])
    np.cumsum(out, out=out)


def _joined(shells: Numbers, keys: Words, bits: int) -> Numbers | None:
    """The shell of each strip after edges have linked them; None if edges do not have two sides each.

    Args:
        shells: (strips,) numbers from zero on, those that are known to be one being equal.
        keys: of sides, in order.
    """
    if keys.size % 2:
        return None
    low = np.uint64(bits)
    links: list[Words] = []
    for start in range(0, keys.size, _PIECE):
        piece = keys[start : start + _PIECE + 1]
        one, other, following = piece[0:-1:2], piece[1::2], piece[2::2]
        gaps = one ^ other
        if (gaps >> low).any() or not ((other[: following.size] ^ following) >> low).all():
            return None
        if shells.any():
            apart = np.flatnonzero(gaps)
            links.append(np.stack((one[apart], other[apart])))
            if sum(link.shape[1] for link in links) >= len(shells):
                shells, links = _merged(shells, links, bits), []
    return _merged(shells, links, bits)


def _merged(shells: Numbers, links: list[Words], bits: int) -> Numbers:
    for link in links and [np.concatenate(links, axis=1)]:
        a, b = shells[link & np.uint64((1 << bits) - 1)]
        shells = components(int(shells.max()) + 1, a, b)[shells]
    return shells
