"""Whether robodyn can work here, line by line: libraries, processor, executors, cache, environment."""

from __future__ import annotations

import os
import platform
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from time import perf_counter
from typing import Any, Literal

import numpy as np

from robodyn.programs.program import trace
from robodyn.programs.run.llvm.machine import Function, compiler_problem, host, machine_code, one_line
from robodyn.programs.run.numpy_blocks import NumpyBlocks
from robodyn.robot.urdf.sources import VARIABLES, listed
from robodyn.support.cache import Key, ObjectCache, cache_folder
from robodyn.support.extras import COMPILER, CORE, OPTIONAL, SCENES, Library
from robodyn.support.libraries import Installed, installed, version_of
from robodyn.support.threads import cores
from robodyn.support.wording import count

Verdict = Literal["ok", "note", "missing", "broken"]
_FEATURES = ("avx512f", "avx2", "fma", "sve", "neon")
_PROBE = Key("doctor", "doctor")
TOLERANCE = 8 * float(np.finfo(float).eps)  # of the largest result: what rounding may make of the few operations
_SAMPLES = 1000


@dataclass(frozen=True)
class Line:
    """One thing that was looked at. found: its version or state, in words. verdict: "note" is worth knowing, "missing"
    costs something, "broken" is to be repaired. remark: what that costs, and what to do; figures: measured, seconds,
    bytes or a ratio."""

    group: str
    name: str
    found: str
    verdict: Verdict = "ok"
    remark: str = ""
    figures: Mapping[str, float] = field(default_factory=dict)


def doctor() -> tuple[Line, ...]:
    """Return everything that was looked at. Libraries are loaded in another process, so that none can end this one."""
    found = installed((*CORE, COMPILER, SCENES, *OPTIONAL))
    compiler = _library("versions", COMPILER, found, "missing")
    if compiler.verdict == "ok" and compiler_problem() is None:
        compiler = replace(compiler, found=f"{compiler.found}, LLVM {'.'.join(map(str, host().llvm))}")
    return (
        Line("versions", "robodyn", version_of("robodyn") or "not installed, run from its sources"),
        Line("versions", "Python", platform.python_version()),
        *(_library("versions", library, found, "broken") for library in CORE),
        compiler,
        _library("versions", SCENES, found, "missing"),
        *(_library("optional", library, found, "missing") for library in OPTIONAL),
        *_processor(not found[COMPILER.name].problem),
        *_executors(tried_apart()),
        _cache(),
        *_environment(os.environ),
    )


def healthy(lines: tuple[Line, ...]) -> bool:
    return all(line.verdict != "broken" for line in lines)


def _library(group: str, library: Library, found: Mapping[str, Installed], absent: Verdict) -> Line:
    here = found[library.name]
    if here.version is None:
        return Line(group, library.name, "", absent, f"without it no {library.cost}; pip install {library.install}")
    if here.problem:
        remark = f"does not load ({here.problem}): no {library.cost}; pip install --force-reinstall {library.install}"
        return Line(group, library.name, here.version, "broken", remark)
    return Line(group, library.name, here.version)


def _processor(loads: bool) -> Iterator[Line]:
    """Args: loads: whether the compiler can be asked; it might end this process."""
    lines = list[str]()
    with suppress(OSError):
        lines = Path("/proc/cpuinfo").read_text(errors="replace").splitlines()
    model = next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), "")
    name = model or platform.processor() or platform.machine()
    yield Line("machine", "processor", f"{name} ({platform.machine()}, {platform.system()})")
    with suppress(ImportError, OSError, RuntimeError):
        if loads:
            here = host()
            features = [name for name in _FEATURES if f"+{name}," in here.features + ","]
            text = f"{here.cpu} to LLVM: {', '.join(features) or 'no vector instructions known'}"
            yield Line("machine", "instructions", text)
    whole, usable = os.cpu_count() or 1, cores()
    limited = usable < whole
    remark = "this process is bound to fewer cores than there are" if limited else ""
    yield Line("machine", "cores", f"{usable} of {whole}", "note" if limited else "ok", remark)


def tried_apart() -> SelfTest:
    """Return the self-test in a process of its own, which machine code that does not suit the processor would end."""
    from robodyn.support.processes import Death, in_processes

    ((_, found),) = in_processes(self_test, [()], 1)
    return SelfTest("machine code ends the process", True, 0.0) if isinstance(found, Death) else found


