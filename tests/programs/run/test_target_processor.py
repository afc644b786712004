"""ROBODYN_CPU: machine code for a processor that can do less than this one, with the same results."""

from __future__ import annotations

import pytest
from helpers.command_line import spawn, write_arm
from helpers.compiled_programs import needs_compiler

from robodyn.errors import InputError
from robodyn.programs.run.llvm import build, machine
from robodyn.programs.run.llvm.machine import LEVELS, Host

pytestmark = needs_compiler


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
