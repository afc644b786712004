"""Contact forces of blocks of samples, by the solver that suits what they cost and what bounds them."""

from __future__ import annotations

from robodyn.dynamics.contacts.plain import plain_forces
from robodyn.dynamics.contacts.problem import Forces, Problem


def contact_forces(problem: Problem, executor: str = "auto", expected: int = 0) -> Forces:
    """Return the forces of least cost that the equations, the cones and the limits allow.

    Where forces alone are unknown and cost, Newton's method on the dual finds those of all samples at a time; what else
    there is goes to Clarabel, one sample after another. Each sample is solved by itself, so results do not depend on
    its neighbours where an executor is named. Forces of hundreds of times |b|, as between wedges, may not be found.

    Args:
        problem: of N samples.
        executor: of the programs: "auto", "numpy" or "compiled".
        expected: samples of the whole work that these are a part of; 0: these are all.

    Raises:
        InputError: Clarabel is needed and not installed.

    Accuracy: without costs of torques and free unknowns, the residual is at most 1e-12 of |b| or |f| where forces
        exist, and their cost is the least to 1e-8 |b|^2; else what Clarabel reaches, 1e-9 |b|.
    """
    if not problem.plain:
        from robodyn.dynamics.contacts.conic import conic_forces

        return conic_forces(problem)
    return plain_forces(problem, executor, expected)
