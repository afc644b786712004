"""Whether a surface is closed, by a fingerprint of its boundary, and one shell, proven edge by edge.

In one pass each, mostly, and in memory that does not grow with the mesh.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robodyn.programs.vectors import Array
from robodyn.solids.mesh.indexed import components
from robodyn.solids.mesh.triangles import Step, Triangles, block_space, fill, rows_for, workspace

Words = NDArray[np.uint64]

_FACTORS = tuple(map(np.uint64, (0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0xD6E8FEB86659FD93)))
_MIX = np.uint64(0xBF58476D1CE4E5B9)
_HALF = np.uint64(32)
_WORD = 1 << 64


@dataclass(frozen=True)
class Fingerprint:
    """What is left of the directed edges of a surface when opposite ones cancel.

    Attributes:
        chain: zero where every edge is passed as often one way as the other. This is exactly when the boundary of the
            surface vanishes, and when the integral over its volume does not depend on the origin.
        parity: zero where every edge belongs to an even number of triangles, whatever their winding.

    Accuracy: edges count in 64 (parity: 63) bits that are as good as random, so that a number that ought not to be zero
        is so with a probability of about 2^-63.
    """

    chain: int
    parity: int

    @property
    def closed(self) -> bool:
        """The surface has no boundary."""
        return self.chain == 0

    @property
    def mixed(self) -> bool:
        """It has none but for the winding of some of its triangles."""
        return self.chain != 0 and self.parity == 0


def fingerprint(triangles: Triangles) -> Fingerprint:
    """The fingerprint of the boundary chain: the sum of H(p, q) over all directed edges from p to q, modulo 2^64.

    H(p, q) = (h(p) - h(q)) M(h(p) + h(q)) = -H(q, p), with h a mix of the bits of a corner (-0 read as +0) and M a mix
    of 64 bits. Corners are equal where their bits are; nothing is merged or sorted. The parity is
    the exclusive or of |H|, which does not tell the two directions of an edge apart; edges from a corner to itself
    count for nothing in both.
    """
    space = block_space(triangles)
    edges = EdgeSums(space)
    for _ in fill(space, triangles):
        edges.add()
    return edges.total()


class EdgeSums:
    """The fingerprint of the blocks added so far.

    Attributes:
        sides: (3, n) |H| of each side of each triangle of the latest block: 63 bits, the same both ways along an edge,
            zero from a corner to itself.
    """

    def __init__(self, space: Array) -> None:
        """
        Args:
            space: of `block_space`, float64, where the corners of each block will be, in units of the file.
        """
        X = space[:3]
        pool = workspace(10, space.shape[-1], np.uint64)
        hashes, total, term = pool[:4], pool[4:7], pool[7:]
        self.sides = term
        self._result = np.empty(2, np.uint64)
        steps = _edge_steps(X.view(np.uint64), hashes, total, term, self._result)
        self._steps: list[Step] = [(np.add, (X, 0.0, X)), *steps]
        self._chain = 0
        self._parity = 0

    def add(self) -> None:
        """Add the block that is there now; its -0 become +0."""
        for function, arguments in self._steps:
            function(*arguments)
        chain, parity = self._result.tolist()
        self._chain += chain
        self._parity ^= parity

    def total(self) -> Fingerprint:
        return Fingerprint(self._chain % _WORD, self._parity)


def _edge_steps(bits: Words, hashes: Words, total: Words, term: Words, result: Words) -> list[Step]:
    """The sum and the exclusive or of one block, into result, of the bits (3 corners, 3 coordinates, n)."""
    corner, following, size = hashes[:3], hashes[1:], term.view(np.int64)
    steps: list[Step] = [(np.multiply, (bits[:, 0], _FACTORS[0], corner))]
    for i in (1, 2):
        steps += [*_fold(corner, term), (np.add, (corner, bits[:, i], corner))]
        steps += [(np.multiply, (corner, _FACTORS[i], corner))]
    return [
        *steps,
        *_fold(corner, term),
        (np.copyto, (hashes[3], hashes[0])),
        (np.add, (corner, following, total)),
        *_fold(total, term),
        (np.multiply, (total, _MIX, total)),
        *_fold(total, term),
        (np.subtract, (corner, following, term)),
        (np.multiply, (term, total, term)),
        (np.add.reduce, (term, None, None, result[0, ...])),
        (np.absolute, (size, size)),
        (np.bitwise_xor.reduce, (term, None, None, result[1, ...])),
    ]


def _fold(words: Words, spare: Words) -> list[Step]:
    """Carry the upper half of each word into the lower, which multiplication does not reach."""
    return [(np.right_shift, (words, _HALF, spare)), (np.bitwise_xor, (words, spare, words))]


HELD = 1 << 22
"""Sides of triangles that are kept at a time."""

_HASH = 63
_STRIP = 8
"""Triangles of a strip, at least, on the average over a file that lists neighbours one after the other."""

_PIECE = 1 << 18
_SPARE = 1 << 12


def _readings(count: int) -> int:
    """Return how often `is_one_shell` reads a mesh of so many triangles, if all goes well."""
    return 1 << (3 * count // HELD).bit_length()


def is_one_shell(triangles: Triangles) -> bool:
    """Return whether every edge belongs to exactly two triangles, and edges connect all triangles.

    Then no face is there twice, and if the boundary vanishes all have one winding. Triangles that follow each other and
    share an edge are a strip. The sides of all triangles are sorted by a hash of their edge (see `EdgeSums`), which has
    the number of the strip for its lowest bits: neighbours of the same hash link their strips. Of a large mesh the
    sides whose hashes begin with the same bits are taken together, and the mesh is read as often as that takes. Strips
    leave 40 to 50 bits of the hash; edges that have these in common, as a few of millions do, link nothing, and all 63
    bits are looked at when the mesh is read once more.

    Accuracy: True is right but for edges with the same 63 bits, which it takes for one edge.
    """
    count = triangles.count
    for strips in (count // _STRIP, count):
        found = _is_linked(triangles, (strips + count // rows_for(count) + 1).bit_length())
        if found is not None:
            return found
    return False


def _is_linked(triangles: Triangles, bits: int) -> bool | None:
    """`is_one_shell` where numbers of strips have so many bits; None if they have more."""
    low, mask = np.uint64(bits), np.uint64((1 << bits) - 1)
    shells, ambiguous = np.zeros(0, np.int64), False
    for part in range(_readings(triangles.count)):
        found = _sides(triangles, bits, part)
        if found is None:
            return None
        keys, strips = found
        if not part:
            shells = np.arange(strips)
        if keys.size % 2:
            return False
        for start in range(0, keys.size, _PIECE):
            one, other = keys[start : start + _PIECE].reshape(-1, 2).T
            if ((one ^ other) >> low).any():
                return False
            before = keys[start - 1 : start] if start else ~one[:1]
            new = (one ^ np.concatenate([before, other[:-1]])) >> low != 0
            lone = new & np.append(new[1:], True)
            ambiguous |= not new.all()
            a, b = shells[one[lone] & mask], shells[other[lone] & mask]
            shells = components(int(shells.max()) + 1, a, b)[shells]
    return not shells.any() and (not ambiguous or _two_on_each(triangles))


def _two_on_each(triangles: Triangles) -> bool:
    """Return whether every edge has two sides, by all bits of its hash."""
    for part in range(_readings(triangles.count)):
        found = _sides(triangles, 0, part)
        if found is None:
            return False
        one, other = found[0].reshape(-1, 2).T
        if (one != other).any() or (other[:-1] == one[1:]).any():
            return False
    return True


def _sides(triangles: Triangles, bits: int, part: int) -> tuple[Words, int] | None:
    """The sides of one part in order, each the hash of its edge with its strip in so many bits; and how many strips.

    The hash is without the bits that name the part, and without those that strips take. None if strips have more bits,
    or sides take more room than chance would have them take.
    """
    split = _readings(triangles.count).bit_length() - 1
    drop, high = np.uint64(_HASH - split), np.uint64((1 << 64) - (1 << bits))
    room, filled, strips = np.empty((3 * triangles.count >> split) + split * _SPARE, np.uint64), 0, 0
    for sides, strip in _sided(triangles):
        keys = (sides << np.uint64(1 + split)) & high
        if bits:
            keys |= strip
        chosen = keys[sides >> drop == part] if split else keys.ravel()
        strips = int(strip[-1]) + 1
        if (bits and strips > 1 << bits) or filled + chosen.size > room.size:
            return None
        room[filled : filled + chosen.size] = chosen
        filled += chosen.size
    room[:filled].sort()
    return room[:filled], strips


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


def _number_strips(sides: Words, first: int, out: Words) -> None:
    """Number the strips of a block, (n,), from here on."""
    shared = np.zeros(out.size - 1, np.bool_)
    for i in range(3):
        for j in range(3):
            shared |= sides[i, 1:] == sides[j, :-1]
    out[0] = first
    np.logical_not(shared, out[1:])
    np.cumsum(out, out=out)
