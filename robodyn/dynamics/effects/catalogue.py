"""Every effect that robodyn knows, in the order of reports."""

from __future__ import annotations

from robodyn.dynamics.effects import (
    coriolis,
    coulomb_friction,
    external_wrench,
    fluid,
    gravity,
    inertia,
    joint_spring,
    limit_spring,
    mimic,
    moving_base,
    payload,
    rotor_inertia,
    viscous_friction,
)
from robodyn.dynamics.effects.effect import Effect

EFFECTS: tuple[Effect, ...] = (
    gravity.EFFECT,
    inertia.EFFECT,
    coriolis.EFFECT,
    moving_base.EFFECT,
    payload.EFFECT,
    viscous_friction.EFFECT,
    coulomb_friction.EFFECT,
    rotor_inertia.EFFECT,
    joint_spring.EFFECT,
    limit_spring.EFFECT,
    external_wrench.EFFECT,
    fluid.EFFECT,
    mimic.EFFECT,
)
