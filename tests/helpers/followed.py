"""Motions of closed chains of which some coordinates are blanked, and what follows."""

from __future__ import annotations

import numpy as np

from robodyn.dynamics.loops.position_continuation import Follow
from robodyn.dynamics.plan import plan


def follow(model, scene, followed, q, qd=None, qdd=None, time=None, blocks=None):
    """The follower, and q, qd and qdd that it completes; entries of joints that follow are blanked first.

    Args:
        q, qd, qdd: by coordinate and rate, (N,) each; what is not there is zero. blocks: samples in each.
    """
    N = len(next(iter(q.values())))
    time = np.linspace(0.0, 1.0, N) if time is None else time
    whole = []
    for given, names in ((q, model.coordinates), (qd or {}, model.rates), (qdd or {}, model.rates)):
        whole.append(np.stack([given.get(n, np.zeros(N)) * (n.split("_")[0] not in followed) for n in names], axis=1))
    follower = Follow(plan(model, scene), followed)
    parts = [
        follower.take(time[k : k + (blocks or N)], *(each[k : k + (blocks or N)] for each in whole), first_row=k + 1)
        for k in range(0, N, blocks or N)
    ]
    return follower, *(np.concatenate([part[i] for part in parts]) for i in range(3))


def named(model, q, qd, qdd):
    """Simulated arrays by coordinate and rate."""
    return (
        dict(zip(model.coordinates, q.T, strict=True)),
        dict(zip(model.rates, qd.T, strict=True)),
        dict(zip(model.rates, qdd.T, strict=True)),
    )
