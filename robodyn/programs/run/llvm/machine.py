"""The machine that code is made for, and the way from LLVM IR to machine code and to functions in memory."""

from __future__ import annotations

import ctypes
import os
import re
from functools import cache
from itertools import count
from typing import Any, NamedTuple

from robodyn.errors import InputError
from robodyn.support.wording import alternatives

NATIVE = "native"
_V2 = ("cx16", "popcnt", "sahf", "sse3", "sse4.1", "sse4.2", "ssse3")
_V3 = (*_V2, "avx", "avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe", "xsave")
_V4 = (*_V3, "avx512bw", "avx512cd", "avx512dq", "avx512f", "avx512vl")
LEVELS = {"x86-64-v2": _V2, "x86-64-v3": _V3, "x86-64-v4": _V4}
"""The levels of x86-64 processors, which LLVM knows by these names, and what each can do beyond the first."""
WORD = re.compile(r"^  (.+), (%\w+)\[(.+)\]$", re.M)


class Host(NamedTuple):
    """What machine code depends on: the processor and its features ("+avx2,-avx512f,...") as LLVM names them, and the
    versions of the compiler and of its binding."""

    triple: str
    cpu: str
    features: str
    llvmlite: str
    llvm: tuple[int, ...]

    @property
    def fused(self) -> bool:
        """Whether the processor multiplies and adds in one instruction."""
        return "+fma," in self.features + "," or self.triple.startswith(("aarch64", "arm64"))

    @property
    def vector(self) -> int:
        """Bytes worked on at a time: a register of AVX-512 or AVX2; or two of NEON, which has twice as many."""
        return 64 if "+avx512vl," in self.features + "," else 32

    @property
    def pooled(self) -> bool:
        """Whether operands in memory must be whole vectors, as AVX2 wants them; the others repeat one number."""
        return self.vector == 32 and self.triple.startswith("x86_64")


@cache
def host() -> Host:
    """Return this machine, or what `ROBODYN_CPU` names in its place.

    Raises:
        ImportError, OSError, RuntimeError: llvmlite is not installed or does not load, or does not know the processor.
        InputError: there is no such processor, or code for it would not run on this one.
    """
    import llvmlite
    import llvmlite.binding as llvm

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    features = llvm.get_host_cpu_features()
    versions = llvmlite.__version__, tuple(llvm.llvm_version_info)
    here = Host(llvm.get_process_triple(), llvm.get_host_cpu_name(), features.flatten(), *versions)
    level = os.environ.get("ROBODYN_CPU") or NATIVE
    known = [NATIVE, *(LEVELS if here.triple.startswith("x86_64") else ())]
    if level not in known:
        remedy = alternatives(level, known, "processors")
        raise InputError(f"ROBODYN_CPU: there is no processor {level!r}", remedy=remedy)
    if level == NATIVE:
        return here
    missing = [name for name in LEVELS[level] if not features.get(name)]
    if missing:
        what = f"ROBODYN_CPU: {level} has {', '.join(missing)}, which this processor ({here.cpu}) has not"
        raise InputError(what, remedy="choose a lower level, or leave it unset")
    return here._replace(cpu=level, features=",".join(f"+{name}" for name in LEVELS[level]))


@cache
def compiler_problem() -> str | None:
    """Return why no machine code can be made here, with a remedy; None if it can."""
    try:
        here = host()
    except (ImportError, OSError, RuntimeError) as error:
        missing = getattr(error, "name", None) == "llvmlite"
        reason = "llvmlite is not installed" if missing else f"llvmlite does not load ({one_line(error)})"
        return f"{reason}; pip install llvmlite"
    if not here.fused:
        return f"the processor ({here.cpu}) has no fused multiply-add"
    return None


def one_line(error: Exception) -> str:
    return str(error).partition("\n")[0][:120] or type(error).__name__


def _target_machine() -> Any:
    """Code that reaches its constants by short distances: instructions take them from memory as they are."""
    import llvmlite.binding as llvm

    here = host()
    target = llvm.Target.from_triple(here.triple)
    return target.create_target_machine(
        cpu=here.cpu, features=here.features, opt=1, codemodel="small", jit=True, reloc="default"
    )


def machine_code(ir: str) -> bytes:
    """`%x = load T, %p[k]` and `store T %x, %p[k]` in the IR, which LLVM does not know, mean word k, of 64 bits."""
    import llvmlite.binding as llvm

    number = count()

    def addressed(found: re.Match[str]) -> str:
        what, pointer, word = found.groups()
        at = f"%word{next(number)}"
        return f"  {at} = getelementptr i64, ptr {pointer}, i64 {word}\n  {what}, ptr {at}"

    return bytes(_target_machine().emit_object(llvm.parse_assembly(WORD.sub(addressed, ir))))


class Function:
    """A function of an object file that returns 64 bits, in memory for as long as this lives."""

    def __init__(self, code: bytes, name: str, *arguments: Any) -> None:
        import llvmlite.binding as llvm

        host()
        # llvmlite's own memory manager keeps code and constants within these short distances.
        self._engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), _target_machine(), use_lmm=True)
        self._engine.add_object_file(llvm.ObjectFileRef.from_data(code))
        self._engine.finalize_object()
        self.address = self.address_of(name)
        self._call = ctypes.CFUNCTYPE(ctypes.c_int64, *arguments)(self.address)

    def address_of(self, name: str) -> int:
        return int(self._engine.get_function_address(name))

    def __call__(self, *arguments: int) -> int:
        return int(self._call(*arguments))
