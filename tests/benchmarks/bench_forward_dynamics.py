"""Forward dynamics and Pinocchio's C++ in one run: `cd tests && python -m benchmarks.bench_forward_dynamics`.

Both have random samples in arrays that are ready, and an array to write to; they take turns, and the shortest runs
count. robodyn is called as users call it; Pinocchio's `abaInParallel` has one thread and states as columns, as it wants
them. Friction and rotors are off, because Pinocchio leaves them out. It moves joints that mimic others as joints of
their own, so its degrees of freedom stand beside ours, and accelerations agree only where no joint mimics another.
"""

from __future__ import annotations

from functools import partial

import numpy as np
import pinocchio as pin
from benchmarks.bench_executors import ROBOTS, described, joints, nanoseconds
from benchmarks.executors import random_sources
from benchmarks.peer_tasks import bare_description, following
from benchmarks.timing import taking_turns
from helpers.machine import machine
from helpers.markdown_tables import main, table
from helpers.oracles import worst

import robodyn
from robodyn.dynamics.forward import acceleration_program
from robodyn.dynamics.plan import Plan

HEAD = (
    *("robot", "joints (Pinocchio)", "operations", "at rest", "NumPy", "compiled", "2 threads"),
    *("Pinocchio", "ratio", "agreement"),
)


def operations(name: str) -> tuple[int, int]:
    """Operations per sample of a moving robot, and of one that stands still."""
    model, scene = described(name)
    still = frozenset(("qd", i) for i in range(model.n))
    return acceleration_program(Plan(model, scene)).size, acceleration_program(Plan(model, scene, still)).size


def peer(model, q, qd, tau):
    """`abaInParallel` of the same samples, and a function for its accelerations in the order of ours."""
    other = pin.buildModelFromXML(bare_description(model))
    S, offset = following(model)
    moving = [body.joint.name for body in model.bodies if body.joint.kind != "fixed"]
    places = [other.joints[other.getJointId(name)] for name in moving]
    Q = np.asfortranarray(np.tile(pin.neutral(other)[:, None], len(q)))
    V, T, out = (np.zeros((other.nv, len(q)), order="F") for _ in range(3))
    for joint, angle in zip(places, (q @ S.T + offset).T, strict=True):
        Q[joint.idx_q : joint.idx_q + joint.nq] = angle if joint.nq == 1 else (np.cos(angle), np.sin(angle))
    rows = [joint.idx_v for joint in places]
    V[rows], T[rows] = (qd @ S.T).T, (tau @ np.linalg.pinv(S)).T
    run = partial(pin.abaInParallel, 1, pin.ModelPool(other, 1), Q, V, T, out)
    return run, lambda: out[rows].T @ np.linalg.pinv(S).T


def row(name: str, samples: int) -> tuple[str, ...]:
    model, scene = described(name)
    sources = random_sources(model, scene, samples)
    state = sources["q"], sources["qd"], sources["qdd"]
    out = np.empty((samples, model.n), order="F")

    def ours(executor, threads=None):
        return partial(
            robodyn.forward_dynamics, model, *state, scene=scene, out=out, executor=executor, threads=threads
        )

    run, found = peer(model, *state)
    acts = {"numpy": ours("numpy"), "compiled": ours("compiled", 1), "threads": ours("compiled", 2), "pinocchio": run}
    times = {way: time.per(samples) for way, time in taking_turns(acts).items()}
    shared = any(body.joint.mimics for body in model.bodies)
    return (
        name,
        joints(name),
        *map(str, operations(name)),
        *(nanoseconds(time) for time in times.values()),
        f"{times['pinocchio'].least / times['compiled'].least:.1f}",
        "-" if shared else f"{worst(out, found()):.0e}",
    )


def report(samples: int) -> str:
    return table(HEAD, [row(name, samples) for name in ROBOTS if name != "Romeo"]) + "\n" + machine("pin", "llvmlite")


if __name__ == "__main__":
    main(report, __doc__, samples=100_000)
