"""Pairs of descriptions of one robot, and conversions: `cd tests && python -m benchmarks.audit_formats`.

1. Pairs that packages bring: files of one name in two formats of a package, and robots of example-robot-data beside
   those of robosuite. For each what `robodyn diff` says: the largest difference of torque, at which joint, what is
   guilty, and why.
2. Conversions of every robot of example-robot-data, without shapes, into MJCF: by robodyn, MuJoCo's own import and
   truerig, each read again and held against the source at random motions: how many keep the torques to 1e-12, 1e-6 and
   1e-2 of the largest of each joint.

Packages that are not installed are left out.
"""

from __future__ import annotations

import importlib.metadata
import re
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path

from helpers.command_line import run
from helpers.example_robots import PATHS
from helpers.markdown_tables import main, table

import robodyn
from robodyn.comparison.compare import Comparison
from robodyn.support.extras import available

SUFFIXES = (".urdf", ".xml", ".sdf")
ACROSS = {"panda": "panda", "xarm7": "xarm7", "baxter": "baxter", "kinova": "kinova3", "tiago_dual": "tiago"}
"""Robots of example-robot-data, and those of robosuite that they should be."""
LEVELS = (1e-12, 1e-6, 1e-2)


def pairs() -> Iterator[tuple[str, Path, Path]]:
    """Yield what it is, and both files."""
    for package in sorted(importlib.metadata.distributions(), key=lambda one: one.name.lower()):
        found: dict[str, list[Path]] = {}
        for file in package.files or []:
            path = Path(str(file.locate()))
            if file.suffix in SUFFIXES and "testdata" not in file.parts and path.is_file():
                text = path.read_bytes()[:4000]
                if file.suffix != ".xml" or b"<mujoco" in text:
                    found.setdefault(path.stem.lower(), []).append(path)
            if package.name == "robosuite" and file.name == "robot.xml":
                for name, theirs in ACROSS.items():
                    mine = next((path for path in PATHS if path.stem == name), None)
                    if theirs == path.parent.name and mine is not None:
                        yield f"{name}: example-robot-data, robosuite", mine, path
        for paths in found.values():
            by_suffix = {path.suffix: path for path in paths}
            if len(by_suffix) > 1:
                one, other = [by_suffix[suffix] for suffix in SUFFIXES if suffix in by_suffix][:2]
                yield (
                    f"{one.stem}: {package.name}, URDF and {other.suffix[1:].upper().replace('XML', 'MJCF')}",
                    one,
                    other,
                )


def compared(name: str, one: Path, other: Path) -> tuple[str, ...]:
    try:
        found = robodyn.compare(robodyn.load(one), robodyn.load(other))
    except robodyn.RobodynError as error:
        return name, "-", "-", "-", getattr(error, "what", str(error))
    worst = found.worst
    kinds = ", ".join(dict.fromkeys(each.kind for each in found.differences)) or "none"
    if worst is None or not worst.exceeds(None):
        return name, "none" if worst is not None else "not compared", "-", "-", kinds
    guilty = worst.difference
    what = "-" if guilty is None else f"{guilty.kind} of {guilty.name or 'the scene'} ({100 * worst.explains:.0f} %)"
    why = guilty.cause if guilty is not None else ""
    return name, f"{worst.worst:.3g} {worst.unit} at {worst.joint}", what, why or "-", kinds


def by_robodyn(source: Path, target: Path) -> None:
    assert run("convert", str(source), "--to", "mjcf", "--out", str(target)).status == 0


IMPORT = (
    "import mujoco, sys; spec = mujoco.MjSpec.from_file(sys.argv[1]); spec.compile();"
    "open(sys.argv[2], 'w').write(spec.to_xml())"
)


def by_mujoco(source: Path, target: Path) -> None:
    subprocess.run(
        [sys.executable, "-c", IMPORT, str(source), str(target)], check=True, capture_output=True, timeout=120
    )


def by_truerig(source: Path, target: Path) -> None:
    call = [sys.executable, "-m", "truerig.cli", "convert", str(source), str(target)]
    subprocess.run(call, check=True, capture_output=True, timeout=120)


CONVERTERS: dict[str, Callable[[Path, Path], None]] = {"robodyn": by_robodyn, "MuJoCo's import": by_mujoco}


def worst_share(found: Comparison) -> float:
    return max((one.worst / one.largest if one.largest else float(one.worst > 0) for one in found.torques), default=0.0)


def conversions() -> str:
    makers = CONVERTERS | ({"truerig": by_truerig} if available("truerig") else {})
    rows = []
    for name, make in makers.items():
        counts, refused, worse = [0, 0, 0], 0, 0
        for path in PATHS:
            with tempfile.TemporaryDirectory() as folder:
                plain, target = Path(folder) / path.name, Path(folder) / "converted.xml"
                text = path.read_text(encoding="utf-8")
                plain.write_text(
                    re.sub(r"<(visual|collision)\b.*?</\1>|<(visual|collision)[^>]*/>", "", text, flags=re.S)
                )
                try:
                    make(plain, target)
                    share = worst_share(robodyn.compare(robodyn.load(plain), robodyn.load(target)))
                except Exception:
                    refused += 1
                    continue
            reached = [k for k, level in enumerate(LEVELS) if share <= level]
            if reached:
                counts[reached[0]] += 1
            else:
                worse += 1
        rows.append((name, *map(str, counts), str(worse), str(refused)))
    head = ("converter", "within 1e-12", "within 1e-6", "within 1e-2", "worse", "refused, or its file is")
    return f"{len(PATHS)} robots of example-robot-data without shapes, into MJCF.\n\n{table(head, rows)}"


def report() -> str:
    warnings.simplefilter("ignore")
    rows = [compared(*each) for each in pairs()]
    head = ("pair", "worst difference of torque", "guilty", "why", "what differs")
    return f"{table(head, rows, left=range(5))}\n{conversions()}"


if __name__ == "__main__":
    main(report, __doc__)
