"""The compiled executor: the same bits whatever the layout, the number of samples, the threads and the neighbours."""

from __future__ import annotations

import os
import sys
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from pathlib import Path
from threading import Event
from time import sleep

import numpy as np
import pytest
from helpers.array_layouts import LAYOUTS, PROGRAM, WIDTHS, expected, ready, state
from helpers.compiled_programs import bits, compiled, needs_compiler, program_of
from helpers.oracles import EPS, worst
from helpers.processes import python

import robodyn
from robodyn.dynamics.plan import torque_runner
from robodyn.programs.run import compiled_blocks
from robodyn.programs.run.compiled_blocks import BLOCK, CompiledBlocks
from robodyn.programs.run.llvm import kernel, machine
from robodyn.programs.run.numpy_blocks import NumpyBlocks
from robodyn.scene.scene import Scene

pytestmark = needs_compiler

SAMPLES = [1, 7, 9, 16, BLOCK - 1, BLOCK, BLOCK + 1, 4097]


@pytest.fixture
def busy_threads(monkeypatch):
    """Threads start however small the work is."""
    monkeypatch.setattr(compiled_blocks, "THREAD_WORK", 1)


def test_agrees_with_numpy():
    arrays = state(1000)
    found, plain = expected(arrays), NumpyBlocks(PROGRAM, WIDTHS)(arrays, 1000)
    finite = np.isfinite(plain)
    np.testing.assert_array_equal(np.isfinite(found), finite)
    assert worst(found[finite], plain[finite]) <= 4 * EPS
    flagged = {name: values[3::101] for name, values in arrays.items()}
    np.testing.assert_array_equal(found[3::101], NumpyBlocks(PROGRAM, WIDTHS)(flagged, len(flagged["a"])))


