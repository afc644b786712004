"""Exported Python modules: they compute what robodyn computes, and libraries differentiate them."""

from __future__ import annotations

import ast

import numpy as np
import pytest
from helpers.exported import ARGUMENTS, CASES, arguments, expected, module_of, named, states, tolerance, turns
from helpers.oracles import worst
from helpers.peers import peer

import robodyn
from robodyn.equations.export.export import TARGETS, WORDS

slow = pytest.mark.slow
WHOLE = ",".join(ARGUMENTS)


@pytest.fixture(autouse=True)
def _double_precision_of_jax(request):
    if "jax" not in request.node.name:
        yield
        return
    module = peer("jax")
    before = module.config.jax_enable_x64
    module.config.update("jax_enable_x64", True)
    yield
    module.config.update("jax_enable_x64", before)


def test_every_function_is_tried():
    assert set(ARGUMENTS) == set(WORDS)
    assert set(TARGETS) == {"c", *MODULES}


def by_arrays(module, word):
    return getattr(module, word)


def by_torch(module, word):
    return lambda *arrays: getattr(module, word)(*map(peer("torch").as_tensor, arrays))


def by_casadi(module, word):
    """Sample after sample; vectors are columns there."""
    function = getattr(module, word)
    assert function.name() == word
    assert tuple(function.name_in())[: len(ARGUMENTS[word])] == ARGUMENTS[word]

    def call(*arrays):
        found = [function.call(list(rows)) for rows in zip(*arrays, strict=True)]
        results = [np.stack([np.asarray(each.full()) for each in result]) for result in zip(*found, strict=True)]
        flat = ("tau", "b", "qdd", "rest")
        return [x[..., 0] if name in flat else x for name, x in zip(function.name_out(), results, strict=True)]

    return call


MODULES = {"numpy": by_arrays, "jax": by_arrays, "torch": by_torch, "casadi": by_casadi}


@pytest.mark.parametrize(
    ("target", "case"),
    [
        ("numpy", "free"),
        *((target, "mimic") for target in MODULES),
        *(pytest.param("numpy", case, marks=slow) for case in ("scara", "puma560")),
        *(pytest.param(target, case, marks=slow) for target in MODULES for case in ("free", "columns")),
    ],
)
def test_modules_compute_what_robodyn_computes(target, case):
    peer(target)
    model, scene = CASES[case]()
    given, columns = states(model, scene)
    module = module_of(robodyn.export(model, target, WHOLE, scene=scene))
    for word in ARGUMENTS:
        found = MODULES[target](module, word)(*arguments(word, given, columns))
        found = found if isinstance(found, (tuple, list)) else [found]
        right = expected(word, model, scene, given, columns)
        assert len(found) == len(right)
        bound = tolerance(word, model, scene, given)
        assert max(worst(np.asarray(ours), theirs) for ours, theirs in zip(found, right, strict=True)) <= bound, word


def by_complex_steps(torques, given):
    out = []
    for k, array in enumerate(given):
        steps = 1e-30j * np.eye(array.shape[-1])[:, None]
        moved = torques(*(array + steps if i == k else other for i, other in enumerate(given)))
        out.append(np.moveaxis(moved.imag, 0, -1) / 1e-30)
    return out


def by_casadis_graphs(torques, given):
    casadi = peer("casadi")
    symbols = [casadi.MX.sym(name, array.shape[1]) for name, array in zip(("q", "qd", "qdd"), given, strict=True)]
    tau = torques(*symbols)
    function = casadi.Function("J", symbols, [casadi.jacobian(tau, each) for each in symbols])
    rows = [function.call(list(row)) for row in zip(*given, strict=True)]
    return [np.stack([each.full() for each in column]) for column in zip(*rows, strict=True)]


def by_jax(way):
    def jacobians(torques, given):
        jax = peer("jax")
        return jax.jit(jax.vmap(getattr(jax, way)(torques, argnums=(0, 1, 2))))(*given)

    return jacobians


def by_torchs_functions(way):
    def jacobians(torques, given):
        torch = peer("torch")
        derivative = torch.func.vmap(getattr(torch.func, way)(torques, argnums=(0, 1, 2)))
        return derivative(*map(torch.as_tensor, given))

    return jacobians


@pytest.mark.parametrize(
    ("target", "case", "jacobians"),
    [
        ("numpy", "free", by_complex_steps),
        ("casadi", "free", by_casadis_graphs),
        ("jax", "mimic", by_jax("jacrev")),
        ("torch", "mimic", by_torchs_functions("jacrev")),
        pytest.param("numpy", "busy_free", by_complex_steps, marks=slow),
        pytest.param("casadi", "busy_free", by_casadis_graphs, marks=slow),
        pytest.param("jax", "scara", by_jax("jacfwd"), marks=slow),
        pytest.param("torch", "scara", by_torchs_functions("jacfwd"), marks=slow),
    ],
)
def test_libraries_differentiate_them(target, case, jacobians):
    """d tau / d (q, qd, qdd), (samples, n, nq or n) each, are robodyn's."""
    peer(target)
    model, scene = CASES[case]()
    q, qd, qdd = given = [states(model, scene)[0][name] for name in ("q", "qd", "qdd")]
    torques = module_of(robodyn.export(model, target, "torques", scene=scene)).torques
    by_q, by_qd, by_qdd = map(np.asarray, jacobians(torques, given))
    right = robodyn.inverse_dynamics_derivatives(model, q, qd, qdd, scene=scene)
    for found, exact in zip((by_q @ turns(model, q), by_qd, by_qdd), right, strict=True):
        assert worst(found, exact) <= 1e-12


def test_shapes_of_numpy():
    model, scene = named("scara")
    module, given = module_of(robodyn.export(model, "numpy", WHOLE)), states(model, scene)[0]
    q, qd, qdd = given["q"], given["qd"], given["qdd"]
    tau = module.torques(q, qd, qdd)
    in_threes = [x.reshape(2, 3, 3) for x in (q, qd, qdd)]
    assert (module.torques(*in_threes[:2], qdd=in_threes[2]).reshape(6, 3) == tau).all()
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


def test_zeros_of_casadi_are_structural():
    peer("casadi")
    module = module_of(robodyn.export(named("scara")[0], "casadi", "mass_matrix"))
    pattern = np.array(module.mass_matrix.sparsity_out(0).nnz())
    M = robodyn.mass_matrix(named("scara")[0], [0.1, 0.2, 0.03])
    assert pattern == np.count_nonzero(M) < 9


def test_autograd_and_types_of_torch():
    torch = peer("torch")
    model, scene = named("scara")
    module, given = module_of(robodyn.export(model, "torch", "torques,mass_matrix")), states(model, scene)[0]
    q, qd, qdd = (torch.tensor(given[name], requires_grad=True) for name in ("q", "qd", "qdd"))
    module.torques(q, qd, qdd).sum().backward()
    right = robodyn.inverse_dynamics_derivatives(model, given["q"], given["qd"], given["qdd"])
    assert worst(q.grad, right.dq.sum(axis=-2)) <= 1e-12
    assert module.mass_matrix(q.float()).dtype == torch.float32


@pytest.mark.parametrize("target", MODULES)
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
