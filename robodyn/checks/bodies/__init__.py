"""Links as rigid bodies: masses, frames, the boxes around their shapes, slips of units."""
