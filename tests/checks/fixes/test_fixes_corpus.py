"""Fixing every planted defect and every published robot: what is edited, that it is done once, who reads it then."""

from __future__ import annotations

import re
import subprocess
import sys
from collections import Counter
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path

import pytest
from helpers.peers import peer
from helpers.planted_defects import DEFECTS, SOUND
from helpers.sampled import sampled
from pinned_findings import name_of, published

from robodyn.checks.fixes import Fixed, fixed
from robodyn.checks.rule import Finding, Severity
from robodyn.checks.run import check_one

PLANTED = {f"{k}-{one.code or 'sound'}.urdf": one.text.encode() for k, one in enumerate((*DEFECTS, *SOUND))}
ROBOTS = {name_of(path): path for path in published()}
_SHAPES = re.compile(rb"<!--.*?-->|<(visual|collision)\b[^>]*/>|<(visual|collision)\b.*?</\2>", re.DOTALL)
_ATTRIBUTE = re.compile(r"""([\w:]+)\s*=\s*("[^"]*"|'[^']*')""")
_WAIVER = re.compile(r"<!-- robodyn: .*? -->")
READ = """
import sys
text = sys.stdin.buffer.read().decode()
if sys.argv[1] == "mujoco":
    import mujoco
    mujoco.MjModel.from_xml_string(text)
else:
    import pinocchio
    pinocchio.buildModelFromXML(text)
"""


def checked(name: str, text: bytes) -> tuple[Finding, ...]:
    return check_one(text, name=name)


@cache
def result(name: str, unsafe: bool) -> Fixed:
    """A planted defect, or a robot where it stands, so that its meshes and its SRDF are found; nothing is written."""
    file = str(ROBOTS[name]) if name in ROBOTS else name
    data = PLANTED[name] if name in PLANTED else ROBOTS[name].read_bytes()
    return fixed(data, file, partial(checked, file), unsafe=unsafe)


def offered(names: dict[str, bytes]) -> list[str]:
    return [name for name, text in names.items() if any(one.fix for one in checked(name, text))]


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


@cache
def loads(program: str, text: bytes) -> bool:
    """Whether a program reads a description without its shapes; in a process of its own, which may crash."""
    done = subprocess.run(
        [sys.executable, "-I", "-c", READ, program], input=_SHAPES.sub(b"", text), capture_output=True, check=False
    )
    return done.returncode == 0


def assert_loads_as_before(one: Fixed) -> None:
    """What loaded loads; and what has no error left that is about more than shapes loads in any case."""
    errors = [found for found in checked(one.file, one.after) if found.severity is Severity.ERROR]
    sound = not [found for found in errors if not found.code.startswith(("RD3", "RD6", "RD7"))]
    for program in ("mujoco", "pinocchio"):
        peer(program)
        assert loads(program, one.after) or not (sound or loads(program, one.before)), program


@pytest.mark.parametrize("name", sampled(PLANTED, 4))
def test_what_has_no_fix_stays_as_it_is(name: str) -> None:
    findings = checked(name, PLANTED[name])
    for unsafe in (False, True):
        wanted = [one for one in findings if one.fix is not None and (unsafe or one.fix.safe)]
        assert bool(wanted) or result(name, unsafe).after == PLANTED[name]


@pytest.mark.parametrize("name", offered(PLANTED))
def test_planted_defects(name: str) -> None:
    for unsafe in (False, True):
        assert_only_values_change(result(name, unsafe))
        assert_idempotent(name, unsafe)
    assert not [one for one in checked(name, result(name, True).after) if one.fix]


@pytest.mark.slow
@pytest.mark.parametrize("name", offered(PLANTED))
def test_planted_defects_load(name: str) -> None:
    for unsafe in (False, True):
        assert_loads_as_before(result(name, unsafe))


@pytest.mark.slow
@pytest.mark.parametrize("unsafe", [False, True])
@pytest.mark.parametrize("name", ROBOTS)
def test_robots(name: str, unsafe: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    one = result(name, unsafe)
    assert_only_values_change(one)
    if one.made:
        assert_idempotent(name, unsafe)
        assert_loads_as_before(one)


@pytest.mark.slow
def test_how_much_there_is_to_fix(record_property: Callable[[str, object], None]) -> None:
    """Enough for the tests above to mean something."""
    for unsafe, planted, robots in ((False, 4, 2), (True, 13, 20)):
        made = [sum(bool(result(name, unsafe).made) for name in names) for names in (PLANTED, ROBOTS)]
        record_property(f"fixed, unsafe={unsafe}", made)
        assert made[0] >= planted
        assert made[1] >= robots
