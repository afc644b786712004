"""Meshes: read, proven closed, repaired, integrated, searched for symmetry, judged for tessellation."""
