"""Random samples for a robot, in every layout that executors take."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

import numpy as np
from numpy.typing import DTypeLike, NDArray

from robodyn.errors import InputError
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene

Floats = NDArray[np.float64]
Order = Literal["F", "C"]
LAYOUTS: dict[str, Order] = {"columnar": "F", "row-major": "C"}
MEMORY = 4 << 30
"""Bytes that samples may take."""
COPIES = 3
"""Of every number: in both layouts, and in both once more in single precision."""


def random_sources(model: Model, scene: Scene, samples: int) -> dict[str, Floats]:
    """Arrays for the programs of this robot, with columns contiguous: q up to 2, rates and further columns up to 3.

    All numbers are those of single precision, so that every executor works on the same; quaternions are of unit length
    within that.

    Raises:
        InputError: they would take too much memory.
    """
    columns = {"q": model.nq, "qd": model.n, "qdd": model.n, "columns": len(scene.columns)}
    size = 8 * COPIES * samples * (sum(columns.values()) + model.n)
    if size > MEMORY:
        raise InputError(
            f"{samples} samples of {model.n} joints take {size / 1e9:.0f} GB",
            remedy=f"--samples {MEMORY // (size // samples)} or fewer; 100000 suffice",
        )
    rng = np.random.default_rng(0)
    sources = {
        name: rng.uniform(-3.0, 3.0, (count, samples)).astype(np.float32).astype(np.float64).T
        for name, count in columns.items()
    }
    sources["q"] *= 2.0 / 3.0
    for joint in model.independent:
        if joint.kind == "floating":
            turn = sources["q"][:, joint.coordinate + 3 : joint.coordinate + 7]
            turn /= np.linalg.norm(turn, axis=1)[:, None]
    sources["q"] = np.asfortranarray(sources["q"].astype(np.float32), np.float64)
    return sources


def laid_out(sources: Mapping[str, Floats], order: Order, dtype: DTypeLike) -> dict[str, NDArray[Any]]:
    """The same numbers with contiguous columns ("F") or rows ("C")."""
    return {name: np.asarray(values, dtype, order) for name, values in sources.items()}
