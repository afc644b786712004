"""Whether a surface is closed, by a fingerprint of its boundary, and one shell, proven edge by edge."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robodyn.programs.vectors import Array
from robodyn.solids.mesh.indexed import Words, components
from robodyn.solids.mesh.triangles import Step, Triangles, block_space, fill, workspace

_FACTORS = tuple(map(np.uint64, (0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0xD6E8FEB86659FD93)))
_MIX = np.uint64(0xBF58476D1CE4E5B9)
_HALF = np.uint64(32)
_WORD = 1 << 64


@dataclass(frozen=True)
class Fingerprint:
    """What is left of the directed edges of a surface when opposite ones cancel; zero by chance once in 2^63.

    chain: zero where every edge is passed as often one way as the other: the boundary of the surface vanishes; parity:
    zero where every edge belongs to an even number of triangles, whatever their winding.
    """

    chain: int
    parity: int

    @property
    def closed(self) -> bool:
        return self.chain == 0

    @property
    def mixed(self) -> bool:
        """It has none but for the winding of some of its triangles."""
        return self.chain != 0 and self.parity == 0


def fingerprint(triangles: Triangles) -> Fingerprint:
    """The fingerprint of the boundary chain: the sum of H(p, q) over all directed edges from p to q, modulo 2^64.

    H(p, q) = (h(p) - h(q)) M(h(p) + h(q)) = -H(q, p), with h a mix of the bits of a corner (-0 read as +0) and M a mix
    of 64 bits. Corners are equal where their bits are; nothing is merged or sorted. The parity is the exclusive or of
    |H|, which does not tell the two directions of an edge apart.
    """
    space = block_space(triangles)
    edges = EdgeSums(space)
    for _ in fill(space, triangles):
        edges.add()
    return edges.total()


class EdgeSums:
    """The fingerprint of the blocks added so far.

    sides: (3, n) |H| of each side of each triangle of the latest block: 63 bits, the same both ways along an edge, zero
    from a corner to itself.
    """

    def __init__(self, space: Array) -> None:
        """`space`: of `block_space`, float64, where the corners of each block will be, in units of the file."""
        X = space[:3]
        pool = workspace(10, space.shape[-1], np.uint64)
        hashes, total, term = pool[:4], pool[4:7], pool[7:]
        self.sides = term
        self._result, self._chain, self._parity = np.empty(2, np.uint64), 0, 0
        bits, size, corner, following = X.view(np.uint64), term.view(np.int64), hashes[:3], hashes[1:]
        self._steps: list[Step] = [(np.add, (X, 0.0, X)), (np.multiply, (bits[:, 0], _FACTORS[0], corner))]
        for i in (1, 2):
            self._steps += [*_fold(corner, term), (np.add, (corner, bits[:, i], corner))]
            self._steps += [(np.multiply, (corner, _FACTORS[i], corner))]
        self._steps += [
            *_fold(corner, term),
            (np.copyto, (hashes[3], hashes[0])),
            (np.add, (corner, following, total)),
            *_fold(total, term),
            (np.multiply, (total, _MIX, total)),
            *_fold(total, term),
            (np.subtract, (corner, following, term)),
            (np.multiply, (term, total, term)),
            (np.add.reduce, (term, None, None, self._result[0, ...])),
            (np.absolute, (size, size)),
            (np.bitwise_xor.reduce, (term, None, None, self._result[1, ...])),
        ]

    def add(self) -> None:
        """Add the block that is there now; its -0 become +0."""
        for function, arguments in self._steps:
            function(*arguments)
        chain, parity = self._result.tolist()
        self._chain += chain
        self._parity ^= parity

    def total(self) -> Fingerprint:
        return Fingerprint(self._chain % _WORD, self._parity)


def _fold(words: Words, spare: Words) -> list[Step]:
    """Carry the upper half of each word into the lower, which multiplication does not reach."""
    return [(np.right_shift, (words, _HALF, spare)), (np.bitwise_xor, (words, spare, words))]


def is_one_shell(triangles: Triangles) -> bool:
    """Return whether every edge belongs to exactly two triangles, and edges connect all triangles.

    Then no face is there twice, and if the boundary vanishes all have one winding. Triangles that follow each other and
    share an edge are a strip. The sides of all triangles are sorted by the hash of their edge (see `EdgeSums`), which
    has the number of the strip for its lowest bits: neighbours of the same hash link their strips. Strips leave 40 to
    50 bits of the hash; edges that have these in common, as a few of millions do, link nothing, and all 63 bits are
    looked at.

    Accuracy: True is right but for edges with the same 63 bits, which it takes for one edge.
    """
    sides, strip = _sides(triangles)
    strips = int(strip[-1]) + 1
    low, mask = np.uint64(strips.bit_length()), np.uint64((1 << strips.bit_length()) - 1)
    keys = sides << np.uint64(1)
    keys &= ~mask
    keys |= strip
    keys = keys.ravel()
    keys.sort()
    if keys.size % 2:
        return False
    one, other = keys.reshape(-1, 2).T
    if ((one ^ other) >> low).any():
        return False
    new = np.concatenate([[True], (one[1:] ^ other[:-1]) >> low != 0, [True]])
    lone = new[:-1] & new[1:]
    if components(strips, *((end[lone] & mask).view(np.int64) for end in (one, other))).any():
        return False
    return bool(lone.all()) or _two_on_each(sides)


def _two_on_each(sides: Words) -> bool:
    """Return whether every edge has two sides, by all bits of its hash."""
    one, other = np.sort(sides, axis=None).reshape(-1, 2).T
    return bool((one == other).all() and (other[:-1] != one[1:]).all())


def _sides(triangles: Triangles) -> tuple[Words, Words]:
    """The hash of each side, (3, m), and the number of the strip of each triangle, (m,)."""
    space = block_space(triangles)
    edges, rows = EdgeSums(space), space.shape[-1]
    sides, starts = np.empty((3, triangles.count), np.uint64), np.ones(triangles.count, np.bool_)
    for first, _ in zip(range(0, triangles.count, rows), fill(space, triangles, checked=False), strict=True):
        edges.add()
        block = edges.sides[:, : triangles.count - first]
        sides[:, first : first + rows] = block
        shared = (block[:, None, 1:] == block[:, :-1]).any(axis=(0, 1))
        starts[first + 1 : first + rows] = ~shared
    starts[0] = False
    return sides, np.cumsum(starts, dtype=np.uint64)
