"""Every effect that robodyn knows, in the order of reports."""

from __future__ import annotations

from robodyn.dynamics.effects import friction, motors, rigid_bodies, springs, wrenches
from robodyn.dynamics.effects.effect import Effect

EFFECTS: tuple[Effect, ...] = (
    rigid_bodies.GRAVITY,
    rigid_bodies.INERTIA,
    rigid_bodies.CORIOLIS,
    rigid_bodies.MOVING_BASE,
    rigid_bodies.PAYLOAD,
    friction.VISCOUS,
    friction.COULOMB,
    motors.ROTOR,
    motors.COUPLED,
    motors.GYROSCOPIC,
    springs.JOINT,
    springs.LIMIT,
    wrenches.EXTERNAL,
    wrenches.LOOPS,
    wrenches.CONTACTS,
    wrenches.FLUID,
    friction.LOAD,
    rigid_bodies.MIMIC,
)
