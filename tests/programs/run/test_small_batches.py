"""Few samples by machine code: in room that is kept, to the same bits as among many."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from helpers.compiled_programs import needs_compiler, program_of

from robodyn.programs.run import compiled_blocks
from robodyn.programs.run.compiled_blocks import FEW, CompiledBlocks

pytestmark = needs_compiler
PROGRAM = program_of(lambda x, y: [x.sin() * y + x, y.cos() / x, x * y, 2.0 * y], 2)
X = np.random.default_rng(5).uniform(-3, 3, (100, 2))


def blocks(dtype=np.float64):
    return CompiledBlocks(PROGRAM, {"x": 2}, dtype)


REPEATED = program_of(lambda x, y: [x * y, x.sin(), x * y, x + y, x.sin()], 2)


@pytest.mark.parametrize("program", [PROGRAM, REPEATED])
@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_the_bits_of_many_samples(dtype, program):
    code, x = CompiledBlocks(program, {"x": 2}, dtype), X.astype(dtype)
    many = code({"x": x}, len(x))
    for samples in [*range(1, FEW + 2), 3, 1]:
        for start in (0, 5):
            part = x[start : start + samples]
            np.testing.assert_array_equal(code({"x": part}, samples), many[start : start + samples])


def test_they_are_done_at_once(monkeypatch):
    monkeypatch.setattr(compiled_blocks, "in_pool", None)
    code = blocks()
    rooms = [code({"x": X[:samples]}, samples) is not None and code._rooms[0] for samples in (1, FEW)]
    assert rooms[0] is rooms[1]
    with pytest.raises(TypeError):
        code({"x": X[: FEW + 1]}, FEW + 1)


@pytest.mark.parametrize("layout", ["rows", "columns", "gaps", "backwards", "one for all", "read-only"])
def test_any_layout(layout):
    x = {
        "rows": X[:4].copy(),
        "columns": np.asfortranarray(X[:4]),
        "gaps": np.repeat(X[:4], 3, axis=0)[::3],
        "backwards": X[:4][::-1].copy()[::-1],
        "one for all": np.broadcast_to(X[0], (4, 2)),
        "read-only": X[:4].view(),
    }[layout]
    if layout == "read-only":
        x.flags.writeable = False
    code = blocks()
    np.testing.assert_array_equal(code({"x": x}, 4), code({"x": np.concatenate([x] * 9)}, 36)[:4])


def test_results_over_inputs():
    code = blocks()
    memory = np.zeros((8, 4))
    memory[:, :2] = X[:8]
    expected = code({"x": X[:8]}, 8)
    assert code({"x": memory[:, :2]}, 8, memory) is memory
    np.testing.assert_array_equal(memory, expected)


@pytest.mark.parametrize("angle", [1e7, np.nan, np.inf])
def test_samples_left_to_numpy(angle):
    """The others keep their bits, and so do later calls, which find nothing of it in their room."""
    code = blocks()
    expected = code({"x": X[:8]}, 8)
    far = X[:8].copy()
    far[2, 0] = angle
    found = code({"x": far}, 8)
    np.testing.assert_array_equal(found[2], code._fallback({"x": far[2:3]}, 1)[0])
    np.testing.assert_array_equal(np.delete(found, 2, 0), np.delete(expected, 2, 0))
    assert not code._rooms
    np.testing.assert_array_equal(code({"x": X[:1]}, 1), expected[:1])
    assert len(code._rooms) == 1


def test_other_numbers_are_converted():
    code = blocks()
    x = np.round(X[:4])
    expected = code({"x": x}, 4)
    for dtype in (int, np.float32, ">f8"):
        np.testing.assert_array_equal(code({"x": x.astype(dtype)}, 4), expected)
    out = np.empty((4, 4), np.float32)
    np.testing.assert_array_equal(code({"x": x}, 4, out), expected.astype(np.float32))


@pytest.mark.parametrize("shape", [(3, 2), (4, 3), (4,), (4, 2, 1)])
def test_wrong_shapes(shape):
    with pytest.raises(ValueError, match=r"x has shape .*, not \(4, 2\)"):
        blocks()({"x": np.zeros(shape)}, 4)


def test_many_threads_at_once():
    """Each has room of its own, and what is left is no more than they were."""
    code = blocks()
    expected = code({"x": X}, len(X))

    def work(start):
        for k in range(60):
            row = (start + k) % 99
            if not (code({"x": X[row : row + 1]}, 1) == expected[row]).all():
                return False
        return True

    with ThreadPoolExecutor(8) as pool:
        assert all(pool.map(work, range(8)))
    assert 1 <= len(code._rooms) <= 8
