"""The tables of docs/: of effects, robots and errors, and those of timings."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

from benchmarks.coverage_of_identified import coverage_of_identified
from benchmarks.derivative_errors import coverage_table, derivatives_table
from benchmarks.peak_bar_coverage import report as torque_bars

from helpers.machine import machine
from helpers.markdown_tables import table
from helpers.oracles import robot
from helpers.robot_catalogue import robots_table
from robodyn.dynamics.plan import EFFECTS
from robodyn.scene.scene import Scene

TIMED = {
    "speed": "bench_executors",
    "libraries": "compare",
    "streaming": "bench_streaming",
    "tables": "bench_tables",
    "startup": "bench_startup",
    "forward": "bench_executors --forward 1",
    "contacts": "bench_contacts",
    "excitation": "bench_excitation",
    "precision": "bench_work_precision",
    "meshes": "bench_startup --meshes 5000000",
    "check": "bench_check",
    "audit": "audit_robots",
    "formats": "audit_formats",
    "slips": "bench_slips",
    "simcheck": "bench_simcheck",
    "iftomm": "bench_iftomm",
}


def effects_table() -> str:
    """Every effect, what it adds to tau, and why a robot that weighs, has and does nothing is without it."""
    nothing, model = Scene(gravity=(0.0, 0.0, 0.0)), robot("two_link_planar")
    still = frozenset((source, i) for source in ("qd", "qdd") for i in range(model.n))
    rows = [(effect.name, effect.adds, effect.why(model, nothing, still).reason) for effect in EFFECTS]
    return table(("effect", "adds", "off when"), rows, left=(0, 1, 2))


def accuracy_table() -> str:
    """Return the table of errors, for which Pinocchio must be installed."""
    from benchmarks.bench_accuracy import accuracy_table as measured_table

    return measured_table()


def steady_tables() -> dict[str, Callable[[], str]]:
    """What makes the tables that do not depend on how fast the machine is."""
    return {
        "effects": effects_table,
        "robots": robots_table,
        "accuracy": accuracy_table,
        "derivatives": derivatives_table,
    }


def timed_tables() -> dict[str, Callable[[], str]]:
    """What makes the tables that take minutes: of error bars, and those of timings, each by a process of its own."""
    return {
        "bars": coverage_table,
        "identified": coverage_of_identified,
        "torque-bars": partial(torque_bars, draws=30, tune=0),
        **{name: partial(measured, script) for name, script in TIMED.items()},
    }


def measured(script: str) -> str:
    """What a benchmark with its options prints, and on which machine if it does not say so."""
    command = [sys.executable, "-m", *f"benchmarks.{script}".split()]
    text = subprocess.run(command, cwd=Path(__file__).parents[1], check=True, stdout=subprocess.PIPE, text=True).stdout
    return text if "Measured on " in text else f"{text}\n{machine('click')}"
