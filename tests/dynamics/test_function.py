"""Functions of one sample: the numbers of the general calls, whatever they are called with, and no crash."""

from __future__ import annotations

import copy
import ctypes
import gc
import pickle
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from helpers.array_layouts import in_bytes
from helpers.busy_robot import BUSY_SCENE, busy_robot
from helpers.c_functions import compiled_c, needs_c
from helpers.oracles import EPS, random_state, robot, worst

import robodyn
from robodyn.dynamics import function as functions
from robodyn.dynamics.function import OF_ONE_SAMPLE, function
from robodyn.errors import InputError, SceneError
from robodyn.programs.run.llvm import python_call
from robodyn.scene.scene import ExternalWrench, Friction, Loop, Scene

ARM = robot("puma")
PUSHED = Scene(
    friction={"elbow": Friction(0.4, 0.8, -0.5, 1.7, 0.9)},
    wrenches=(ExternalWrench("forearm", ("push", 0.0, 2.0), (0.0, "twist", 0.0)),),
)


def called(kind, model=ARM, scene=PUSHED):
    """The function, its arguments, and what the general call returns."""
    rng = np.random.default_rng(7)
    q, qd, qdd = (x[0] for x in random_state(model, rng, 1))
    values = {"q": q, "qd": qd, "qdd": qdd, "tau": qdd, "columns": rng.uniform(-1, 1, len(scene.columns))}
    found = function(model, kind, scene=scene)
    given = [values[name] for name in found.arguments]
    own = [x for name, x in zip(found.arguments, given, strict=True) if name != "columns"]
    more = {"columns": dict(zip(scene.columns, values["columns"], strict=True))} if scene.columns else {}
    more = {} if kind in ("mass_matrix", "coriolis_matrix") else more
    expected = np.stack(getattr(robodyn, kind)(model, *own, scene=scene, executor="compiled", **more))
    return found, given, expected


OF_FREE_BASES = [pytest.param(kind, True, marks=pytest.mark.slow) for kind in OF_ONE_SAMPLE if kind.startswith("inv")]


@pytest.mark.parametrize(("kind", "free"), [*((kind, False) for kind in OF_ONE_SAMPLE), *OF_FREE_BASES])
def test_the_numbers_of_the_general_call(kind, free):
    found, given, expected = called(kind, *((busy_robot(True), BUSY_SCENE) if free else ()))
    result = found(*given)
    assert (result.shape, result.dtype, result.flags.c_contiguous) == (found.shape, np.float64, True)
    assert worst(result, expected) <= 8 * EPS
    out = np.full(found.shape, np.nan)
    assert found(*given, out=out) is out
    assert (out == result).all()


@pytest.mark.parametrize("far", [0.0, 1e9])
def test_written_over_an_argument_and_with_gaps(far):
    """What machine code declines is computed from the arguments as they were, though the result goes over one."""
    found, given, _ = called("inverse_dynamics")
    given[0] = given[0] + far
    expected = found(*given)
    for k in range(3):
        mine = [x.copy() for x in given]
        assert (found(*mine, out=mine[k]) == expected).all()
    every_other = np.zeros(2 * found.shape[0])[::2]
    assert found(*given, out=every_other) is every_other
    assert (every_other == expected).all()


def test_other_numbers_are_converted():
    """Lists, integers, other types, views with gaps, read-only and unaligned arrays: the same to the last bit."""
    found, given, _ = called("inverse_dynamics")
    whole = [np.round(x) for x in given]
    expected = found(*whole)
    for change in (
        list,
        tuple,
        lambda x: x.astype(np.float32),
        lambda x: x.astype(int),
        lambda x: x.astype(x.dtype.newbyteorder()),
        lambda x: np.repeat(x, 2)[::2],
        lambda x: x[::-1].copy()[::-1],
        lambda x: in_bytes(x[None], 3, x.itemsize)[0],
        lambda x: x.view(np.recarray),
    ):
        assert (found(*map(change, whole)) == expected).all()
    for x in whole:
        x.flags.writeable = False
    assert (found(*whole) == expected).all()


