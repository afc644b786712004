"""The search for modes: eigenvalues of A, and bounds of their errors."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import hypot

import numpy as np

from robodyn.equations.linearized.modes import Mode, Modes
from robodyn.equations.linearized.small_motion import SmallMotion
from robodyn.equations.linearized.unheld import Split, split
from robodyn.errors import InputError
from robodyn.programs.linear import Complexes, general_eigen
from robodyn.programs.vectors import length, product
from robodyn.support.floats import Floats

_ROUNDINGS = 16.0
_DEPENDENT = 1e-8
"""Squared part of a row that is left, below which the columns are one space less."""


def modes_of(found: SmallMotion) -> Modes:
    """Return the modes of A, drives closed.

    What nothing holds (no stiffness) is split off first: its eigenvalues are zero to the last bit and not, as QR
    iterations find a double zero, some 1e-8. The others are those of what is left.

    Raises:
        InputError: the eigenvalues overflow.

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
    return Modes(tuple(_ordered(_marked(out))), found.at_rest)


def _held(found: SmallMotion, parts: Split) -> list[Mode]:
    both = np.concatenate((parts.scale, parts.scale))
    A = found.A * both / both[:, None]
    inner, cut = product(parts.rest, A, parts.rest.T), product(parts.rest, A, parts.basis.T)
    pairs = general_eigen(inner)
    few, cuts = _ROUNDINGS * float(np.finfo(float).eps), length(cut.ravel())
    lost = few * found.condition * pairs.size + cuts
    right = _completed(A, parts, np.where(pairs.values == 0.0, lost, pairs.values), pairs.right)
    whole = right * both[:, None]
    doubt = length((found.doubt * np.outer(parts.scale, parts.scale)).ravel())
    soft = (few + doubt) * _softness(found, parts, pairs.left, right)
    meet = np.abs((pairs.left.conj() * pairs.right).sum(axis=0))
    errors = np.maximum(lost * pairs.conditions, (soft + 2.0 * cuts * _lengths(product(parts.basis, right))) / meet)
    errors = np.minimum(errors, np.sqrt(lost * (pairs.size + lost) + soft + cuts))
    shapes, kept = whole[: len(found.M)], _paired(pairs.values, errors)
    out = []
    while kept:
        _, first, close = kept[0]
        alike = [each for each in kept if abs(each[1] - first) <= each[2] + close]
        columns = _sparse(shapes[:, [k for k, _, _ in alike]])
        out += [_mode(found, value, error, column) for (_, value, error), column in zip(alike, columns.T, strict=True)]
        kept = [each for each in kept if each not in alike]
    return out


def _sparse(columns: Complexes) -> Complexes:
    """Return the basis of the same space (n, k) in which k of its entries are one in a column and zero in the others.

    The entries are those with the largest parts of the space, the first of equals: no rounding chooses the basis. One
    whose columns are dependent within rounding, of a defective eigenvalue, stays as it is.
    """
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


def _softness(found: SmallMotion, parts: Split, inner: Complexes, right: Complexes) -> Floats:
    """Return |M^-T y| |x| of the speeds of left eigenvectors and the coordinates of right ones: how far a change of the
    scaled stiffness by 1 moves their eigenvalues. What is soft because the weight takes nearly all stiffness of a drive
    away is known no better than that."""
    k = len(found.M)
    left = product(parts.rest.T, inner)[k:]
    n = left.shape[1]
    pushed = np.linalg.solve((found.M * np.outer(parts.scale, parts.scale)).T, np.hstack((left.real, left.imag)))
    return _lengths(pushed[:, :n] + 1j * pushed[:, n:]) * _lengths(right[:k])


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


def _completed(A: Floats, parts: Split, values: Complexes, inner: Complexes) -> Complexes:
    """Return eigenvectors of A from those of what is left of it: with their parts along what was split off."""
    out = product(parts.rest.T, inner)
    if len(parts.basis):
        own = product(parts.basis, A, parts.basis.T)
        given = product(product(parts.basis, A, parts.rest.T), inner)
        one = np.eye(len(own))
        for k, value in enumerate(values.tolist()):
            a, b = value.real * one - own, value.imag * one
            along = np.linalg.solve(np.block([[a, -b], [b, a]]), np.concatenate((given[:, k].real, given[:, k].imag)))
            out[:, k] += product(parts.basis.T, along[: len(own)] + 1j * along[len(own) :])
    return np.asarray(out)


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
        alike = [mode for mode in left if size(mode) - size(first) <= 2.0 * min(first.error, mode.error)]
        close = 2.0 * max(mode.error for mode in alike)
        yield from sorted(alike, key=lambda mode: (mode.real > close, mode.real >= -close, _leader(mode)))
        left = [mode for mode in left if mode not in alike]


def _leader(mode: Mode) -> int:
    """Return the coordinate whose share is one."""
    return next((k for k, each in enumerate(mode.shape) if each == 1.0), 0)


def _marked(modes: Sequence[Mode]) -> list[Mode]:
    """Return the modes, those marked that share an eigenvalue within rounding."""

    def near(a: Mode, b: Mode) -> bool:
        return abs(complex(a.real, a.imag) - complex(b.real, b.imag)) <= a.error + b.error

    return [replace(a, alike=any(a is not b and near(a, b) for b in modes)) for a in modes]
