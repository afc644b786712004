"""Velocities and accelerations that a table does not give: `derive.py` is the door."""
