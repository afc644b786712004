"""What `check` finds in published robots, as a table: `python tests/pinned_findings.py` writes it anew.

The file has for each robot the findings by code and severity, E, W or I, with their counts.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

from helpers.example_robots import all_paths
from helpers.other_robots import other_paths

from robodyn.checks.check import check_one
from robodyn.checks.rule import Finding

FILE = Path(__file__).parent / "data" / "check_findings.json"


def published() -> list[Path]:
    """Those of example-robot-data, and of the packages of `other_robots`."""
    return [*all_paths(), *other_paths()]


def name_of(path: Path) -> str:
    """The robot's folder and file, since several have one name; of iCub's, all called model, iCub and the folder."""
    return f"iCub/{path.parent.name}" if path.stem == "model" else f"{path.parent.parent.name}/{path.stem}"


def counts(findings: Iterable[Finding]) -> dict[str, int]:
    found = Counter(f"{one.code} {one.severity.name}" for one in findings)
    return dict(sorted(found.items()))


def pinned() -> dict[str, dict[str, int]]:
    table: dict[str, dict[str, int]] = json.loads(FILE.read_text(encoding="utf-8"))
    return table


def write() -> None:
    table = {name_of(path): counts(check_one(str(path))) for path in published()}
    lines = ",\n".join(f"  {json.dumps(name)}: {json.dumps(found)}" for name, found in sorted(table.items()))
    FILE.write_text(f"{{\n{lines}\n}}\n", encoding="utf-8")


if __name__ == "__main__":
    write()
