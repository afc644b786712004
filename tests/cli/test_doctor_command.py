"""`robodyn doctor`: what it finds here, and what it says of what is missing or broken."""

from __future__ import annotations

from pathlib import Path

import pytest
from helpers.command_line import Outcome, run

from robodyn.measure import doctor
from robodyn.measure.doctor import TOLERANCE, Line, SelfTest, healthy, self_test
from robodyn.report.accuracy import doctor_sections
from robodyn.report.document import text
from robodyn.robot.urdf.sources import VARIABLES
from robodyn.support.extras import COMPILER, CORE, OPTIONAL, SCENES
from robodyn.support.libraries import _MARK, Installed, loading

LIBRARIES = (*CORE, COMPILER, SCENES, *OPTIONAL)
WORKS = SelfTest(None, False, 1e-4, 1e-2, 1e-3, 1e-5, 1e-16)


def here(**changed: Installed) -> dict[str, Installed]:
    return {library.name: Installed("1.2.3", "") for library in LIBRARIES} | changed


def diagnosed(
    monkeypatch: pytest.MonkeyPatch, libraries: dict[str, Installed] | None = None, tried: SelfTest = WORKS
) -> Outcome:
    monkeypatch.setattr(doctor, "installed", lambda _: libraries or here())
    monkeypatch.setattr(doctor, "tried_apart", lambda: tried)
    return run("doctor")


def test_all_is_well(monkeypatch: pytest.MonkeyPatch) -> None:
    assert diagnosed(monkeypatch).out.endswith("\n\neverything that is needed works\n")
    bare = diagnosed(monkeypatch, here(**{library.name: Installed(None, "") for library in OPTIONAL}))
    assert bare.status == 0
    assert all(f'pip install "robodyn[{library.extra}]"' in bare.out for library in OPTIONAL)


@pytest.mark.parametrize(
    ("name", "found", "status", "said"),
    [
        ("scipy", Installed(None, ""), 1, "broken   without it no splines"),
        ("polars", Installed("1.0", "bad ELF"), 1, "broken   1.0: does not load (bad ELF): no reading"),
        ("sympy", Installed(None, ""), 0, 'pip install "robodyn[symbolic]"'),
        ("llvmlite", Installed(None, ""), 0, "missing  without it no machine code"),
    ],
)
def test_libraries(monkeypatch: pytest.MonkeyPatch, name: str, found: Installed, status: int, said: str) -> None:
    outcome = diagnosed(monkeypatch, here(**{name: found}))
    line = next(line for line in outcome.out.splitlines() if line.startswith(f"  {name} "))
    assert (outcome.status, said in line) == (status, True), line
    assert f"{'to be repaired' if status else 'missing'}: {name}" in outcome.out.splitlines()[-1]


@pytest.mark.parametrize(
    ("tried", "status", "said"),
    [
        (SelfTest("llvmlite is not installed; pip install llvmlite", False, 1e-4), 0, "missing  llvmlite is not"),
        (SelfTest("machine code ends the process", True, 0.0), 1, "broken   machine code ends the process; long"),
        (SelfTest("results differ", True, 1e-4, difference=0.5), 1, "results may be wrong: --executor numpy"),
    ],
)
def test_executors(monkeypatch: pytest.MonkeyPatch, tried: SelfTest, status: int, said: str) -> None:
    outcome = diagnosed(monkeypatch, tried=tried)
    assert (outcome.status, said in outcome.out) == (status, True), outcome.out


def test_executors_agree_here() -> None:
    found = self_test()
    assert found.problem is None or not found.broken
    assert found.difference <= TOLERANCE


def test_wrong_machine_code_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("llvmlite")
    from robodyn.programs.run import compiled_blocks

    right = compiled_blocks.CompiledBlocks.__call__
    monkeypatch.setattr(compiled_blocks.CompiledBlocks, "__call__", lambda *args: right(*args) * (1 + 1e-9))
    found = self_test()
    assert found.broken
    assert "results differ from NumPy's by 1.0e-09" in str(found.problem)


@pytest.mark.parametrize(
    ("place", "status", "verdict"), [("kept", 0, "ok"), ("file", 1, "broken"), ("0", 0, "note"), ("open", 1, "broken")]
)
def test_cache(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, place: str, status: int, verdict: str) -> None:
    (tmp_path / "file").write_text("")
    (tmp_path / "open" / "objects").mkdir(parents=True)
    (tmp_path / "open" / "objects").chmod(0o777)
    monkeypatch.setenv("ROBODYN_CACHE", place if place == "0" else str(tmp_path / place))
    outcome = diagnosed(monkeypatch)
    line = next(line for line in outcome.out.splitlines() if "cache folder" in line)
    assert (outcome.status, line.split()[2]) == (status, verdict), line
    if place == "kept":
        assert line.endswith("in 1 file")


def test_environment(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    (name, *_) = VARIABLES
    monkeypatch.setenv(name, f"{tmp_path}:/nowhere/at/all")
    outcome = diagnosed(monkeypatch)
    line = next(line for line in outcome.out.splitlines() if name in line)
    assert (outcome.status, line.split()[1]) == (0, "note")
    assert line.endswith("no such folder: /nowhere/at/all")


def test_modules_are_loaded_apart(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    (tmp_path / "loud_module.py").write_text("print('hello', end='')")
    more = f"import atexit; atexit.register(print, {_MARK + '0'!r})"
    (tmp_path / "late_module.py").write_text(more)
    (tmp_path / "dying_module.py").write_text("import os; os._exit(7)")
    (tmp_path / "failing_module.py").write_text("raise OSError('no libX.so\\nmore')")
    monkeypatch.syspath_prepend(tmp_path)
    assert list(loading(["late_module"])) == [("late_module", "")]
    answers = list(loading(["loud_module", "dying_module", "failing_module", "json"]))
    assert answers == [
        ("loud_module", ""),
        ("dying_module", "it ends the process, exit status 7"),
        ("failing_module", "no libX.so"),
        ("json", ""),
    ]


def test_text_escapes_what_it_is_given() -> None:
    lines = (Line("environment", "X", "a\x1b[31m", "broken", "b"),)
    assert text(doctor_sections(lines)) == "environment\n  X  broken   a\\x1b[31m: b\n\nto be repaired: X\n"
    assert not healthy(lines)
