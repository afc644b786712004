"""Fixing every planted defect and every published robot: what is edited, that it is done once, who reads it then."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from functools import cache, partial
from pathlib import Path

import pytest
from helpers.peers import peer
from helpers.planted_defects import DEFECTS, SOUND
from helpers.sampled import sampled
from pinned_findings import name_of, published

from robodyn.checks.check import check_one
from robodyn.checks.fixes import Fixed, fixed
from robodyn.checks.rule import Finding, Severity

PLANTED = {f"{k}-{one.code or 'sound'}.urdf": one.text.encode() for k, one in enumerate((*DEFECTS, *SOUND))}
ROBOTS = {name_of(path): path for path in published()}
_SHAPES = re.compile(rb"<!--.*?-->|<(visual|collision)\b[^>]*/>|<(visual|collision)\b.*?</\2>", re.DOTALL)
_ATTRIBUTE = re.compile(r"""([\w:]+)\s*=\s*("[^"]*"|'[^']*')""")
_WAIVER = re.compile(r"<!-- robodyn: .*? -->")
READ = """
import json, os, sys
if sys.argv[1] == "mujoco":
    from mujoco import MjModel
    read = MjModel.from_xml_string
else:
    from pinocchio import buildModelFromXML as read
for text in map(json.loads, sys.stdin):
    child = os.fork()
    if not child:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        try:
            read(text)
        except Exception:
            os._exit(1)
        os._exit(0)
    print(os.waitpid(child, 0)[1], flush=True)
"""
"""Reads descriptions, one in a line, each in a fork, which may crash, and answers with the statuses that they leave."""


@cache
def checked(name: str, text: bytes) -> tuple[Finding, ...]:
    return check_one(text, name=name)


@cache
def result(name: str, unsafe: bool) -> Fixed:
    """A planted defect, or a robot where it stands, so that its meshes and its SRDF are found; nothing is written."""
    file = str(ROBOTS[name]) if name in ROBOTS else name
    data = PLANTED[name] if name in PLANTED else ROBOTS[name].read_bytes()
    return fixed(data, file, partial(checked, file), unsafe=unsafe)


OFFERED = [name for name, text in PLANTED.items() if any(one.fix for one in checked(name, text))]
"""Those of which something can be fixed."""


def attributes(line: bytes) -> Counter[tuple[str, str]]:
    return Counter(_ATTRIBUTE.findall(line.decode()))


def other(line: bytes) -> str:
    """What is neither an attribute nor a waiver."""
    return _ATTRIBUTE.sub("", _WAIVER.sub("", line.decode())).replace(" ", "")


def assert_only_values_change(one: Fixed) -> None:
    """Only attributes differ, no more of them than edits, in lines that fixes name, and as their edits say."""
    edits = [edit for made in one.made for edit in made.fix.edits]
    lines = zip(one.before.split(b"\n"), one.after.split(b"\n"), strict=True)
    changed = {number: (old, new) for number, (old, new) in enumerate(lines, 1) if old != new}
    named = {made.finding.line for made in one.made}
    assert named <= set(changed)
    assert all(other(old) == other(new) for old, new in changed.values())
    gone = [pair for old, new in changed.values() for pair in (attributes(old) - attributes(new)).elements()]
    come = [pair for old, new in changed.values() for pair in (attributes(new) - attributes(old)).elements()]
    assert len(come) <= len(gone) <= len(edits)
    assert {value.strip("'\"") for _, value in come} <= {edit.text for edit in edits}


def assert_idempotent(name: str, unsafe: bool) -> None:
    one = result(name, unsafe)
    again = fixed(one.after, one.file, partial(checked, one.file), unsafe=unsafe)
    assert again.after == one.after
    assert not again.made


Loads = Callable[[str, bytes], bool]


@pytest.fixture(scope="module")
def loads(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Loads]:
    """Whether a program reads a description without its shapes."""
    with ExitStack() as readers:

        @cache
        def reader(program: str) -> subprocess.Popen[str]:
            peer(program)
            command, folder = [sys.executable, "-I", "-c", READ, program], tmp_path_factory.mktemp(program)
            pipe, nothing = subprocess.PIPE, subprocess.DEVNULL
            started = subprocess.Popen(command, cwd=folder, stdin=pipe, stdout=pipe, stderr=nothing, text=True)
            readers.callback(started.communicate)
            return started

        @cache
        def read(program: str, text: bytes) -> bool:
            to, back = reader(program).stdin, reader(program).stdout
            assert to
            assert back
            print(json.dumps(_SHAPES.sub(b"", text).decode()), file=to, flush=True)
            return int(back.readline()) == 0

        yield read


def assert_loads_as_before(one: Fixed, loads: Loads) -> None:
    """What loaded loads; and what has no error left that is about more than shapes loads in any case."""
    errors = [found for found in checked(one.file, one.after) if found.severity is Severity.ERROR]
    sound = not [found for found in errors if not found.code.startswith(("RD3", "RD6", "RD7"))]
    for program in ("mujoco", "pinocchio"):
        assert loads(program, one.after) or not (sound or loads(program, one.before)), program


@pytest.mark.parametrize("name", sampled(PLANTED, 4))
def test_what_has_no_fix_stays_as_it_is(name: str) -> None:
    findings = checked(name, PLANTED[name])
    for unsafe in (False, True):
        wanted = [one for one in findings if one.fix is not None and (unsafe or one.fix.safe)]
        assert bool(wanted) or result(name, unsafe).after == PLANTED[name]


@pytest.mark.parametrize("name", OFFERED)
def test_planted_defects(name: str) -> None:
    for unsafe in (False, True):
        assert_only_values_change(result(name, unsafe))
        assert_idempotent(name, unsafe)
    assert not [one for one in checked(name, result(name, True).after) if one.fix]


@pytest.mark.slow
@pytest.mark.parametrize("name", OFFERED)
def test_planted_defects_load(name: str, loads: Loads) -> None:
    for unsafe in (False, True):
        assert_loads_as_before(result(name, unsafe), loads)


@pytest.mark.slow
@pytest.mark.parametrize("unsafe", [False, True])
@pytest.mark.parametrize("name", ROBOTS)
def test_robots(name: str, unsafe: bool, loads: Loads, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    one = result(name, unsafe)
    assert_only_values_change(one)
    if one.made:
        assert_idempotent(name, unsafe)
        assert_loads_as_before(one, loads)


@pytest.mark.slow
def test_how_much_there_is_to_fix(record_property: Callable[[str, object], None]) -> None:
    """Enough for the tests above to mean something."""
    for unsafe, planted, robots in ((False, 4, 2), (True, 13, 20)):
        made = [sum(bool(result(name, unsafe).made) for name in names) for names in (PLANTED, ROBOTS)]
        record_property(f"fixed, unsafe={unsafe}", made)
        assert made[0] >= planted
        assert made[1] >= robots
