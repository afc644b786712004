"""Effects, a file for each family: what each adds to the recursions, and when a scene calls for it."""