@pytest.mark.parametrize("samples", SAMPLES)
def test_any_number_of_samples(samples, busy_threads):
    arrays = state(samples)
    found = expected(arrays)
    if samples <= 16:
        apart = [ready()({name: x[[i]] for name, x in arrays.items()}, 1)[0] for i in range(samples)]
        np.testing.assert_array_equal(bits(found), bits(apart))
    few = {name: x[: samples // 2] for name, x in arrays.items()}
    np.testing.assert_array_equal(bits(found[: samples // 2]), bits(ready()(few, samples // 2)))
    last = {name: x[-1:] for name, x in arrays.items()}
    np.testing.assert_array_equal(bits(found[-1:]), bits(ready()(last, 1)))


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("layout", LAYOUTS)
def test_any_layout_and_thread_count(layout, dtype, busy_threads):
    for samples in (1, 9, BLOCK + 1, 4097):
        arrays = {name: LAYOUTS[layout](values) for name, values in state(samples, dtype).items()}
        right = bits(expected(arrays, dtype))
        for threads in (1, 3):
            np.testing.assert_array_equal(bits(ready(dtype)(arrays, samples, None, threads)), right)


def test_work_is_shared_among_threads(monkeypatch):
    """No more threads than asked for, and each has work enough."""
    started = []
    monkeypatch.setattr(compiled_blocks, "in_pool", lambda part, threads: started.append(threads))
    for shares, asked, threads in ((4, 1, 1), (4, 2, 2), (4, 9, 4), (1, 9, 1), (0.1, 9, 1)):
        samples = int(shares * compiled_blocks.THREAD_WORK / PROGRAM.size) + 1
        ready()(state(samples), samples, None, asked)
        assert started.pop() == threads


@pytest.mark.parametrize("begin", [(0,), (2, 0)])
def test_a_thread_takes_over_what_others_leave(begin, busy_threads, monkeypatch):
    """The first takes all pieces where the others come late."""

    def some(part, threads):
        assert threads == 3
        for number in begin:
            part(number)

    arrays = state(4097)
    right = expected(arrays)
    monkeypatch.setattr(compiled_blocks, "in_pool", some)
    np.testing.assert_array_equal(bits(ready()(arrays, 4097, None, 3)), bits(right))


def test_threads_inside_are_waited_for_and_those_that_are_late_do_not_begin():
    inside, done = Event(), []

    def slow(number):
        if number == 0:
            assert inside.wait(10)
        else:
            inside.set()
            sleep(0.05)
            done.append(number)

    compiled_blocks.in_pool(slow, 2)
    assert done == [1]
    with ThreadPoolExecutor(1) as busy, pytest.MonkeyPatch.context() as patch:
        patch.setattr(compiled_blocks, "_pool", lambda process: busy)
        inside.clear()
        busy.submit(inside.wait, 10)
        compiled_blocks.in_pool(done.append, 3)
        inside.set()
    assert done == [1, 0]


def test_an_error_in_another_thread_is_raised():
    begun = Event()

    def part(number):
        if number == 0:
            assert begun.wait(10)
        else:
            begun.set()
            raise OverflowError

    with pytest.raises(OverflowError):
        compiled_blocks.in_pool(part, 2)


ROBOT = Path(__file__).parents[3] / "robots" / "puma560.urdf"
TWO_THREADS = """
import numpy as np, os, robodyn, warnings
warnings.simplefilter("ignore", DeprecationWarning)  # of a fork where threads run
model = robodyn.load({robot!r})
q = np.random.default_rng(0).uniform(-1, 1, (20_000, model.n))
def torques(): return robodyn.inverse_dynamics(model, q, q, q, executor="compiled", threads=2)
before = torques()
child = os.fork() if {fork} else 1
assert (torques() == before).all()
if child == 0: os._exit(0)
assert not {fork} or os.waitpid(child, 0)[1] == 0
"""


@pytest.mark.parametrize(
    "fork", [False, pytest.param(True, marks=pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork"))]
)
def test_a_process_and_its_fork_have_threads_of_their_own_and_end(fork):
    assert python(TWO_THREADS.format(robot=str(ROBOT), fork=fork)).stderr == ""


X = np.random.default_rng(5).uniform(-3, 3, (100, 2))


def blocks():
    return CompiledBlocks(program_of(lambda x, y: [x.sin() * y + x, y.cos() / x, x * y, 2.0 * y], 2), {"x": 2})


@pytest.mark.parametrize("angle", [1e7, np.nan, np.inf])
def test_few_samples_left_to_numpy(angle):
    """The others keep their bits, and so do later calls, which find nothing of it in their room."""
    code = blocks()
    expected = code({"x": X[:8]}, 8)
    far = X[:8].copy()
    far[2, 0] = angle
    found = code({"x": far}, 8)
    np.testing.assert_array_equal(found[2], code._fallback({"x": far[2:3]}, 1)[0])
    np.testing.assert_array_equal(np.delete(found, 2, 0), np.delete(expected, 2, 0))
    assert not code._rooms[8]
    np.testing.assert_array_equal(code({"x": X[:8]}, 8), expected)
    assert len(code._rooms[8]) == 1


def test_few_samples_of_many_threads_at_once():
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
    assert 1 <= len(code._rooms[1]) <= 8


def test_wrong_shapes():
    for shape in ((3, 2), (4,), (4, 2, 1)):
        with pytest.raises(ValueError, match=r"x has shape .*, not \(4, 2\)"):
            blocks()({"x": np.zeros(shape)}, 4)


@pytest.fixture(params=["kept in caches", "past the caches"])
def way(request, monkeypatch):
    """How copied results are written: as those of small arrays, and as those of large ones."""
    if request.param == "past the caches":
        monkeypatch.setattr(compiled_blocks, "MOST_STREAMS", 0)
        monkeypatch.setattr(compiled_blocks, "MOST_KEPT", -1)
    return request.param


@pytest.mark.parametrize("layout", [name for name in LAYOUTS if name not in ("other bytes first", "fewer bits")])
def test_output_array_of_any_layout(layout, way, busy_threads):
    for samples in (8, 1000):
        arrays = state(samples)
        out = LAYOUTS[layout](np.full((samples, len(PROGRAM.outputs)), -7.0))
        assert ready()(arrays, samples, out, 3) is out
        np.testing.assert_array_equal(bits(out), bits(expected(arrays)))


@pytest.mark.parametrize("step", [1, 2, -1])
@pytest.mark.parametrize("order", "CF")
def test_nothing_beside_the_output_is_written(order, step, way):
    for samples in (1, 9, BLOCK + 5):
        table = np.full((samples * 2 + 40, 20), -7.0, order=order)
        inside = table[20 : 20 + samples * abs(step), 6:12][::step]
        ready()(state(samples), samples, inside)
        assert np.count_nonzero(table == -7.0) == table.size - inside.size
        np.testing.assert_array_equal(bits(inside), bits(expected(state(samples))))


def test_output_over_an_input(busy_threads):
    """In place, shifted by a sample, and laid across."""
    samples = 700
    right = bits(expected(state(samples)))
    for shift in (0, -1, 130):
        for order in "CF":
            table = np.zeros((samples + 200, 9), order=order)
            arrays = state(samples)
            arrays["a"] = table[10 : 10 + samples, 2:5]
            arrays["a"][...] = state(samples)["a"]
            out = table[10 + shift : 10 + shift + samples, 1:7] if shift >= 0 else table[9 : 9 + samples, 3:9]
            assert ready()(arrays, samples, out, 2) is out
            np.testing.assert_array_equal(bits(out), right)


@pytest.mark.filterwarnings("error")
def test_numbers_too_large_for_single_precision_warn_as_little_as_others():
    found = compiled(lambda x: [x * 2.0], 1, np.float32)({"x": np.array([[1e300], [-1e300], [3.0]])}, 3)
    np.testing.assert_array_equal(found[:, 0], [np.inf, -np.inf, 6.0])


@pytest.mark.parametrize("layout", ["rows", "both backwards", "unaligned"])
@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_repeated_outputs_of_any_layout(layout, dtype, way):
    """Each is computed once and copied to wherever it stands, from where it lies."""
    run = compiled(lambda x, y: [x * y, 0.0, x + y, x * y, 0.0, y, x * y, y], 2, dtype)
    x = np.random.default_rng(0).normal(size=(5 * BLOCK + 3, 2)).astype(dtype)
    p, q = x.T
    zeros = np.zeros(len(x))
    expected = np.column_stack((p * q, zeros, p + q, p * q, zeros, q, p * q, q))
    for samples in (1, BLOCK, len(x)):
        out = LAYOUTS[layout](np.full((samples, 8), -7.0, dtype))
        assert run({"x": np.asfortranarray(x[:samples])}, samples, out) is out
        np.testing.assert_array_equal(out, expected[:samples])


def test_no_inputs_no_outputs_no_samples():
    found = compiled(lambda: [2.5, -1.0, 2.5], 0)({}, 300, None, 2)
    np.testing.assert_array_equal(found, np.broadcast_to([2.5, -1.0, 2.5], (300, 3)))
    assert compiled(lambda x: [])({"x": np.zeros((5, 1))}, 5).shape == (5, 0)
    assert ready()(state(0), 0).shape == (0, len(PROGRAM.outputs))
    out = np.empty((0, len(PROGRAM.outputs)))
    assert ready()(state(0), 0, out, 4) is out


GUARDED = """
import ctypes, mmap
import numpy as np
import robodyn
from robodyn.dynamics.plan import torque_runner
from robodyn.programs.run import compiled_blocks
from robodyn.programs.run.compiled_blocks import CompiledBlocks
from robodyn.programs.vectors import sin
from robodyn.programs.program import trace

LIBC, PAGE = ctypes.CDLL(None), mmap.PAGESIZE
keep = []

def placed(samples, columns, order):
    "An array between two pages that may not be touched: the first byte after it, or before it, is forbidden."
    size = samples * columns * 8
    room = -(-size // PAGE) * PAGE
    memory = mmap.mmap(-1, room + 2 * PAGE)
    address = ctypes.addressof(ctypes.c_char.from_buffer(memory))
    for page in (address, address + PAGE + room):
        assert LIBC.mprotect(ctypes.c_void_p(page), PAGE, 0) == 0
    keep.append(memory)
    for first in (PAGE, PAGE + room - size):
        yield np.frombuffer(memory, np.float64, samples * columns, first).reshape((samples, columns), order=order)

compiled_blocks.MOST_STREAMS, compiled_blocks.MOST_KEPT = WAY

def outputs(t):
    "The first and the last share a result."
    y = sin(t.input("x", 0)) * t.input("x", 1)
    return [y, t.input("x", 0), y]

run = CompiledBlocks(trace(outputs), {"x": 2})
for samples in (1, 9, 131, 4097):
    for order in "CF":
        for x in placed(samples, 2, order):
            x[...] = np.arange(2 * samples).reshape(samples, 2)
            for out in placed(samples, 3, order):
                for each in (out, out[:, ::-1]):
                    run({"x": x}, samples, each, 2)
                    assert (each[:, 1] == x[:, 0]).all()
                    assert (each[:, 0] == each[:, 2]).all()
print("unharmed")
"""


@pytest.mark.skipif(sys.platform != "linux", reason="needs mprotect")
@pytest.mark.parametrize("limits", ["64, 1 << 22", "0, -1", "64, -1"])
def test_nothing_beside_the_arrays_is_touched(limits):
    assert python(GUARDED.replace("WAY", limits)).stdout == "unharmed\n"


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("vector", [32, 64])
def test_parts_of_a_program_leave_every_bit(dtype, vector, monkeypatch, tmp_path):
    """Torques of a robot in many parts, of 4 groups at a time and of more than there are; some samples with an angle
    that is too large; and in a single part, as what parts keep would be too much."""
    runner = torque_runner(robodyn.load(ROBOT), Scene())
    program, widths = runner.program, runner.widths
    monkeypatch.setattr(machine.Host, "vector", vector)
    rng = np.random.default_rng(8)
    sources = {name: rng.uniform(-3, 3, (403, width)).astype(dtype) for name, width in widths.items()}
    sources["q"][5::97, 1] *= 1e7
    found, sizes = [], []
    for part, groups, kept in ((10**9, 32, 10**9), (60, 4, 10**9), (60, 32, 10**9), (60, 32, 100)):
        for name, value in {"PART": part, "GROUPS": groups, "KEPT": kept}.items():
            monkeypatch.setattr(kernel, name, value)
        monkeypatch.setenv("ROBODYN_CACHE", str(tmp_path / f"{part}-{groups}-{kept}"))
        found.append(bits(CompiledBlocks(program, widths, dtype)(sources, 403)))
        sizes.append(compiled_blocks.kernel_of(program, widths, dtype).count("\nloop"))
    assert sizes[0] == sizes[3] == 2
    assert sizes[1] == sizes[2] > 8
    for each in found[1:]:
        np.testing.assert_array_equal(each, found[0])


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("last", ["constant", "input"])
@pytest.mark.parametrize("inputs", [3, 300])
def test_angles_are_looked_at_whatever_stands_last(last, inputs, dtype):
    """A constant or an input that is nothing but an output; in one part and in several."""

    def outputs(*x):
        return [*(a.sin() * b.cos() for a, b in pairwise(x[:-1])), {"constant": 7.0, "input": x[-1]}[last]]

    program = program_of(outputs, inputs)
    assert program.operations[-1][0] == last
    blocks, plain = (each(program, {"x": inputs}, dtype) for each in (CompiledBlocks, NumpyBlocks))
    x = np.random.default_rng(1).uniform(-3, 3, (40, inputs)).astype(dtype)
    x[3, 0] = x[8, 1] = 1e20
    x[11, -2] = np.inf
    found = blocks({"x": x}, 40)
    np.testing.assert_array_equal(bits(found[[3, 8, 11]]), bits(plain({"x": x[[3, 8, 11]]}, 3)))
    np.testing.assert_array_equal(bits(blocks({"x": x[:9]}, 9)), bits(found[:9]))


def test_zeros_with_a_sign():
    constants = compiled(lambda x: [-0.0, x, 0.0, -0.0])  # a trace takes all for one constant, the first
    few, many = (constants({"x": np.ones((samples, 1))}, samples)[0] for samples in (3, 20))
    np.testing.assert_array_equal(bits(few), bits(many))
    np.testing.assert_array_equal(np.signbit(many), [True, False, True, True])
