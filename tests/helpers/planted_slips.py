"""Slips of people in published robots, drawn by chance, and what `check` says of them.

`data/planted_slips.json` has kinds of them and some changes that are none, each in up to four robots. They were written
from a list of what goes wrong (geometry and tree, inertia, joints, ROS, appearance, format) before the rules were read,
with what a finding must name: one of the `names` in its subject or message, and the cause, a pattern in its words.
Robots and links were drawn by chance, and the robots parted into halves A and B by a hash of their names: what went
unseen in A was looked at, B only counted.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from pinned_findings import name_of, published

from helpers.planted_ros import write
from robodyn.checks.catalogue import BY_CODE
from robodyn.checks.check import Options, check_one, select_findings
from robodyn.checks.rule import Finding

FILE = Path(__file__).parents[1] / "data" / "planted_slips.json"
NAMED, NEAR, UNSEEN = "named", "at its place only", "unseen"
HARMLESS = "harmless"
_QUOTED = re.compile(r"'([^']*)'")
_FIGURES = re.compile(r"[-+\d.e]+")

Said = tuple[str, str, str]
"""Code, subject and message of a place."""


class Slip(NamedTuple):
    """A slip: what is replaced in a description, or in its SRDF if that is named.

    Attributes:
        form: "bytes" for the text as it is, otherwise the elements are written anew first, so that lines are known.
        edits: from which line, what stands there, what is put in its place, and how many lines it takes.
        names: of what must be named; where there are none, a finding in `line` or beside it is meant.
        rule: which names it; `benchmarks.bench_slips --rules 1` writes them.
    """

    group: str
    kind: str
    robot: str
    half: str
    path: str
    form: str
    srdf: str
    edits: list[tuple[int, str, str, int]]
    names: list[str]
    cause: str
    line: int | None
    rule: str | None = None

    @property
    def urdf(self) -> Path:
        return _paths()[self.path]

    def __str__(self) -> str:
        return f"{self.kind}-{self.robot}"


class Outcome(NamedTuple):
    """What is new with a slip: how well it is named, what is said of something else, and the rule that names it."""

    verdict: str
    elsewhere: tuple[Finding, ...]
    rule: str | None


def slips() -> list[Slip]:
    return [Slip(**each) for each in json.loads(FILE.read_text(encoding="utf-8"))]


def outcome(slip: Slip, select: tuple[str, ...] = ()) -> Outcome:
    """Check the robot with and without the slip, by all rules or some, and judge the difference."""
    before = {said for one in _found(slip, select, planted=False) for said in _said(one)}
    alike = {(code, subject, _FIGURES.sub("#", words)) for code, subject, words in before}
    new = [(one, said) for one in _found(slip, select, planted=True) for said in _said(one) if said not in before]
    own = [(one, said) for one, said in new if _is_about(slip, one, said)]
    elsewhere = tuple(
        one
        for one, (code, subject, words) in new
        if not _is_about(slip, one, (code, subject, words)) and (code, subject, _FIGURES.sub("#", words)) not in alike
    )
    named = [one.code for one, said in own if re.search(slip.cause, _words(one, said), re.IGNORECASE)]
    return Outcome(NAMED if named else NEAR if own else UNSEEN, elsewhere, named[0] if named else None)


def by_its_rule(slip: Slip) -> Outcome:
    """What its rule alone finds, run with those that may explain its findings away, or be explained by them: these are
    what it finds among all rules, and what is shown of them."""
    assert slip.rule
    own = BY_CODE[slip.rule].explains
    others = (code for code, rule in BY_CODE.items() if code in own or slip.rule in rule.explains)
    return outcome(slip, (slip.rule, *others))


def _is_about(slip: Slip, one: Finding, said: Said) -> bool:
    if slip.names:
        return not {said[1], *_QUOTED.findall(said[2])}.isdisjoint(slip.names)
    return slip.line is not None and (abs(one.line - slip.line) <= 1 or one.code.startswith("RD00"))


def _words(one: Finding, said: Said) -> str:
    return " | ".join((one.name, said[2], one.cause or "", one.remedy or ""))


def _said(one: Finding) -> Iterator[Said]:
    for place in one.places or (one,):
        subject = place.subject or one.subject
        yield one.code, "" if subject is None else subject.name, place.message


def _found(slip: Slip, select: tuple[str, ...], *, planted: bool) -> tuple[Finding, ...]:
    if not planted and not slip.srdf:
        return _as_it_is(slip.path, select)
    urdf = slip.urdf.read_bytes()
    if not slip.srdf:
        data = urdf.decode() if slip.form == "bytes" else _anew(urdf)
        return _shown(
            check_one(_edited(slip, data).encode("utf-8", "surrogateescape"), Options(select), str(slip.urdf))
        )
    with TemporaryDirectory() as folder:
        srdf = _anew((slip.urdf.parent.parent / "srdf" / slip.srdf).read_bytes())
        path = write(Path(folder), (urdf.decode(), _edited(slip, srdf) if planted else srdf))
        return _shown(check_one(str(path), Options(select, package_path=(str(slip.urdf.parents[4]),))))


@cache
def _as_it_is(path: str, select: tuple[str, ...]) -> tuple[Finding, ...]:
    return _shown(check_one(str(_paths()[path]), Options(select)))


def _shown(found: Sequence[Finding]) -> tuple[Finding, ...]:
    """What is shown by default."""
    return tuple(select_findings(found, Options()).shown)


@cache
def _paths() -> dict[str, Path]:
    return {name_of(path): path for path in published()}


@cache
def _anew(data: bytes) -> str:
    from lxml import etree

    tree = etree.fromstring(data).getroottree()
    return str(etree.tostring(tree, encoding="utf-8", xml_declaration=True).decode())


def _edited(slip: Slip, text: str) -> str:
    lines = text.split("\n")
    for first, old, new, count in reversed(slip.edits):
        assert "\n".join(lines[first : first + count]) == old, f"{slip}: line {first + 1} is another one"
        lines[first : first + count] = new.split("\n")
    return "\n".join(lines)
