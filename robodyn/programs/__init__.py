"""Straight-line programs: the scalars that record them, vectors over any scalar, and (run/) what executes them."""
