"""Paths in time, worst poses, catalogues and heat, as text, JSON and pages."""
