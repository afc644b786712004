"""Bring README.md and docs/ up to date: `python tests/make_docs.py [PAGE ...] [--benchmarks [NAME ...]]`.

Runs every command and every Python example and puts what they print in its place; regenerates the tables between
`<!-- begin: NAME -->` and `<!-- end: NAME -->`. Tables of timings only change with `--benchmarks`, all or those named,
which takes minutes and wants a quiet machine.
"""

from __future__ import annotations

import argparse
import re
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path

from helpers.doc_examples import ROOT, hand_written, regenerated
from helpers.doc_tables import steady_tables, timed_tables

MARK = re.compile(r"(<!-- begin: ([\w-]+) -->\n).*?(<!-- end: \2 -->)", re.DOTALL)


def with_tables(text: str, tables: Mapping[str, str]) -> str:
    """Return the text with these tables between their marks."""
    return MARK.sub(lambda found: found[1] + tables[found[2]] + found[3] if found[2] in tables else found[0], text)


def tables_in(text: str) -> dict[str, str]:
    """Return what stands between marks, by name."""
    return {found[2]: found[0][len(found[1]) : -len(found[3])] for found in MARK.finditer(text)}


def tables_of_all() -> dict[str, str]:
    """Return the tables of all pages, by name."""
    found: dict[str, str] = {}
    for page in hand_written():
        for name, text in tables_in(page.read_text(encoding="utf-8")).items():
            assert name not in found, f"{page}: there is another table {name}"
            found[name] = text
    return found


def main() -> None:
    """Rewrite the pages that are not up to date."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    timed = timed_tables()
    parser.add_argument("pages", nargs="*", type=Path, metavar="PAGE", help="only these; default: all")
    parser.add_argument("--benchmarks", nargs="*", choices=timed, metavar="NAME", help="measure tables of timings too")
    arguments = parser.parse_args()
    asked = arguments.benchmarks
    chosen = {name: make for name, make in timed.items() if asked is not None and (not asked or name in asked)}
    makers = {**steady_tables(), **chosen}
    for page in [path.resolve() for path in arguments.pages] or hand_written():
        before = page.read_text(encoding="utf-8")
        text = with_tables(before, {name: makers[name]() for name in tables_in(before) if name in makers})
        with tempfile.TemporaryDirectory() as folder:
            text = regenerated(text, Path(folder))
        if text != before:
            page.write_text(text, encoding="utf-8")
            print(f"changed: {page.relative_to(ROOT)}", file=sys.stderr)


if __name__ == "__main__":
    main()
