"""When integrals are left to machine code, and what it adds up."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from robodyn.programs.run.llvm import machine
from robodyn.programs.vectors import Array
from robodyn.solids.mesh import kernel
from robodyn.solids.mesh.kernel import LEAST, SUMS, TOGETHER, Kernel, kernel_for, triangle_program, volume_kernel
from robodyn.solids.mesh.triangles import ROWS, workspace


@pytest.fixture(autouse=True)
def _nothing_made_yet(monkeypatch: pytest.MonkeyPatch) -> None:
    """No machine code of an earlier test is at hand."""
    kernel._machine_code.cache_clear()
    monkeypatch.setattr(kernel, "_seen", kernel._Seen())


def test_from_some_ten_million_triangles_on() -> None:
    """What machine code saves on them is more than its start."""
    millions = (0.2, 0.5, 1, 2, 5, 10, 20)
    assert [kernel._worth_its_start(int(1e6 * each)) for each in millions] == [False] * 5 + [True] * 2


def test_small_meshes_do_not_ask() -> None:
    assert kernel_for(LEAST - 1) is volume_kernel


def test_once_made_it_is_used(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("llvmlite")
    assert kernel_for(100_000_000) is not volume_kernel
    assert kernel_for(LEAST) is not volume_kernel


def test_many_meshes_are_worth_what_a_larger_one_is() -> None:
    """As soon as the meshes before it were: the second of five million triangles."""
    pytest.importorskip("llvmlite.binding")
    assert [kernel_for(5_000_000) is volume_kernel for _ in range(4)] == [True, False, False, False]


def test_without_a_compiler(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(machine, "compiler_problem", lambda: "no llvmlite")
    assert kernel_for(100_000_000) is volume_kernel


def test_where_it_does_not_compile(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("llvmlite")

    def fails(*_: object, **__: object) -> None:
        raise RuntimeError("no such processor")

    monkeypatch.setattr("robodyn.programs.run.compiled_blocks.CompiledBlocks", fails)
    assert kernel_for(100_000_000) is volume_kernel


@pytest.mark.parametrize("rows", [256, ROWS])
def test_moments_are_those_of_numpy_to_the_bit(rows: int) -> None:
    """So that it does not show what a process has had before; sizes in the order of the triangles."""
    pytest.importorskip("llvmlite")
    (sums, sizes), (expected, expected_sizes) = (taken(make, rows) for make in (kernel_for(100_000_000), volume_kernel))
    np.testing.assert_array_equal(sizes, expected_sizes)
    np.testing.assert_array_equal(sums[:SUMS], expected[:SUMS])
    np.testing.assert_allclose(sums[SUMS:], expected[SUMS:], rtol=1e-13)


def taken(make: Callable[[Array], Kernel], rows: int) -> tuple[Array, Array]:
    """Sums and sizes of a block of random triangles."""
    space = workspace(12, rows).reshape(4, 3, rows)
    kernel = make(space)
    space[:3] = np.random.default_rng(rows).normal(size=(3, 3, rows))
    for function, arguments in kernel.steps:
        function(*arguments)
    return kernel.result, kernel.sizes


def test_operations() -> None:
    """What a triangle costs: 86, and the 17 sums with its neighbour."""
    assert triangle_program().size == 86 * TOGETHER + 17 * (TOGETHER - 1)
