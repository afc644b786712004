"""Machine code for NEON, assembled here for a processor that has it: nothing but vectors of two numbers."""

from __future__ import annotations

import re
from collections import Counter

import pytest
from helpers.compiled_programs import needs_compiler
from helpers.oracles import ROBOTS

import robodyn
from robodyn.dynamics.plan import torque_runner
from robodyn.programs.run.llvm import machine
from robodyn.programs.run.llvm.kernel import kernel
from robodyn.scene.scene import Scene

pytestmark = needs_compiler
OPERATIONS = {"fma": ("fmla", "fmls"), "fmul": ("fmul",), "fadd": ("fadd",), "fsub": ("fsub",)}


def test_every_operation_is_one_instruction_for_two_samples():
    import llvmlite.binding as llvm

    machine.host()
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    try:
        target = llvm.Target.from_triple("aarch64-linux-gnu")
    except RuntimeError:
        pytest.skip("this LLVM makes no code for aarch64")
    neon = machine.Host("aarch64-linux-gnu", "cortex-a76", "+neon", "", ())
    runner = torque_runner(robodyn.load(ROBOTS / "puma560.urdf"), Scene())
    program, lanes = runner.program, neon.vector // 8
    assert (lanes, neon.pooled, neon.fused) == (4, False, True)
    ir = kernel(program.distinct, program.rows(runner.widths), "double", lanes)
    text = target.create_target_machine(cpu=neon.cpu, features=neon.features, opt=1).emit_assembly(
        llvm.parse_assembly(ir)
    )
    made = Counter(re.findall(r"^\s+(f\w+)\s+v\d+\.2d", text, re.M))
    for name, instructions in OPERATIONS.items():
        asked = len(re.findall(rf"@llvm\.fma\.v{lanes}f64\(<" if name == "fma" else rf" = {name} ", ir))
        declared = name == "fma"
        assert sum(made[each] for each in instructions) == lanes // 2 * (asked - declared)
    assert not re.search(r"^\s+(bl|fm\w+\s+d\d)", text, re.M)
