"""robodyn beside other libraries of rigid-body dynamics: `cd tests && python -m benchmarks.compare --out compare.html`.

All are given the same description, links and joints alone, and the same states. Each works in a process of its own;
they take turns. What is not installed, or does not take a robot, is left out and named. Tables are printed; `--out`
writes them with charts as a page, and beside it all that was measured as JSON.
"""

from __future__ import annotations

import argparse
import json
import os
import shlex
import subprocess
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from benchmarks.compare_tables import document, printed
from benchmarks.libraries import ALGORITHMS, CHECKED, LIBRARIES, OURS
from benchmarks.pinocchio_runs import bare_description
from benchmarks.published import PUBLISHED
from helpers.example_robots import PATHS
from helpers.machine import machine

import robodyn
from robodyn.dynamics.function import KINDS
from robodyn.dynamics.plan import plan
from robodyn.errors import RobodynError
from robodyn.measure.accuracy.ladder import Spread
from robodyn.programs.run.llvm.machine import LEVELS, host
from robodyn.programs.run.multiprecision import Multiprecision
from robodyn.report.document import written
from robodyn.report.renderers.pages import html
from robodyn.scene.scene import DEFAULT

TESTS = Path(__file__).parents[1]
ROBOTS = {
    "UR5": "ur5_robot",
    "iiwa": TESTS / "data" / "reference" / "urdf" / "iiwa14_drake.urdf",
    "Panda": "panda",
    "HyQ": "hyq_no_sensors",
    "ANYmal": "anymal",
    "Baxter": "baxter",
    "TALOS": "talos_reduced",
}
"""Files, and names of those that example-robot-data brings."""
QUICK = ("UR5", "HyQ")
ROUNDS, QUICK_ROUNDS = 9, 3
DIGITS = 50
SEED = 0
ALONE = {
    "JAX_ENABLE_X64": "1",
    "JAX_PLATFORMS": "cpu",
    "XLA_FLAGS": "--xla_cpu_multi_thread_eigen=false",
    **dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1"),
}
"""Variables of every process."""
CODE = {"AVX2": "x86-64-v3", "AVX-512": "x86-64-v4"}
"""Machine code of robodyn: both are measured where the processor has both."""


class Process:
    """A library in a process of its own, by lines of JSON."""

    def __init__(self, title: str, library: str, **variables: str) -> None:
        self.title = title
        command = [sys.executable, "-m", "benchmarks.libraries", library]
        pipes: dict[str, Any] = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL}
        self._process = subprocess.Popen(command, cwd=TESTS, env=os.environ | ALONE | variables, text=True, **pipes)

    def ask(self, **asked: Any) -> None:
        assert self._process.stdin is not None
        try:
            print(json.dumps(asked), file=self._process.stdin, flush=True)
        except BrokenPipeError:
            return  # its answer says so

    def answer(self) -> Any:
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        return json.loads(line) if line else {"problem": f"{self._process.wait()} is the exit status of its process"}

    def end(self) -> None:
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait()


def processes(names: Iterable[str]) -> list[Process]:
    """The libraries, robodyn once for each kind of code."""
    features, found = host().features.split(","), []
    both = all(f"+{feature}" in features for feature in LEVELS["x86-64-v4"])
    for name in names:
        kinds = CODE.items() if name == "robodyn" and both else ()
        found += [Process(f"{name} {kind}", name, ROBODYN_CPU=level) for kind, level in kinds] or [Process(name, name)]
    return found


def path_of(robot: str) -> Path | None:
    """Where the description of a robot is, or a file of that name; None if there is none."""
    where = ROBOTS.get(robot, Path(robot))
    if isinstance(where, str):
        return next((path for path in PATHS if path.stem == where), None)
    return where if where.is_file() else None


def drawn(model: robodyn.Model) -> dict[str, Any]:
    """The states: q up to 2, rates and accelerations up to 3, and the torques of these motions."""
    rng = np.random.default_rng(SEED)
    q, v, a = (rng.uniform(-most, most, (OURS, model.n)) for most in (2.0, 3.0, 3.0))
    return {"q": q, "v": v, "a": a, "t": robodyn.inverse_dynamics(model, q, v, a)}


def exact(model: robodyn.Model, states: Mapping[str, Any], algorithm: str) -> Any:
    """The results of the first states in 50 digits, as robodyn's programs have them."""
    kind, n = KINDS[ALGORITHMS[algorithm].function], model.n
    arguments = dict(zip(kind.sources, ALGORITHMS[algorithm].sources, strict=True))
    program = kind.program(plan(model, DEFAULT))
    count = CHECKED[algorithm]
    given = {source: states[name][:count] for source, name in arguments.items()}
    found = Multiprecision(program, digits=DIGITS)(given, count)
    if algorithm.startswith("d"):
        return found.reshape(count, 3, n, n)[:, :2]
    return found.reshape(count, *[n] * ALGORITHMS[algorithm].axes)


def error(found: Any, expected: Any) -> float:
    """The largest difference over the largest result; of derivatives by q and by qd the larger one."""
    parts = [(found[:, k], expected[:, k]) for k in range(2)] if found.ndim == 4 else [(found, expected)]
    return max(float(abs(a - b).max() / abs(b).max()) for a, b in parts)


