"""What `robodyn check` finds in the robots of installed packages: `cd tests && python -m benchmarks.audit_robots`.

Every URDF, and every xacro file that makes a robot, of installed packages: by package and by rule, and each error
with a witness, the number that condemns it, which `benchmarks/witness.py` recomputes from the file without
robodyn; the file that it takes is named at the end. `--list 40` adds so many findings, spread evenly over all, for
judging them by hand.
"""

from __future__ import annotations

import importlib.metadata
import json
import os
import re
import sys
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path
from statistics import median
from tempfile import mkdtemp

from benchmarks.witness import witness
from helpers.markdown_tables import main, table

from robodyn.checks.catalogue import BY_CODE
from robodyn.checks.check import Checked, check_tasks, tasks_for
from robodyn.checks.rule import Finding, Severity
from robodyn.robot.urdf.sources import is_xacro
from robodyn.robot.urdf.xacro import expanded

CONDEMNS = {
    "RD201": "mass, kg",
    "RD202": "mass of the rigid group, kg",
    "RD204": "radius of gyration, m",
    "RD206": "smallest by largest moment",
    "RD207": "two smaller by largest moment",
    "RD301": "times what its reach allows",
    "RD302": "distance by size of its shapes",
    "RD510": "joints of that name",
    "RD601": "files there",
    "RD701": "elements of that name",
}
"""Rules whose errors have a witness, and what it is."""
KINDS = (".urdf", ".xacro", ".stl", ".dae", ".obj")
NAMED = re.compile(r"(there is no [a-z ]*|mimics joint |the mesh )'([^']+)'")


def installed() -> dict[str, Path]:
    """Return the folders of descriptions and meshes of installed packages, by the package's name."""
    found = {}
    for package in importlib.metadata.distributions():
        files = [Path(str(file.locate())).resolve() for file in package.files or [] if file.suffix.lower() in KINDS]
        if any(file.suffix in (".urdf", ".xacro") for file in files):
            found[package.name] = Path(os.path.commonpath([file.parent for file in files]))
    return dict(sorted(found.items(), key=lambda item: item[0].lower()))


def errors_of(package: str, folder: Path, checked: Checked, scratch: Path) -> Iterator[dict[str, str]]:
    """Yield the errors with a witness at every place, as `witness` takes them."""
    for one in (each for finding in checked.findings for each in finding.places):
        if one.severity is Severity.ERROR and one.code in CONDEMNS and one.subject is not None:
            file = Path(one.robots[0] if one.robots else one.checked)
            if is_xacro(str(file)):
                text = expanded(str(file), (str(folder),)).text
                file = scratch / f"{file.stem}-{len(text)}.urdf"
                file.write_bytes(text)
            named = NAMED.search(one.message)
            yield {
                "robot": f"{package}: {Path(one.checked).stem}",
                "rule": one.code,
                "name": one.subject.name,
                "kind": named[1] if named else "",
                "names": named[2] if named else "",
                "at": f"{Path(one.file).name}:{one.line}",
                "says": one.message,
                "file": str(file),
                "folder": str(folder),
            }


def robots_of(finding: Finding) -> set[str]:
    """Return the descriptions that have it, since findings that are equal in several are one."""
    return {robot for place in finding.places for robot in place.robots or (place.checked,)}


def by_package(audited: dict[str, Checked]) -> str:
    head = ("package", "descriptions", "errors", "warnings", "median of both", "without any", "not readable")
    rows = []
    for package, checked in audited.items():
        each = Counter(robot for one in checked.findings for robot in robots_of(one))
        counts = [each[file] for file in checked.files] or [0]
        kinds = (checked.count(kind) for kind in (Severity.ERROR, Severity.WARNING))
        more = (f"{median(counts):g}", str(counts.count(0)), str(len(checked.unread)))
        rows.append((package, str(len(checked.files)), *map(str, kinds), *more))
    return table(head, rows)


def by_rule(findings: Iterable[Finding]) -> str:
    found = list(findings)
    columns = (
        Counter(one.code for one in found if one.severity is Severity.ERROR),
        Counter(one.code for one in found if one.severity is not Severity.ERROR),
        Counter(one.code for each in found for one in each.places),
        Counter(code for code, _ in {(one.code, robot) for one in found for robot in robots_of(one)}),
    )
    order = sorted(columns[2], key=lambda code: (-columns[0][code], -columns[1][code], code))
    rows = [(f"{code} {BY_CODE[code].name}", *(str(column[code] or "-") for column in columns)) for code in order]
    return table(("rule", "errors", "warnings", "places", "robots"), rows)


def by_witness(errors: Iterable[dict[str, str]]) -> str:
    """Return the errors of a robot and rule in a row, with the witness that is worst."""
    worst: dict[tuple[str, str], list[tuple[float, dict[str, str]]]] = {}
    for error in errors:
        worst.setdefault((error["robot"], error["rule"]), []).append((float(witness(error)), error))
    rows = []
    for (robot, code), found in sorted(worst.items()):
        number, error = (max if code in ("RD301", "RD302") else min)(found, key=lambda pair: pair[0])
        what = f"{number:.3g} {CONDEMNS[code]}"
        rows.append((robot, code, error["names"] or error["name"], error["at"], what, str(len(found))))
    return table(("robot", "rule", "worst at", "line", "witness", "places"), rows, left=(0, 1, 2, 3, 4))


def report(list: int) -> str:
    folders, scratch = installed(), Path(mkdtemp(prefix="audit-"))
    audited = {package: check_tasks(tasks_for([str(folder)])) for package, folder in folders.items()}
    errors = [
        one for package, checked in audited.items() for one in errors_of(package, folders[package], checked, scratch)
    ]
    (scratch / "audit.json").write_text(json.dumps(errors, indent=1))
    print(f"the errors, for witness.py: {scratch / 'audit.json'}", file=sys.stderr)
    findings = [one for checked in audited.values() for one in checked.findings]
    text = "\n".join((by_package(audited), by_rule(findings), by_witness(errors)))
    if not list:
        return text
    chosen = [findings[(k * len(findings)) // list] for k in range(min(list, len(findings)))]
    shown = (
        f"{one.checked}:{one.line} {one.severity.value} {one.code} ({len(one.places)}): {one.message}\n"
        for one in chosen
    )
    return f"{text}\n{''.join(shown)}"


if __name__ == "__main__":
    main(report, __doc__, list=0)
