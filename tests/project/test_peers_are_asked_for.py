"""`pip install ".[test]" && pytest` passes where no other program is installed: tests ask for those that they need."""

from __future__ import annotations

import ast
from pathlib import Path

TESTS = Path(__file__).parents[1]
PEERS = {"pinocchio", "mujoco", "pydrake", "idyntree", "casadi", "jax", "torch", "igl"}
"""Modules that `[test]` does not bring."""


def _tops(node: ast.AST) -> set[str]:
    """Return the packages that a statement imports."""
    if isinstance(node, ast.Import):
        return {alias.name.split(".")[0] for alias in node.names}
    return {(node.module or "").split(".")[0]} if isinstance(node, ast.ImportFrom) else set()


def _asked(statement: ast.stmt) -> set[str]:
    """Return the packages without which a statement skips the test."""
    calls = [node for node in ast.walk(statement) if isinstance(node, ast.Call)]
    skips = [call for call in calls if ast.unparse(call.func) in ("peer", "pytest.importorskip")]
    return {
        str(ast.literal_eval(call.args[0])).split(".")[0] for call in skips if isinstance(call.args[0], ast.Constant)
    }


def _unasked(body: list[ast.stmt], asked: set[str]) -> list[tuple[int, str]]:
    """Return (line, package) of the imports before which nothing asked for the package."""
    found = []
    for statement in body:
        found += [(statement.lineno, name) for name in sorted(_tops(statement) & PEERS - asked)]
        bodies = [getattr(statement, field, []) for field in ("body", "orelse", "finalbody")]
        bodies += [handler.body for handler in getattr(statement, "handlers", [])]
        for inner in bodies:
            found += _unasked(inner, asked)
        asked = asked | _asked(statement)
    return found


def test_tests_ask_before_they_import() -> None:
    found = {
        str(path.relative_to(TESTS)): _unasked(ast.parse(path.read_text()).body, set())
        for path in TESTS.rglob("*.py")
        if "benchmarks" not in path.parts
    }
    assert {path: imports for path, imports in found.items() if imports} == {}
