"""One sample a call and Pinocchio in one run: `cd tests && python -m benchmarks.bench_one_sample`.

Torques (ID), accelerations (FD) and mass matrix (M) of one state after the other, called from Python, one thread, base
fixed: by what `robodyn.function` returns, with and without an array to write to, and by the call for arrays
(`robodyn.inverse_dynamics` and so on, compiled), against Pinocchio's `rnea`, `aba` and `crba`, whose results are arrays
that it keeps. They take turns, and the shortest runs count. Friction and rotors are off, because Pinocchio leaves them
out; TALOS is its file without hands, for no joint mimics another there.
"""

from __future__ import annotations

from functools import partial

import numpy as np
import pinocchio as pin
from benchmarks.pinocchio_runs import described, each, peer_states, random_sources
from benchmarks.timing import taking_turns
from helpers.example_robots import path_of
from helpers.machine import machine
from helpers.markdown_tables import main, table
from helpers.oracles import worst
from helpers.pinocchio_robots import PinocchioRobot

import robodyn

ROBOTS = {"UR5": "ur5_robot", "ANYmal": "anymal", "TALOS": "talos_reduced"}


ALGORITHMS = {
    "ID": ("inverse_dynamics", 3, pin.rnea),
    "FD": ("forward_dynamics", 3, pin.aba),
    "M": ("mass_matrix", 1, pin.crba),
}
"""The name of robodyn's function, how many arrays a state is, and Pinocchio's function."""
HEAD = (
    *("robot", "joints", "", "Pinocchio", "function, `out=`", "ratio", "function", "ratio", "call for arrays", "ratio"),
    "agreement",
)


def states_of(name: str, calls: int) -> list[tuple[np.ndarray, ...]]:
    sources = random_sources(*described(ROBOTS[name]), calls)
    return list(zip(*(np.ascontiguousarray(sources[x]) for x in ("q", "qd", "qdd")), strict=True))


def agreement(name: str, algorithm: str) -> float:
    """The largest difference from Pinocchio's results; of accelerations from the torques that they take there."""
    model, scene = described(ROBOTS[name])
    other, states = PinocchioRobot(path_of(ROBOTS[name])), states_of(name, 5)
    name, arrays, _ = ALGORITHMS[algorithm]
    one = robodyn.function(model, name, scene=scene)
    found = np.array([one(*state[:arrays]) for state in states])
    q, qd, last = map(np.array, zip(*states, strict=True))
    if algorithm == "M":
        return worst(found, other.mass_matrices(model, q))
    if algorithm == "ID":
        return worst(found, other.torques(model, q, qd, last))
    return worst(other.torques(model, q, qd, found), last)


def row(name: str, algorithm: str, calls: int) -> tuple[str, ...]:
    model, scene = described(ROBOTS[name])
    ours, arrays, peer = ALGORITHMS[algorithm]
    other, data, random = peer_states(model, calls)
    theirs = [state[:arrays] for state in random]
    states = [state[:arrays] for state in states_of(name, calls)]
    one = robodyn.function(model, ours, scene=scene)
    general = partial(getattr(robodyn, ours), model, scene=scene, executor="compiled")
    acts = {
        "Pinocchio": each(partial(peer, other, data), theirs),
        "out": each(partial(one, out=np.empty(one.shape)), states),
        "function": each(one, states),
        "general": each(general, states),
    }
    times = {way: time / calls for way, time in taking_turns(acts).items()}

    base = times.pop("Pinocchio")
    cells = [cell for time in times.values() for cell in (f"{1e6 * time:.2f} us", f"{time / base:.2f}")]
    return name, str(model.n), algorithm, f"{1e6 * base:.2f} us", *cells, f"{agreement(name, algorithm):.0e}"


def report(calls: int) -> str:
    rows = [row(name, algorithm, calls) for name in ROBOTS for algorithm in ALGORITHMS]
    return table(HEAD, rows, left=(0, 2)) + "\n" + machine("pin", "llvmlite")


if __name__ == "__main__":
    main(report, __doc__, calls=200)
