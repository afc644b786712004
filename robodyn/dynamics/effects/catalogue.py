"""Every effect that robodyn knows, in the order of reports."""

from __future__ import annotations

from importlib import import_module

from robodyn.dynamics.effects.effect import Effect

_FILES = (
    *("gravity", "inertia", "coriolis", "moving_base", "payload", "viscous_friction", "coulomb_friction"),
    *("rotor_inertia", "coupled_motor", "gyroscopic_moment", "joint_spring", "limit_spring"),
    *("external_wrench", "loop_forces", "contact_forces", "fluid", "load_friction", "mimic"),
)
EFFECTS: tuple[Effect, ...] = tuple(import_module(f"robodyn.dynamics.effects.{name}").EFFECT for name in _FILES)
