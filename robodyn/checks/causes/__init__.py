"""Why an inertia tensor is wrong: what speaks against it, what it was meant to be, the one cause that explains it."""
