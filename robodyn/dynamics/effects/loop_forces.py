"""Forces and moments by which closed loops hold links together."""

from __future__ import annotations

from robodyn.dynamics.effects.external_wrench import wrench_effect

EFFECT = wrench_effect("loop forces", "loop", "no loop is closed", "-J^T lambda of the forces that close loops")
