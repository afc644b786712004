"""Printed digits do not come from BLAS or LAPACK, whose order of sums depends on the processor."""

from __future__ import annotations

import ast

from project.test_layers import MODULES

ANY_SCALAR = (
    *("dynamics.recursions", "dynamics.effects", "dynamics.momenta", "dynamics.balance", "dynamics.mass"),
    "dynamics.contacts.dual",
    *("programs.vectors", "programs.dual", "robot.kinematics", "robot.configuration"),
    *(
        "dynamics.loops.closure",
        "dynamics.loops.closed_chain",
        "equations.dae.equations",
        "equations.dae.state",
        "equations.dae.system",
    ),
    *("equations.dae.closed", "simulation.equations", "simulation.conserving"),
)
"""Parts that say `A @ B` of objects, which NumPy multiplies in order."""
NO_DIGITS = {
    "measure.accuracy.operations": "counts",
    "measure.speed": "times",
    "dynamics.constraints.torque_distribution": "ranks, and which rows vanish",
    "identification": "estimates and their errors, told to fewer digits than rounding reaches",
    "dynamics.forward": "the name of a joint; and products of objects",
    "equations.dae.counts": "ranks; the comparison has no matrix product of its own",
    "solids.mesh.integrate.kernel": "bounds, which are rounded",
    "solids.mesh.integrate.residues": "integers",
    "solids.mesh.read.scenes": "a sign",
    "simulation.loop_figures": "a rank",
    "dynamics.loops.closed_start": "a rank",
    "simulation.singular": "ranks, and times to four digits",
    "simulation.stiffness": "steps of 1, 2 and 5",
    "report.pictures.robot": "pictures",
    "scene.uncertainty": "a sign",
}
"""Parts that may use them, and what for."""
LINEAR_ALGEBRA = {"solve", "inv", "pinv", "lstsq", "svd", "qr", "eig", "eigh", "eigvals", "eigvalsh", "cholesky", "det"}
SUMS = {"dot", "vdot", "inner", "tensordot", "matmul"}


def _uses(tree: ast.AST, any_scalar: bool) -> set[str]:
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.MatMult) and not any_scalar:
            found.add("@")
        elif isinstance(node, ast.Attribute):
            of_linalg = isinstance(node.value, ast.Attribute) and node.value.attr == "linalg"
            if (of_linalg and node.attr in LINEAR_ALGEBRA) or (ast.unparse(node.value) == "np" and node.attr in SUMS):
                found.add(node.attr)
        elif isinstance(node, ast.Call) and ast.unparse(node.func) == "np.linalg.norm" and len(node.args) == 1:
            found |= set() if any(each.arg == "axis" for each in node.keywords) else {"norm without axis"}
    return found


def _among(module: str, parts: tuple[str, ...]) -> bool:
    return any(module == f"robodyn.{part}" or module.startswith(f"robodyn.{part}.") for part in parts)


def test_floats_are_multiplied_and_solved_in_one_order() -> None:
    found = {
        module: _uses(tree, _among(module, ANY_SCALAR))
        for module, tree in MODULES.items()
        if not _among(module, tuple(NO_DIGITS))
    }
    assert {module: sorted(uses) for module, uses in found.items() if uses} == {}


def test_named_axes_are_summed_in_one_place() -> None:
    """`einsum` of NumPy leaves what stood in memory where it sums over nothing."""
    bare = {module for module, tree in MODULES.items() if "einsum" in _of_numpy(tree)}
    assert bare == {"robodyn.support.sums"}


def _of_numpy(tree: ast.AST) -> set[str]:
    """Return the names that a module takes from NumPy."""
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and ast.unparse(node.value).split(".")[0] in ("np", "numpy"):
            found.add(node.attr)
        elif isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "numpy":
            found |= {alias.name for alias in node.names}
    return found
