"""URDF: a document with positions, a strict description made of it, geometry, packages, xacro."""
