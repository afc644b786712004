"""Meshes read (read/), measured, repaired; their symmetry and tessellation. The map is in `mass_properties` above."""
