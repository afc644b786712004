"""NumPy whose new memory holds what is no result: what a sum or an array that nobody filled would show by chance."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

DIRT = 7.5e77
"""Finite, so that a search for values that are not finite does not save the day."""


def soil(monkeypatch: pytest.MonkeyPatch) -> None:
    """Have `np.empty` and `np.empty_like` return dirt, and `np.einsum` where a factor is empty, as NumPy 2.4 may."""
    for name in ("empty", "empty_like"):
        monkeypatch.setattr(np, name, _soiled(getattr(np, name), lambda *_, **__: True))
    monkeypatch.setattr(
        np, "einsum", _soiled(np.einsum, lambda _, *factors, **__: any(np.size(each) == 0 for each in factors))
    )


def _soiled(function: Callable[..., Any], when: Callable[..., bool]) -> Callable[..., Any]:
    def soiled(*arguments: Any, **options: Any) -> Any:
        found = function(*arguments, **options)
        if when(*arguments, **options) and np.asarray(found).dtype.kind == "f":
            found = np.asarray(found)
            found[...] = DIRT if found.dtype.itemsize > 4 else 7.5e33
        return found

    return soiled
