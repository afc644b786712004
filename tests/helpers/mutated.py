"""Sources with one piece of their syntax tree changed."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from textwrap import dedent


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
