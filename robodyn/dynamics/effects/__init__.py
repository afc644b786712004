"""One effect, one file: what it adds to the recursions, and when a scene calls for it."""
