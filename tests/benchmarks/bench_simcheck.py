"""`robodyn check` beside simcheck: `cd tests && python -m benchmarks.bench_simcheck`.

simcheck's command must be on the path (pip install simcheck mujoco pybullet, in an environment of its own). Both are
given the same files in the same run:

- Every defect that the tests plant, in the small robot and in published ones. What counts is what is said with the
  defect and not without it, whatever the numbers in it. A defect is *named* where the rule that it is planted for finds
  it, or where simcheck has words for it; there is *something* where there is a warning or an error of another kind at
  the link or joint or at a neighbour of it, or a refusal. simcheck's static checks run on the small robot and on
  published ones whose meshes take it seconds, its engines on the small one.
- Published descriptions as they are, one in so many (`--every`) and the clean ones: errors, warnings, and the files
  that fail; the engines run on those that are timed.
- Time: the best of several turns for each of some clean ones, in one process, without its start.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cache, partial
from itertools import islice
from pathlib import Path
from statistics import median
from typing import NamedTuple
from zlib import crc32

from benchmarks.bench_check import times
from benchmarks.timing import in_turns
from checks.mirror.test_planted_twins import KINDS, ROBOTS
from checks.mirror.test_planted_twins import planted as planted_twins
from checks.rules.test_planted_in_real import OTHER_UNIT, PLANTS, UNITS, drawn
from checks.test_check_real_robots import CLEAN
from helpers.example_robots import path_of
from helpers.importers import packages
from helpers.machine import machine
from helpers.markdown_tables import main, table
from helpers.planted_defects import DEFECTS, HEALTHY
from helpers.planted_ros import NEIGHBOURS, PLANTED, texts_of, write
from helpers.urdfdom import check_urdf, refused
from pinned_findings import published

from robodyn.checks.catalogue import BY_CODE
from robodyn.checks.check import Options, check_one, select_findings
from robodyn.checks.rule import Finding, Severity

STATIC = ("--static-only",)


def unnumbered(text: str) -> str:
    """Return what a message says, whatever the numbers."""
    return re.sub(r"\d[\d.e+-]*", "#", text)


class Said(NamedTuple):
    """One finding."""

    check: str
    severity: str
    target: str
    message: str

    @property
    def words(self) -> str:
        return f"{self.check}: {self.message}"

    @property
    def key(self) -> str:
        """What it says, whatever the numbers."""
        return unnumbered(f"{self.severity} {self.target} {self.words}")

    def names(self, names: frozenset[str]) -> bool:
        return bool(names & {*self.target.split("|"), *re.findall(r"'([^']+)'", self.message)})


class Verdict(NamedTuple):
    """What it says of a file, and how long it took [s]."""

    said: tuple[Said, ...]
    seconds: float


def version() -> str:
    """Its version and its engines', as it prints them."""
    lines = subprocess.run(["simcheck", "doctor"], capture_output=True, text=True, check=False).stdout.splitlines()
    engines = [" ".join(line.split()[:2]) for line in lines if line.endswith("(engine)")]
    return f"{lines[0]} with {' and '.join(engines) or 'no engine'}"


def verdicts(files: Sequence[Path], *options: str, packages: Mapping[str, str] | None = None) -> dict[Path, Verdict]:
    """Return its verdicts, of one process for all files. A file that it says nothing of is missing."""
    given = [f"--package-path={name}={folder}" for name, folder in (packages or {}).items()]
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "report.json"
        fixed = ["simcheck", "check", "--no-config", "--jobs=1", "--quiet", "--no-cache", "--json", str(report)]
        done = subprocess.run(
            [*fixed, *given, *options, "--", *map(str, files)], capture_output=True, text=True, check=False
        )
        if not report.exists():
            raise RuntimeError(f"simcheck failed: {done.stderr[-300:]}")
        assets = json.loads(report.read_text(encoding="utf-8"))
    listed = assets if isinstance(assets, list) else [assets]
    found = {}
    for asset in listed:
        findings = [one for result in asset["results"] for one in result["findings"]]
        said = [Said(*(one[key] for key in ("check", "severity", "target", "message"))) for one in findings]
        found[Path(asset["asset"])] = Verdict(tuple(said), float(asset["stats"]["seconds"]))
    return found


