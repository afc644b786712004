"""Steps of RK4 and Pinocchio's in one run: `cd tests && python -m benchmarks.bench_simulation`.

Time per step and rollout. Ours is one call for all steps, each of them recorded. Pinocchio has no RK4 of its own: for
one rollout its `aba` is called four times a step, once the way of Python and once as `abaInParallel` does it, in C++ on
as many states as four times the steps; for many rollouts each of the four stages is one `abaInParallel`. One thread.
Friction and rotors are off, because Pinocchio leaves them out. Motions agree where no joint mimics another.
"""

from __future__ import annotations

from functools import partial

import numpy as np
import pinocchio as pin
from benchmarks.bench_executors import described, joints, nanoseconds
from benchmarks.executors import random_sources
from benchmarks.peer_tasks import bare_description
from benchmarks.timing import taking_turns
from helpers.machine import machine
from helpers.markdown_tables import main, table

import robodyn
from robodyn.dynamics.plan import plan
from robodyn.simulation.equations import Equations
from robodyn.simulation.methods import method_named
from robodyn.simulation.steps import Steps

ROBOTS = ("UR5", "Panda", "ANYmal")
HEAD = (
    *(
        "robot",
        "joints",
        "operations per step",
        "one rollout",
        "Pinocchio from Python",
        "its four `aba` in C++",
        "ratio",
    ),
    *("of many", "Pinocchio's many", "ratio", "difference"),
)
STEP = 1e-3


def rk4(accelerations, q, v):
    """A step from functions of angles and speeds: arrays of one state or of many."""
    h, a1 = STEP, accelerations(q, v)
    v2 = v + h / 2 * a1
    a2 = accelerations(q + h / 2 * v, v2)
    v3 = v + h / 2 * a2
    a3 = accelerations(q + h / 2 * v2, v3)
    v4 = v + h * a3
    a4 = accelerations(q + h * v3, v4)
    return q + h / 6 * (v + 2 * v2 + 2 * v3 + v4), v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)


class Peer:
    """Pinocchio with the joints in our order."""

    def __init__(self, model):
        self.other = pin.buildModelFromXML(bare_description(model))
        self.data, self.pool = self.other.createData(), pin.ModelPool(self.other, 1)
        self.rows = np.array([self.other.joints[self.other.getJointId(name)].idx_v for name in model.rates])
        self.simple = self.other.nq == self.other.nv == model.n
        self.still = np.zeros(self.other.nv)

    def single(self, q, v, steps):
        q, v = (x[0][np.argsort(self.rows)] for x in (q, v))
        for _ in range(steps):
            q, v = rk4(lambda q, v: pin.aba(self.other, self.data, q, v, self.still), q, v)
        return q[self.rows]

    def many(self, q, v, steps):
        q, v = (np.asfortranarray(x[:, np.argsort(self.rows)].T) for x in (q, v))
        still, out = np.zeros_like(v, order="F"), np.zeros_like(v, order="F")

        def accelerations(q, v):
            pin.abaInParallel(1, self.pool, np.asfortranarray(q), np.asfortranarray(v), still, out)
            return out.copy(order="F")

        for _ in range(steps):
            q, v = rk4(accelerations, q, v)
        return q[self.rows].T

    def bare(self, q, v, count):
        q, v = (np.asfortranarray(np.repeat(x[:1, np.argsort(self.rows)].T, count, axis=1)) for x in (q, v))
        still, out = np.zeros_like(v, order="F"), np.zeros_like(v, order="F")
        return partial(pin.abaInParallel, 1, self.pool, q, v, still, out)


def row(name: str, steps: int, count: int) -> tuple[str, ...]:
    model, scene = described(name)
    size = Steps(Equations(plan(model, scene)), method_named("rk4")).step.size
    sources = random_sources(model, scene, count)
    q, v = sources["q"], 0.1 * sources["qd"]
    peer = Peer(model)
    ours = partial(robodyn.rollouts, model, step=STEP, scene=scene, executor="compiled", threads=1)
    acts = {
        "one": partial(ours, q[:1], v[:1], steps),
        "many": partial(ours, q, v, 20, every=20),
    }
    if peer.simple:
        acts["python"] = partial(peer.single, q, v, min(steps, 50))
        acts["bare"] = peer.bare(q, v, 4 * steps)
        acts["peers"] = partial(peer.many, q, v, 20)
    times = taking_turns(acts)
    one, many = times["one"].per(steps), times["many"].per(20 * count)
    if not peer.simple:
        return (name, joints(name), str(size), nanoseconds(one), *"---", nanoseconds(many), *"---")
    python, bare = times["python"].per(min(steps, 50)), times["bare"].per(steps)
    theirs = times["peers"].per(20 * count)
    difference = np.abs(acts["many"]().q[-1] - acts["peers"]()).max()
    return (
        *(name, joints(name), str(size), nanoseconds(one), nanoseconds(python), nanoseconds(bare)),
        *(f"{bare.least / one.least:.1f}", nanoseconds(many), nanoseconds(theirs)),
        *(f"{theirs.least / many.least:.1f}", f"{difference:.0e}"),
    )


def report(steps: int, rollouts: int) -> str:
    return table(HEAD, [row(name, steps, rollouts) for name in ROBOTS]) + "\n" + machine("pin", "llvmlite")


if __name__ == "__main__":
    main(report, __doc__, steps=1000, rollouts=4096)
