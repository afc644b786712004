"""Coulomb friction as simulations have it: regularised over a slip speed."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

from robodyn.dynamics.effects import coulomb_friction
from robodyn.dynamics.effects.friction import rubbing
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene

SLIP_SPEED = 1e-3
"""rad/s, where a joint has Coulomb friction and the scene gives none."""


@lru_cache(maxsize=16)
def with_friction(model: Model, scene: Scene) -> tuple[Scene, tuple[str, ...]]:
    """The scene with a slip speed if some joint has Coulomb friction, and what is to be said about it."""
    if not coulomb_friction.why(model, scene, frozenset()).active:
        return scene, ()
    chosen = scene.slip_speed or SLIP_SPEED
    steepest = max(max(abs(f.forward), abs(f.backward), abs(f.stribeck or 0.0)) for _, _, f in rubbing(model, scene))
    said = f"Coulomb friction is regularised, f qd / sqrt(qd^2 + {chosen:g}^2)"
    given = scene if scene.slip_speed else replace(scene, slip_speed=chosen)
    return given, (f"{said}: up to {steepest / chosen:.3g} N m s/rad near rest",)
