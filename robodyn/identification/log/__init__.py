"""Logs: samples on even grids, measured torques, and filters."""
