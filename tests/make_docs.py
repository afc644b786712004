"""Bring README.md up to date: `python tests/make_readme.py [--benchmarks [NAME ...]]`.

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

from helpers.readme_examples import regenerated
from helpers.readme_tables import steady_tables, timed_tables

README = Path(__file__).parent.parent / "README.md"
MARK = re.compile(r"(<!-- begin: ([\w-]+) -->\n).*?(<!-- end: \2 -->)", re.DOTALL)


def with_tables(text: str, tables: Mapping[str, str]) -> str:
    """The text with these tables between their marks."""
    missing = tables.keys() - {name for _, name, _ in MARK.findall(text)}
    if missing:
        raise SystemExit(f"README.md has no mark for {', '.join(sorted(missing))}")
    return MARK.sub(lambda found: found[1] + tables[found[2]] + found[3] if found[2] in tables else found[0], text)


def tables_in(text: str) -> dict[str, str]:
    """What stands between marks, by name."""
    return {found[2]: found[0][len(found[1]) : -len(found[3])] for found in MARK.finditer(text)}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    timed = timed_tables()
    parser.add_argument("--benchmarks", nargs="*", choices=timed, metavar="NAME", help="measure tables of timings too")
    asked = parser.parse_args().benchmarks
    chosen = {name: make for name, make in timed.items() if asked is not None and (not asked or name in asked)}
    makers = {**steady_tables(), **chosen}
    tables = {name: make() for name, make in makers.items()}
    text = with_tables(README.read_text(encoding="utf-8"), tables)
    with tempfile.TemporaryDirectory() as folder:
        text = regenerated(text, Path(folder))
    README.write_text(text, encoding="utf-8")
    print(f"{README.name}: {', '.join(tables)} and every example are up to date", file=sys.stderr)


if __name__ == "__main__":
    main()
