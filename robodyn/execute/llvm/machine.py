"""The machine that code is made for, and the way from LLVM IR to machine code and to functions in memory."""

from __future__ import annotations

import ctypes
from functools import cache
from typing import Any, NamedTuple


class Host(NamedTuple):
    """What machine code depends on.

    Attributes:
        cpu: its name to LLVM.
        features: "+avx2,-avx512f,..." as LLVM writes them.
        llvmlite: the version of the compiler's binding.
    """

    triple: str
    cpu: str
    features: str
    llvmlite: str

    @property
    def fused(self) -> bool:
        """Whether the processor multiplies and adds in one instruction."""
        return "+fma," in self.features + "," or self.triple.startswith(("aarch64", "arm64"))


@cache
def host() -> Host:
    """This machine.

    Raises:
        ImportError, OSError: llvmlite is not installed or does not load.
    """
    import llvmlite
    import llvmlite.binding as llvm

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    features = llvm.get_host_cpu_features().flatten()
    return Host(llvm.get_process_triple(), llvm.get_host_cpu_name(), features, llvmlite.__version__)


def _target_machine() -> Any:
    import llvmlite.binding as llvm

    here = host()
    target = llvm.Target.from_triple(here.triple)
    return target.create_target_machine(
        cpu=here.cpu, features=here.features, opt=1, codemodel="jitdefault", jit=True, reloc="default"
    )


def machine_code(ir: str) -> bytes:
    """The object file of a module of LLVM IR."""
    import llvmlite.binding as llvm

    return bytes(_target_machine().emit_object(llvm.parse_assembly(ir)))


class Function:
    """A function of an object file that returns 64 bits, in memory for as long as this lives."""

    def __init__(self, code: bytes, name: str, *arguments: Any) -> None:
        """Args: arguments: ctypes types of its arguments."""
        import llvmlite.binding as llvm

        host()
        self._engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), _target_machine())
        self._engine.add_object_file(llvm.ObjectFileRef.from_data(code))
        self._engine.finalize_object()
        self.address = int(self._engine.get_function_address(name))
        self._call = ctypes.CFUNCTYPE(ctypes.c_int64, *arguments)(self.address)

    def __call__(self, *arguments: int) -> int:
        """Calls it, without Python's lock."""
        return int(self._call(*arguments))
