"""Moments of mass and their laws: parallel axes, rotation, principal axes, what a body can have."""
