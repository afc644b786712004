"""Markdown tables, and the command line that benchmarks share."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path


def table(head: Sequence[str], rows: Sequence[Sequence[str]], left: Sequence[int] = (0,)) -> str:
    """A table; the columns but those in `left` are aligned at their right."""
    rule = ["---" if k in left else "---:" for k in range(len(head))]
    return "\n".join(f"| {' | '.join(row)} |" for row in (head, rule, *rows)) + "\n"


def cells(text: str) -> list[list[str]]:
    """The rows of a table, without head and rule."""
    rows = [line.strip().strip("|").split("|") for line in text.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in row] for row in rows[2:]]


def main(report: Callable[..., str], description: str, **options: int) -> None:
    """Print what `report` returns and with `--write FILE` store it; `options` are whole numbers with their defaults."""
    parser = argparse.ArgumentParser(description=description.splitlines()[0])
    parser.add_argument("--write", type=Path, metavar="FILE", help="store what is printed")
    for name, default in options.items():
        parser.add_argument(f"--{name}", type=int, default=default, metavar="N", help=f"default {default}")
    arguments = vars(parser.parse_args())
    file = arguments.pop("write")
    text = report(**arguments)
    print(text, end="")
    if file:
        file.write_text(text, encoding="utf-8")
