"""Derivatives and Pinocchio in one run: `cd tests && python -m benchmarks.bench_derivatives`.

Torques (ID), the gradients of torques (dID: d tau/dq, d tau/dqd and M) and of accelerations (dFD: d qdd/dq, d qdd/dqd
and M^-1), one thread, for robots whose base is fixed. Pinocchio's `rnea`, `computeRNEADerivatives` and
`computeABADerivatives` are called from Python, a sample a call, of which the call takes some 0.3 us. robodyn is called
with all samples, and an array to write to. They take turns, and the shortest runs count. Friction and rotors are off,
because Pinocchio leaves them out; TALOS is its file without hands, for no joint mimics another there. "Compact" are
the entries that are not always zero.
"""

from __future__ import annotations

from functools import partial

import numpy as np
import pinocchio as pin
from benchmarks.pinocchio_runs import described, each, nanoseconds, peer_states, random_sources
from benchmarks.timing import taking_turns
from helpers.example_robots import path_of
from helpers.machine import machine
from helpers.markdown_tables import main, table
from helpers.oracles import worst
from helpers.pinocchio_robots import PinocchioRobot

import robodyn
from robodyn.dynamics.derivatives import forward_derivatives, inverse_derivatives
from robodyn.dynamics.plan import Plan

ROBOTS = {
    "UR5": "ur5_robot",
    "xArm7": "xarm7",
    "Panda": "panda",
    "HyQ": "hyq_no_sensors",
    "ANYmal": "anymal",
    "simple humanoid": "simple_humanoid",
    "TALOS": "talos_reduced",
}
CALLS = 50
"""Samples of Pinocchio in a turn."""
HEAD = (
    *("robot", "joints", "operations of dID", "entries (compact)", "operations of dFD"),
    *("ID", "ratio", "dID", "ratio", "dID compact", "ratio", "dFD", "ratio", "agreement"),
)


def peers(model):
    """Pinocchio's three algorithms, each for `CALLS` samples one after another."""
    other, data, states = peer_states(model, CALLS)
    algorithms = {"ID": pin.rnea, "dID": pin.computeRNEADerivatives, "dFD": pin.computeABADerivatives}
    return {name: each(partial(algorithm, other, data), states) for name, algorithm in algorithms.items()}


def agreement(name: str) -> float:
    model, scene = described(ROBOTS[name])
    other, sources = PinocchioRobot(path_of(ROBOTS[name])), random_sources(model, scene, 5)
    state = [sources[source] for source in ("q", "qd", "qdd")]
    found = robodyn.inverse_dynamics_derivatives(model, *state, scene=scene)
    expected = [other.derivatives(model, *sample) for sample in zip(*state, strict=True)]
    pairs = [(found[k], np.array([both[k] for both in expected])) for k in range(2)]
    return max(worst(a, b) for a, b in (*pairs, (found.dqdd, other.mass_matrices(model, state[0]))))


def row(name: str, samples: int) -> tuple[str, ...]:
    model, scene = described(ROBOTS[name])
    n, sources = model.n, random_sources(model, scene, samples)
    state = [sources[source] for source in ("q", "qd", "qdd")]
    count = len(robodyn.inverse_dynamics_derivative_entries(model, *(x[0] for x in state), scene=scene).row)
    dense = np.moveaxis(np.empty((3, n, n, samples)), -1, 0)
    ours = {
        "ID": (robodyn.inverse_dynamics, np.empty((samples, n), order="F")),
        "dID": (robodyn.inverse_dynamics_derivatives, dense),
        "compact": (robodyn.inverse_dynamics_derivative_entries, np.empty((samples, count), order="F")),
        "dFD": (robodyn.forward_dynamics_derivatives, dense),
    }
    options = {"scene": scene, "executor": "compiled", "threads": 1}
    acts = {name: partial(function, model, *state, out=out, **options) for name, (function, out) in ours.items()}
    theirs = {f"Pinocchio {name}": act for name, act in peers(model).items()}
    spent = taking_turns(acts | theirs)
    times = {way: time / (CALLS if way in theirs else samples) for way, time in spent.items()}

    def pair(way: str, peer: str) -> tuple[str, str]:
        ratio = times[f"Pinocchio {peer}"] / times[way]
        return nanoseconds(times[way]), f"{ratio:.1f}"

    a_plan = Plan(model, scene)
    return (
        name,
        *map(str, (n, inverse_derivatives(a_plan).size)),
        f"{3 * n * n} ({count})",
        str(forward_derivatives(a_plan).size),
        *pair("ID", "ID"),
        *pair("dID", "dID"),
        *pair("compact", "dID"),
        *pair("dFD", "dFD"),
        f"{agreement(name):.0e}",
    )


def report(samples: int) -> str:
    return table(HEAD, [row(name, samples) for name in ROBOTS]) + "\n" + machine("pin", "llvmlite")


if __name__ == "__main__":
    main(report, __doc__, samples=20_000)
