"""Equations of motion, worked solutions, free bodies and small motions as documents."""