PRECISE = {
    "RD001": r"XML parse error",
    "RD002": r"undefined entity|DOCTYPE|DTD",
    "RD003": r"unbound prefix",
    "RD004": r"xacro|unbound prefix",
    "RD005": r"repeated element|unknown|unrecognized|not recognized",
    "RD006": r"\biyx|\bizx|\bizy",
    "RD007": r"unreadable|not a (finite )?number|not finite|NaN|needs \d|needs radius|without a valid|bad format"
    r"|attribute missing|infinite|no damping and no friction",
    "RD010": r"version",
    "RD101": r"missing link",
    "RD102": r"more than one parent",
    "RD103": r"cycle",
    "RD104": r"root links",
    "RD105": r"duplicate link",
    "RD106": r"duplicate joint",
    "RD107": r"no name|unnamed|not named",
    "RD108": r"\btype\b",
    "RD110": r"names?\b.*(slash|digit|same|character)",
    "RD111": r"kinematics.attached",
    "RD112": r"kinematics.attached",
    "RD113": r"geometry.scale|authored in|\bunits?\b",
    "RD201": r"explicit mass",
    "RD202": r"no <inertial>|mass is zero",
    "RD203": r"unreadable (mass|inertia)|all-zero inertia|no <inertial>|mass is zero",
    "RD204": r"all-zero inertia|mjMINVAL",
    "RD205": r"mass is zero|explicit mass",
    "RD206": r"not positive definite",
    "RD207": r"triangle inequality",
    "RD208": r"placeholder|default|copied",
    "RD209": r"tiny|smaller than a solid",
    "RD210": r"joins parts of",
    "RD213": r"twice|again",
    "RD214": r"no <inertial>",
    "RD301": r"too large for its geometry",
    "RD302": r"centre of mass is .* outside",
    "RD303": r"smaller than a solid",
    "RD304": r"inertia.density",
    "RD305": r"\bunits?\b",
    "RD404": r"mirror|twin|opposite",
    "RD405": r"mirror|twin|opposite",
    "RD501": r"zero axis",
    "RD502": r"axis has length",
    "RD503": r"is above upper",
    "RD504": r"has no lower/upper|lower == upper|joints.limits: .* range is",
    "RD505": r"no <limit>",
    "RD506": r"(effort|velocity) limit|no (effort|velocity)|limit.*(effort|velocity)",
    "RD507": r"degrees|\bdeg\b",
    "RD508": r"\bsoft\b|safety",
    "RD509": r"negative damping or friction",
    "RD510": r"mimics missing|missing: 'joint'",
    "RD511": r"mimics itself|mimic (cycle|loop)|repeated in equality",
    "RD512": r"joints.mimic: .*(range|limit)",
    "RD513": r"continuous joint",
    "RD514": r"no axis|has no <axis>",
    "RD515": r"joints.limits: .*travels|(velocity|effort) limit|\bunits?\b",
    "RD516": r"\brevolute\b|\bprismatic\b",
    "RD601": r"mesh .*not found|unreadable mesh",
    "RD603": r"outside|escapes",
    "RD606": r"must be positive|scale|without a valid size",
    "RD608": r"<geometry> is missing",
    "RD609": r"geometry.visual_match",
    "RD610": r"overlap|start inside|interpenetrat",
    "RD611": r"\bflat\b|zero volume|no volume|kg/m\^3|coplanar|volume.* too small",
    "RD621": r"material",
    "RD622": r"colou?r|rgba",
    "RD623": r"texture",
    "RD701": r"reference|ros2_control|transmission|plugin",
    "RD702": r"ros2_control|command_interface|state_interface",
    "RD703": r"transmission|reduction",
    "RD704": r"ros2_control|\bmin\b.*\bmax\b",
    "RD705": r"ros2_control",
    "RD706": r"srdf",
    "RD707": r"srdf|group",
    "RD708": r"srdf|group",
    "RD709": r"srdf|adjacent|disable_collisions",
    "RD801": r"torque|effort",
    "RD803": r"effort",
    "RD804": r"damping",
}


def precise(code: str, words: str) -> bool:
    pattern = PRECISE.get(code)
    return pattern is not None and re.search(pattern, words, re.IGNORECASE) is not None


ELEMENT = re.compile(r"<(link|joint)\s[^>]*?/>|<(link|joint)\s.*?</\2>", re.DOTALL)
NAME = re.compile(r"\bname\s*=\s*[\"']([^\"']*)[\"']")
ENDS = re.compile(r"<(?:parent|child)\s[^>]*\blink\s*=\s*[\"']([^\"']*)[\"']")
SMALL_ROBOT = "small robot"
UNREAD = "${not read}"
"""Stands in the small robot where nobody reads it; other programs take the file for a xacro by it."""


class Case(NamedTuple):
    """A defect planted in a robot, and its rule: the texts of description and SRDF before and after."""

    code: str
    robot: str
    before: tuple[str, str]
    after: tuple[str, str]
    packages: tuple[tuple[str, str], ...] = ()

    @property
    def about(self) -> frozenset[str]:
        """Names of the links and joints whose text is another, of the links that such a joint joins, and of the joints
        at such a link; empty if it is about none."""
        old, new = elements(self.before[0]), elements(self.after[0])
        changed = {name for name in old.keys() | new.keys() if old.get(name) != new.get(name)}
        ends = {name: ENDS.findall(old.get(name, "") + new.get(name, "")) for name in old.keys() | new.keys()}
        near = {one for name in changed for one in ends[name]}
        beside = {name for name, links in ends.items() if changed.intersection(links)}
        return frozenset(changed | near | beside)


