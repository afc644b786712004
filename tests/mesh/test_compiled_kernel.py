"""When integrals are left to machine code, and what it adds up."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from robodyn.execute.llvm import machine
from robodyn.mesh import compiled_kernel
from robodyn.mesh.blocks import ROWS, workspace
from robodyn.mesh.compiled_kernel import LEAST, TOGETHER, kernel_for, triangle_program
from robodyn.mesh.kernel import volume_kernel

MILLIONS = (0.2, 0.5, 1, 2, 5, 10, 20)


@pytest.fixture(autouse=True)
def _nothing_made_yet(monkeypatch: pytest.MonkeyPatch) -> None:
    """No machine code of an earlier test is at hand."""
    compiled_kernel._machine_code.cache_clear()
    monkeypatch.setattr(compiled_kernel, "_is_kept", lambda: True)
    monkeypatch.setattr(compiled_kernel, "_seen", compiled_kernel._Seen())


def first_worth(monkeypatch: pytest.MonkeyPatch, started: bool, kept: bool) -> float:
    """Millions of triangles of the smallest mesh that is left to machine code; all larger ones are, too."""
    monkeypatch.setattr(compiled_kernel, "_is_kept", lambda: kept)
    if started:
        monkeypatch.setitem(sys.modules, "llvmlite.binding", sys)
    else:
        monkeypatch.delitem(sys.modules, "llvmlite.binding", raising=False)
    worth = [compiled_kernel._worth_its_start(int(1e6 * each)) for each in MILLIONS]
    assert worth == sorted(worth)
    return MILLIONS[worth.index(True)]


def test_the_more_there_is_the_sooner_it_is_worth_it(monkeypatch: pytest.MonkeyPatch) -> None:
    least = [first_worth(monkeypatch, *there) for there in ((True, True), (True, False), (False, True), (False, False))]
    assert least == [0.5, 2, 10, 10]


def test_small_meshes_do_not_ask() -> None:
    assert kernel_for(LEAST - 1) is volume_kernel


def test_once_made_it_is_used(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("llvmlite")
    assert kernel_for(100_000_000) is not volume_kernel
    assert kernel_for(LEAST) is not volume_kernel


def test_many_meshes_are_worth_what_a_larger_one_is(monkeypatch: pytest.MonkeyPatch) -> None:
    """As soon as the meshes before it were: the second of a million triangles, where code is yet to be made."""
    pytest.importorskip("llvmlite.binding")
    monkeypatch.setattr(compiled_kernel, "_is_kept", lambda: False)
    kernels = [kernel_for(1_000_000) is volume_kernel for _ in range(5)]
    assert kernels == [True, False, False, False, False]


def test_without_a_compiler(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(machine, "compiler", lambda: machine.Compiler("no llvmlite", None))
    assert kernel_for(100_000_000) is volume_kernel


def test_where_it_does_not_compile(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("llvmlite")

    def fails(*_: object) -> None:
        raise RuntimeError("no such processor")

    monkeypatch.setattr("robodyn.execute.compiled_blocks.CompiledBlocks", fails)
    assert kernel_for(100_000_000) is volume_kernel


@pytest.mark.parametrize("rows", [256, ROWS])
def test_sums_are_those_of_numpy(rows: int) -> None:
    """Within the rounding of sums of so many terms; sizes in the order of the triangles."""
    pytest.importorskip("llvmlite")
    corners = np.random.default_rng(rows).normal(size=(3, 3, rows))
    found = []
    for make in (kernel_for(100_000_000), volume_kernel):
        space = workspace(12, rows).reshape(4, 3, rows)
        kernel = make(space)
        space[:3] = corners
        for function, arguments in kernel.steps:
            function(*arguments)
        found.append((kernel.result, kernel.sizes))
    (sums, sizes), (expected, expected_sizes) = found
    np.testing.assert_allclose(sizes, expected_sizes, rtol=1e-14)
    np.testing.assert_allclose(sums, expected, atol=8 * np.finfo(float).eps * np.abs(expected).max())


def test_operations() -> None:
    """What a triangle costs: 86, and the 17 sums with its neighbour."""
    assert triangle_program().size == 86 * TOGETHER + 17 * (TOGETHER - 1)
