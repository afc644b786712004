"""What becomes of every mesh of real robots: `cd tests && python -m benchmarks.bench_corpus [--processes N]`.

The link meshes of example-robot-data and icub-models, as `robodyn.mass_properties` takes them:
integrated as they are, after repairs, by columns or winding numbers, or refused, with the reason. A traceback, a result
that is not finite, a mass or a principal moment that is not positive ends the run.
"""

from __future__ import annotations

import importlib.metadata
import os
import re
import sys
import time
import warnings
from collections import Counter, defaultdict
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from statistics import median

import numpy as np
from helpers.machine import machine
from helpers.markdown_tables import main, table

import robodyn

PACKAGES = ("example-robot-data", "icub-models")
SUFFIXES = (".stl", ".obj", ".dae", ".ply", ".glb")
HEAD = ("outcome", "meshes", "share", "median time", "largest change of the volume")


def meshes() -> list[Path]:
    files = [file for package in PACKAGES for file in importlib.metadata.files(package) or []]
    return sorted({Path(str(file.locate())).resolve() for file in files if file.suffix.lower() in SUFFIXES})


def outcome(path: Path) -> tuple[list[str], float, float]:
    """Names of what was done, seconds, and by how much repairs changed the volume, of the volume before."""
    start = time.perf_counter()
    try:
        part = robodyn.mass_properties(path)
    except robodyn.RobodynError as error:
        return [f"refused: {reason(str(error))}"], time.perf_counter() - start, 0.0
    spent = time.perf_counter() - start
    numbers = np.concatenate([[part.body.mass], part.body.com, part.body.inertia.ravel()])
    if not (np.isfinite(numbers).all() and part.body.mass > 0 and (part.body.principal.moments > 0).all()):
        raise SystemExit(f"{path}: {numbers}")
    steps = part.repairs
    first, last = (steps[0].volume_before, steps[-1].volume_after) if steps else (1.0, 1.0)
    return [step.name for step in steps] or ["as it is"], spent, abs(last / first - 1) if first else np.inf


def reason(message: str) -> str:
    """Without names and figures."""
    text = message.removeprefix("error: ").split(": ", 1)[-1].split(" (")[0]
    return re.sub(r"\d[\d.e+-]*", "N", text)


def measured(path: Path) -> tuple[list[str], float, float]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return outcome(path)


def report(processes: int) -> str:
    paths = meshes()
    with ProcessPoolExecutor(processes) as pool:
        found = list(pool.map(measured, paths, chunksize=4))
    times, changes, count = defaultdict(list), defaultdict(float), Counter()
    for names, spent, change in found:
        for name in {*names}:
            times[name].append(spent)
            changes[name] = max(changes[name], change)
            count[name] += 1
    rows = [
        (
            name,
            str(n),
            f"{100 * n / len(paths):.1f} %",
            f"{1e3 * median(times[name]):.0f} ms",
            "-" if name == "as it is" or name.startswith("refused") else f"{100 * changes[name]:.3g} %",
        )
        for name, n in sorted(
            count.items(), key=lambda item: (item[0] != "as it is", item[0].startswith("ref"), -item[1])
        )
    ]
    packages = ", ".join(f"{name} {importlib.metadata.version(name)}" for name in PACKAGES)
    whole = f"{len(paths)} meshes of {packages}; one may be repaired in several ways. "
    return f"{whole}\n\n{table(HEAD, rows)}\n{machine('trimesh', 'manifold3d')}"


if __name__ == "__main__":
    sys.path.insert(0, os.getcwd())
    main(report, __doc__, processes=2)
