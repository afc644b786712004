"""Derivatives of programs by differences of their values with 100 digits, which share nothing with `derivative`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robodyn.programs.program import Program
from robodyn.programs.run.multiprecision import Multiprecision


def exact_rates(
    program: Program, directions: Sequence[Mapping[tuple[str, int], Any]], sources: Mapping[str, NDArray[np.float64]]
) -> NDArray[np.object_]:
    """Return how fast the outputs change along each direction, which says how fast inputs (source, column) change.

    By differences over a step of 1e-40, right to about 40 digits where the program is smooth that far ahead.

    Returns:
        (samples, outputs, directions)
    """
    run, samples = Multiprecision(program, digits=100), len(next(iter(sources.values())))
    number = run.context.mpf
    step = number(10) ** -40
    exact = {name: np.vectorize(number, otypes=[object])(values) for name, values in sources.items() if values.size}
    here = run(exact, samples)
    rates = [(run(_moved(exact, direction, step), samples) - here) / step for direction in directions]
    return np.stack(rates, axis=2)


def _moved(sources: Mapping[str, Any], direction: Mapping[tuple[str, int], Any], step: Any) -> dict[str, Any]:
    moved = {name: values.copy() for name, values in sources.items()}
    for (source, column), rate in direction.items():
        moved[source][:, column] += rate * step
    return moved
