"""Every executor and Pinocchio's C++ in one run, robot by robot: `cd tests && python -m benchmarks.bench_executors`.

All have the same random samples in arrays that are ready, and an array to write to; they take turns, and the shortest
runs count. robodyn is called as users call it; Pinocchio's `rneaInParallel` has one thread and states as columns, as it
wants them. Friction and rotors are off, because Pinocchio leaves them out. It moves joints that mimic others as joints
of their own, so its degrees of freedom stand beside ours.
"""

from __future__ import annotations

from functools import cache, partial
from pathlib import Path

import numpy as np
from benchmarks.executors import build_times, random_sources
from benchmarks.peer_tasks import bare_scene, following, library_tasks
from benchmarks.timing import Timing, repeated, taking_turns
from helpers.example_robots import path_of
from helpers.machine import machine
from helpers.markdown_tables import main, table
from helpers.oracles import ROBOTS as FOLDER
from helpers.oracles import worst

import robodyn
from robodyn.dynamics.plan import Plan, torque_runner
from robodyn.measure.accuracy.torques import available, laid_out

OURS = {"Two links": "two_link_planar", "SCARA": "scara"}
"""Robots of robots/; the others are of example-robot-data."""
ROBOTS = OURS | {
    "UR5": "ur5_robot",
    "Kinova": "kinova",
    "xArm7": "xarm7",
    "Panda": "panda",
    "Solo12": "solo12",
    "ANYmal": "anymal",
    "Allegro hand": "allegro_right_hand",
    "Baxter": "baxter",
    "ANYmal with arm": "anymal-kinova",
    "iCub": "icub",
    "TALOS": "talos_full_v2",
    "Romeo": "romeo",
    "Centauro": "centauro",
    "G1 with hands": "g1_29dof_with_hand_rev_1_0",
    "Tiago": "tiago",
}
HEAD = (
    *("robot", "joints (Pinocchio)", "operations", "at rest", "trace", "build", "from cache", "NumPy", "compiled"),
    *("row-major", "2 threads", "Pinocchio", "ratio", "agreement"),
)


@cache
def described(name: str) -> tuple[robodyn.Model, robodyn.Scene]:
    path: Path = FOLDER / f"{OURS[name]}.urdf" if name in OURS else path_of(ROBOTS[name])
    model = robodyn.load(path)
    return model, bare_scene(model)


def operations(name: str) -> tuple[int, int]:
    """Operations per sample of a motion, and of a robot at rest."""
    model, scene = described(name)
    still = frozenset((source, i) for source in ("qd", "qdd") for i in range(model.n))
    return Plan(model, scene).torques().size, Plan(model, scene, still).torques().size


def joints(name: str) -> str:
    """Degrees of freedom here and, where they differ, in Pinocchio."""
    moving, n = following(described(name)[0])[0].shape
    return str(n) if moving == n else f"{n} ({moving})"


def builds(name: str) -> tuple[Timing, Timing, Timing | None]:
    """Tracing, making machine code, and loading it from the cache."""
    runner = torque_runner(*described(name))
    compiled = next(way for way in available() if way.name == "compiled")
    return repeated(Plan(*described(name)).torques), *build_times(compiled, runner.program, runner.widths)


def runs(name: str, samples: int) -> tuple[dict[str, Timing], float]:
    """Time per sample of every way, and the largest difference from Pinocchio's torques, of the largest torque."""
    model, scene = described(name)
    sources = random_sources(model, scene, samples)
    task, *_ = library_tasks("Pinocchio", model, scene.gravity, sources)
    columns, rows = (laid_out(sources, order, np.float64) for order in ("F", "C"))
    out = np.empty((samples, model.n), order="F")

    def ours(arrays, executor, threads=None, out=out):
        states = (arrays[source] for source in ("q", "qd", "qdd"))
        return partial(
            robodyn.inverse_dynamics, model, *states, scene=scene, out=out, executor=executor, threads=threads
        )

    spent = taking_turns(
        {
            "numpy": ours(columns, "numpy"),
            "compiled": ours(columns, "compiled", 1),
            "row-major": ours(rows, "compiled", 1, np.empty_like(out, order="C")),
            "threads": ours(columns, "compiled", 2),
            "pinocchio": task.run,
        }
    )
    off = worst(out, task.torques() @ following(model)[0])
    return {way: time.per(samples) for way, time in spent.items()}, off


def row(name: str, samples: int) -> tuple[str, ...]:
    times, off = runs(name, samples)
    return (
        name,
        joints(name),
        *map(str, operations(name)),
        *("-" if time is None else f"{1e3 * time.least:.1f} ms" for time in builds(name)),
        *(nanoseconds(time) for time in times.values()),
        f"{times['pinocchio'].least / times['compiled'].least:.1f}",
        f"{off:.0e}",
    )


def nanoseconds(time: Timing) -> str:
    value = 1e9 * time.least
    return f"{value:.0f} ns" if value >= 100 else f"{value:.1f} ns"


def report(samples: int) -> str:
    return table(HEAD, [row(name, samples) for name in ROBOTS]) + "\n" + machine("pin", "llvmlite")


if __name__ == "__main__":
    main(report, __doc__, samples=100_000)
