"""Masses of links: what a description declares against what its shapes have."""
