"""`robodyn check` beside simcheck: `cd tests && python -m benchmarks.bench_simcheck`.

simcheck's command must be on the path (pip install simcheck mujoco pybullet, in an environment of its own). Both are
given the same files in the same run:

- Every defect that the tests plant, in the small robot and in published ones, judged as `helpers/judged.py` says. Its
  static checks run on the small robot and on published ones whose meshes take it seconds, its engines on the small one.
- Published descriptions as they are, one in so many (`--every`) and the clean ones: errors, warnings, and the files
  that fail; the engines run on those that are timed.
- Time: the best of several turns for each of some clean ones, in one process, without its start.
"""

from __future__ import annotations

import tempfile
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from statistics import median

from benchmarks.bench_check import times
from benchmarks.timing import in_turns
from checks.test_check_real_robots import CLEAN
from helpers.judged import NAMED, VERDICTS, Case, by_check_urdf, by_robodyn, by_simcheck, files, of_robots, real, small
from helpers.machine import machine
from helpers.markdown_tables import main, table
from helpers.simcheck import STATIC, Verdict, verdicts, version
from helpers.urdfdom import check_urdf
from pinned_findings import published

from robodyn.checks.catalogue import BY_CODE
from robodyn.checks.check import Options, check_one, select_findings

TIMED = ("go2", "xarm7", "kinova")
"""Clean robots whose meshes are of middling size."""
QUICK = (*TIMED, "panda", "ur5_robot", "talos_full_v2", "tiago_no_hand", "hyq_no_sensors", "pr2")
"""Robots in which planted defects are given to simcheck."""
OURS, PLAIN, ENGINES = "robodyn check", "simcheck, static", "simcheck, engines"
Judged = Mapping[str, Mapping[int, str]]
"""By program, what it makes of the defects, by their numbers."""


def planted(cases: Sequence[Case], engines: bool) -> str:
    with tempfile.TemporaryDirectory() as folder:
        paths = [files(case, Path(folder)) for case in cases]
        judged = {OURS: {k: by_robodyn(case, paths[k]) for k, case in enumerate(cases)}}
        if check_urdf():
            judged["check_urdf"] = {k: by_check_urdf(pair) for k, pair in enumerate(paths)}
        judged[PLAIN] = by_simcheck(cases, paths, of_robots(cases, QUICK), *STATIC)
        if engines:
            judged[ENGINES] = by_simcheck(cases, paths, of_robots(cases))
    return f"{in_all(cases, judged)}\n{by_rule(cases, judged)}"


def in_all(cases: Sequence[Case], judged: Judged) -> str:
    """Return how many each program names, of the same defects."""
    rows = []
    for numbers in sorted({frozenset(verdict) for verdict in judged.values()}, key=len, reverse=True):
        for name, verdict in judged.items():
            if numbers <= verdict.keys():
                counted = Counter(verdict[k] for k in numbers)
                share = f"{100 * counted[NAMED] / len(numbers):.0f} %"
                rows.append(
                    (f"{len(numbers)} of {len(cases)}", name, *(str(counted[each]) for each in VERDICTS), share)
                )
    return table(("planted defects", "program", *VERDICTS, "share named"), rows, left=(0, 1))


def by_rule(cases: Sequence[Case], judged: Judged) -> str:
    """Return for each rule what each program makes of its defects."""
    rows = []
    for code in sorted({case.code for case in cases}):
        numbers = [k for k, case in enumerate(cases) if case.code == code]
        counts = (Counter(verdict[k] for k in numbers if k in verdict) for verdict in judged.values())
        cells = (" / ".join(str(counted[each]) for each in VERDICTS) for counted in counts)
        rows.append((f"{code} {BY_CODE[code].name}", *cells))
    return table((f"{' / '.join(VERDICTS)}, by rule", *judged), rows)


def chosen(every: int) -> list[Path]:
    """Return one in so many of the published descriptions, and the clean ones."""
    return [path for k, path in enumerate(published()) if k % every == 0 or path.stem in CLEAN]


def alarms(paths: Sequence[Path], engines: bool) -> str:
    """Return what each program finds in published robots as they are, remarks left out."""
    found = {OURS: {path: _shown(path) for path in paths}, PLAIN: _said(verdicts(paths, *STATIC))}
    if engines:
        found[ENGINES] = _said(verdicts([path for path in paths if path.stem in TIMED]))
    rows = []
    for name, counts in found.items():
        failed = {path for path, each in counts.items() if each["error"]}
        clean = {path for path in counts if path.stem in CLEAN}
        errors, warnings = ([each[kind] for each in counts.values()] for kind in ("error", "warning"))
        both = median(map(sum, zip(errors, warnings, strict=True)))
        ends = f"{len(failed)} of {len(counts)}", f"{len(failed & clean)} of {len(clean)}"
        rows.append((name, str(sum(errors)), str(sum(warnings)), f"{both:g}", *ends))
    return table(
        ("published robots", "errors", "warnings", "median of both", "files that fail", "clean ones that fail"), rows
    )


def _shown(path: Path) -> Counter[str]:
    return Counter(one.severity.value for one in select_findings(check_one(str(path)), Options()).shown)


def _said(found: Mapping[Path, Verdict]) -> dict[Path, Counter[str]]:
    return {path: Counter(one.severity for one in verdict.said) for path, verdict in found.items()}


def timed(paths: Sequence[Path], turns: int) -> str:
    """Return the time of each program per robot, both in each turn; simcheck's is that which it reports."""
    with tempfile.TemporaryDirectory() as folder:
        ways: dict[str, Callable[[], list[float]]] = {
            f"{OURS}, meshes known": partial(times, paths, folder),
            f"{OURS}, meshes read anew": partial(times, paths, "0"),
            PLAIN: partial(_seconds, paths, *STATIC),
        }
        rounds = in_turns(ways, turns)
    best = {name: [min(robot) for robot in zip(*found, strict=True)] for name, found in rounds.items()}
    base = sum(best[f"{OURS}, meshes read anew"])
    rows = [
        (name, f"{1e3 * median(each):.0f} ms", f"{1e3 * max(each):.0f} ms", f"{sum(each) / base:.2g}")
        for name, each in best.items()
    ]
    return table((f"{len(paths)} robots, one process, best of {turns}", "median", "worst", "ratio of sums"), rows)


def _seconds(paths: Sequence[Path], *options: str) -> list[float]:
    found = verdicts(paths, *options)
    return [found[path].seconds for path in paths]


def report(turns: int, engines: int, every: int) -> str:
    cases = [*small(), *real()]
    parts = (
        f"{version()}.\n",
        planted(cases, bool(engines)),
        alarms(chosen(every), bool(engines)),
        timed([path for path in published() if path.stem in TIMED], turns),
        machine(),
    )
    return "\n".join(parts)


if __name__ == "__main__":
    main(report, __doc__, turns=2, engines=1, every=16)
