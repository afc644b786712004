"""The executors that random programs hold together."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from robodyn.programs.run.compiled_blocks import CompiledBlocks
from robodyn.programs.run.numpy_blocks import NumpyBlocks


class Executor(NamedTuple):
    """What makes a program ready to run: (program, widths) -> (sources, samples) -> outputs, all in one format.

    Its sines, cosines and exponentials are right to so many units in the last place.
    """

    ready: Callable[..., Any]
    dtype: Any = np.float64
    ulps: int = 1


EXECUTORS = {
    "numpy": Executor(NumpyBlocks),
    "numpy float32": Executor(partial(NumpyBlocks, dtype=np.float32), np.float32, ulps=3),
    "compiled": Executor(CompiledBlocks),
    "compiled float32": Executor(partial(CompiledBlocks, dtype=np.float32), np.float32),
}
