"""Every mutation of the list is killed: its test fails on a copy of the package that has it."""

from __future__ import annotations

import ast
import os
import shutil
import subprocess
import sys
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from helpers.mutated import mutated
from helpers.mutation_list import MUTATIONS

ROOT = Path(__file__).parents[2]
CASES = [(test, *mutation) for test, mutations in MUTATIONS.items() for mutation in mutations]
RUN = "import sys, pytest, robodyn; print(robodyn.__file__); sys.exit(pytest.main(sys.argv[1:]))"
FAILED = 1, 2
"""What pytest ends with where a test failed, or could not even be read."""


def _copy(folder: Path) -> None:
    skipped = shutil.ignore_patterns("__pycache__")
    shutil.copytree(ROOT / "robodyn", folder / "robodyn", ignore=skipped)
    shutil.copytree(ROOT / "cli", folder / "robodyn" / "cli", ignore=skipped)


def _tests(folder: Path, names: Iterable[str]) -> subprocess.CompletedProcess[str]:
    """These tests against the package in a folder, up to the first failure."""
    options = ["-x", "-q", "-p", "no:cacheprovider", "--no-header", "--tb=no", "--hypothesis-seed=0"]
    environment = os.environ | {"PYTHONPATH": str(folder), "PYTHONDONTWRITEBYTECODE": "1", "OMP_NUM_THREADS": "1"}
    command = [sys.executable, "-c", RUN, *options, *(str(ROOT / "tests" / name) for name in names)]
    done = subprocess.run(command, check=False, cwd=folder, env=environment, capture_output=True, text=True)
    assert done.stdout.startswith(str(folder)), done.stdout + done.stderr
    return done


def _survives(folder: Path, case: tuple[str, str, str, str]) -> bool:
    """Whether the test passes on a copy with this change."""
    test, file, old, new = case
    _copy(folder)
    path = folder / "robodyn" / file
    path.write_text(mutated(path.read_text(), old, new))
    done = _tests(folder, [test])
    shutil.rmtree(folder)
    assert done.returncode in (0, *FAILED), done.stdout + done.stderr
    return done.returncode == 0


def test_pieces_are_there() -> None:
    """Each piece to change stands in its file once, and is another after the change."""
    assert len(CASES) >= 40
    for _, file, old, new in CASES:
        source = (ROOT / "robodyn" / file).read_text()
        assert mutated(source, old, new) != ast.unparse(ast.parse(source)), (file, old)


@pytest.mark.slow
def test_the_product_itself_survives(tmp_path: Path) -> None:
    _copy(tmp_path)
    done = _tests(tmp_path, MUTATIONS)
    assert done.returncode == 0, done.stdout


@pytest.mark.slow
def test_every_mutation_is_killed(tmp_path: Path) -> None:
    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        folders = [tmp_path / str(k) for k in range(len(CASES))]
        survivors = list(pool.map(_survives, folders, CASES))
    assert not [case for case, survived in zip(CASES, survivors, strict=True) if survived]