def elements(text: str) -> dict[str, str]:
    """Return the texts of links and joints by name."""
    found: dict[str, str] = {}
    for element in ELEMENT.finditer(text):
        name = NAME.search(element[0])
        found[name[1] if name else ""] = found.get(name[1] if name else "", "") + element[0]
    return found


def small() -> Iterator[Case]:
    """Those of the small robot, which needs no other files."""
    before = HEALTHY.replace(UNREAD, "not read")
    for defect in DEFECTS:
        yield Case(defect.code, SMALL_ROBOT, (before, ""), (defect.text.replace(UNREAD, "not read"), ""))


def real() -> Iterator[Case]:
    """Those of links, joints and masses, of all lengths, of twins, and of what ROS reads, in published robots."""
    for plant in PLANTS:
        before = plant.path.read_text(encoding="utf-8")
        yield Case(plant.code, plant.robot, (before, ""), (plant.text, ""), _packages(plant.robot))
    for robot in OTHER_UNIT:
        before = path_of(robot).read_text(encoding="utf-8")
        for factor in UNITS:
            yield Case("RD113", robot, (before, ""), (drawn(before, factor), ""), _packages(robot))
    for kind, code in KINDS.items():
        for robot in ROBOTS:
            before = path_of(robot).read_text(encoding="utf-8")
            for _, text in islice(planted_twins(robot, kind), 1):
                yield Case(code, robot, (before, ""), (text.decode(), ""), _packages(robot))
    for each in (*PLANTED, NEIGHBOURS):
        for robot in each.robots:
            texts = texts_of(robot)
            yield Case(each.code, robot, texts, each.edit(*texts), _packages(robot))


def _packages(robot: str) -> tuple[tuple[str, str], ...]:
    return tuple(packages(path_of(robot)).items())


def files(case: Case, folder: Path) -> tuple[Path, Path]:
    """Write the case's files, and return the paths of the description before and after."""
    names = (f"{case.robot}-{crc32(''.join(texts).encode()):08x}" for texts in (case.before, case.after))
    before, after = (write(folder / name, texts) for name, texts in zip(names, (case.before, case.after), strict=True))
    return before, after


NAMED, SOMETHING, SILENT = "named", "something", "silent"
VERDICTS = (NAMED, SOMETHING, SILENT)
Paths = tuple[Path, Path]
"""A description as it was, and with a defect."""


@cache
def _known(path: Path, packages: tuple[str, ...]) -> Counter[tuple[str, ...]]:
    return Counter(map(_key, check_one(str(path), Options(package_path=packages))))


def _key(one: Finding) -> tuple[str, ...]:
    return one.code, one.subject.name if one.subject else "", unnumbered(one.message)


def by_robodyn(case: Case, paths: Paths) -> str:
    """Judge all that it finds, remarks among it."""
    packages = tuple(str(Path(folder).parent) for _, folder in case.packages)
    found = check_one(str(paths[1]), Options(package_path=packages))
    fresh = Counter(map(_key, found)) - _known(paths[0], packages)
    if any(code == case.code for code, *_ in fresh):
        return NAMED
    about, worse = case.about, {_key(one) for one in found if one.severity is not Severity.NOTE}
    return SOMETHING if any(not about or key[1] in about for key in worse & fresh.keys()) else SILENT


def of_simcheck(case: Case, before: Verdict, after: Verdict) -> str:
    """Judge all that it says, remarks among it."""
    known, about = {one.key for one in before.said}, case.about
    fresh = [one for one in after.said if one.key not in known]
    placed = [one for one in fresh if not about or not one.target or one.names(about)]
    if any(precise(case.code, one.words) for one in placed):
        return NAMED
    return SOMETHING if any(one.severity != "info" for one in placed) else SILENT


def by_simcheck(cases: Sequence[Case], paths: Sequence[Paths], which: Iterable[int], *options: str) -> dict[int, str]:
    """Return what it makes of these of the cases, by their numbers; one process for each robot."""
    judged: dict[int, str] = {}
    by_robot: dict[str, list[int]] = {}
    for k in which:
        by_robot.setdefault(cases[k].robot, []).append(k)
    for robot, numbers in by_robot.items():
        wanted = dict.fromkeys(path for k in numbers for path in paths[k])
        found = verdicts([*wanted], *options, packages=dict(cases[numbers[0]].packages))
        judged.update({k: of_simcheck(cases[k], *(found[path] for path in paths[k])) for k in numbers})
        print("simcheck", *options, robot, len(numbers), file=sys.stderr, flush=True)
    return judged


def by_check_urdf(paths: Paths) -> str:
    """Judge urdfdom's program: it reads up to a fault, and refuses the file or takes it."""
    return SOMETHING if refused(paths[1]) and not refused(paths[0]) else SILENT


def of_robots(cases: Sequence[Case], robots: Sequence[str] = ()) -> list[int]:
    """Return the numbers of those in the small robot, and in these published ones."""
    return [k for k, case in enumerate(cases) if case.robot in (SMALL_ROBOT, *robots)]


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
