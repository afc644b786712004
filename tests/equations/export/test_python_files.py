"""Exported Python modules: they compute what robodyn computes, and libraries differentiate them."""

from __future__ import annotations

import ast

import numpy as np
import pytest
from helpers.exported import (
    ARGUMENTS,
    CASES,
    arguments,
    each_case,
    expected,
    module_of,
    named,
    states,
    tolerance,
    turns,
)
from helpers.oracles import worst
from helpers.peers import peer

import robodyn
from robodyn.equations.export.export import TARGETS, WORDS

slow = pytest.mark.slow
WAYS = [
    ("scara", "jacrev"),
    pytest.param("scara", "jacfwd", marks=slow),
    pytest.param("busy_free", "jacrev", marks=slow),
]
WHOLE = ",".join(ARGUMENTS)
few = pytest.mark.parametrize("case", ["mimic", pytest.param("free", marks=slow), pytest.param("columns", marks=slow)])
small = pytest.mark.parametrize("case", ["free", pytest.param("busy_free", marks=slow)])


def test_every_function_is_tried():
    assert set(ARGUMENTS) == set(WORDS)
    assert set(TARGETS) == {"c", "numpy", "casadi", "jax", "torch"}


def compared(call, word, case):
    """Compare what `call` makes of the arguments with robodyn."""
    model, scene = CASES[case]()
    given, columns = states(model, scene)
    found = call(*arguments(word, given, columns))
    found = found if isinstance(found, (tuple, list)) else [found]
    right = expected(word, model, scene, given, columns)
    assert len(found) == len(right)
    bound = tolerance(word, model, scene, given)
    assert max(worst(np.asarray(ours), theirs) for ours, theirs in zip(found, right, strict=True)) <= bound


def derivative_of_torques(case, jacobians):
    """Compare d tau / d (q, qd, qdd) that a library finds, (samples, n, nq or n) each, with robodyn's."""
    model, scene = CASES[case]()
    given, _ = states(model, scene)
    q, qd, qdd = (given[name] for name in ("q", "qd", "qdd"))
    by_q, by_qd, by_qdd = map(np.asarray, jacobians(robodyn.export, model, scene, q, qd, qdd))
    right = robodyn.inverse_dynamics_derivatives(model, q, qd, qdd, scene=scene)
    for found, exact in zip((by_q @ turns(model, q), by_qd, by_qdd), right, strict=True):
        assert worst(found, exact) <= 1e-12


@each_case
def test_numpy(case):
    module = module_of(robodyn.export(CASES[case]()[0], "numpy", WHOLE, scene=CASES[case]()[1]))
    for word in ARGUMENTS:
        compared(getattr(module, word), word, case)


def test_shapes_of_numpy():
    model, _ = named("scara")
    module = module_of(robodyn.export(model, "numpy", WHOLE))
    given, _ = states(model, named("scara")[1])
    q, qd, qdd = given["q"], given["qd"], given["qdd"]
    tau = module.torques(q, qd, qdd)
    assert (
        module.torques(q.reshape(2, 3, 3), qd.reshape(2, 3, 3), qdd=qdd.reshape(2, 3, 3)).reshape(6, 3) == tau
    ).all()
    assert module.torques(q[0], qd[0], qdd[0]).tolist() == tau[0].tolist()
    assert (module.torques(q, qd[0], qdd[0])[0] == tau[0]).all()
    assert module.torques(q[:0], qd[:0], qdd[:0]).shape == (0, 3)
    assert module.torques(*(x.astype(np.float32) for x in (q, qd, qdd))).dtype == np.float32
    M = module.mass_matrix(q)
    assert M.shape == (6, 3, 3)
    assert (np.swapaxes(M, -1, -2) == M).all()
    Y, rest = module.regressor(q, qd, qdd)
    assert worst(Y @ np.array(module.THETA) + rest, tau) <= 1e-13
    assert len(module.PARAMETERS) == Y.shape[-1]
    assert module.COORDINATES == module.RATES == model.rates
    for wrong in (q[:, :2], 0.0):
        with pytest.raises(ValueError, match=r"q has shape \(.*\), not \(\.\.\., 3\)"):
            module.mass_matrix(wrong)


@small
def test_complex_steps_through_numpy(case):
    def jacobians(export, model, scene, *given):
        module = module_of(export(model, "numpy", "torques", scene=scene))
        out = []
        for k, array in enumerate(given):
            steps = 1e-30j * np.eye(array.shape[-1])[:, None]
            moved = module.torques(*(array + steps if i == k else other for i, other in enumerate(given)))
            out.append(np.moveaxis(moved.imag, 0, -1) / 1e-30)
        return out

    derivative_of_torques(case, jacobians)


@few
def test_casadi(case):
    peer("casadi")
    model, scene = CASES[case]()
    module = module_of(robodyn.export(model, "casadi", WHOLE, scene=scene))
    for word in ARGUMENTS:
        function = getattr(module, word)
        assert function.name() == word
        assert tuple(function.name_in())[: len(ARGUMENTS[word])] == ARGUMENTS[word]

        def call(*arrays, function=function):
            found = [function.call(list(rows)) for rows in zip(*arrays, strict=True)]
            results = [np.stack([np.asarray(each.full()) for each in result]) for result in zip(*found, strict=True)]
            flat = ("tau", "b", "qdd", "rest")
            return [x[..., 0] if name in flat else x for name, x in zip(function.name_out(), results, strict=True)]

        compared(call, word, case)


