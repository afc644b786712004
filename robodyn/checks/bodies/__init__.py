"""Links as rigid bodies: poses, masses, the boxes around their shapes, slips of units."""
