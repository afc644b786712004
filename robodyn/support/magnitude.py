"""Numbers of a size that products of several do not carry out of floating point."""

from __future__ import annotations

LARGEST = 1e30
"""In SI units no part of a robot has a larger number; the tenth power of this one can still be held."""

SMALLEST = 1e-60
"""What is less is what rounding left of zero, as in files that CAD systems write, and counts as zero."""
