"""Sources with one piece of their syntax tree changed."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from textwrap import dedent


def mutated(source: str, old: str, new: str) -> str:
    """Return a source in which what reads `old` reads `new`, however it is laid out.

    Args:
        old: an expression or a statement that stands in the source once, or what stands once in its texts, such as
            code of another language.
        new: the same, changed.

    Raises:
        ValueError: there is no such piece, or more than one.
    """
    tree = ast.parse(source)
    change = _piece_changed(tree, old, new) or _text_changed(tree, old, new)
    if change is None:
        raise ValueError(f"not there once: {old}")
    return ast.unparse(ast.fix_missing_locations(change.visit(tree)))


class _Change(ast.NodeTransformer):
    def __init__(self, node: ast.AST, instead: ast.AST) -> None:
        self.node, self.instead = node, instead

    def visit(self, node: ast.AST) -> ast.AST:
        return self.instead if node is self.node else self.generic_visit(node)


def _piece_changed(tree: ast.AST, old: str, new: str) -> _Change | None:
    try:
        piece, instead = _parsed(old), _parsed(new)
    except SyntaxError:
        return None
    found = [node for node in ast.walk(tree) if type(node) is type(piece) and ast.dump(node) == ast.dump(piece)]
    return _Change(found[0], instead) if len(found) == 1 else None


def _parsed(text: str) -> ast.AST:
    (statement,) = ast.parse(dedent(text)).body
    return statement.value if isinstance(statement, ast.Expr) else statement


def _text_changed(tree: ast.AST, old: str, new: str) -> _Change | None:
    found = [node for node in _texts(tree) if old in node.value]
    if len(found) != 1 or found[0].value.count(old) != 1:
        return None
    return _Change(found[0], ast.Constant(found[0].value.replace(old, new)))


def _texts(tree: ast.AST) -> Iterator[ast.Constant]:
    return (node for node in ast.walk(tree) if isinstance(node, ast.Constant) and isinstance(node.value, str))
