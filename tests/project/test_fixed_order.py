"""Sums over named axes do not take in what stood in memory."""

from __future__ import annotations

import ast

from project.test_layers import MODULES


def test_named_axes_are_summed_in_one_place() -> None:
    """`einsum` of NumPy leaves what stood in memory where it sums over nothing."""
    bare = {module for module, tree in MODULES.items() if "einsum" in _of_numpy(tree)}
    assert bare == {"robodyn.support.sums"}


def _of_numpy(tree: ast.AST) -> set[str]:
    """Return the names that a module takes from NumPy."""
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and ast.unparse(node.value).split(".")[0] in ("np", "numpy"):
            found.add(node.attr)
        elif isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "numpy":
            found |= {alias.name for alias in node.names}
    return found
