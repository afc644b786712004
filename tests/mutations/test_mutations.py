"""Every mutation of the list is killed: its test fails on a copy of the package that has it."""

from __future__ import annotations

import ast
import compileall
import os
import shutil
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from importlib.util import cache_from_source
from pathlib import Path
from textwrap import dedent

import pytest
from helpers.mutation_list import MUTATIONS
from helpers.preloaded import Run, preloaded

ROOT = Path(__file__).parents[2]
CASES = [(test, *mutation) for test, mutations in MUTATIONS.items() for mutation in mutations]
Case = tuple[str, str, str, str]
ENVIRONMENT = {"PYTHONDONTWRITEBYTECODE": "1", "OMP_NUM_THREADS": "1"}
FAILED = 1, 2
"""What pytest ends with where a test failed, or could not even be read."""


def mutated(source: str, old: str, new: str) -> str:
    """Return a source in which what reads `old` reads `new`, however it is laid out; see `change`."""
    tree = ast.parse(source)
    return ast.unparse(ast.fix_missing_locations(change(tree, old, new).visit(tree)))


def change(tree: ast.AST, old: str, new: str) -> Change:
    """Return what makes the change when it visits the tree.

    Args:
        old: an expression or a statement that stands in the source once, or what stands once in its texts, such as
            code of another language.
        new: the same, changed.

    Raises:
        ValueError: there is no such piece, or more than one.
    """
    found = _piece_changed(tree, old, new) or _text_changed(tree, old, new)
    if found is None:
        raise ValueError(f"not there once: {old}")
    return found


class Change(ast.NodeTransformer):
    def __init__(self, node: ast.AST, instead: ast.AST) -> None:
        self.node, self.instead = node, instead

    def visit(self, node: ast.AST) -> ast.AST:
        return self.instead if node is self.node else self.generic_visit(node)


def _piece_changed(tree: ast.AST, old: str, new: str) -> Change | None:
    try:
        piece, instead = _parsed(old), _parsed(new)
    except SyntaxError:
        return None
    found = [node for node in ast.walk(tree) if _alike(node, piece)]
    return Change(found[0], instead) if len(found) == 1 else None


def _alike(one: object, other: object) -> bool:
    if type(one) is not type(other):
        return False
    if isinstance(one, ast.AST):
        return all(_alike(getattr(one, name, None), getattr(other, name, None)) for name in one._fields)
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and all(map(_alike, one, other))
    return one == other


def _parsed(text: str) -> ast.AST:
    (statement,) = ast.parse(dedent(text)).body
    return statement.value if isinstance(statement, ast.Expr) else statement


def _text_changed(tree: ast.AST, old: str, new: str) -> Change | None:
    found = [node for node in _texts(tree) if old in node.value]
    if len(found) != 1 or found[0].value.count(old) != 1:
        return None
    return Change(found[0], ast.Constant(found[0].value.replace(old, new)))


def _texts(tree: ast.AST) -> Iterator[ast.Constant]:
    return (node for node in ast.walk(tree) if isinstance(node, ast.Constant) and isinstance(node.value, str))


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