def test_large_angles_are_reduced_with_care():
    """The C function declines angles by the root of the sum of their squares; the call computes them all the same."""
    found, given, _ = called("inverse_dynamics")
    columns, far = dict(zip(PUSHED.columns, given[3], strict=True)), given[0] + 1e9
    expected = robodyn.inverse_dynamics(ARM, far, *given[1:3], scene=PUSHED, columns=columns, executor="numpy")
    assert (found(far, *given[1:]) == expected).all()
    assert np.isnan(found(np.full(ARM.n, np.nan), *given[1:])).any()
    f, out = in_c(found), np.empty(found.shape)
    turned = [2, 1]
    for angle, count, declined in ((0.7, 1, 0), (1.5e6, 1, 0), (1.2e6, 2, 1), (1.7e6, 1, 1)):
        q = given[0].copy()
        q[turned[:count]] = angle
        assert f(*(x.ctypes.data for x in (q, *given[1:], out))) == declined
        assert np.isfinite(found(q, *given[1:])).all()
        assert declined or (out == found(q, *given[1:])).all()


def in_c(found):
    return ctypes.CFUNCTYPE(ctypes.c_int64, *[ctypes.c_void_p] * (len(found.arguments) + 1))(found.address)


BAD = {
    "too few": (lambda a: a[:-1], {}, "arguments q, qd, qdd, columns: 3 given"),
    "too many": (lambda a: [*a, a[0]], {}, "5 given"),
    "short": (lambda a: [a[0][:-1], *a[1:]], {}, r"q has shape \(2,\), not \(3,\)"),
    "batch": (lambda a: [a[0][None], *a[1:]], {}, "it is one sample"),
    "number": (lambda a: [0.0, *a[1:]], {}, r"q has shape \(\)"),
    "words": (lambda a: ["elbow", *a[1:]], {}, "q is no array of numbers"),
    "nothing": (lambda a: [None, *a[1:]], {}, "q is no array of numbers"),
    "complex": (lambda a: [a[0] * 1j, *a[1:]], {}, "q is no array of numbers"),
    "ragged": (lambda a: [[[1.0], 2.0], *a[1:]], {}, "q is no array of numbers"),
    "short out": (lambda a: a, {"out": np.empty(6)}, "out "),
    "integers out": (lambda a: a, {"out": np.empty(3, int)}, "out "),
    "list out": (lambda a: a, {"out": [0.0] * 3}, "out "),
    "read-only out": (lambda a: a, {"out": np.broadcast_to(0.0, (3,))}, "read-only"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_calls(case):
    change, more, words = BAD[case]
    found, given, _ = called("inverse_dynamics")
    with pytest.raises(InputError, match=words):
        found(*change(list(given)), **more)
    with pytest.raises(TypeError):
        found(*given, to=np.empty(3))


@needs_c
def test_called_from_c(tmp_path):
    """A program of C that is handed the address falls with the arm: semi-implicit steps, as here."""
    text = """#include <stdint.h>
typedef int64_t acceleration(const double *q, const double *qd, const double *tau, double *qdd);
int fall(acceleration *f, double *q, double *qd, const double *tau, int steps, double h) {
    double qdd[6];
    for (int k = 0; k < steps; k++) {
        if (f(q, qd, tau, qdd)) return k;
        for (int i = 0; i < 6; i++) { qd[i] += h * qdd[i]; q[i] += h * qd[i]; }
    }
    return steps;
}"""
    fall = compiled_c(text, tmp_path).fall
    found, tau = function(robot("puma560"), "forward_dynamics"), np.zeros(6)
    states = [[np.full(6, 0.3), np.zeros(6)] for _ in range(2)]
    at = [ctypes.c_void_p(x.ctypes.data) for x in (*states[0], tau)]
    assert fall(ctypes.c_void_p(found.address), *at, 100, ctypes.c_double(1e-3)) == 100
    q, qd = states[1]
    for _ in range(100):
        qd += 1e-3 * found(q, qd, tau)
        q += 1e-3 * qd
    assert worst(states[0], states[1]) <= 1e-12
    states[0][0][:] = 1e9
    assert fall(ctypes.c_void_p(found.address), *at, 100, ctypes.c_double(1e-3)) == 0


def test_called_by_threads_at_once():
    """ctypes gives Python's lock away, so calls of the C function overlap; they share no memory."""
    found, given, _ = called("inverse_dynamics")
    f = in_c(found)

    def wrong(k):
        mine = [x + 0.1 * k for x in given]
        expected, out = found(*mine), np.empty(found.shape)
        at = [x.ctypes.data for x in (*mine, out)]
        return sum(f(*at) or not (out == expected).all() for _ in range(100))

    with ThreadPoolExecutor(4) as pool:
        assert not any(pool.map(wrong, range(8)))


def test_it_outlives_its_model():
    gc.freeze()  # collections look at what this test makes, not at all that others have left
    found, given, _ = called("inverse_dynamics", scene=Scene(gravity=(0.1, 0.2, 0.3)))
    expected = found(*given)
    functions._function.cache_clear()
    gc.collect()
    call = found.__call__
    del found
    gc.collect()
    assert (call(*given) == expected).all()


@pytest.mark.parametrize("again", [lambda f: pickle.loads(pickle.dumps(f)), copy.copy, copy.deepcopy])
def test_pickled_and_copied(again):
    found, given, _ = called("inverse_dynamics")
    other = again(found)
    assert (other(*given) == found(*given)).all()
    assert repr(other) == repr(found)
    assert other.address is not None


def test_nothing_leaks():
    found, given, _ = called("inverse_dynamics")
    out = np.empty(found.shape)
    calls = {
        "new": lambda: found(*given),
        "out": lambda: found(*given, out=out),
        "converted": lambda: found(list(given[0]), *given[1:]),
    }
    for name, call in calls.items():
        call()
        before = [sys.getrefcount(x) for x in (*given, out, np.dtype(float))]
        for _ in range(1000):
            call()
        after = [sys.getrefcount(x) for x in (*given, out, np.dtype(float))]
        assert max(b - a for a, b in zip(before, after, strict=True)) < 20, name


@pytest.mark.parametrize("case", ["no compiler", "another Python"])
def test_without_machine_code(case, monkeypatch):
    """The same results, slowly, and no address."""
    fast, given, _ = called("inverse_dynamics")
    functions._function.cache_clear()
    if case == "no compiler":
        monkeypatch.setattr(functions, "compiler_problem", lambda: "llvmlite is not installed")
    else:
        monkeypatch.setattr(python_call, "_usual", lambda: False)
    slow, given, _ = called("inverse_dynamics")
    functions._function.cache_clear()
    assert slow.address is None
    assert worst(slow(*given), fast(*given)) <= 1e-13


def test_words():
    model = robot("pendulum")
    assert repr(function(model, "inverse_dynamics")) == "<inverse_dynamics(q[1], qd[1], qdd[1])>"
    with pytest.raises(InputError, match=r"there is no function 'inverse_dynamic' of one sample.*inverse_dynamics"):
        function(model, "inverse_dynamic")
    with pytest.raises(InputError, match="there is no function"):
        function(model, ["inverse_dynamics"])
    with pytest.raises(SceneError, match="elbow"):
        function(model, "inverse_dynamics", scene=Scene(friction={"elbow": Friction(0.1)}))
    with pytest.raises(SceneError, match="loop"):
        function(busy_robot(), "inverse_dynamics", scene=Scene(loops=(Loop("l", "tool"),)))
