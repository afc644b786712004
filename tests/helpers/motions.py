"""Motions for tests of loads: smooth ones with exact derivatives, and trajectories in pieces."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from robodyn.trajectory.read import motion


class Pieces:
    """A trajectory handed out in blocks of the given lengths, as a reader of a stream does."""

    size_bytes = position_bytes = 0

    def __init__(self, trajectory, lengths):
        self.trajectory, self.lengths = trajectory, lengths

    def blocks(self):
        start = 0
        for length in self.lengths:
            part, cut = self.trajectory, slice(start, start + length)
            extra = {name: values[cut] for name, values in part.extra.items()}
            arrays = {name: getattr(part, name)[cut] for name in ("time", "q", "qd", "qdd")}
            trust = part.sampling
            known = trust and replace(trust, off=trust.off[cut], noise=trust.noise[cut])
            yield replace(part, **arrays, extra=extra, first_row=part.first_row + start, sampling=known)
            start += length
        assert start == len(self.trajectory)


def waves(model, time, seed=0, amplitude=0.8, columns=None):
    """Joint n of a fixed base moves as a sum of two sines, with its exact velocity and acceleration."""
    rng = np.random.default_rng(seed)
    size, rate, phase = (
        rng.uniform(0.3, 1, (2, model.n)),
        rng.uniform(1, 4, (2, model.n)),
        rng.uniform(0, 6, (2, model.n)),
    )
    angle = rate[:, None] * time[:, None] + phase[:, None]
    size = amplitude * size[:, None]
    q = (size * np.sin(angle)).sum(0)
    qd = (size * rate[:, None] * np.cos(angle)).sum(0)
    qdd = -(size * rate[:, None] ** 2 * np.sin(angle)).sum(0)
    return motion(model, time, q, qd, qdd, columns=columns)
