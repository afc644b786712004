"""Every mutation of the list is killed: its test fails on a copy of the package that has it."""

from __future__ import annotations

import ast
import compileall
import os
import shutil
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from importlib.util import cache_from_source
from pathlib import Path

import pytest
from helpers.mutated import change, mutated
from helpers.mutation_list import MUTATIONS
from helpers.preloaded import Run, preloaded

ROOT = Path(__file__).parents[2]
CASES = [(test, *mutation) for test, mutations in MUTATIONS.items() for mutation in mutations]
Case = tuple[str, str, str, str]
ENVIRONMENT = {"PYTHONDONTWRITEBYTECODE": "1", "OMP_NUM_THREADS": "1"}
FAILED = 1, 2
"""What pytest ends with where a test failed, or could not even be read."""


def _copied(folder: Path) -> Path:
    """The package as it is in a folder, with its bytecode."""
    skipped = shutil.ignore_patterns("__pycache__")
    shutil.copytree(ROOT / "robodyn", folder / "robodyn", ignore=skipped)
    shutil.copytree(ROOT / "cli", folder / "robodyn" / "cli", ignore=skipped)
    assert compileall.compile_dir(folder / "robodyn", quiet=1)
    return folder


def _tests(run: Run, folder: Path, names: Iterable[str]) -> tuple[int, str]:
    """What pytest ends with, and writes, for these tests against the package in a folder, up to the first failure."""
    options = ["-x", "-q", "-n", "0", "-p", "no:cacheprovider", "--no-header", "--tb=no", "--hypothesis-seed=0"]
    status, output = run(folder, [*options, *(str(ROOT / "tests" / name) for name in names)])
    assert output.startswith(str(folder)), output
    return status, output


def _survivors(whole: Path, folder: Path, cases: Iterable[Case]) -> list[Case]:
    """Those of the changes with which, on a copy of the package, their test passes."""
    with preloaded(**ENVIRONMENT) as run:
        return [case for k, case in enumerate(cases) if _survives(run, whole, folder / str(k), case)]


def _survives(run: Run, whole: Path, folder: Path, case: Case) -> bool:
    test, file, old, new = case
    shutil.copytree(whole, folder, copy_function=os.link)
    path = folder / "robodyn" / file
    source = path.read_text()
    for kept in path, Path(cache_from_source(path)):
        kept.unlink()
    path.write_text(mutated(source, old, new))
    status, output = _tests(run, folder, [test])
    shutil.rmtree(folder)
    assert status in (0, *FAILED), output
    return status == 0


def test_pieces_are_there() -> None:
    """Each piece to change stands in its file once, and is another after the change."""
    assert len(CASES) >= 40
    for file in {file for _, file, _, _ in CASES}:
        tree = ast.parse((ROOT / "robodyn" / file).read_text())
        for old, new in ((old, new) for _, other, old, new in CASES if other == file):
            found = change(tree, old, new)
            assert ast.dump(found.node) != ast.dump(found.instead), (file, old)


@pytest.mark.slow
def test_the_product_itself_survives(tmp_path: Path) -> None:
    with preloaded(**ENVIRONMENT) as run:
        status, output = _tests(run, _copied(tmp_path), MUTATIONS)
    assert status == 0, output


@pytest.mark.slow
def test_every_mutation_is_killed(tmp_path: Path) -> None:
    whole, together = _copied(tmp_path / "whole"), os.cpu_count() or 1
    with ThreadPoolExecutor(together) as pool:
        folders = [tmp_path / str(k) for k in range(together)]
        shares = [CASES[k::together] for k in range(together)]
        survivors = list(pool.map(lambda folder, share: _survivors(whole, folder, share), folders, shares))
    assert not [case for share in survivors for case in share]
