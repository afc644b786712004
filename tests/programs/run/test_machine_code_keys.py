"""Machine code is found again by all that it depends on, and by nothing less; ROBODYN_CPU says what it is made for."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from helpers.command_line import spawn, write_arm
from helpers.compiled_programs import needs_compiler, program_of

from robodyn.errors import InputError
from robodyn.programs.program import Program
from robodyn.programs.run.compiled_blocks import CompiledBlocks, content_of
from robodyn.programs.run.llvm import build, machine
from robodyn.programs.run.llvm.machine import LEVELS, Host

pytestmark = needs_compiler
PROGRAM = program_of(lambda x, y: [x * 2.5 + y, y.sin()], 2)
X = np.random.default_rng(3).uniform(-2, 2, (50, 2))


@pytest.fixture
def built(monkeypatch, tmp_path):
    """Names of the functions that are compiled, in an empty cache, as they are."""
    monkeypatch.setenv("ROBODYN_CACHE", str(tmp_path))
    names = []
    compile_it = build.machine_code

    def machine_code(ir):
        names.append("kernel" if "@kernel(" in ir else "run")
        return compile_it(ir)

    monkeypatch.setattr(build, "machine_code", machine_code)
    return names


def results(program=PROGRAM, widths=2, dtype=np.float64):
    return CompiledBlocks(program, {"x": widths}, dtype)({"x": X.astype(dtype)}, len(X))


@pytest.mark.parametrize("size", [0, 1000])
def test_damaged_machine_code_is_made_again(built, tmp_path, size):
    first = results()
    for path in (tmp_path / "objects").iterdir():
        path.write_bytes(path.read_bytes()[:size])
    np.testing.assert_array_equal(results(), first)
    np.testing.assert_array_equal(results(), first)
    assert built.count("kernel") == 2


def _other(**changes):
    return Program(**{"operations": PROGRAM.operations, "outputs": PROGRAM.outputs, **changes})


def _with(place, operation):
    return _other(operations=(*PROGRAM.operations[:place], operation, *PROGRAM.operations[place + 1 :]))


CONSTANT = next(k for k, (op, _, _) in enumerate(PROGRAM.operations) if op == "constant")
SINE = next(k for k, (op, _, _) in enumerate(PROGRAM.operations) if op == "sin")
CONTENTS = {
    "constant by one bit": content_of(_with(CONSTANT, ("constant", np.nextafter(2.5, 3.0), None)), {"x": 2}, "f8"),
    "sign of a zero": content_of(_with(CONSTANT, ("constant", -0.0, None)), {"x": 2}, "f8"),
    "zero": content_of(_with(CONSTANT, ("constant", 0.0, None)), {"x": 2}, "f8"),
    "operation": content_of(_with(SINE, ("cos", *PROGRAM.operations[SINE][1:])), {"x": 2}, "f8"),
    "order of the outputs": content_of(_other(outputs=PROGRAM.outputs[::-1]), {"x": 2}, "f8"),
    "columns of the source": content_of(PROGRAM, {"x": 3}, "f8"),
    "number format": content_of(PROGRAM, {"x": 2}, "f4"),
    "as it is": content_of(PROGRAM, {"x": 2}, "f8"),
}


def test_every_part_of_a_program_changes_the_key():
    keys = {build.code_key(content) for content in CONTENTS.values()}
    assert len(keys) == len(CONTENTS)
    assert build.code_key(content_of(PROGRAM, {"x": 2, "unused": 5}, np.float64)) in keys


@pytest.mark.parametrize("field", Host._fields)
def test_every_part_of_the_machine_changes_the_key(built, monkeypatch, field):
    expected = results()
    here = build.host()
    key = build.code_key(CONTENTS["as it is"])
    monkeypatch.setattr(build, "host", lambda: here._replace(**{field: "another"}))
    other = build.code_key(CONTENTS["as it is"])
    assert other.content == key.content
    assert other.maker != key.maker
    np.testing.assert_array_equal(results(), expected)
    assert built.count("kernel") == 2, "machine code of another machine is not run"


def test_every_module_that_makes_machine_code_changes_the_key(monkeypatch, tmp_path):
    """A copy of the package with one byte more in any of its modules has another digest."""
    package = Path(build.__file__).parent.parent
    for path in package.rglob("*.py"):
        copy = tmp_path / path.relative_to(package)
        copy.parent.mkdir(exist_ok=True)
        copy.write_bytes(path.read_bytes())
    monkeypatch.setattr(build, "__file__", str(tmp_path / "llvm" / "build.py"))
    digest = build.generator.__wrapped__
    assert digest() == build.generator()
    changed = set()
    for path in tmp_path.rglob("*.py"):
        text = path.read_bytes()
        path.write_bytes(text + b"\n")
        changed.add(digest())
        path.write_bytes(text)
    assert len(changed) == len(list(package.rglob("*.py")))
    assert digest() not in changed


@pytest.mark.parametrize("reason", ["no cache", "no sources of robodyn", "another version"])
def test_code_that_nothing_would_tell_from_other_code_is_compiled_anew(built, monkeypatch, tmp_path, reason):
    expected = results()
    if reason == "no cache":
        monkeypatch.setenv("ROBODYN_CACHE", "0")
    else:
        monkeypatch.setattr(build, "generator", lambda: "another" if reason == "another version" else "")
    kept = len(list((tmp_path / "objects").iterdir()))
    np.testing.assert_array_equal(results(), expected)
    assert built.count("kernel") == 2
    assert (len(list((tmp_path / "objects").iterdir())) > kept) == (reason == "another version")


@pytest.fixture
def machine_with(monkeypatch: pytest.MonkeyPatch) -> object:
    """Makes the machine that `ROBODYN_CPU` names, on a processor with these features."""
    import llvmlite.binding as llvm

    def made(level: str, *features: str) -> Host:
        class Features(dict[str, bool]):
            def flatten(self) -> str:
                return "all"

        monkeypatch.setenv("ROBODYN_CPU", level)
        monkeypatch.setattr(llvm, "get_host_cpu_features", lambda: Features.fromkeys(features, True))
        monkeypatch.setattr(llvm, "get_process_triple", lambda: "x86_64-unknown-linux-gnu")
        return machine.host.__wrapped__()

    return made


def test_a_level_is_what_code_is_made_for_under_a_key_of_its_own(machine_with, monkeypatch) -> None:
    found = machine_with("x86-64-v3", *LEVELS["x86-64-v4"])
    assert (found.cpu, found.fused) == ("x86-64-v3", True)
    assert "+avx2" in found.features
    assert "avx512" not in found.features
    assert not machine_with("x86-64-v2", *LEVELS["x86-64-v4"]).fused
    assert machine_with("native").features == machine_with("").features == "all"
    keys = set()
    for level in ("native", *LEVELS):
        here = machine_with(level, *LEVELS["x86-64-v4"])
        monkeypatch.setattr(build, "host", lambda here=here: here)
        keys.add(build.code_key("something"))
    assert len(keys) == 4


def test_a_level_that_this_processor_does_not_reach(machine_with) -> None:
    with pytest.raises(InputError, match=r"ROBODYN_CPU: x86-64-v4 has avx512bw, .*, which this processor \(.*has not"):
        machine_with("x86-64-v4", *LEVELS["x86-64-v3"])


def test_the_command_says_so_in_one_line(tmp_path) -> None:
    write_arm(tmp_path)
    call = "torques", "arm.urdf", "arm.csv", "--executor", "compiled"
    done = spawn(*call, cwd=tmp_path, ROBODYN_CPU="avx9000")
    assert (done.status, done.out) == (2, "")
    assert done.err.startswith("error: ROBODYN_CPU: there is no processor 'avx9000' (")
    assert done.err.count("\n") == 1


@pytest.mark.slow
def test_doctor_shows_it(tmp_path) -> None:
    if not machine.host().triple.startswith("x86_64"):
        pytest.skip("levels are of x86-64")
    done = spawn("doctor", cwd=tmp_path, ROBODYN_CPU="x86-64-v2")
    assert "x86-64-v2 to LLVM" in done.out
    assert "the processor (x86-64-v2) has no fused multiply-add" in done.out
    assert any(line.split() == ["ROBODYN_CPU", "ok", "x86-64-v2"] for line in done.out.splitlines())
