"""URDF: one parse with faults as data, a strict description and a tolerant view of it, geometry, packages, xacro."""