@small
def test_derivatives_by_casadi(case):
    casadi = peer("casadi")

    def jacobians(export, model, scene, *given):
        torques = module_of(export(model, "casadi", scene=scene)).torques
        symbols = [casadi.MX.sym(name, array.shape[1]) for name, array in zip(("q", "qd", "qdd"), given, strict=True)]
        tau = torques(*symbols)
        function = casadi.Function("J", symbols, [casadi.jacobian(tau, each) for each in symbols])
        rows = [function.call(list(row)) for row in zip(*given, strict=True)]
        return [np.stack([each.full() for each in column]) for column in zip(*rows, strict=True)]

    derivative_of_torques(case, jacobians)


def test_zeros_of_casadi_are_structural():
    peer("casadi")
    module = module_of(robodyn.export(named("scara")[0], "casadi", "mass_matrix"))
    pattern = np.array(module.mass_matrix.sparsity_out(0).nnz())
    M = robodyn.mass_matrix(named("scara")[0], [0.1, 0.2, 0.03])
    assert pattern == np.count_nonzero(M) < 9


@pytest.fixture
def jax():
    module = peer("jax")
    before = module.config.jax_enable_x64
    module.config.update("jax_enable_x64", True)
    yield module
    module.config.update("jax_enable_x64", before)


@few
def test_jax(case, jax):
    model, scene = CASES[case]()
    module = module_of(robodyn.export(model, "jax", WHOLE, scene=scene))
    for word in ARGUMENTS:
        compared(getattr(module, word), word, case)


@pytest.mark.parametrize(("case", "way"), WAYS)
def test_derivatives_by_jax(case, way, jax):
    def jacobians(export, model, scene, *given):
        torques = module_of(export(model, "jax", scene=scene)).torques
        derivative = jax.vmap(getattr(jax, way)(torques, argnums=(0, 1, 2)))
        return (derivative if case == "busy_free" else jax.jit(derivative))(*given)  # compiled in a minute

    derivative_of_torques(case, jacobians)


@few
def test_torch(case):
    torch = peer("torch")
    model, scene = CASES[case]()
    module = module_of(robodyn.export(model, "torch", WHOLE, scene=scene))
    for word in ARGUMENTS:

        def call(*arrays, word=word):
            found = getattr(module, word)(*map(torch.as_tensor, arrays))
            return found if isinstance(found, tuple) else [found]

        compared(call, word, case)


@pytest.mark.parametrize(("case", "way"), WAYS)
def test_derivatives_by_torch(case, way):
    torch = peer("torch")

    def jacobians(export, model, scene, *given):
        torques = module_of(export(model, "torch", scene=scene)).torques
        return torch.func.vmap(getattr(torch.func, way)(torques, argnums=(0, 1, 2)))(*map(torch.as_tensor, given))

    derivative_of_torques(case, jacobians)


def test_autograd_and_types_of_torch():
    torch = peer("torch")
    model, _ = named("scara")
    module = module_of(robodyn.export(model, "torch", "torques,mass_matrix"))
    given, _ = states(model, named("scara")[1])
    q, qd, qdd = (torch.tensor(given[name], requires_grad=True) for name in ("q", "qd", "qdd"))
    module.torques(q, qd, qdd).sum().backward()
    right = robodyn.inverse_dynamics_derivatives(model, given["q"], given["qd"], given["qdd"])
    assert worst(q.grad, right.dq.sum(axis=-2)) <= 1e-12
    assert module.mass_matrix(q.float()).dtype == torch.float32


@pytest.mark.parametrize("target", ["numpy", "jax", "torch", "casadi"])
def test_modules_import_their_library_alone(target):
    tree = ast.parse(robodyn.export(named("scara")[0], target, WHOLE))
    found = {alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names}
    found |= {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    assert {name.partition(".")[0] for name in found} <= {target, "math"}


def docstring(case, target, what):
    model, scene = CASES[case]()
    return ast.get_docstring(ast.parse(robodyn.export(model, target, what, scene=scene)))


def test_the_docstring_says_what_is_in_the_module():
    text, plain = docstring("columns", "jax", "torques,derivatives"), docstring("scara", "jax", "torques")
    aside = ("sign(0) = 0", "small turn about the", "'push', 'twist'", "Columns of d / d q are by the coordinates")
    for words in (
        *aside,
        "quaternion qx qy qz qw",
        "jax_enable_x64",
        "torques(q, qd, qdd, columns) -> tau: the torques of a motion; ",
        "tau and b [N m or N]",
    ):
        assert words in text
    assert not [words for words in aside if words in plain]
    assert "Gravity (0.0, 0.0, -9.81) m/s^2" in plain
    mimic = docstring("mimic", "numpy", "torques")
    for words in ('Dynamics of "gripper" for ', "q[0]  lift: prismatic, m", "jaw + "):
        assert words in mimic


def test_the_length_of_a_quaternion_does_not_matter():
    model, scene = CASES["busy_free"]()
    torques = module_of(robodyn.export(model, "numpy", scene=scene)).torques
    given, _ = states(model, scene)
    q = given["q"].copy()
    q[:, 3:7] *= 1.7
    assert worst(torques(q, given["qd"], given["qdd"]), torques(given["q"], given["qd"], given["qdd"])) <= 1e-13
