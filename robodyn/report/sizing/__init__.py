"""Paths in time, worst poses and catalogues, as text, JSON and pages."""