class Comparison:
    """What is measured, robot by robot; `skipped` says what could not be, and why, a line each."""

    def __init__(self, libraries: Iterable[str], algorithms: Sequence[str], rounds: int) -> None:
        self.algorithms, self.rounds = algorithms, rounds
        self.processes, self.skipped, self.versions = processes(libraries), [], {}
        self.results: list[dict[str, Any]] = []
        self.empty: dict[str, list[float]] = {}

    def skip(self, what: str, why: str) -> None:
        if (line := f"{what} is left out: {why}") not in self.skipped:
            self.skipped.append(line)
            print(line, file=sys.stderr)

    def measure(self, robot: str) -> None:
        """Measure one robot by every library that takes it."""
        where = path_of(robot)
        if where is None:
            self.skip(robot, "there is no such file" if robot not in ROBOTS else "example-robot-data is not installed")
            return
        name = robot if robot in ROBOTS else where.stem
        try:
            described = bare_description(robodyn.load(where))
        except RobodynError as error:
            self.skip(robot, str(error))
            return
        with TemporaryDirectory() as folder:
            file, states_file = Path(folder) / "robot.urdf", Path(folder) / "states.npz"
            file.write_text(described, encoding="utf-8")
            model = robodyn.load(file)
            if model.nq > model.n:
                self.skip(robot, "not every joint has one degree of freedom")
                return
            states = drawn(model)
            np.savez(states_file, **states)
            about = json.dumps({"file": str(file), "root": model.bodies[0].name, "names": list(model.rates)})
            given = {"robot": about, "states": str(states_file), "algorithms": list(self.algorithms)}
            stores = {process.title: Path(folder) / f"{k}.npz" for k, process in enumerate(self.processes)}
            for process in self.processes:
                process.ask(do="robot", results=str(stores[process.title]), **given)
            expected = {algorithm: exact(model, states, algorithm) for algorithm in self.algorithms}
            taken = {process: process.answer() for process in self.processes}
            for process, answer in list(taken.items()):
                if "problem" in answer:
                    self._without(process, name, taken.pop(process)["problem"])
            errors = {process: self._errors(stores[process.title], expected) for process in taken}
        acts = dict.fromkeys(act for answer in taken.values() for act in answer["samples"])
        times: dict[tuple[Process, str], list[float]] = {}
        for _, act, (process, answer) in product(range(self.rounds), acts, taken.items()):
            if act in answer["samples"]:
                process.ask(do="turn", act=act)
                times.setdefault((process, act), []).append(process.answer())
        for process, answer in taken.items():
            self.versions[process.title] = answer["version"]
            self.empty.setdefault(process.title, []).extend(times.pop((process, "empty")))
        for (process, act), spent in times.items():
            algorithm, way = act.split()
            answer = taken[process]
            told = answer["told"][algorithm] if way == "block" else {}
            self.results.append(
                {
                    "robot": name,
                    "joints": model.n,
                    "algorithm": algorithm,
                    "library": process.title,
                    "way": way,
                    "samples": answer["samples"][act],
                    "seconds": asdict(Spread.of(spent)),
                    "error": errors[process][act],
                    **told,
                }
            )

    def _without(self, process: Process, robot: str, why: str) -> None:
        gone = why.endswith(("is not installed", "of its process"))
        self.skip(process.title if gone else f"{process.title} with {robot}", why)
        if gone:
            self.processes.remove(process)
            process.end()

    def _errors(self, file: Path, expected: Mapping[str, Any]) -> dict[str, float]:
        with np.load(file) as stored:
            return {act: error(found, expected[act.split()[0]]) for act, found in stored.items()}

    def data(self) -> dict[str, Any]:
        """All that was measured, as JSON has it; times in seconds."""
        return {
            "machine": machine(),
            "processor": host().cpu,
            "threads": 1,
            "versions": self.versions,
            "digits": DIGITS,
            "checked_states": CHECKED,
            "seed": SEED,
            "rounds": self.rounds,
            "results": self.results,
            "empty_call": {title: asdict(Spread.of(times)) for title, times in self.empty.items()},
            "published": [each._asdict() for each in PUBLISHED],
            "skipped": self.skipped,
        }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--robots", nargs="+", metavar="ROBOT", help=f"of {', '.join(ROBOTS)}, or files; default: all")
    parser.add_argument("--libraries", nargs="+", choices=LIBRARIES, default=list(LIBRARIES), help="default: all")
    parser.add_argument("--algorithms", nargs="+", choices=ALGORITHMS, default=list(ALGORITHMS), help="default: all")
    parser.add_argument("--quick", action="store_true", help=f"{' and '.join(QUICK)} alone, and fewer rounds: a minute")
    parser.add_argument("--out", type=Path, metavar="FILE.html", help="the page; its data stand beside it as FILE.json")
    given = parser.parse_args()
    comparison = Comparison(given.libraries, given.algorithms, QUICK_ROUNDS if given.quick else ROUNDS)
    for robot in given.robots or (QUICK if given.quick else ROBOTS):
        comparison.measure(robot)
    for process in comparison.processes:
        process.end()
    if not comparison.results:
        parser.error("nothing could be measured")
    data = comparison.data()
    if given.out:
        command = shlex.join(["python", "-m", "benchmarks.compare", *sys.argv[1:]])
        given.out.write_text(html(document(data, command)), encoding="utf-8")
        given.out.with_suffix(".json").write_text(written(data), encoding="utf-8")
    print(printed(data), end="")


if __name__ == "__main__":
    main()
