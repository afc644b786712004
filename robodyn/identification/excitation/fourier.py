"""Fourier series that begin and end at rest (Swevers and others 1997), and how far they go between samples."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, pi

import numpy as np

from robodyn.support.floats import Floats


@dataclass(frozen=True)
class Fourier:
    """q(t) = c + sum a_k sin(k w t) + b_k cos(k w t) for k = 1..harmonics, with speed and acceleration zero at t = 0.

    That is so if sum k a_k = 0 and sum k^2 b_k = 0, and it is so in the shapes that follow, by which motions are
    combined: 1, sin(k w t)/k - sin((k+1) w t)/(k+1) and cos(k w t)/k^2 - cos((k+1) w t)/(k+1)^2.

    Attributes:
        period: [s], w = 2 pi / period.
        harmonics: 2 or more.
    """

    period: float
    harmonics: int

    @property
    def size(self) -> int:
        """How many shapes there are."""
        return 2 * self.harmonics - 1

    def even(self, samples: int) -> Floats:
        """Return so many times of a period, evenly from 0 on [s]."""
        return np.asarray(np.arange(samples) * (self.period / samples))

    def shapes(self, time: Floats) -> Floats:
        """Return q, qd and qdd of every shape: (3, N, size)."""
        k = np.arange(1, self.harmonics + 1)
        w = k * (2.0 * pi / self.period)
        sine, cosine = np.sin(np.outer(time, w)), np.cos(np.outer(time, w))
        waves = np.array([[sine, w * cosine, -w * w * sine] / k, [cosine, -w * sine, -w * w * cosine] / (k * k)])
        pairs = waves[..., :-1] - waves[..., 1:]
        still = np.zeros((3, len(time), 1))
        still[0] = 1.0
        return np.concatenate((still, pairs[0], pairs[1]), axis=-1)

    def coefficients(self, x: Floats) -> tuple[Floats, Floats, Floats]:
        """Return c (n,), a (n, harmonics) and b of combinations x (n, size) of the shapes."""
        k = np.arange(1, self.harmonics + 1)
        nothing = np.zeros((len(x), 1))
        of_sines, of_cosines = x[:, 1 : self.harmonics], x[:, self.harmonics :]
        a = (np.hstack((of_sines, nothing)) - np.hstack((nothing, of_sines))) / k
        b = (np.hstack((of_cosines, nothing)) - np.hstack((nothing, of_cosines))) / (k * k)
        return x[:, 0], a, b

    def between(self, samples: int) -> float:
        """Return how many times larger than at even samples of a period |q - c|, |qd| or |qdd| can be between them.

        Ehlich and Zeller 1964: a trigonometric polynomial of degree n is at most 1 / cos(pi n / N) times as large as at
        N > 2 n even points.
        """
        return 1.0 / cos(pi * self.harmonics / samples)