def _executors(tried: SelfTest) -> Iterator[Line]:
    yield Line("executors", "numpy", f"runs in {1e3 * tried.numpy:.3g} ms", figures={"run": tried.numpy})
    if tried.problem is not None:
        verdict: Verdict = "broken" if tried.broken else "missing"
        cost = "results may be wrong: --executor numpy" if tried.difference else "long trajectories take longer"
        yield Line("executors", "compiled", "", verdict, f"{tried.problem}; {cost}")
        return
    figures = {name: getattr(tried, name) for name in ("build", "load", "run", "difference")}
    times = f"built in {1e3 * tried.build:.3g} ms, loaded in {1e3 * tried.load:.3g} ms"
    agreement = f"within {tried.difference:.0e} of NumPy" if tried.difference else "as NumPy to the last bit"
    yield Line("executors", "compiled", f"{times}, {agreement}", figures=figures)


def _cache() -> Line:
    folder, slow = cache_folder(), "machine code is compiled anew by every process"
    if folder is None:
        remark = f"switched off or without a place: {slow}; ROBODYN_CACHE names one"
        return Line("cache", "cache folder", "", "note", remark)
    objects, content = ObjectCache(folder), os.urandom(8)
    objects.put(_PROBE, content)
    if objects.get(_PROBE) != content:
        remark = f"nothing can be kept there: {slow}; let only this user write to it (chmod 700), or set ROBODYN_CACHE"
        return Line("cache", "cache folder", str(folder), "broken", remark)
    files, size = objects.held()
    text = f"{folder}, writable, {size / 1e6:.3g} MB in {count(files, 'file')}"
    return Line("cache", "cache folder", text, figures={"bytes": size, "files": files})


def _environment(variables: Mapping[str, str]) -> Iterator[Line]:
    meanings = {
        "ROBODYN_CACHE": "not set: the user's cache folder",
        "ROBODYN_LIMITS": "not set: inputs have the limits of robodyn",
        "ROBODYN_CPU": "not set: machine code is for this processor",
        **dict.fromkeys(VARIABLES, "not set: package:// by --package-path, or above the file"),
        "ROBODYN_TRACEBACK": "not set: an error is one line",
        "NO_COLOR": "not set: bold headers on terminals",
    }
    for name, meaning in meanings.items():
        value = variables.get(name)
        lost = [entry for entry in listed(name) if not os.path.isdir(entry)] if name in VARIABLES else []
        remark = f"no such folder: {', '.join(lost)}" if lost else ""
        found = meaning if value is None else value or "empty"
        yield Line("environment", name, found, "note" if lost else "ok", remark)


@dataclass(frozen=True)
class SelfTest:
    """What became of the program.

    Attributes:
        problem: why there is no machine code; None if there is. broken: whether that is a fault, not what is missing.
        numpy: seconds to run all samples by NumPy; build, load, run: to compile, load and run machine code.
        difference: between the results, of the largest.
    """

    problem: str | None
    broken: bool
    numpy: float
    build: float = 0.0
    load: float = 0.0
    run: float = 0.0
    difference: float = 0.0


def self_test() -> SelfTest:
    """Both executors on the same samples; machine code is made anew, whatever is kept."""

    def outputs(tape: Any) -> list[Any]:
        angle, length = tape.input("x", 0), tape.input("x", 1)
        return [length * angle.cos(), length * angle.sin() + angle / length, length.sqrt() - angle]

    program, widths = trace(outputs), {"x": 2}
    x = np.asfortranarray(np.stack([np.linspace(-3, 3, _SAMPLES), np.linspace(0.1, 2, _SAMPLES)], axis=1))
    by_numpy = NumpyBlocks(program, widths)
    expected, numpy = _timed(lambda: by_numpy({"x": x}, _SAMPLES))
    missing = compiler_problem()
    if missing is not None:
        return SelfTest(missing, "does not load" in missing, numpy)
    try:
        from robodyn.programs.run.compiled_blocks import CompiledBlocks, kernel_of

        code, build = _timed(lambda: machine_code(kernel_of(program, widths)))
        _, load = _timed(lambda: Function(code, "kernel"))
        by_code = CompiledBlocks(program, widths)
        found, run = _timed(lambda: by_code({"x": x}, _SAMPLES))
    except (ImportError, OSError, RuntimeError) as error:
        return SelfTest(f"machine code cannot be made ({one_line(error)})", True, numpy)
    difference = float(np.abs(found - expected).max() / np.abs(expected).max())
    wrong = not difference <= TOLERANCE
    problem = f"results differ from NumPy's by {difference:.1e} of the largest" if wrong else None
    return SelfTest(problem, wrong, numpy, build, load, run, difference)


def _timed(run: Any) -> tuple[Any, float]:
    start = perf_counter()
    result = run()
    return result, perf_counter() - start
