"""The findings in published robots are those that were looked at; see `pinned_findings` for how to write them anew."""

from __future__ import annotations

from pathlib import Path

import pytest
from helpers.sampled import sampled
from pinned_findings import counts, name_of, pinned, published

PINNED = pinned()


def test_the_same_robots() -> None:
    assert set(PINNED) == {name_of(path) for path in published()}


@pytest.mark.parametrize("path", sampled(published(), 6), ids=name_of)
def test_the_same_findings(path: Path) -> None:
    assert counts(path) == PINNED[name_of(path)]
