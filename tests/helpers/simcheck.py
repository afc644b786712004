"""simcheck, whose command has to be on the path: what it finds in descriptions, in which time, its words for defects.

It is no dependency of the tests: benchmarks hold it beside `robodyn check`.
"""

from __future__ import annotations

import json
import re
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

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
