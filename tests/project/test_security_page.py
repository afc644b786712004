"""The page on security says what holds: the limits by their table, the paths that it names."""

from __future__ import annotations

import ast
import re
from collections import Counter
from dataclasses import fields
from itertools import pairwise
from pathlib import Path

from robodyn.support import input_file
from robodyn.support.input_file import VARIABLE, InputLimits

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / ".github" / "SECURITY.md").read_text()


def _explained() -> dict[str, str]:
    """What is written below each limit."""
    tree = ast.parse(Path(input_file.__file__).read_text())
    body = next(node.body for node in tree.body if isinstance(node, ast.ClassDef))
    found = {}
    for line, below in pairwise(body):
        if isinstance(line, ast.AnnAssign) and isinstance(below, ast.Expr):
            found[ast.unparse(line.target)] = " ".join(ast.literal_eval(below.value).split()).rstrip(".")
    return found


def test_every_limit_is_there() -> None:
    rows = re.findall(r"^\| `(\w+)` \| (\d+) \| (.+) \|$", PAGE, re.MULTILINE)
    what = _explained()
    assert [tuple(row) for row in rows] == [
        (each.name, str(each.default), what[each.name]) for each in fields(InputLimits)
    ]


def test_every_limit_is_used() -> None:
    words = Counter(word for path in (ROOT / "robodyn").rglob("*.py") for word in re.findall(r"\w+", path.read_text()))
    assert [each.name for each in fields(InputLimits) if words[each.name] < 2] == []  # once stands in the table


def test_what_it_names_is_there() -> None:
    for path in re.findall(r"`(tests/[\w/.]+)`", PAGE):
        assert (ROOT / path).exists(), path
    for link, anchor in re.findall(r"\]\(\.\./([\w/.]+)#([\w-]+)\)", PAGE):
        headings = re.findall(r"^#+ (.*)$", (ROOT / link).read_text(), re.MULTILINE)
        assert anchor in [heading.lower().replace(" ", "-") for heading in headings]
    assert "(.github/SECURITY.md)" in (ROOT / "CONTRIBUTING.md").read_text()
    assert f"`{VARIABLE}`" in (ROOT / "docs" / "reference" / "environment.md").read_text()
