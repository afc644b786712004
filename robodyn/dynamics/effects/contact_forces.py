"""Forces and moments of what links stand on."""

from __future__ import annotations

from robodyn.dynamics.effects.external_wrench import wrench_effect

EFFECT = wrench_effect("contact forces", "contact", "no link stands on anything", "-J^T f of what links stand on")
