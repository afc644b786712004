"""Forward dynamics and Pinocchio's C++ in one run: `cd tests && python -m benchmarks.bench_forward_dynamics`.

Both have random samples in arrays that are ready, and an array to write to; they take turns, and the shortest runs
count. robodyn is called as users call it; Pinocchio's `abaInParallel` has one thread and states as columns, as it wants
them. Friction and rotors are off, because Pinocchio leaves them out. It moves joints that mimic others as joints of
their own, so its degrees of freedom stand beside ours, and accelerations agree only where no joint mimics another.
"""

from __future__ import annotations

from functools import partial

import numpy as np
from benchmarks.pinocchio_runs import ROBOTS, described, in_parallel, joints, nanoseconds, random_sources
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


def row(name: str, samples: int) -> tuple[str, ...]:
    model, scene = described(name)
    sources = random_sources(model, scene, samples)
    state = sources["q"], sources["qd"], sources["qdd"]
    out = np.empty((samples, model.n), order="F")

    def ours(executor, threads=None):
        return partial(
            robodyn.forward_dynamics, model, *state, scene=scene, out=out, executor=executor, threads=threads
        )

    run, found = in_parallel(model, "abaInParallel", state)
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
