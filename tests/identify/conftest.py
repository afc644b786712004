"""Fits choose among two strengths, not six, where tests are to be quick: slow ones and logs of real robots have all."""

from __future__ import annotations

import pytest


@pytest.fixture(autouse=True)
def _few_strengths(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    if request.node.get_closest_marker("slow") is None:
        monkeypatch.setattr("robodyn.identification.model_selection.STRENGTHS", (0.1, 10.0))
