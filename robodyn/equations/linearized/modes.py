"""Modes of a linear system: how it moves by itself, whether it comes back; their search, and bounds of their errors."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import hypot, inf, pi
from typing import NamedTuple

import numpy as np

from robodyn.errors import InputError
from robodyn.programs.vectors import length, product
from robodyn.support.floats import Floats
from robodyn.support.linear import Complexes, general_eigen, null_space, range_basis

_WRITTEN = 5e-10
"""Half a unit of the tenth digit, with which descriptions write right angles (1.570796327): an axis is so far off, and
a weight turns by this part into stiffness that is none."""
_ROUNDED = 16.0 * float(np.finfo(float).eps)
_ROUNDINGS = 16.0
_DEPENDENT = 1e-8
"""Squared part of a row that is left, below which the columns are one space less."""


class SmallMotion(NamedTuple):
    """M dx'' + damping dx' + stiffness dx = directions^T u, drives closed; z' = A z + ... with z = (dx, dx').

    Attributes:
        directions: (n, k) how all joints move with x; without loops the unit matrix.
        M, damping, stiffness: (k, k).
        doubt: (k, k) by how much the stiffness may be another where an equilibrium is off.
        A: (2 k, 2 k).
        inertia: (n,) of each joint, the others at rest [kg m^2 or kg].
        weight: (k,) the stiffness that the weight can make at each coordinate at most [N m or N/m].
        condition: number of M, scaled to a unit diagonal.
        at_rest: whether the state is one.
    """

    directions: Floats
    M: Floats
    damping: Floats
    stiffness: Floats
    doubt: Floats
    A: Floats
    inertia: Floats
    weight: Floats
    condition: float
    at_rest: bool


@dataclass(frozen=True)
class Mode:
    """x(t) = Re(shape exp((real + i imag) t)).

    Attributes:
        real, imag: of the eigenvalue [1/s, rad/s]; imag >= 0, its conjugate is the same motion.
        error: how far the eigenvalue may be off by rounding [1/s].
        shape: (n,) complex, how the rates' coordinates move, the one with most kinetic energy 1.
        shares: (n,) of the kinetic energy that each coordinate alone would have, the largest 1.
        alike: whether another mode has the same eigenvalue, so that any mixture of their shapes is one.
    """

    real: float
    imag: float
    error: float
    shape: tuple[complex, ...]
    shares: tuple[float, ...]
    alike: bool = False

    @property
    def free(self) -> bool:
        """Whether nothing holds it: moved or set going it stays so."""
        return self.real == 0.0 and self.imag == 0.0

    @property
    def oscillates(self) -> bool:
        return self.imag > self.error

    @property
    def frequency(self) -> float:
        """Of the undamped motion, |eigenvalue| / (2 pi) [Hz]; 0 where it does not oscillate."""
        return hypot(self.real, self.imag) / (2.0 * pi) if self.oscillates else 0.0

    @property
    def damping_ratio(self) -> float:
        """-real / |eigenvalue|: 0 undamped, 1 without oscillation, negative where it grows."""
        return 0.0 if self.undecided else -self.real / hypot(self.real, self.imag)

    @property
    def time_constant(self) -> float:
        """In which it shrinks, or grows, to 1/e or e times its size [s]; infinite where it does neither."""
        return inf if self.undecided else 1.0 / abs(self.real)

    @property
    def undecided(self) -> bool:
        """Whether it neither grows nor decays within rounding."""
        return abs(self.real) <= self.error


@dataclass(frozen=True)
class Modes:
    """All modes, the slowest first, one of each pair; at_rest: whether the state is one: of one that moves, eigenvalues
    say nothing about stability."""

    modes: tuple[Mode, ...]
    at_rest: bool = True

    @property
    def verdict(self) -> str:
        """Return "stable" if all modes decay, "unstable" if one grows, "marginal" if none grows and some do neither or
        rounding hides what they do, and "moving" where nothing is said."""
        if not self.at_rest:
            return "moving"
        if any(mode.real > mode.error for mode in self.modes):
            return "unstable"
        return "marginal" if any(mode.undecided for mode in self.modes) else "stable"

    @property
    def stable(self) -> bool | None:
        """Return whether every small disturbance dies away; None where that is not decided."""
        return {"stable": True, "unstable": False}.get(self.verdict)

    @property
    def margin(self) -> float | None:
        """-real of the mode that decays slowest, negative if one grows [1/s]; None where nothing is held."""
        return min((0.0 - mode.real for mode in self.modes if not mode.free), default=None)


class Split(NamedTuple):
    """Coordinates x = scale * y (k,); `drift` (r, k): motions without stiffness; `basis` (r + s, 2 k): these, and the
    speeds of the s of them that nothing slows either; `rest`: what stands across them. A maps the basis onto itself."""

    scale: Floats
    drift: Floats
    basis: Floats
    rest: Floats


def split(found: SmallMotion) -> Split:
    """Return what nothing holds: no stiffness above 5e-10 of what the robot's weight can make at each joint.
    Coordinates are scaled so that this, or a joint's own stiffness where that is larger, is 1. Of a state that moves
    nothing is split off."""
    k = len(found.M)
    inertia = np.abs(np.diag(found.M))
    stiff = np.maximum(found.weight, np.abs(np.diag(found.stiffness)))
    scale = 1.0 / np.sqrt(np.where(stiff > 0.0, stiff, np.where(inertia > 0.0, inertia, 1.0)))
    none = np.zeros((0, 2 * k))
    if not found.at_rest:
        return Split(scale, none[:, :k], none, np.eye(2 * k))
    drift = _null(found.stiffness * np.outer(scale, scale), k * _WRITTEN)
    damping, free = found.damping * np.outer(scale, scale), drift
    slowed, nothing = product(damping, drift.T), _ROUNDED * length(damping.ravel())
    if len(drift) and length(slowed.ravel()) > nothing:  # that part of the drift which nothing slows
        free = _null(slowed, nothing)
        free = range_basis(product(free, drift), 0.0) if len(free) else drift[:0]
    basis = np.vstack((np.hstack((drift, np.zeros_like(drift))), np.hstack((np.zeros_like(free), free))))
    return Split(scale, drift, basis, null_space(basis, 0.0) if len(basis) else np.eye(2 * k))


def _null(rows: Floats, nothing: float) -> Floats:
    """Return an orthonormal basis (r, n) of what rows (m, n) of a size of 1 map to less than this."""
    largest = float(np.sqrt((rows * rows).sum(axis=1)).max(initial=0.0))
    return null_space(rows, nothing / largest) if largest > nothing else np.eye(rows.shape[1])


def modes_of(found: SmallMotion) -> Modes:
    """Return the modes of A, drives closed; InputError where eigenvalues overflow.

    What nothing holds (no stiffness) is split off first: its eigenvalues are zero to the last bit and not, as QR
    iterations find a double zero, some 1e-8. The others are those of what is left.

    Accuracy: `error` of each: 16 roundings of the scaled A times the condition numbers of the scaled mass matrix and of
        the eigenvalue, or the square root of that where two eigenvalues meet (Golub, Van Loan, *Matrix Computations*,
        7.2), what 16 roundings of the stiffnesses that add up do, and how far the equilibrium may be off, and what was
        cut off with the split.
    """
    with np.errstate(all="ignore"):
        try:
            parts = split(found)
            drift = _sparse((parts.drift * parts.scale).T.astype(complex)).T
            out = [_mode(found, 0j, 0.0, row) for row in drift]
            if len(parts.rest):
                out += _held(found, parts)
        except np.linalg.LinAlgError:
            raise InputError("the eigenvalues overflow at this state", remedy="smaller numbers") from None

    def near(a: Mode, b: Mode) -> bool:
        return abs(complex(a.real, a.imag) - complex(b.real, b.imag)) <= a.error + b.error

    marked = [replace(a, alike=any(a is not b and near(a, b) for b in out)) for a in out]
    return Modes(tuple(_ordered(marked)), found.at_rest)


def _held(found: SmallMotion, parts: Split) -> list[Mode]:
    both = np.concatenate((parts.scale, parts.scale))
    A = found.A * both / both[:, None]
    inner, cut = product(parts.rest, A, parts.rest.T), product(parts.rest, A, parts.basis.T)
    pairs = general_eigen(inner)
    few, cuts = _ROUNDINGS * float(np.finfo(float).eps), length(cut.ravel())
    lost = few * found.condition * pairs.size + cuts
    right = product(parts.rest.T, pairs.right)  # eigenvectors of A, with their parts along what was split off
    if len(parts.basis):
        own, given = product(parts.basis, A, parts.basis.T), product(product(parts.basis, A, parts.rest.T), pairs.right)
        for k, value in enumerate(np.where(pairs.values == 0.0, lost, pairs.values).tolist()):
            right[:, k] += product(parts.basis.T, np.linalg.solve(value * np.eye(len(own)) - own, given[:, k]))
    scales, size = np.outer(parts.scale, parts.scale), len(found.M)
    # |M^-T y| |x| of left and right eigenvectors: how far 1 more of the scaled stiffness moves eigenvalues
    left = product(parts.rest.T, pairs.left)[size:]
    softness = _lengths(np.linalg.solve((found.M * scales).T, left)) * _lengths(right[:size])
    soft = (few + length((found.doubt * scales).ravel())) * softness
    meet = np.abs((pairs.left.conj() * pairs.right).sum(axis=0))
    errors = np.maximum(lost * pairs.conditions, (soft + 2.0 * cuts * _lengths(product(parts.basis, right))) / meet)
    errors = np.minimum(errors, np.sqrt(lost * (pairs.size + lost) + soft + cuts))
    shapes, out = right[:size] * parts.scale[:, None], list[Mode]()
    kept = _paired(pairs.values, errors)
    while kept:
        _, first, close = kept[0]
        alike = [kept[0], *(each for each in kept[1:] if abs(each[1] - first) <= each[2] + close)]
        columns = _sparse(shapes[:, [k for k, _, _ in alike]])
        out += [_mode(found, value, error, column) for (_, value, error), column in zip(alike, columns.T, strict=True)]
        kept = [each for each in kept if each not in alike]
    return out


def _sparse(columns: Complexes) -> Complexes:
    """Return the basis of the same space (n, k) in which k of its entries are one in a column and zero in the others.
    The entries are those with the largest parts of the space, the first of equals: no rounding chooses the basis. One
    whose columns are dependent within rounding, of a defective eigenvalue, stays as it is."""
    if columns.shape[1] < 2:
        return columns
    left = np.linalg.qr(columns / _lengths(columns))[0]
    rows: list[int] = []
    for _ in range(columns.shape[1]):
        sizes = (left.real**2 + left.imag**2).sum(axis=1)
        if sizes.max() < _DEPENDENT:
            return columns
        rows.append(int(np.argmax(sizes >= sizes.max() * (1.0 - 1e-6))))
        pivot = left[rows[-1]] / np.sqrt(sizes[rows[-1]])
        left = left - np.outer((left * pivot.conj()).sum(axis=1), pivot)
    return np.asarray(np.linalg.solve(columns[rows].T, columns.T).T)


def _lengths(columns: Complexes) -> Floats:
    return np.asarray(np.sqrt((columns.real**2 + columns.imag**2).sum(axis=0)))


def _paired(values: Complexes, errors: Floats) -> list[tuple[int, complex, float]]:
    """Return which eigenvalues stand for a mode each: one of every conjugate pair, and those that are real."""
    out, left = [], sorted(range(len(values)), key=lambda k: -float(values[k].imag))
    while left:
        k = left.pop(0)
        value, error = complex(values[k]), float(errors[k])
        if value.imag > error:
            left.remove(min(left, key=lambda j: abs(complex(values[j]) - value.conjugate())))
            out.append((k, value, error))
        else:
            out.append((k, complex(value.real), error))
    return out


def _mode(found: SmallMotion, value: complex, error: float, along: Complexes) -> Mode:
    shape = product(found.directions, along)
    energy = np.abs(shape) * np.sqrt(np.maximum(found.inertia, 0.0))
    most = int(np.argmax(energy > energy.max() * (1.0 - 1e-6)))
    turned = shape / shape[most] if shape[most] else shape
    shares = (energy / energy.max()) ** 2 if energy.max() else energy
    return Mode(value.real, value.imag, error, tuple(map(complex, turned)), tuple(shares.tolist()))


def _ordered(modes: Sequence[Mode]) -> Iterator[Mode]:
    """Yield the slowest first; of those that are as fast within rounding, such as a pair of -a and a, what decays."""

    def size(mode: Mode) -> float:
        return hypot(mode.real, mode.imag)

    left = sorted(modes, key=size)
    while left:
        first = left[0]
        alike = [first, *(mode for mode in left[1:] if size(mode) - size(first) <= 2.0 * min(first.error, mode.error))]
        close = 2.0 * max(mode.error for mode in alike)
        yield from sorted(
            alike, key=lambda mode: (mode.real > close, mode.real >= -close, int(np.argmax(np.equal(mode.shape, 1.0))))
        )
        left = [mode for mode in left if mode not in alike]
