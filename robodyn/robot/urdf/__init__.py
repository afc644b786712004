"""URDF: one parse and one view with faults as data, strict reading that raises the first, geometry, packages, xacro."""
