"""Many cases of one kind: some of them in every run, all of them in the slow one."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pytest


def sampled(cases: Iterable[Any], every: int = 8) -> list[Any]:
    """Return the cases, or what `pytest.param` makes of them, all marked slow but the first of each `every`.

    Cases of several arguments are given as `pytest.param` makes them.
    """
    return [case if k % every == 0 else _slow(case) for k, case in enumerate(cases)]


def _slow(case: Any) -> Any:
    if hasattr(case, "marks"):
        return pytest.param(*case.values, id=case.id, marks=[*case.marks, pytest.mark.slow])
    return pytest.param(case, marks=pytest.mark.slow)
