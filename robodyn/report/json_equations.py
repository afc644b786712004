"""The equations of motion as one JSON document with stable keys and full precision."""

from __future__ import annotations

from typing import Any

from robodyn.equations.closed import STATES, Closed
from robodyn.equations.ode import Ode


def ode_json(ode: Ode) -> str:
    """The document of the ODE form; a singular M has the condition null."""
    return _dumped(
        {
            "robot": ode.robot,
            "form": "ode",
            "gravity": ode.gravity,
            "coordinates": ode.coordinates,
            "rates": ode.rates,
            "units": ode.units,
            "q": ode.q.tolist(),
            "qd": ode.qd.tolist(),
            "M": ode.M.tolist(),
            "condition": None if ode.cond == float("inf") else ode.cond,
            "bias": ode.bias.tolist(),
            "shares": {name: share.tolist() for name, share in ode.shares.items()},
            "warnings": ode.warnings,
        }
    )


def closed_json(closed: Closed) -> str:
    """The document of the closed form; expressions are SymPy's, fractions exact."""
    return _dumped(
        {
            "robot": closed.robot,
            "form": "closed",
            "gravity": closed.gravity,
            "joints": [
                {"name": name, "kind": kind, "q": str(q), "qd": str(qd)}
                for name, kind, q, qd in zip(closed.joints, closed.kinds, closed.q, closed.qd, strict=True)
            ],
            "M": [[str(entry) for entry in row] for row in closed.M],
            "shares": {name: [str(entry) for entry in entries] for name, entries in closed.bias.items()},
            "check": {"states": STATES, "largest_difference": closed.error, "not_simplified": closed.plain},
        }
    )


def _dumped(document: dict[str, Any]) -> str:
    import json

    return json.dumps(document, indent=2, allow_nan=False) + "\n"
