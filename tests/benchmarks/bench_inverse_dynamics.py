"""Inverse dynamics against Pinocchio's C++ in one run: `cd tests && python -m benchmarks.bench_inverse_dynamics`.

Both have one thread, the same number of random samples in arrays that are ready, and an array to write to. They take
turns, and the medians count. Friction is off, because Pinocchio ignores it. Pinocchio moves joints that mimic others as
joints of their own, so its degrees of freedom stand beside ours.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import cache
from pathlib import Path
from statistics import median

import numpy as np
import pinocchio as pin
from example_robots import path_of
from machine import machine
from markdown_tables import main, table
from oracles import frictionless, random_state, worst
from pinocchio_robots import PinocchioRobot

import robodyn
from robodyn.plan import Plan

ROBOTS = {"UR5": "ur5_robot", "Panda": "panda", "ANYmal": "anymal", "TALOS": "talos_full_v2"}
HEAD = ("robot", "joints (Pinocchio)", "operations", "at rest", "trace", "robodyn", "Pinocchio", "ratio", "agreement")


@cache
def described(name: str) -> tuple[Path, robodyn.Model, robodyn.Scene]:
    path = path_of(ROBOTS[name])
    model = robodyn.load(path)
    return path, model, frictionless(model)


def operations(name: str) -> tuple[int, int]:
    """Operations per sample of a motion, and of a robot at rest."""
    _, model, scene = described(name)
    still = frozenset((source, i) for source in ("qd", "qdd") for i in range(model.n))
    return Plan(model, scene).torques().size, Plan(model, scene, still).torques().size


def joints(name: str) -> str:
    """Degrees of freedom here and, where they differ, in Pinocchio."""
    path, model, _ = described(name)
    theirs = pin.buildModelFromUrdf(str(path)).nv
    return str(model.n) if theirs == model.n else f"{model.n} ({theirs})"


def seconds(act: Callable[[], object]) -> float:
    start = time.perf_counter()
    act()
    return time.perf_counter() - start


def taking_turns(first: Callable[[], object], second: Callable[[], object], turns: int) -> tuple[float, float]:
    """Median seconds of each; one turn of warming up is not counted."""
    first(), second()
    spent = [(seconds(first), seconds(second)) for _ in range(turns)]
    return median(a for a, _ in spent), median(b for _, b in spent)


def nanoseconds(name: str, samples: int, turns: int) -> tuple[float, float]:
    """Time per sample of robodyn and of Pinocchio."""
    path, model, scene = described(name)
    rng = np.random.default_rng(0)
    q, qd, qdd = random_state(model, rng, samples)
    tau = np.empty((samples, model.n))
    theirs = pin.buildModelFromUrdf(str(path))
    angles, V, A = (np.asfortranarray(rng.uniform(-2, 2, (theirs.nv, samples))) for _ in range(3))
    Q = np.asfortranarray(np.stack([pin.integrate(theirs, pin.neutral(theirs), x) for x in angles.T], axis=1))
    out, pool = np.zeros_like(A), pin.ModelPool(theirs, 1)
    spent = taking_turns(
        lambda: robodyn.inverse_dynamics(model, q, qd, qdd, scene=scene, out=tau),
        lambda: pin.rneaInParallel(1, pool, Q, V, A, out),
        turns,
    )
    ours, others = (1e9 * each / samples for each in spent)
    return ours, others


def agreement(name: str) -> float:
    """The largest difference of torques at 20 random states, of the largest torque."""
    path, model, scene = described(name)
    q, qd, qdd = random_state(model, np.random.default_rng(1), 20)
    expected = PinocchioRobot(path).torques(model, q, qd, qdd)
    return worst(robodyn.inverse_dynamics(model, q, qd, qdd, scene=scene), expected)


def row(name: str, samples: int, turns: int) -> tuple[str, ...]:
    _, model, scene = described(name)
    moving, resting = operations(name)
    trace = median(seconds(lambda: Plan(model, scene).torques()) for _ in range(3))
    ours, others = nanoseconds(name, samples, turns)
    return (
        name,
        joints(name),
        str(moving),
        str(resting),
        f"{1e3 * trace:.1f} ms",
        f"{ours:.0f} ns",
        f"{others:.0f} ns",
        f"{others / ours:.2f}",
        f"{agreement(name):.0e}",
    )


def report(samples: int, turns: int) -> str:
    return table(HEAD, [row(name, samples, turns) for name in ROBOTS]) + "\n" + machine("pin")


if __name__ == "__main__":
    main(report, __doc__, samples=100_000, turns=7)
