"""Every mutation of the list is killed: some quick test fails on a copy of the package that has it."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from mutation_list import MUTATIONS

ROOT = Path(__file__).parents[2]
QUICK = [
    "dynamics/test_golden.py",
    "effects",
    "model/test_invariance.py",
    "dynamics/test_momentum.py",
    "trace/test_folding.py",
    "execute/test_numpy_blocks.py",
    "execute/test_fusion.py",
    "execute/test_compiled_blocks.py",
    "execute/test_compiled_outputs.py",
    "execute/test_elementary_functions.py",
    "loads/test_sizing_figures.py",
    "sizing/test_motor_torque.py",
    "sizing/test_bearings.py",
    "sizing/test_sizing_blocks.py",
    "sizing/test_sizing_report.py",
    "loads/test_blocks.py",
    "loads/test_self_checks.py",
    "loops/test_closures.py",
    "loops/test_closed_chain.py",
    "maximal/test_single_equations.py",
    "maximal/test_consistent.py",
    "maximal/test_closed_dae.py",
    "maximal/test_dae.py",
    "simulation/test_friction_and_limits.py",
    "simulation/test_tables.py",
    "simulation/test_verlet.py",
    "simulation/test_free_bodies_fly.py",
]
RUN = "import sys, pytest, robodyn; print(robodyn.__file__); sys.exit(pytest.main(sys.argv[1:]))"


def _copy(folder):
    skipped = shutil.ignore_patterns("__pycache__")
    shutil.copytree(ROOT / "robodyn", folder / "robodyn", ignore=skipped)
    shutil.copytree(ROOT / "cli", folder / "robodyn" / "cli", ignore=skipped)


def _tests(folder, area=""):
    """The quick tests against the package in `folder`, those of one area first, up to the first failure."""
    options = ["-x", "-q", "-p", "no:cacheprovider", "--no-header", "--tb=no", "--hypothesis-seed=0"]
    paths = [str(ROOT / "tests" / name) for name in sorted(QUICK, key=lambda name: not name.startswith(area))]
    environment = os.environ | {"PYTHONPATH": str(folder), "PYTHONDONTWRITEBYTECODE": "1", "OMP_NUM_THREADS": "1"}
    command = [sys.executable, "-c", RUN, *options, *paths]
    done = subprocess.run(command, check=False, cwd=folder, env=environment, capture_output=True, text=True)
    assert done.stdout.startswith(str(folder)), done.stdout + done.stderr
    return done


def _survives(folder, mutation):
    """Whether every quick test passes on a copy with this change."""
    file, old, new = mutation
    _copy(folder)
    path = folder / "robodyn" / file
    text = path.read_text()
    assert text.count(old) == 1, f"{file} has {old!r} {text.count(old)} times"
    path.write_text(text.replace(old, new))
    done = _tests(folder, file.split("/")[0])
    shutil.rmtree(folder)
    assert done.returncode in (0, 1, 2), done.stdout + done.stderr
    return done.returncode == 0


def test_lines_are_there():
    """Each line to change stands in its file exactly once."""
    assert len(MUTATIONS) >= 40
    lost = [(file, old) for file, old, _ in MUTATIONS if (ROOT / "robodyn" / file).read_text().count(old) != 1]
    assert not lost


@pytest.mark.slow
def test_the_product_itself_survives(tmp_path):
    _copy(tmp_path)
    done = _tests(tmp_path)
    assert done.returncode == 0, done.stdout


@pytest.mark.slow
def test_every_mutation_is_killed(tmp_path):
    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        folders = [tmp_path / str(k) for k in range(len(MUTATIONS))]
        survivors = list(pool.map(_survives, folders, MUTATIONS))
    assert not [mutation for mutation, survived in zip(MUTATIONS, survivors, strict=True) if survived]
