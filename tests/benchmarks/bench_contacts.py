"""Contact forces of a trot and a walk, and Clarabel in the same run: `cd tests && python -m benchmarks.bench_contacts`.

Ours takes all samples at a time, from arrays of equations to forces. Clarabel is called once per sample with matrices
that are ready, and its default tolerances; only building its solver and solving count. They take turns, and the
shortest runs count. What has to be balanced is random, some of it on edges of the cones, some beyond.
"""

from __future__ import annotations

from functools import partial

import clarabel
import numpy as np
from benchmarks.timing import taking_turns
from helpers.machine import machine
from helpers.markdown_tables import main, table
from helpers.stances import base_columns
from scipy import sparse

from robodyn.dynamics.contacts.solve import Problem, contact_forces

HEAD = (
    *("motion", "points", "samples", "without forces", "NumPy", "compiled"),
    *("Clarabel", "ratio", "largest difference of cost"),
)
UP = np.array((0.0, 0.0, 1.0))
ALONE = 200
"""Samples that Clarabel solves."""


def feet(samples, both, places, weight, friction):
    """Feet that stand in turn, and all of them for some steps; both: (2, K) which points stand in either half."""
    phase = np.linspace(0.0, 40.0, samples) % 1.0
    active = np.array([*both, np.ones(len(places), dtype=bool)])[np.digitize(phase, (0.4, 0.8))]
    return motion(np.tile(places, (samples, 1, 1)), active, weight, friction)


def trot(samples):
    """Four point feet, diagonal pairs in turn."""
    places = np.array([(x, y, -0.3) for x in (-0.2, 0.2) for y in (-0.15, 0.15)])
    return feet(samples, [(True, False, False, True), (False, True, True, False)], places, 120.0, 0.6)


def walk(samples):
    """Two feet of four points."""
    corners = [(x, y, -0.9) for side in (-0.1, 0.1) for x in (-0.1, 0.12) for y in (side - 0.05, side + 0.05)]
    return feet(samples, [[True] * 4 + [False] * 4, [False] * 4 + [True] * 4], np.array(corners), 900.0, 0.7)


def motion(arms, active, weight, friction):
    """Equations that forces inside or on the cones solve, but for one sample in fifty, which is pushed beyond."""
    random = np.random.default_rng(0)
    N, K, _ = arms.shape
    arms = arms + 0.03 * random.normal(size=arms.shape) * (1.0, 1.0, 0.1)
    press = random.uniform(0.2, 1.0, (N, K)) * active
    share, angle = np.minimum(random.uniform(0.0, 1.2, (N, K)), 1.0), random.uniform(0.0, 2.0 * np.pi, (N, K))
    along = friction * share * press
    f = np.stack((along * np.cos(angle), along * np.sin(angle), press), -1)
    f *= weight / press.sum(axis=1)[:, None, None]
    G = base_columns(arms, 0.3)
    b = np.einsum("nij,nj->ni", G, f.reshape(N, 3 * K))
    beyond = random.random(N) < 0.02
    b[beyond, 3] += weight
    return Problem(G, b, np.tile(UP, (K, 1)), np.full(K, friction), active)


def settings():
    """Clarabel's, as they are."""
    found = clarabel.DefaultSettings()
    found.verbose = False
    return found


def prepared(problem, n):
    """What Clarabel wants to know of a sample, in units of |b|."""
    used = np.flatnonzero(np.repeat(problem.active[n], 3))
    K, b = len(used) // 3, problem.b[n] / np.linalg.norm(problem.b[n])
    cone = np.kron(np.eye(K), -np.array(((0.0, 0.0, problem.friction[0]), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))))
    A = sparse.csc_matrix(np.vstack((problem.G[n][:, used], cone)))
    cones = [clarabel.ZeroConeT(6), *([clarabel.SecondOrderConeT(3)] * K)]
    return sparse.identity(3 * K, format="csc"), np.zeros(3 * K), A, np.append(b, np.zeros(3 * K)), cones


def by_clarabel(ready):
    options = settings()
    return [clarabel.DefaultSolver(*each, options).solve() for each in ready]


def row(name, make, samples):
    problem = make(samples)
    looked = np.linspace(0, samples - 1, ALONE).astype(int)
    ready = [prepared(problem, n) for n in looked]
    acts = {
        "numpy": partial(contact_forces, problem, "numpy"),
        "compiled": partial(contact_forces, problem, "compiled"),
        "clarabel": partial(by_clarabel, ready),
    }
    times = {way: time / (ALONE if way == "clarabel" else samples) for way, time in taking_turns(acts).items()}
    found = contact_forces(problem, "compiled")
    held = found.feasible[looked]
    ours = 0.5 * (found.f[looked] ** 2).sum(axis=(1, 2)) / (problem.b[looked] ** 2).sum(axis=1)
    theirs = np.array([each.obj_val for each in by_clarabel(ready)])
    return (
        name,
        str(problem.shape[2]),
        str(samples),
        str(int((~found.feasible).sum())),
        *(f"{1.0 / time:,.0f}/s".replace(",", " ") for time in times.values()),
        f"{times['clarabel'] / times['compiled']:.0f}",
        f"{np.abs(ours - theirs)[held].max():.0e}",
    )


def report(samples: int) -> str:
    rows = [row("trot on four feet", trot, samples), row("walk on two soles", walk, samples)]
    return table(HEAD, rows) + "\n" + machine("clarabel", "llvmlite")


if __name__ == "__main__":
    main(report, __doc__, samples=10_000)
