"""Inverse dynamics under constraints: which forces of loops and contacts, and which torques, a motion takes."""
