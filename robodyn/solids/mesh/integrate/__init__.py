"""Integrals over volumes and surfaces of triangles: in floats, in machine code, and without rounding."""
