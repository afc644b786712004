"""Equations of loops that others imply wherever the loops are closed, if not elsewhere, as in Bennett's linkage."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from robodyn.dynamics.initial_state import initial_state
from robodyn.dynamics.loops.closed_chain import ClosedChain
from robodyn.dynamics.loops.closed_start import closed_near, closed_start
from robodyn.dynamics.loops.find import closed_chain, independent
from robodyn.dynamics.plan import Plan
from robodyn.errors import InputError
from robodyn.programs.linear import null_space
from robodyn.programs.vectors import product
from robodyn.support.floats import Floats

AWAY = 0.1
"""rad or m, to where the rank of J is looked at again."""
LOOKS = 3
FEW = 1e-6
"""Singular values of J that are a smaller part of the largest count as none: loops are closed to rounding there."""


@lru_cache(maxsize=16)
def independent_equations(plan: Plan) -> ClosedChain:
    """The closed chain without equations that depend on others where the motion begins and at closed places nearby.

    Steps leave the loops by a little, and there such equations contradict each other. Where the rank is less at the
    start alone, as for four-bars that lie flat, all are kept.
    """
    chain = closed_chain(plan)
    begun = _begun(plan)
    if begun is None:
        return chain
    J = chain.jacobian(chain.sample(begun.tolist()))
    rank = _rank(J)
    others = (chain.jacobian(chain.sample(q.tolist())) for q in nearby(chain, begun))
    if rank == chain.count or any(_rank(other) > rank for other in others):
        return chain
    return chain.keeping(independent(J, FEW))


def _begun(plan: Plan) -> Floats | None:
    """q where the motion begins; None where it cannot."""
    try:
        return closed_start(plan, initial_state(plan.model, plan.scene))[: plan.model.nq]
    except InputError:
        return None


def nearby(chain: ClosedChain, q: Floats) -> list[Floats]:
    """Return closed places that motions which the loops allow lead to from the closed place q (nq,)."""
    free = null_space(chain.jacobian(chain.sample(q.tolist())), FEW)
    drawn = product(np.random.default_rng(0).normal(size=(LOOKS, len(free))), free)
    places = [closed_near(chain, q, AWAY * u / max(float(np.abs(u).max(initial=0.0)), 1e-300)) for u in drawn]
    return [place for place in places if place is not None]


def _rank(J: Floats) -> int:
    values = np.linalg.svd(J, compute_uv=False)
    return int((values > FEW * values.max(initial=0.0)).sum())
